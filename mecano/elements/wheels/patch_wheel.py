"""Wheels with a flexible patch: load in the patch, deck fields, outputs, energies, events and warnings of all of them.

The load is the radial force and that of the lateral law. The friction F in the ground is left to the kind of wheel: its
patch slips, or it is held.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mecano.constraints.ground import GROUND_RECORD, lies_flat
from mecano.constraints.tire_patch import Y, add_patch_force
from mecano.constraints.tread import flat_on_ground, rounded_on_ground
from mecano.constraints.wheels import Wheel
from mecano.element_interface import Kind, Output, named, record
from mecano.elements.wheels.enveloping import refuse_enveloping
from mecano.elements.wheels.ground_surface import SURFACE_RECORD, surface_at
from mecano.elements.wheels.lateral_law import (
    FORMS,
    LATERAL_RECORD,
    Course,
    Lateral,
    check_lateral,
    lateral_law,
    prepare_lateral,
    twists,
)
from mecano.elements.wheels.sliding_friction import RECORD as FRICTION_RECORD
from mecano.elements.wheels.sliding_friction import prepare as prepare_friction
from mecano.elements.wheels.slip_law import Slip, unchanged
from mecano.elements.wheels.start_warnings import start_warnings
from mecano.elements.wheels.tire_law import RADIAL_RECORD, radial_force
from mecano.elements.wheels.tire_wheel import (
    CONTACT,
    EVENTS,
    PHASES,
    TYRE_DISPLAY,
    Grip,
    check_wheel,
    end_conditions,
    large_wheel,
    prepare_wheel,
    put_depths,
    put_tire,
    range_of_law,
)
from mecano.elements.wheels.tire_wheel import FIELDS as WHEEL_FIELDS
from mecano.elements.wheels.tire_wheel import OUTPUTS as TIRE_OUTPUTS
from mecano.jit.kernel import kernel
from mecano.laws.contact_force import elastic_force
from mecano.maths.dual import select
from mecano.maths.surface import directions
from mecano.maths.vector import add_vec, cross, dot, mat, norm, put, vec
from mecano.schema import NUMBER, Field, mapping

INITIAL = mapping(
    Field("y", NUMBER, "m", "lateral displacement of the patch", 0.0),
    Field("psi", NUMBER, "rad", "torsion of the patch, where the lateral law has a rate of psi", 0.0),
)
FIELDS = (*WHEEL_FIELDS, Field("initial", INITIAL, "-", "the patch at the start", {}))
SCALARS = ("y", "psi", "bow")
OUTPUTS = (
    *TIRE_OUTPUTS,
    Output("y", "m", "lateral displacement of the patch against the wheel plane, along -a", rate="y_rate"),
    Output("psi", "rad", "torsion of the patch: rotation of its rolling direction about n", rate="psi_rate"),
    Output(
        "bow", "m", "curvature of the contact line of a string: its second Legendre coefficient; otherwise zero",
        rate="bow_rate",
    ),
    Output("tire_force", "N", "force F of the lateral law along y"),
    Output("tire_moment", "N m", "moment M of the lateral law along psi"),
    Output("aligning_moment", "N m", "aligning moment on the wheel about n"),
    Output("y_rate", "m/s", "rate of y"),
    Output("psi_rate", "rad/s", "rate of psi"),
    Output("bow_rate", "m/s", "rate of bow"),
    Output("divergence", "-", "braking force relative to that at which y becomes unstable (Moreland: kap C K)"),
)  # fmt: skip
DIVERGENT = (
    "above 1 braking exceeds the capacity of the torsional stiffness of the tyre: its patch is laterally unstable; "
    "increase 'torsional_stiffness'"
)
RECORD = {"start": 3, **LATERAL_RECORD, "axis": 3, **GROUND_RECORD, **SURFACE_RECORD, **RADIAL_RECORD}
STRING = {
    "cornering_stiffness": 2e3, "relaxation_length": 2.0, "contact_length": 3.0, "torsional_stiffness": 300.0,
    "least_speed": 1.0,
}  # fmt: skip
MATRICES = {"stiffness": [900.0, 50.0, -80.0, 300.0], "damping": [30.0, -2.0, 4.0, 20.0]}


class Load(NamedTuple):
    """Forces in the patch except its friction."""

    radial: float  # F_r [N]
    N: float  # normal force [N]
    damping: float  # its part by radial damping [N]
    slip: Slip
    law: Lateral


class PatchFriction(NamedTuple):
    """Action of the ground on a patch; 3-vectors in the inertial frame."""

    v: tuple  # slip velocity [m/s]
    F: tuple  # force on the wheel, in the ground [N]
    lost: float  # dissipated power [W]


def loads_by(slipping):
    """Return the kernel that gives the Load of a Patch whose Slip is changed by ``slipping``, see SlipLaw.slip.

    The patch rolls along t + psi (n x t). It is laid down without lateral slip by the rolling of the changed Slip.
    """

    @kernel
    def load_of(p, at, k):
        """Return the Load of the Patch ``k``."""
        w = p.radius - k.g.r
        v, radial = vec(at.v, 0), radial_force(p, at.laws, w, k.w1)
        N, damping = radial / k.tread.tilt, (radial - elastic_force(at.laws, p.radial, w)) / k.tread.tilt
        u, (t, l) = v - dot(k.g.n, v) * k.g.n, directions(k.a, k.g)
        grip = surface_at(p, at, k.g.n, vec(at.q, 0) + k.rho).grip
        rolling, spin = t + k.psi * l, dot(k.omega, k.a)
        slip = slipping(p, Slip(N, w, grip, k.v_C, k.v_0, u, k.omega, spin, k.g.s, rolling, l, k.g.n, 0.0))
        course = Course(norm(u), dot(t, u), dot(k.g.n, k.omega), dot(slip.v_0, k.a) / (k.g.q * k.g.q))
        return Load(radial, N, damping, slip, lateral_law(p, at, N, course))

    return load_of


load_of = loads_by(unchanged)


@kernel
def add_load(f, at, k, load, F):
    """Add the forces of a Load and of the friction F (3,) [N] in the ground."""
    R = mat(at.R[0])
    add_patch_force(f, R, k, F, load.N, load.damping)
    add_vec(f, 3, -load.law.turn, R.T @ k.g.n)
    add_vec(f, Y, 1.0, load.law.f)


@kernel
def put_patch(p, at, k, load, friction, y, e):
    """Write OUTPUTS and energies of the Patch ``k`` under the Load ``load`` and the PatchFriction ``friction``."""
    q, v, contact, law = at.q, at.v, at.phase == CONTACT, load.law
    arm = select(contact, k.rho, k.tread.lowest)
    lowest = vec(v, 0) + cross(k.omega, arm)
    v_C = select(contact, friction.v, lowest - dot(k.g.n, lowest) * k.g.n)
    grip = Grip(load.radial, friction.F, load.N, v_C, friction.lost, k.w1)
    touching = put_tire(p, at, Wheel(k.g, k.a, arm, dot(k.omega, k.a), k.tread.height), grip, y, e)
    put(y, 18, vec(q, Y))
    put(y, 24, vec(v, Y))
    if touching and p.twist > 0.0 and p.A0[1, 0] < 0.0:
        y[27] = law.way * dot(friction.F, directions(k.a, k.g)[0]) / p.A0[1, 0]
    f = select(contact, law.f, mat(p.A0) @ vec(q, Y) + mat(p.A1_air) @ vec(v, Y))
    if contact:
        put(y, 21, (f[0], f[1], law.turn))
    stored, rate = mat(p.stored) @ vec(q, Y), dot(vec(v, Y), mat(p.stored) @ vec(q, Y))
    e[1] += 0.5 * dot(vec(q, Y), stored)
    damped = select(contact, law.damped, dot(vec(v, Y), mat(p.damped_air) @ vec(v, Y)))
    e[2] += damped
    e[3] = damped + rate - dot(f, vec(v, Y)) + select(contact, law.turn * dot(k.g.n, k.omega), 0.0)


def event_values_with(tread_on_ground):
    """Return ``event_values`` of a wheel with a tread of tread.py."""

    @kernel
    def event_values(p, at, g):
        axis = mat(at.R[0]) @ vec(p.axis, 0)
        put_depths(g, p, tread_on_ground(p, at.laws, vec(at.q, 0) - at.q[Y] * axis, axis).g)

    return event_values


def prepare(d, nodes, context):
    """Return the record: that of a wheel with a tyre law, the lateral law, the initial values."""
    return {
        **prepare_wheel(d, nodes, context),
        **prepare_friction(d["tire_law"], context),
        **prepare_lateral(d["tire_law"]["lateral"], context),
        "start": [d["initial"].get("y", 0.0), d["initial"].get("psi", 0.0), 0.0],
    }


def check(d, nodes):
    """Return errors of any wheel with a tyre law, and in its lateral law."""
    law = d["tire_law"]
    slips = [] if law["friction"] is not None else [f"a {d['type']} needs 'tire_law.friction'"]
    if d["ground"].get("motion"):
        slips.append("'ground.motion' is available for the kinds wheel and transient_wheel only")
    slips += refuse_enveloping(d)
    return slips + check_wheel(d, nodes) + check_lateral(law["lateral"])


def limits(d):
    """Return the range of the radial law, and the braking at which the patch becomes laterally unstable."""
    found, lateral = range_of_law(d), d["tire_law"]["lateral"]
    return [*found, ("divergence", 1.0, DIVERGENT)] if lateral and twists(lateral) else found


def _twist_warnings(d, nodes):
    """Return a warning if the twist of a rolling wheel is damped too little at its initial slip angle.

    At a slip angle alpha, spin inertia I and speed V, twist and spin oscillate with growing amplitude unless
    C1 > V I alpha^2/(r^2 kap C K): docs/tyre-equations.md, Twist.
    """
    law, (node,) = d["tire_law"]["lateral"]["moreland"], nodes
    axis, normal = node.orientation.T @ d["axis"] / np.linalg.norm(d["axis"]), np.array(d["ground"]["plane"]["normal"])
    if not law or lies_flat(normal, node.R @ axis):
        return []
    ahead = np.cross(node.R @ axis, normal)
    along, across = abs(node.v @ ahead), abs(node.v @ np.cross(normal, ahead)) / np.linalg.norm(normal)
    speed, angle = np.hypot(along, across) / np.linalg.norm(ahead), math.atan2(across, along)
    stiffness = law["torsional_stiffness"] * law["yaw_coefficient"] * law["lateral_stiffness"]
    needed = speed * (axis @ node.inertia() @ axis) * angle**2 / (d["tire_law"]["radius"] ** 2 * stiffness)
    if not 0.0 < law["yaw_time"] < needed:
        return []
    return [
        f"rolling at its initial slip angle, {math.degrees(angle):.3g} deg at {speed:.3g} m/s, the twist of its patch "
        "and its spin oscillate with growing amplitude, unless 'tire_law.lateral.moreland.yaw_time' "
        f"({law['yaw_time']:g} s) is more than {needed:.2g} s"
    ]


def remedies(d):
    """Return what to try if the solution fails in the equations of the patch: larger stiffness or damping."""
    law, lateral = d["tire_law"], d["tire_law"]["lateral"]
    (form,) = (name for name in FORMS if lateral[name])
    units = {"torsional_stiffness": "N m/rad", "yaw_time": "s", "lateral_damping": "N s/m"}
    given = [(name, lateral[form][name], unit) for name, unit in units.items() if name in lateral[form]]
    found = [f"a greater 'tire_law.lateral.{form}.{name}' (now {value:g} {unit})" for name, value, unit in given]
    return [
        *found,
        f"a greater 'tire_law.slip_regularization' (now {law['slip_regularization']:g} m/s)",
        f"a greater 'tire_law.lateral.relaxation_in_air' (now {lateral['relaxation_in_air']:g} s), for a leaning wheel "
        "that leaves the ground and meets it again at once",
    ]


def _sample(rng, profile, eps, phase, form):
    """Return (values, nodes, phase) of a large wheel on a plane or a profile, with one form of lateral law."""
    growing = (("linear", {"slope": 1e-5, "offset": 0.5}),)
    falling = (("exponential", {"start": 1.0, "limit": 0.2, "rate": 0.2, "origin": 0.0}),)
    lateral = {
        **dict.fromkeys(FORMS), form: MATRICES if form == "matrices" else STRING,
        "stiffness_by_load": growing, "stiffness_by_speed": falling,
        "damping_by_load": growing, "damping_by_speed": falling, "aligning_moment": [20.0, -30.0, 4.0, 5.0],
        "relaxation_in_air": 0.01,
    }  # fmt: skip
    return large_wheel(rng, profile, eps, falling, falling, lateral), 1, phase


def sample(rng):
    """Return large wheels that touch the ground from near the origin: plane, profile, air; all forms of lateral law."""
    cases = (
        (False, 0.05, "contact", "matrices"), (True, 50.0, "contact", "matrices"), (True, 0.05, "air", "matrices"),
        (True, 0.05, "contact", "string"), (False, 50.0, "contact", "straight_tangent"),
        (True, 0.05, "contact", "relaxation"),
    )  # fmt: skip
    return [_sample(rng, *case) for case in cases]


def with_round_tread(kind, **declared):
    """Return the Kind of ``patch_wheel`` with a rounded tread; ``declared``: its name, functions that depend on it."""
    return replace(kind, variant=None, event_values=event_values_with(rounded_on_ground), **declared)


def patch_wheel(name, doc, massless, events=EVENTS, **functions):
    """Return the Kind of a wheel with a flexible patch; ``functions``: residual, observe, and those of constraints."""
    return Kind(
        name=name, section="elements", doc=doc, display=TYRE_DISPLAY, dtype=record(**RECORD, **FRICTION_RECORD),
        layout=("x0", "R0"), scalars=SCALARS, massless=massless,
        fields=FIELDS,
        outputs=OUTPUTS,
        phases=PHASES,
        events=events,
        start_warnings=lambda d, nodes: [*start_warnings(d, nodes), *_twist_warnings(d, nodes)],
        start=lambda p: p["start"],
        **named(prepare, check, limits, remedies, end_conditions, sample),
        event_values=event_values_with(flat_on_ground),
        **functions,
    )  # fmt: skip
