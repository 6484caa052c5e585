r"""Wheel that rolls on a surface of another body: a drum of a test rig, a treadmill, the deck of a ship.

The first node carries the surface, a ``plane`` or a ``cylinder`` on whose outer or inner side the wheel rolls; the
second one is the hub. Forces are those of the kind ``wheel`` with the same tyre law, with all velocities relative to
the material of the surface at the contact C, which moves with v_g = v_a + omega_a x (C - x_a):

    radial deformation   w = radius - r                  dw/dt = -n.(v + omega x r c - v_g)/q
    normal force         N = F_r(w, dw/dt)/q
    slip velocity        v_C = (I - n n^T)(v + omega x r c - v_g)
    force and moment     F, M of the slip law; its velocities of the axle and of the spin are those in axes that turn
                         with the surface, times R/(R + r) along t on a drum of the radius R

The contact on a drum follows the lean and the heading of the wheel. The force F + N n acts at C on the wheel and with
the opposite sign on the body, and so does M, so that momentum is conserved. The motor of a driven drum supplies its
work, not this element. Motions of the first node may be prescribed.

Validity: as for the kind ``wheel``. Inside a drum, its radius must exceed that of the wheel. A drum is infinitely wide.
Its curvature affects the rolling at the effective radius, but not the stiffness and the patch of the tyre.
"""

from functools import partial

import numpy as np

from mecano.constraints.carried_surface import (
    CARRIED_RECORD,
    FIELDS,
    carried_record,
    contact_at_start,
    touch_carried,
    touch_carried_round,
)
from mecano.constraints.ground import LEAST_Q, check_crown, too_low
from mecano.constraints.touching import check_one_surface, named_surface
from mecano.constraints.tread import flat, rounded
from mecano.constraints.triads import carried_axis, unit
from mecano.element_interface import Display, named
from mecano.elements.wheels.crown import crown_of, with_crown
from mecano.elements.wheels.enveloping import refuse_enveloping
from mecano.elements.wheels.ground_surface import Surface
from mecano.elements.wheels.rolling_contact import (
    OUTPUTS,
    add_ground,
    by_slip_law,
    law_samples,
    put_rolling,
    rolling_on,
    wheel_with,
    with_slip,
)
from mecano.elements.wheels.rolling_tyre import with_rolling
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.elements.wheels.start_warnings import start_warnings_on_body
from mecano.elements.wheels.tire_law import check_tire_law, prepare_radial
from mecano.elements.wheels.tire_wheel import AIR, CONTACT, deepest, large_wheel, put_depths
from mecano.jit.kernel import kernel
from mecano.maths.dual import constant
from mecano.maths.surface import directions
from mecano.maths.vector import add_vec, cross, dot, mat, vec
from mecano.schema import DIRECTION, NODE_PAIR, TIRE_LAW, Field

BODY, TURN = 6, 9  # local unknowns of the first node; those of the hub come first, as in all wheels


def on_surface(touch, tread):
    """Return the kernels that give the Rolling of a wheel, with the arm from the first node, and its event values."""

    @kernel
    def touching_at(p, at):
        """Return the Contact, the axis of the wheel, and the arm from the first node to the contact [m]."""
        R, x_a, x, axis = mat(at.R[1]), vec(at.q, BODY), vec(at.q, 0), mat(at.R[0]) @ vec(p.axis, 0)
        g = touch(p, x, axis, x_a + R @ vec(p.surface_origin, 0), R @ vec(p.surface_axis, 0))
        return g, axis, x + g.arm - x_a

    @kernel
    def rolling(p, at, touching):
        """Return the Rolling of the wheel and the arm from the first node to the contact [m]."""
        g, axis, arm = touching_at(p, at)
        R = mat(at.R[1])
        omega = R @ vec(at.v, TURN)
        v_g = vec(at.v, BODY) + cross(omega, arm)
        rise = dot(g.n, v_g)
        surface = Surface(constant(1.0, rise), v_g - rise * g.n, omega)
        along = dot(directions(axis, g)[0], R @ vec(p.surface_axis, 0))
        curvature = p.drum_curvature * (1.0 - along * along)
        return rolling_on(p, at, touching, tread(p, g), axis, surface, rise, curvature), arm

    @kernel
    def event_values(p, at, g):
        put_depths(g, p, touching_at(p, at)[0])

    return rolling, event_values


ON_FLAT, ON_ROUND = on_surface(touch_carried, flat), on_surface(touch_carried_round, rounded)


def compiled(law):
    """Return ``residual``, ``observe`` and ``event_values`` of a wheel with a SlipLaw."""
    forces, slip, seen, (rolling, event_values) = law.forces, law.slip, law.seen, ON_ROUND if law.crowned else ON_FLAT

    @kernel
    def residual(p, at, f):
        """Add force and material moment of the wheel and of the body that carries it; see element_interface."""
        if at.phase == AIR:
            return
        k, arm = rolling(p, at, True)
        k = with_slip(k, slip(p, k.slip))
        ground = forces(p, at.laws, k.slip)
        add_ground(f, at, k, ground)
        push = ground.F + k.slip.N * k.slip.n
        add_vec(f, BODY, 1.0, push)
        add_vec(f, TURN, 1.0, mat(at.R[1]).T @ (cross(arm, push) + ground.M))

    @kernel
    def observe(p, at, F, y, e):
        """Write outputs and energies."""
        k, _ = rolling(p, at, at.phase == CONTACT)
        k = with_slip(k, slip(p, k.slip))
        ground = forces(p, at.laws, k.slip)
        if put_rolling(p, at, with_slip(k, seen(p, k.slip)), ground, y, e):
            e[3] = ground.given

    return named(residual, observe, event_values)


def check(d, nodes):
    """Return errors in the surface and the tyre law, for a wheel that lies flat or starts too far in the surface."""
    texts = check_one_surface(d) + refuse_enveloping(d) + check_crown(d["tire_law"]["radius"], crown_of(d))
    return texts + check_tire_law(d["tire_law"]) + ([] if texts else _check_place(d, nodes))


def _check_place(d, nodes):
    """Return errors in the place of the wheel at the start."""
    (name, values), law = named_surface(d), d["tire_law"]
    if name == "cylinder" and values["inside"] and values["radius"] <= law["radius"]:
        return [f"'cylinder.radius' must exceed the radius of the wheel inside it, {law['radius']:g} m"]
    g = contact_at_start(d, nodes, unit(d["axis"]))
    if g.q < LEAST_Q:
        return ["the wheel lies flat: its axis is along the normal of the surface"]
    if g.r <= 0.0:
        return [f"the wheel's centre is {-g.r * g.q:.4g} m beyond the surface, on the side away from it"]
    depth, (most, limit) = law["radius"] - g.r, deepest(law)
    return [too_low(depth, depth * g.q, limit)] if depth > most else []


def sample(rng):
    """Return large wheels on a plane, outside and inside of drums, in contact and in the air, with each slip law."""
    friction = (("exponential", {"start": 0.8, "limit": 0.3, "rate": 0.1, "origin": 0.0}),)
    wheels = [(large_wheel(rng, False, eps, friction, 1.0, None), phase)
              for eps, phase in ((0.05, "contact"), (50.0, "contact"), (50.0, "contact"), (0.05, "air"))]  # fmt: skip
    for law, own in zip(SLIP_LAWS.values(), rng.spawn(len(SLIP_LAWS)), strict=True):
        wheels += [(wheel, phase) for wheel, _, phase in law_samples(own, law)]
    found = [(*_on_body(rng, wheel, i), phase) for i, (wheel, phase) in enumerate(wheels)]
    return [*found, with_rolling(found[1]), *map(with_crown, (*found[:3], with_rolling(found[1])))]


def _on_body(rng, wheel, number):
    """Return values and nodes of a wheel of ``large_wheel`` on a plane, outside or inside of a drum, by turns."""
    plane = wheel["ground"]["plane"]
    point, normal = (np.array(plane[name], float) for name in ("point", "normal"))
    across = np.cross(normal, rng.normal(size=3))
    radius = (0.0, 20.0, 30.0)[number % 3]
    surface = {"plane": plane, "cylinder": None}
    if radius:
        inside = number % 3 == 2
        center = point + (radius if inside else -radius) * normal
        cylinder = {"axis": across, "radius": radius, "center": center, "inside": inside}
        surface = {"plane": None, "cylinder": cylinder}
    nodes = [(point + rng.normal(size=3), np.eye(3)), (np.zeros(3), np.eye(3))]
    own = {name: wheel[name] for name in ("axis", "tire_law")}
    return {**own, **surface, "nodes": ["drum", "hub"]}, nodes


def prepare(d, nodes, context):
    """Return the values of the record; see element_interface."""
    own = {"axis": carried_axis(d, nodes[1:]), **carried_record(d, nodes)}
    return {**own, **prepare_radial(d["tire_law"], context)}


with_law = partial(
    wheel_with,
    compiled=compiled,
    own_record=CARRIED_RECORD,
    name="wheel_on_body", doc=__doc__,
    display=Display("wheel_on_body", pictures=("wheels",), force="contact_force", force_at="contact_point"),
    layout=("x1", "R1", "x0", "R0"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "the body that carries the surface, and the hub, which turns with the wheel"),
        Field("axis", DIRECTION, "-", "spin axis at the start, inertial; rolling forward turns right-handed"),
        *FIELDS,
        Field("tire_law", TIRE_LAW, "-", "law of the tyre: radius, forces, friction"),
    ),
    outputs=OUTPUTS,
    start_warnings=start_warnings_on_body,
    **named(prepare, check, sample),
)  # fmt: skip
WHEEL_ON_BODY = by_slip_law(with_law, SLIP_LAWS["friction"])
