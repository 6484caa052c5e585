r"""Gear mesh: the pitch circles of two nodes roll on one another at a point that a third one, the carrier, shows.

With the angles :math:`\theta_1, \theta_2` of both gears relative to the carrier (the twist of carried.py), their
travels :math:`h_1, h_2` in metres per radian and the unit vector :math:`\tau`, carried by the carrier, tangential to
both circles:

.. math::  \Phi = h_1\theta_1 + h_2\theta_2 + \tau \cdot (x_1 - x_2) - c = 0

The last terms vanish where the carrier holds both centres; they let the multiplier be the force of the teeth on the
first gear along :math:`\tau`, on the second against it, each at the pitch point, and leave no moment on the carrier.
The angles are followed over whole turns by the memory of those of the last accepted step.
"""

from numba import njit

from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.carried import (
    add_blocks,
    carried,
    follow,
    product_rates,
    relative_rotation,
    twist,
    twist_curvature,
    twist_gradient,
)  # fmt: skip
from mecano.constraints.joint_frame import triad
from mecano.constraints.relative_angle import turning_levels
from mecano.contract import Kind, Row, record
from mecano.maths.vec import (
    add,
    add_mat,
    cross,
    dot,
    mat,
    matmul,
    mul,
    scale,
    skew,
    sub,
    tmul,
    transpose,
    vec,
)  # fmt: skip

MESH_RECORD = record(mu_1=(3, 3), xi_1=(3, 3), mu_2=(3, 3), xi_2=(3, 3), travel=2, tangent=3, offset=())
MULTIPLIER = 15


@njit
def gear_angles(p, m, R):
    """Angles of both gears relative to the carrier over any turns [rad]."""
    first = twist(relative_rotation(mat(R[0]), mat(R[1])), mat(p.mu_1), mat(p.xi_1))
    second = twist(relative_rotation(mat(R[0]), mat(R[2])), mat(p.mu_2), mat(p.xi_2))
    return follow(m[0], first), follow(m[1], second)


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Forces on both gears, moments on all three nodes."""
    A, tau = mat(R[0]), vec(p.tangent, 0)
    Q_1, Q_2 = relative_rotation(A, mat(R[1])), relative_rotation(A, mat(R[2]))
    mu_1, xi_1, mu_2, xi_2 = vec(p.mu_1[2], 0), vec(p.xi_1[2], 0), vec(p.mu_2[2], 0), vec(p.xi_2[2], 0)
    h_1, h_2, d, along = p.travel[0], p.travel[1], tmul(A, sub(vec(q, 3), vec(q, 9))), mul(A, tau)
    angle_1, angle_2 = gear_angles(p, m, R)
    Phi = h_1 * angle_1 + h_2 * angle_2 + dot(tau, d) - p.offset
    (c_1, b_1), (c_2, b_2) = twist_gradient(Q_1, mu_1, xi_1), twist_gradient(Q_2, mu_2, xi_2)
    b_0 = add(cross(tau, d), add(scale(h_1, c_1), scale(h_2, c_2)))
    blocks = ((0, b_0), (3, along), (6, scale(h_1, b_1)), (9, scale(-1.0, along)), (12, scale(h_2, b_2)))
    g = add_constraint(f, K, MULTIPLIER, k, penalty, Phi, q[MULTIPLIER], blocks)
    add_blocks(K, 0, 6, h_1 * g, twist_curvature(Q_1, mu_1, xi_1))
    add_blocks(K, 0, 12, h_2 * g, twist_curvature(Q_2, mu_2, xi_2))
    _add_tangent_curvature(K, g, A, tau, d)


@njit
def _add_tangent_curvature(K, g, A, tau, d):
    hat = skew(tau)
    turn, arm = matmul(A, hat), matmul(hat, transpose(A))
    add_mat(K, 3, 0, -g, turn)
    add_mat(K, 9, 0, g, turn)
    add_mat(K, 0, 3, g, arm)
    add_mat(K, 0, 9, -g, arm)
    add_mat(K, 0, 0, g, matmul(hat, skew(d)))


@njit
def levels(p, m, mode, t, laws, q, v, a, R, g):
    """Value and rates."""
    carrier = (mat(R[0]), vec(v, 0), vec(a, 0))
    first, second = (mat(R[1]), vec(v, 6), vec(a, 6)), (mat(R[2]), vec(v, 12), vec(a, 12))
    _, rate_1, second_1 = turning_levels(mat(p.mu_1), mat(p.xi_1), carrier, first)
    _, rate_2, second_2 = turning_levels(mat(p.mu_2), mat(p.xi_2), carrier, second)
    along = carried(carrier[0], carrier[1], carrier[2], vec(p.tangent, 0))
    d = (sub(vec(q, 3), vec(q, 9)), sub(vec(v, 3), vec(v, 9)), sub(vec(a, 3), vec(a, 9)))
    s, s_rate, s_second = product_rates(along, d)
    angle_1, angle_2 = gear_angles(p, m, R)
    h_1, h_2 = p.travel[0], p.travel[1]
    Phi = h_1 * angle_1 + h_2 * angle_2 + s - p.offset
    put_levels(g, 0, Phi, h_1 * rate_1 + h_2 * rate_2 + s_rate, h_1 * second_1 + h_2 * second_2 + s_second)


@njit
def commit(p, m, mode, t, laws, q, v, a, R, m_out):
    """Follow both angles over whole turns."""
    m_out[0], m_out[1] = gear_angles(p, m, R)


def sample(rng):
    """Axes in general position."""
    axes = {name: triad(rng.normal(size=3)) for name in ("mu_1", "xi_1", "mu_2", "xi_2")}
    return [({**axes, "travel": (0.6, -0.9), "tangent": triad(rng.normal(size=3))[0], "offset": rng.normal()}, 3, "")]


GEAR_MESH = Kind(
    name="gear_mesh",
    section="",
    doc=__doc__,
    dtype=MESH_RECORD,
    layout=("R0", "x1", "R1", "x2", "R2"),
    multipliers=(Row("force of the teeth", "N", "m"),),
    memory=("angle_1", "angle_2"),
    force=force,
    levels=levels,
    commit=commit,
    sample=sample,
)
