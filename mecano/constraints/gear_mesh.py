r"""Gear mesh: two pitch circles roll on one another at a pitch point defined by a third node, the carrier.

With the angles :math:`\theta_1, \theta_2` of both gears relative to the carrier (twist.py), their
travels :math:`h_1, h_2` in metres per radian and the unit vector :math:`\tau`, fixed in the carrier, tangential to
both circles:

.. math::  \Phi = h_1\theta_1 + h_2\theta_2 + \tau \cdot (x_1 - x_2) - c = 0

The last terms vanish where the carrier holds both centres. They make the multiplier the tooth force on the first gear
along :math:`\tau`, and on the second gear against it, each at the pitch point, without a moment on the carrier. The
angles are continued over whole turns with the memory of their values at the last accepted step; the whole turns are
added first (body_fixed.py). The tangent is written by hand: with dual numbers a step of the deck gears takes 7 % more
processor time.
"""

from typing import NamedTuple

from mecano.constraints.augmented_lagrangian import add_constraint
from mecano.constraints.body_fixed import add_blocks, whole_turns
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.constraints.coordinates.slide import add_slide_curvature, slide, slide_gradient
from mecano.constraints.coordinates.twist import twist, twist_curvature, twist_gradient
from mecano.element_interface import Kind, Row, named, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import mat, vec

MESH_RECORD = record(mu=(2, 3, 3), xi=(2, 3, 3), travel=2, tangent=3, offset=())
MULTIPLIER = 15


class Gear(NamedTuple):
    """A gear relative to the carrier."""

    Q: tuple  # its rotation (3, 3)
    turns: float  # whole turns [rad]
    angle: float  # within a turn [rad]
    by_carrier: tuple  # derivatives (3,) of the angle by the material rotations of both
    by_gear: tuple


@kernel
def gear(p, at, i):
    """Return the Gear of number i, 0 or 1."""
    Q, mu, xi = mat(at.R[0]).T @ mat(at.R[1 + i]), mat(p.mu[i]), mat(p.xi[i])
    angle, (by_carrier, by_gear) = twist(Q, mu, xi), twist_gradient(Q, mu[2], xi[2])
    return Gear(Q, whole_turns(at.m[i], angle), angle, by_carrier, by_gear)


@kernel
def _coupling(p, at):
    """Return both gears, the constraint [m] and its gradient."""
    a, b, h_1, h_2, tau = gear(p, at, 0), gear(p, at, 1), p.travel[0], p.travel[1], vec(p.tangent, 0)
    Phi = (h_1 * a.turns + h_2 * b.turns) + (h_1 * a.angle + h_2 * b.angle)
    Phi = Phi + slide(at, tau)[0] - p.offset
    back, (_, b_0), along = slide_gradient(at, tau)
    b_0 = b_0 + (h_1 * a.by_carrier + h_2 * b.by_carrier)
    return (a, b), Phi, (back, (3, b_0), along, (9, h_1 * a.by_gear), (12, h_2 * b.by_gear))


@kernel
def gear_travel(p, at):
    """Return the constraint [m] with its gradient, and the mean travel of both gears [m] with its gradient."""
    (a, b), Phi, gradient = _coupling(p, at)
    h_1, h_2 = 0.5 * p.travel[0], -0.5 * p.travel[1]
    mean = ((3, h_1 * a.by_carrier + h_2 * b.by_carrier), (9, h_1 * a.by_gear), (12, h_2 * b.by_gear))
    return (Phi, gradient), (h_1 * (a.turns + a.angle) + h_2 * (b.turns + b.angle), mean)


@kernel
def force(p, at, f, K, C, M):
    """Add forces to both gears, moments to all three nodes."""
    gears, Phi, gradient = _coupling(p, at)
    g = add_constraint(f, K, at, MULTIPLIER, Phi, gradient)
    for i in range(2):
        curvature = twist_curvature(gears[i].Q, vec(p.mu[i][2], 0), vec(p.xi[i][2], 0))
        add_blocks(K, 3, 9 + 3 * i, p.travel[i] * g, curvature)
    add_slide_curvature(K, g, at, vec(p.tangent, 0))


@kernel
def constraints(p, at, g):
    """Write value and rate."""
    _, Phi, gradient = _coupling(p, at)
    g[0, 0], g[0, 1] = Phi, rate_of(gradient, at.v)


@kernel
def commit(p, at, m_out):
    """Continue both angles over whole turns."""
    for i in range(2):
        now = gear(p, at, i)
        m_out[i] = now.turns + now.angle


GEAR_MESH = Kind(
    name="gear_mesh",
    doc=__doc__,
    dtype=MESH_RECORD,
    layout=("x2", "R0", "x1", "R1", "R2"),  # order as in slide.py: x1 relative to x2, along an axis of node 0
    multipliers=(Row("force of the teeth", "N", "m"),),
    memory=("angle_1", "angle_2"),
    **named(force, constraints, commit),
)
