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

In mode "air" there is no force. In mode "contact" the tyre law goes on smoothly to w < 0, for the sake of
steps that end at the lift-off; no accepted step is there. A regularized contact creeps: at rest under a
driving force T it slides at about eps T/(2 mu N).

Validity: one contact; where the ground is hollow, its radius of curvature is larger than the wheel's
radius; the wheel does not lie flat (q > 0: checked at the start, finite at all times). The node is the
wheel body's: its rotation spins with the wheel.
"""

from typing import NamedTuple

from mecano.compiled.kernel import kernel
from mecano.constraints.ground import GROUND_RECORD, ends, touch
from mecano.contract import Kind, record
from mecano.elements.tire_law import TIRE_RECORD, gripping, radial_force, speed_over_ground
from mecano.elements.tire_wheel import (
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
from mecano.maths.contact_force import add_columns, add_force, add_position_tangent, add_velocity_tangent
from mecano.maths.surface import disc_variation
from mecano.maths.vector import EYE, ZERO, cross, dot, mat, norm, outer, skew, vec


class Slip(NamedTuple):
    """State of force in a contact; 3-vectors in the inertial frame."""

    f: tuple  # F_fr - N n [N]: what the wheel exerts on the ground
    u: tuple  # velocity of the wheel at C [m/s]
    v_C: tuple  # slip velocity [m/s]
    e: tuple  # its direction, zero at rest
    w1: float  # dw/dt [m/s]
    F: float  # F_r [N]
    F_w: float  # dF_r/dw [N/m]
    F_w1: float  # dF_r/d(dw/dt) [N s/m]
    N: float  # normal force [N]
    grip: float  # mu phi [-]
    b: float  # mu phi/|v_C| [s/m]
    b1: float  # |v_C| db/d|v_C| [s/m]
    b_u: float  # db/d(speed of the axle) [s2/m2]
    v: tuple  # velocity of the axle [m/s]
    ahead: tuple  # its direction over the ground


@kernel
def _slip(p, laws, g, u, v):
    """The Slip of a wheel of record ``p`` in the Contact ``g``, whose point at C moves with ``u``, its axle with v."""
    along = dot(g.n, u)
    w1 = -along / g.q
    F, F_w, F_w1 = radial_force(p, laws, p.radius - g.r, w1)
    v_C = u - along * g.n
    speed = norm(v_C)
    axle_speed, ahead = speed_over_ground(g.n, v)
    grip, b, b1, b_u = gripping(p, laws, speed, axle_speed)
    N = F / g.q
    f = N * (b * v_C - g.n)
    e = v_C / speed if speed > 0.0 else ZERO
    return Slip(f, u, v_C, e, w1, F, F_w, F_w1, N, grip, b, b1, b_u, v, ahead)


@kernel
def _by_velocity(g, k):
    """df/du, 3x3, of the Slip ``k``: the contact is fixed."""
    dN = -k.F_w1 / g.q**2 * g.n
    dv = k.b * (EYE + outer(-g.n, g.n)) + outer(k.b1 * k.e, k.e)
    return outer(k.b * k.v_C - g.n, dN) + k.N * dv


@kernel
def _by_contact(g, k, dw, by):
    """df, 3x3, of the Slip ``k`` by three variables of which w has the derivatives ``dw`` (3,): u is fixed."""
    lift = by.n.T @ k.u  # d(n.u)
    dw1 = -lift / g.q + k.w1 * g.s / g.q**2 * by.s
    dF = k.F_w * dw + k.F_w1 * dw1
    dN = dF / g.q + k.N * g.s / g.q**2 * by.s
    dv_C = outer(-g.n, lift) + k.w1 * g.q * by.n
    d_speed = -dot(g.n, k.v) * (by.n.T @ k.ahead)
    dv = k.b * dv_C + outer(k.b1 * k.e, dv_C.T @ k.e)
    dv = dv + outer(k.b_u * k.v_C, d_speed)
    return outer(k.b * k.v_C - g.n, dN) + k.N * (dv - by.n)


@kernel
def force(p, at, f, K, C, M):
    """Add force and material moment of the ground, and their derivatives; see the contract."""
    if at.phase == AIR:
        return
    Rn = mat(at.R[0])
    axis = Rn @ vec(p.axis, 0)
    g = touch(p, at.laws, vec(at.q, 0), axis)
    omega = Rn @ vec(at.v, 3)
    slip = _slip(p, at.laws, g, vec(at.v, 0) + cross(omega, g.arm), vec(at.v, 0))
    add_force(f, Rn, g.arm, slip.f)

    arm, w = skew(g.arm), skew(omega)
    by_x, by_t = disc_variation(vec(p.direction, 0), axis, g)
    f_u = _by_velocity(g, slip)
    add_velocity_tangent(C, Rn, g.arm, f_u)
    by_speed = outer(slip.N * slip.b_u * slip.v_C, slip.ahead)
    add_columns(C, 0, Rn, EYE, by_speed, arm @ by_speed)
    f_x = _by_contact(g, slip, -g.n / g.q, by_x) + f_u @ (w @ by_x.arm)
    u_t = arm @ w + w @ by_t.arm
    f_t = _by_contact(g, slip, -g.r / g.q * cross(g.c, g.n), by_t) + f_u @ u_t
    add_position_tangent(K, Rn, g.arm, (by_x.arm, by_t.arm), slip.f, (f_x, f_t))


@kernel
def observe(p, at, F, y, e):
    """Outputs and energies; see OUTPUTS and the contract."""
    Rn = mat(at.R[0])
    axis, omega = Rn @ vec(p.axis, 0), Rn @ vec(at.v, 3)
    g = touch(p, at.laws, vec(at.q, 0), axis)
    arm = (g.r if at.phase == CONTACT else p.radius) * g.c
    slip = _slip(p, at.laws, g, vec(at.v, 0) + cross(omega, arm), vec(at.v, 0))
    friction = -slip.N * slip.b * slip.v_C
    lost = slip.N * slip.grip * norm(slip.v_C)
    grip = Grip(slip.F, friction, slip.grip, slip.v_C, lost, slip.w1)
    put_tire(p, at.laws, at.phase == CONTACT, g, axis, arm, dot(omega, axis), grip, at.q, y, e)


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
    force=force,
    observe=observe,
    event_values=event_values,
    sample=sample,
)
