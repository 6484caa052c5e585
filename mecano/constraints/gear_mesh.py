r"""Gear mesh: two pitch circles roll on one another at a pitch point defined by a third node, the carrier.

With the angles :math:`\theta_1, \theta_2` of both gears relative to the carrier (twist.py), their
travels :math:`h_1, h_2` in metres per radian and the unit vector :math:`\tau`, fixed in the carrier, tangential to
both circles:

.. math::  \Phi = h_1\theta_1 + h_2\theta_2 + \tau \cdot (x_1 - x_2) - c = 0

The last terms vanish where the carrier holds both centres. They make the multiplier the tooth force on the first gear
along :math:`\tau`, and on the second gear against it, each at the pitch point, without a moment on the carrier. The
angles are continued over whole turns with the memory of their values at the last accepted step; the whole turns are
added first (body_fixed.py). The tangent is written by hand: with dual numbers the time integration of the deck gears
takes a third more processor time.
"""

from mecano.constraints.augmented_lagrangian import add_constraint
from mecano.constraints.body_fixed import add_blocks, relative_rotation, whole_turns
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.constraints.coordinates.slide import add_slide_curvature, slide, slide_gradient
from mecano.constraints.coordinates.twist import twist, twist_curvature, twist_gradient
from mecano.constraints.triads import triad
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import mat, vec

MESH_RECORD = record(mu_1=(3, 3), xi_1=(3, 3), mu_2=(3, 3), xi_2=(3, 3), travel=2, tangent=3, offset=())
MULTIPLIER = 15


@kernel
def _turned(p, m, R):
    """Return the whole turns of both gears relative to the carrier, and their angles within a turn [rad]."""
    first = twist(relative_rotation(mat(R[0]), mat(R[1])), mat(p.mu_1), mat(p.xi_1))
    second = twist(relative_rotation(mat(R[0]), mat(R[2])), mat(p.mu_2), mat(p.xi_2))
    return (whole_turns(m[0], first), whole_turns(m[1], second)), (first, second)


@kernel
def gear_angles(p, m, R):
    """Return the angles of both gears relative to the carrier, over any number of turns [rad]."""
    turns, angles = _turned(p, m, R)
    return turns[0] + angles[0], turns[1] + angles[1]


@kernel
def _coupling(p, at):
    """Return both relative rotations, the constraint [m] and its gradient."""
    A, tau = mat(at.R[0]), vec(p.tangent, 0)
    Q_1, Q_2 = relative_rotation(A, mat(at.R[1])), relative_rotation(A, mat(at.R[2]))
    h_1, h_2 = p.travel[0], p.travel[1]
    turns, angles = _turned(p, at.m, at.R)
    Phi = (h_1 * turns[0] + h_2 * turns[1]) + (h_1 * angles[0] + h_2 * angles[1])
    Phi = Phi + slide(at, tau)[0] - p.offset
    c_1, b_1 = twist_gradient(Q_1, vec(p.mu_1[2], 0), vec(p.xi_1[2], 0))
    c_2, b_2 = twist_gradient(Q_2, vec(p.mu_2[2], 0), vec(p.xi_2[2], 0))
    back, (_, b_0), along = slide_gradient(at, tau)
    b_0 = b_0 + (h_1 * c_1 + h_2 * c_2)
    return (Q_1, Q_2), Phi, (back, (3, b_0), along, (9, h_1 * b_1), (12, h_2 * b_2))


@kernel
def gear_travel(p, at):
    """Return the constraint [m] with its gradient, and the mean travel of both gears [m] with its gradient."""
    (Q_1, Q_2), Phi, gradient = _coupling(p, at)
    h_1, h_2 = 0.5 * p.travel[0], -0.5 * p.travel[1]
    angle_1, angle_2 = gear_angles(p, at.m, at.R)
    c_1, b_1 = twist_gradient(Q_1, vec(p.mu_1[2], 0), vec(p.xi_1[2], 0))
    c_2, b_2 = twist_gradient(Q_2, vec(p.mu_2[2], 0), vec(p.xi_2[2], 0))
    mean = ((3, h_1 * c_1 + h_2 * c_2), (9, h_1 * b_1), (12, h_2 * b_2))
    return (Phi, gradient), (h_1 * angle_1 + h_2 * angle_2, mean)


@kernel
def force(p, at, f, K, C, M):
    """Add forces to both gears, moments to all three nodes."""
    (Q_1, Q_2), Phi, gradient = _coupling(p, at)
    g = add_constraint(f, K, MULTIPLIER, at.k, at.penalty, Phi, at.q[MULTIPLIER], gradient)
    add_blocks(K, 3, 9, p.travel[0] * g, twist_curvature(Q_1, vec(p.mu_1[2], 0), vec(p.xi_1[2], 0)))
    add_blocks(K, 3, 12, p.travel[1] * g, twist_curvature(Q_2, vec(p.mu_2[2], 0), vec(p.xi_2[2], 0)))
    add_slide_curvature(K, g, at, vec(p.tangent, 0))


@kernel
def constraints(p, at, g):
    """Write value and rate."""
    _, Phi, gradient = _coupling(p, at)
    g[0, 0], g[0, 1] = Phi, rate_of(gradient, at.v)


@kernel
def commit(p, at, m_out):
    """Continue both angles over whole turns."""
    m_out[0], m_out[1] = gear_angles(p, at.m, at.R)


def sample(rng):
    """Return axes in general position."""
    axes = {name: triad(rng.normal(size=3)) for name in ("mu_1", "xi_1", "mu_2", "xi_2")}
    return [({**axes, "travel": (0.6, -0.9), "tangent": triad(rng.normal(size=3))[0], "offset": rng.normal()}, 3, "")]


GEAR_MESH = Kind(
    name="gear_mesh",
    doc=__doc__,
    dtype=MESH_RECORD,
    layout=("x2", "R0", "x1", "R1", "R2"),  # order as in slide.py: x1 relative to x2, along an axis of node 0
    multipliers=(Row("force of the teeth", "N", "m"),),
    memory=("angle_1", "angle_2"),
    force=force,
    constraints=constraints,
    commit=commit,
    sample=sample,
)
