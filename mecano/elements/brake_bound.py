r"""What bounds the torque of a brake: a curve of the speed, the grip of the tyre under its load, the slip of the wheel.

With the speed u of the wheel's centre over the ground, the radial force F_r and the loaded radius r of its tyre (of the
disc, without the lateral displacement of a patch), and the velocities v_x = v.t of the centre and Omega r of the rim:

    bound            B = B(u), or with ``adhesion`` mu_b: B = mu_b(u) F_r r, nothing in the air
    slip ratio       kappa = (v_x - Omega r) v_x/(v_x^2 + v_0^2)
    anti-skid        factor 1 below the slip kappa_0, falling without a corner to 0 at kappa_0 + width

The slip ratio is that of textbooks at speeds above v_0 and goes to zero with the speed, so a stopped wheel is held.
"""

from typing import NamedTuple

from mecano.compiled.kernel import kernel
from mecano.constraints.ground import touch
from mecano.elements.tire_law import radial_force, speed_over_ground
from mecano.laws.table import evaluate_curve
from mecano.maths.surface import directions, directions_variation, disc_variation
from mecano.maths.vector import NO_MATRIX, ZERO, cross, dot, mat, norm, skew, vec

PLACE, SPIN = 3, 6  # local unknowns of the wheel's node in a brake
UNBOUNDED, BY_SPEED, BY_ADHESION = 0.0, 1.0, 2.0


class Gradient(NamedTuple):
    """Derivatives (3,) by position and inertial rotation of the wheel's node, by its velocity and angular velocity."""

    x: tuple
    t: tuple
    v: tuple
    w: tuple


class Bound(NamedTuple):
    """The bound B [N m], the factor of the anti-skid, the slip ratio, and the gradients of the first two."""

    B: float
    B_by: Gradient
    factor: float
    factor_by: Gradient
    slip: float


NO_GRADIENT = Gradient(ZERO, ZERO, ZERO, ZERO)


@kernel
def scaled(s, by):
    """s times a Gradient."""
    return Gradient(s * by.x, s * by.t, s * by.v, s * by.w)


@kernel
def summed(a, b):
    """The sum of two Gradients."""
    return Gradient(a.x + b.x, a.t + b.t, a.v + b.v, a.w + b.w)


@kernel
def bound_of(p, laws, q, v, R):
    """The Bound of a brake of record ``p`` whose wheel's node has the rotation R[1]."""
    if p.watches == 0.0:
        if p.bounded == UNBOUNDED:
            return Bound(0.0, NO_GRADIENT, 1.0, NO_GRADIENT, 0.0)
        u = norm(vec(v, PLACE))
        B, B_u, _ = evaluate_curve(laws, p.bound, u)
        ahead = B_u / u * vec(v, PLACE) if u > 0.0 else ZERO
        return Bound(B, Gradient(ZERO, ZERO, ahead, ZERO), 1.0, NO_GRADIENT, 0.0)
    return _by_tire(p, laws, q, v, mat(R[1]))


@kernel
def _by_tire(p, laws, q, v, Rn):
    """The Bound of a brake that watches its wheel."""
    axis, velocity, omega = Rn @ vec(p.axis, 0), vec(v, PLACE), Rn @ vec(v, SPIN)
    g = touch(p, laws, vec(q, PLACE), axis)
    by_x, by_t = disc_variation(vec(p.direction, 0), axis, g)
    r, r_by = g.r, Gradient(g.n / g.q, cross(g.arm, g.n) / g.q, ZERO, ZERO)
    if r > p.radius:
        r, r_by = p.radius, NO_GRADIENT
    u, ahead = speed_over_ground(g.n, velocity)
    rise = -dot(g.n, velocity)
    u_by = Gradient(rise * (by_x.n.T @ ahead), rise * (by_t.n.T @ ahead), ahead, ZERO)
    B, B_by = 0.0, NO_GRADIENT
    if p.bounded == BY_SPEED:
        B, B_u, _ = evaluate_curve(laws, p.bound, u)
        B_by = scaled(B_u, u_by)
    if p.bounded == BY_ADHESION and g.r < p.radius:
        F, F_by = _pressing(p, laws, g, by_x, by_t, r_by, velocity, omega)
        grip, grip_u, _ = evaluate_curve(laws, p.bound, u)
        B = grip * F * r
        B_by = summed(scaled(grip_u * F * r, u_by), summed(scaled(grip * r, F_by), scaled(grip * F, r_by)))
    slip, slip_by = _slip_ratio(p, axis, g, (by_x, by_t), r, r_by, velocity, dot(omega, axis))
    factor, factor_slip = _released(p, slip)
    return Bound(B, B_by, factor, scaled(factor_slip, slip_by), slip)


@kernel
def _pressing(p, laws, g, by_x, by_t, r_by, velocity, omega):
    """Radial force [N] of the tyre in the Contact ``g``, and its Gradient."""
    at_rim, w = velocity + cross(omega, g.arm), skew(omega)
    w1 = -dot(g.n, at_rim) / g.q
    F, F_w, F_w1 = radial_force(p, laws, p.radius - g.r, w1)
    moved_x = w @ by_x.arm
    moved_t = skew(g.arm) @ w + w @ by_t.arm
    climb = Gradient(
        by_x.n.T @ at_rim + moved_x.T @ g.n, by_t.n.T @ at_rim + moved_t.T @ g.n, g.n,
        cross(g.arm, g.n),
    )  # fmt: skip
    lean = Gradient(by_x.s, by_t.s, ZERO, ZERO)
    w1_by = summed(scaled(-1.0 / g.q, climb), scaled(w1 * g.s / g.q**2, lean))
    return F, summed(scaled(-F_w, r_by), scaled(F_w1, w1_by))


@kernel
def _slip_ratio(p, axis, g, by, r, r_by, velocity, spin):
    """The slip ratio and its Gradient; ``spin`` [rad/s] of the wheel about its axis."""
    t, _ = directions(axis, g)
    t_x, _ = directions_variation(axis, g, t, by[0], NO_MATRIX)
    t_t, _ = directions_variation(axis, g, t, by[1], -skew(axis))
    forward, rim = dot(t, velocity), spin * r
    forward_by = Gradient(t_x.T @ velocity, t_t.T @ velocity, t, ZERO)
    rim_by = summed(scaled(spin, r_by), Gradient(ZERO, ZERO, ZERO, r * axis))
    size = forward * forward + p.least_speed * p.least_speed
    slip = (forward - rim) * forward / size
    by_forward = (2.0 * forward - rim - 2.0 * slip * forward) / size
    return slip, summed(scaled(by_forward, forward_by), scaled(-forward / size, rim_by))


@kernel
def _released(p, slip):
    """Factor of the anti-skid and its derivative by the slip ratio."""
    if p.slip_width == 0.0:
        return 1.0, 0.0
    x = (slip - p.slip_start) / p.slip_width
    if x <= 0.0:
        return 1.0, 0.0
    if x >= 1.0:
        return 0.0, 0.0
    return 1.0 - x * x * (3.0 - 2.0 * x), -6.0 * x * (1.0 - x) / p.slip_width
