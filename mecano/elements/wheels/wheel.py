r"""Wheel that deforms radially and slips on the ground, at any lean and heading.

Theory: section 3.3 of Cardona, Geradin and Doan, CMAME 89 (1991), equations (27)-(46), here for leaning
wheels too. With the axis a = R a0, the contact C = x + r c (n, q = |n - (n.a) a| and r taken at C),
and the tyre law:

    radial deformation   w = radius - r                  dw/dt = -n.(v + omega x r c)/q
    normal force         N = F_r(w, dw/dt)/q             F_r acts in the plane of the wheel
    slip velocity        v_C = (I - n n^T)(v + omega x r c)
    force and moment     F, M of the slip law: friction, fiala, magic_formula, ...

The whole ground force F + N n acts at C. Internal forces, with f = -(F + N n) (36):

    force: f          material moment: R^T (r c x f - M)

Upright, with friction, this is the paper's vector; leaning, -N (r c) x n is the moment that tips the wheel. Its power
is -(F.v_C + M.omega) + F_r dw/dt: what slip and damping dissipate, never negative, what the slip law exchanges with the
rolling, and what the radial law stores. dw/dt depends on q and on v.

In mode "air" there is no force. In mode "contact" the tyre law goes on smoothly to w < 0, for the sake of
steps that end at the lift-off; no accepted step is there. A regularized contact creeps: at rest under a
driving force T it slides at about eps T/(2 mu N).

Validity: one contact; where the ground is hollow, its radius of curvature is larger than the wheel's
radius; the wheel does not lie flat (q > 0: checked at the start, finite at all times). The node is the
wheel body's: its rotation spins with the wheel.
"""

import math
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np

from mecano.compiled.kernel import kernel
from mecano.constraints.ground import GROUND_RECORD, ends, touch
from mecano.contract import Kind, Output, record
from mecano.elements.wheels.slip_law import Slip, SlipForces, default_values
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.elements.wheels.tire_law import RADIAL_RECORD, radial_force, slip_law_of
from mecano.elements.wheels.tire_wheel import (
    AIR,
    CONTACT,
    EVENTS,
    FIELDS,
    MODES,
    OUTPUTS,
    Grip,
    check_wheel,
    large_wheel,
    prepare_wheel,
    put_tire,
    range_of_law,
)  # fmt: skip
from mecano.maths.surface import Contact, directions
from mecano.maths.vector import add_vec, cross, dot, mat, put, vec

MOMENT = Output(
    "slip_moment", "N m", "moment of the slip law on the wheel: overturning about t, along l, aligning about n", (3,)
)
SLIP = (
    Output("slip_ratio", "-", "slip of the point of contact along t over the speed of the axle: 1 spinning, -1 locked"),
    Output("slip_angle", "rad", "angle of the motion of the point of contact from t, positive towards l"),
)
SLOW = 0.1  # m/s, below which they fade
FRICTION = SLIP_LAWS["friction"]


class Forces(NamedTuple):
    """Contact and forces of a wheel; 3-vectors in the inertial frame."""

    g: Contact
    axis: tuple
    w1: float  # dw/dt [m/s]
    F: float  # F_r [N]
    slip: Slip
    ground: SlipForces


def compiled(law):
    """Return ``residual`` and ``observe`` of a wheel with a SlipLaw."""
    forces = law.forces

    @kernel
    def ground_forces(p, at, touching):
        R, x, v = mat(at.R[0]), vec(at.q, 0), vec(at.v, 0)
        axis, omega = R @ vec(p.axis, 0), R @ vec(at.v, 3)
        g = touch(p, at.laws, x, axis)
        arm = g.arm if touching else p.radius * g.c
        point = v + cross(omega, arm)
        lift = dot(g.n, point)
        v_C, w1 = point - lift * g.n, -lift / g.q
        F = radial_force(p, at.laws, p.radius - g.r, w1)
        t, l = directions(axis, g)
        u = v - dot(g.n, v) * g.n
        slip = Slip(F / g.q, p.radius - g.r, v_C, v_C, u, omega, dot(omega, axis), g.s, t, l, g.n)
        return Forces(g, axis, w1, F, slip, forces(p, at.laws, slip))

    @kernel
    def residual(p, at, f):
        """Add force and material moment of the ground; see the contract."""
        if at.phase == AIR:
            return
        k = ground_forces(p, at, True)
        push = k.ground.F + k.slip.N * k.slip.n
        add_vec(f, 0, -1.0, push)
        add_vec(f, 3, -1.0, mat(at.R[0]).T @ (cross(k.g.arm, push) + k.ground.M))

    @kernel
    def observe(p, at, F, y, e):
        """Outputs and energies; see OUTPUTS and the contract."""
        touching = at.phase == CONTACT
        k = ground_forces(p, at, touching)
        arm = (k.g.r if touching else p.radius) * k.g.c
        grip = Grip(k.F, k.ground.F, k.slip.N, k.slip.v, k.ground.lost, k.w1)
        if put_tire(p, at.laws, touching, k.g, k.axis, arm, k.slip.spin, grip, at.q, y, e):
            M = k.ground.M
            put(y, 18, (dot(k.slip.t, M), dot(k.slip.l, M), dot(k.slip.n, M)))
            e[3] = k.ground.given
            forward = dot(k.slip.t, k.slip.u)
            V = math.sqrt(forward * forward + SLOW * SLOW)
            y[21], y[22] = -dot(k.slip.t, k.slip.v) / V, math.atan(dot(k.slip.l, k.slip.v) / V)

    return residual, observe


@kernel
def event_values(p, at, g):
    """Write w for the touch-down, -w for the lift-off [m]."""
    contact = touch(p, at.laws, vec(at.q, 0), mat(at.R[0]) @ vec(p.axis, 0))
    g[0] = p.radius - contact.r
    g[1] = contact.r - p.radius


@cache
def with_law(law):
    """The Kind of a wheel with a SlipLaw."""
    residual, observe = compiled(law)

    def prepare(d, nodes, context):
        return {**prepare_wheel(d, nodes, context), **law.prepare(d["tire_law"], context)}

    return replace(
        WHEEL, name=f"wheel_{law.name}", dtype=record(axis=3, **GROUND_RECORD, **RADIAL_RECORD, **law.record),
        prepare=prepare, residual=residual, observe=observe, variant=None,
    )  # fmt: skip


def variant(d):
    """The wheel with the slip law of its tyre."""
    law = slip_law_of(d["tire_law"])
    return WHEEL if law is FRICTION else with_law(law)


def limits(d):
    """The ranges of the radial law and of the slip law."""
    return range_of_law(d) + slip_law_of(d["tire_law"]).limits(d["tire_law"])


def prepare(d, nodes, context):
    """Record: that of any wheel with a tyre law, friction."""
    return {**prepare_wheel(d, nodes, context), **FRICTION.prepare(d["tire_law"], context)}


def sample(rng):
    """Large wheels: plane, profile, slip, stick, air; and with each other slip law."""
    friction = (("exponential", {"start": 0.8, "limit": 0.3, "rate": 0.1, "origin": 0.0}),)
    by_speed = (("exponential", {"start": 1.0, "limit": 0.0, "rate": 0.2, "origin": 0.0}),)
    found = [
        (large_wheel(rng, profile, eps, friction, by_speed, None), 1, mode)
        for profile, eps, mode in ((False, 0.05, "contact"), (True, 50.0, "contact"), (True, 0.05, "air"))
    ]
    for law, own in zip(SLIP_LAWS.values(), rng.spawn(len(SLIP_LAWS)), strict=True):
        found += law_samples(own, law)
    return found


def law_samples(rng, law):
    """Samples of a wheel with a slip law: each of the law in contact, the last one in the air too."""
    found = []
    for values in law.sample(rng) if law.sample else ():
        wheel = large_wheel(rng, True, None, None, 1.0, None)
        wheel["tire_law"][law.name] = default_values(law.type.options, values)
        found.append((wheel, [(np.zeros(3), np.eye(3))], "contact"))
    return [*found, *((wheel, nodes, "air") for wheel, nodes, _ in found[-1:])]


RESIDUAL, OBSERVE = compiled(FRICTION)
WHEEL = Kind(
    name="wheel",
    section="elements",
    doc=__doc__,
    dtype=record(axis=3, **GROUND_RECORD, **RADIAL_RECORD, **FRICTION.record),
    layout=("x0", "R0"),
    fields=FIELDS,
    outputs=(*OUTPUTS, MOMENT, *SLIP),
    modes=MODES,
    events=EVENTS,
    variant=variant,
    prepare=prepare,
    check=check_wheel,
    limits=limits,
    ends=ends,
    residual=RESIDUAL,
    observe=OBSERVE,
    event_values=event_values,
    sample=sample,
)
