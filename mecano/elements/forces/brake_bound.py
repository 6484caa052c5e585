r"""Bounds of the torque of a brake: a curve of the speed, the adhesion of the tyre under its load, the slip of the
wheel.

With the speed u of the wheel's centre over the ground, the radial force F_r and the loaded radius r of its tyre (of the
disc, without the lateral displacement of a patch), and the velocities v_x = v.t of the centre and Omega r of the rim:

    bound            B = B(u), or with ``adhesion`` mu_b: B = mu_b(u) F_r r, zero in the air
    slip ratio       kappa = (v_x - Omega r) v_x/(v_x^2 + v_0^2)
    anti-skid        factor 1 below the slip kappa_0, falling smoothly to 0 at kappa_0 + width

At speeds above v_0 the slip ratio is that of textbooks; it vanishes with the speed, so that a stopped wheel is held.
"""

from typing import NamedTuple

from mecano.constraints.ground import touch
from mecano.elements.wheels.tire_law import radial_force, speed_over_ground
from mecano.jit.kernel import kernel
from mecano.laws.table import curve
from mecano.maths.dual import at_least, at_most, constant, select
from mecano.maths.surface import directions
from mecano.maths.vector import cross, dot, mat, norm, vec

PLACE, SPIN = 3, 6  # local unknowns of the wheel's node in a brake
UNBOUNDED, BY_SPEED, BY_ADHESION = 0.0, 1.0, 2.0


class Bound(NamedTuple):
    """The bound of a brake."""

    B: float  # [N m]
    factor: float  # of the anti-skid
    slip: float  # slip ratio


@kernel
def bound_of(p, at):
    """Return the Bound of a brake with record ``p`` whose wheel's node has the rotation R[1]."""
    velocity = vec(at.v, PLACE)
    if p.watches == 0.0:
        B = curve(at.laws, p.bound, norm(velocity))
        return Bound(B, constant(1.0, B), constant(0.0, B))
    R = mat(at.R[1])
    axis, omega = R @ vec(p.axis, 0), R @ vec(at.v, SPIN)
    g = touch(p, at.laws, vec(at.q, PLACE), axis)
    r, u = at_most(g.r, p.radius), speed_over_ground(g.n, velocity)
    w1 = -dot(g.n, velocity + cross(omega, g.arm)) / g.q
    pressing = select(g.r < p.radius, radial_force(p, at.laws, p.radius - g.r, w1) * r, 0.0)
    pressing = select(p.bounded == BY_ADHESION, pressing, 1.0)
    slip = _slip_ratio(p, dot(directions(axis, g)[0], velocity), dot(omega, axis) * r)
    return Bound(curve(at.laws, p.bound, u) * pressing, _released(p, slip), slip)


@kernel
def _slip_ratio(p, forward, rim):
    """Return the slip ratio from the velocities [m/s] of the centre, forward, and of the rim."""
    return (forward - rim) * forward / (forward * forward + p.least_speed * p.least_speed)


@kernel
def _released(p, slip):
    """Return the factor of the anti-skid for a slip ratio."""
    width = select(p.slip_width > 0.0, p.slip_width, 1.0)
    x = at_most(at_least((slip - p.slip_start) / width, 0.0), select(p.slip_width > 0.0, 1.0, 0.0))
    return 1.0 - x * x * (3.0 - 2.0 * x)
