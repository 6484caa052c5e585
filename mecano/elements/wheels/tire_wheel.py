"""Deck fields, outputs, energies, phases and events, checks and samples shared by wheels with a tyre law."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mecano.constraints.ground import LYING, check_axle, check_crown, check_ground, prepare_ground, slope_below, too_low
from mecano.constraints.tread import tread_above
from mecano.constraints.triads import carried_axis
from mecano.constraints.wheels import CONTACT_OUTPUTS, PLACED, WHEEL_DISPLAY, put_contact
from mecano.element_interface import Event, Output
from mecano.elements.wheels.crown import crown_of
from mecano.elements.wheels.enveloping import check_enveloping, ground_of, prepare_paths
from mecano.elements.wheels.ground_surface import check_surface, prepare_surface
from mecano.elements.wheels.tire_law import check_tire_law, prepare_radial
from mecano.jit.kernel import kernel
from mecano.laws.contact_force import elastic_energy, elastic_force
from mecano.laws.probe import table_bounds
from mecano.maths.dual import at_least, select, value
from mecano.maths.surface import directions
from mecano.maths.vector import dot, norm
from mecano.schema import TIRE_LAW, Field

AIR, CONTACT = 0, 1
PHASES = ("air", "contact")
MOST_DEFORMATION = 0.5  # of the radius: initially, for a law without a range of validity
CLEAR = 2.0  # of the radius: a wheel that starts higher may lie flat, one near the ground has a wrong axis
LIFT_OFF = Event("lift_off", "contact", "air", "the deformation returns to zero")
EVENTS = (Event("touch_down", "air", "contact", "the undeformed rim reaches the ground", brief=True), LIFT_OFF)
FIELDS = (*PLACED, Field("tire_law", TIRE_LAW, "-", "law of the tyre: radius, forces, friction"))
TYRE_DISPLAY = replace(WHEEL_DISPLAY, pictures=("wheels", "drop_test"))
OUTPUTS = (
    *CONTACT_OUTPUTS,
    Output("deformation", "m", "radial deformation w of the tyre; zero in the air", geometric=True),
    Output("radial_force", "N", "radial force F_r in the plane of the wheel; with a crown, along the normal"),
    Output("longitudinal_slip", "m/s", "slip velocity v_C along t; in the air, of the lowest point of the rim"),
    Output("lateral_slip", "m/s", "slip velocity v_C along l; in the air, of the lowest point of the rim"),
    Output("friction_coefficient", "-", "tangential over normal force; zero in the air"),
)


class Grip(NamedTuple):
    """Action of the ground on a wheel, by the laws of its tyre; 3-vectors in the inertial frame."""

    radial: float  # F_r [N]
    force: tuple  # of the ground on the wheel, tangential [N]
    N: float  # normal force [N]
    v_C: tuple  # slip velocity [m/s]
    lost: float  # power of the friction [W]
    w1: float  # dw/dt [m/s]


@kernel
def put_tire(p, at, wheel, grip, y, e):
    """Write OUTPUTS, and to ``e`` the energies of radial force and friction; return True if the ground pushes.

    ``wheel`` is a Wheel (constraints/wheels.py), ``grip`` the Grip of the phase "contact".
    """
    g, laws, contact = wheel.g, at.laws, at.phase == CONTACT
    # an accepted step that ends at the lift-off is within the tolerance of w = 0, on either side
    touching = contact and grip.radial > 0.0
    t, l = directions(wheel.axis, g)
    radius = select(contact, g.r, p.radius)
    w = at_least(p.radius - radius, 0.0)
    F = select(touching, grip.radial, 0.0)
    along, across = select(touching, dot(grip.force, t), 0.0), select(touching, dot(grip.force, l), 0.0)
    push = select(touching, grip.N, 0.0), along, across
    put_contact(y, at.q, push, radius, wheel)
    y[13], y[14] = w, F
    y[15], y[16] = dot(grip.v_C, t), dot(grip.v_C, l)
    if touching:
        y[17] = norm(grip.force) / grip.N
    if contact:
        e[1] = elastic_energy(laws, p.radial, value(w))
        e[2] = select(touching, grip.lost, 0.0) + (F - elastic_force(laws, p.radial, w)) * grip.w1
    return touching


@kernel
def put_depths(g, p, contact):
    """Write the values of EVENTS [m]: the depth of the undeformed rim below the ground at its Contact, and back."""
    g[0], g[1] = p.radius - contact.r, contact.r - p.radius


def prepare_wheel(d, nodes, context):
    """Return the record: axis in the node's frame, ground, radial law."""
    return {
        "axis": carried_axis(d, nodes),
        **prepare_ground(ground_of(d), context, crown_of(d)),
        **prepare_paths(d, context),
        **prepare_surface(d["ground"], context),
        **prepare_radial(d["tire_law"], context),
    }


def check_wheel(d, nodes):
    """Return errors for an unusable ground or tyre law, a wheel that lies flat or starts too far below the ground."""
    if texts := check_enveloping(d):
        return check_tire_law(d["tire_law"]) + texts
    place = ground_of(d), nodes[0][0], d["axis"]
    texts = check_ground(place[0]) + check_surface(d["ground"]) + check_axle(*place, CLEAR * d["tire_law"]["radius"])
    texts += check_crown(d["tire_law"]["radius"], crown_of(d))
    if not texts:
        gap, along_normal = tread_above(place[0], d["tire_law"]["radius"], crown_of(d), *place[1:])
        most, limit = deepest(d["tire_law"])
        texts = [too_low(-gap, -along_normal, limit)] if -gap > most else []
    return check_tire_law(d["tire_law"]) + texts


def deepest(law):
    """Return the largest deformation [m] of a tyre at the start, and a text that gives the reason for this bound."""
    valid = law["valid_deformation"]
    if valid:
        return valid, f", its law is valid up to {valid:g} m ('valid_deformation') of its radius of {law['radius']:g} m"
    return MOST_DEFORMATION * law["radius"], f", more than half of its radius of {law['radius']:g} m"


def range_of_law(d):
    """Return the ``limits`` of a wheel: the range of its radial law, or where a table of it ends."""
    valid = d["tire_law"]["valid_deformation"]
    if valid is None:
        found = table_bounds("deformation", d["tire_law"]["radial"], "the radial force")
        return [(output, high, text) for output, (_, high), text in found if high < np.inf]
    return [("deformation", valid, f"the radial law is valid up to {valid:g} m only")]


def end_conditions(d):
    """Return the end condition of a wheel that lies flat on the ground; in the air it may, as in a wheel bay."""
    return [(*LYING, "deformation")]


def large_wheel(rng, profile, eps, friction, by_speed, lateral):
    """Return, for samples, the deck values of a wheel that touches the ground, with or without a ``profile``."""
    wave = (("sine", {"amplitude": 0.3, "frequency": 0.03, "phase": 1.0, "offset": 0.0}),)
    ground, normal, level = slope_below(rng, wave if profile else None)
    tire_law = {
        "radius": 12.0, "radial": (("polynomial", {"coefficients": [0.0, 2e3, 3e2, -4.0, 0.5]}),),
        "radial_damping": 0.02, "friction": friction, "friction_by_speed": by_speed, "slip_regularization": eps,
        "valid_deformation": None, "lateral": lateral,
    }  # fmt: skip
    across = np.cross(normal, level)
    if profile:
        uneven = (("sine", {"amplitude": 0.2, "frequency": 0.05, "phase": 0.3, "offset": 1.0}),)
        ground["friction"] = {"direction": level + across, "factor": uneven}
    elif lateral is None:
        rising = (("linear", {"slope": 0.4, "offset": 0.3}),)
        centre = ground["plane"]["point"] + 3.0 * across
        ground["motion"] = {"direction": across, "speed": rising, "rate": 0.2, "centre": centre}
    return {"axis": level + rng.uniform(-0.5, 0.5) * normal, "tire_law": tire_law, "ground": ground}
