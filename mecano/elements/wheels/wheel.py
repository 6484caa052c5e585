r"""Wheel that deforms radially and slips on the ground, at any lean and heading.

Theory: section 3.3 of Cardona, Geradin and Doan, CMAME 89 (1991), equations (27)-(46), here for leaning
wheels too. With the axis a = R a0, the contact C = x + r c (n, q = |n - (n.a) a| and r taken at C),
and the tyre law:

    radial deformation   w = radius - r                  dw/dt = -n.(v + omega x r c)/q
    normal force         N = F_r(w, dw/dt)/q             F_r acts in the plane of the wheel
    slip velocity        v_C = (I - n n^T)(v + omega x r c)
    friction             F_fr = mu(|v_C|) sigma(u) phi(|v_C|) N v_C/|v_C|,   u = |(I - n n^T) v|

The whole ground force -(F_fr - N n) acts at C. Internal forces, with f = F_fr - N n (36):

    force: f          material moment: R^T (r c x f)

Upright this is the paper's vector; leaning, -N (r c) x n is the moment that tips the wheel. Its power is
F_fr.v_C + F_r dw/dt: what slip and damping dissipate, never negative, and what the radial law stores. The
tangents are exact and not symmetric, through slip, lean, and the curvature of the ground; dw/dt depends
on q and on v.

In the phase "air" there is no force. In the phase "contact" the tyre law continues smoothly to w < 0, for steps that
end at the lift-off; no accepted step is there. A regularized contact creeps: at rest under a
driving force T it slides at about eps T/(2 mu N).

Validity: one contact; where the ground is concave, its radius of curvature is larger than the wheel's
radius; the wheel does not lie flat (q > 0: checked initially, finite at all times). The node is that of
the wheel body: its rotation spins with the wheel.
"""

from typing import NamedTuple

from mecano.compiled.kernel import kernel
from mecano.constraints.ground import GROUND_RECORD, ends, touch
from mecano.contract import Kind, record
from mecano.elements.wheels.tire_law import TIRE_RECORD, gripping, radial_force, speed_over_ground
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
from mecano.maths.surface import Contact
from mecano.maths.vector import add_vec, cross, dot, mat, norm, vec


class Forces(NamedTuple):
    """Contact and forces of a wheel; 3-vectors in the inertial frame."""

    g: Contact
    axis: tuple
    omega: tuple  # [rad/s]
    v_C: tuple  # slip velocity [m/s]
    w1: float  # dw/dt [m/s]
    F: float  # F_r [N]
    N: float  # normal force [N]
    b: float  # mu phi/|v_C| [s/m]


@kernel
def _forces(p, at):
    """Return the Forces of a wheel in contact."""
    R, x, v = mat(at.R[0]), vec(at.q, 0), vec(at.v, 0)
    axis, omega = R @ vec(p.axis, 0), R @ vec(at.v, 3)
    g = touch(p, at.laws, x, axis)
    u = v + cross(omega, g.arm)
    lift = dot(g.n, u)
    v_C, w1 = u - lift * g.n, -lift / g.q
    F, speed = radial_force(p, at.laws, p.radius - g.r, w1), norm(v_C)
    return Forces(g, axis, omega, v_C, w1, F, F / g.q, gripping(p, at.laws, speed, speed, speed_over_ground(g.n, v)))


@kernel
def residual(p, at, f):
    """Add force and material moment of the ground; see the contract."""
    if at.phase == AIR:
        return
    k = _forces(p, at)
    push = k.N * (k.b * k.v_C - k.g.n)
    add_vec(f, 0, 1.0, push)
    add_vec(f, 3, 1.0, mat(at.R[0]).T @ cross(k.g.arm, push))


@kernel
def observe(p, at, F, y, e):
    """Outputs and energies; see OUTPUTS and the contract."""
    k = _forces(p, at)
    arm = (k.g.r if at.phase == CONTACT else p.radius) * k.g.c
    u = vec(at.v, 0) + cross(k.omega, arm)
    v_C = u - dot(k.g.n, u) * k.g.n
    speed = norm(v_C)
    grip = Grip(k.F, -k.N * k.b * v_C, k.b * speed, v_C, k.N * k.b * speed * speed, k.w1)
    put_tire(p, at.laws, at.phase == CONTACT, k.g, k.axis, arm, dot(k.omega, k.axis), grip, at.q, y, e)


@kernel
def event_values(p, at, g):
    """Write w for the touch-down, -w for the lift-off [m]."""
    contact = touch(p, at.laws, vec(at.q, 0), mat(at.R[0]) @ vec(p.axis, 0))
    g[0] = p.radius - contact.r
    g[1] = contact.r - p.radius


def sample(rng):
    """Large wheels: plane, profile, slip, stick, air."""
    friction = (("exponential", {"start": 0.8, "limit": 0.3, "rate": 0.1, "origin": 0.0}),)
    by_speed = (("exponential", {"start": 1.0, "limit": 0.0, "rate": 0.2, "origin": 0.0}),)
    return [
        (large_wheel(rng, profile, eps, friction, by_speed, None), 1, mode)
        for profile, eps, mode in ((False, 0.05, "contact"), (True, 50.0, "contact"), (True, 0.05, "air"))
    ]


WHEEL = Kind(
    name="wheel",
    section="elements",
    doc=__doc__,
    dtype=record(axis=3, **GROUND_RECORD, **TIRE_RECORD),
    layout=("x0", "R0"),
    fields=FIELDS,
    outputs=OUTPUTS,
    modes=MODES,
    events=EVENTS,
    prepare=prepare_wheel,
    check=check_wheel,
    limits=range_of_law,
    ends=ends,
    residual=residual,
    observe=observe,
    event_values=event_values,
    sample=sample,
)
