r"""Rigid offset: :math:`x_1 - x_0 - R_0 d = 0`, for d fixed in the first node.

Three rows in inertial axes; the multipliers are the force on the second node. The tangent is written by hand: with dual
numbers a step of the deck stewart takes 1 % more processor time, and compiling 7 % more.
"""

from mecano.element_interface import Kind, Row, named, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import EYE, add_mat, add_vec, cross, mat, skew, vec

RECORD = record(d=3)
MULTIPLIERS = 9


@kernel
def force(p, at, f, K, C, M):
    """Add forces to both nodes and the moment to the first."""
    d, A = vec(p.d, 0), mat(at.R[0])
    Phi = vec(at.q, 6) - vec(at.q, 0) - A @ d
    g = at.penalty * Phi - vec(at.q, MULTIPLIERS)
    g_body, hat_d = A.T @ g, skew(d)
    add_vec(f, 0, -1.0, g)
    add_vec(f, 3, -1.0, cross(d, g_body))
    add_vec(f, 6, 1.0, g)
    add_vec(f, MULTIPLIERS, -at.k, Phi)
    _add_gradient(K, at.k, at.penalty, A, hat_d)
    add_mat(K, 3, 3, -1.0, hat_d @ (skew(g_body) + at.penalty * hat_d))


@kernel
def _add_gradient(K, k, penalty, A, hat_d):
    """Add -k B^T, -k B and penalty B^T B, except its rotation block; B = (-I, A hat(d), I)."""
    turn, arm = A @ hat_d, hat_d @ A.T
    for i, s in ((0, -1.0), (6, 1.0)):
        add_mat(K, i, MULTIPLIERS, -k * s, EYE)
        add_mat(K, MULTIPLIERS, i, -k * s, EYE)
        add_mat(K, i, 3, penalty * s, turn)
        add_mat(K, 3, i, -penalty * s, arm)
        for j, s_j in ((0, -1.0), (6, 1.0)):
            add_mat(K, i, j, penalty * s * s_j, EYE)
    add_mat(K, 3, MULTIPLIERS, k, arm)
    add_mat(K, MULTIPLIERS, 3, -k, turn)


@kernel
def constraints(p, at, g):
    """Write value and rate, inertial."""
    R, d = mat(at.R[0]), vec(p.d, 0)
    Phi = vec(at.q, 6) - vec(at.q, 0) - R @ d
    rate = vec(at.v, 6) - vec(at.v, 0) - R @ cross(vec(at.v, 3), d)
    for i in range(3):
        g[i, 0], g[i, 1] = Phi[i], rate[i]


RIGID_OFFSET = Kind(
    name="rigid_offset", doc=__doc__, dtype=RECORD, layout=("x0", "R0", "x1"),
    multipliers=tuple(Row(f"force {axis} of the rigid offset", "N", "m") for axis in "xyz"),
    **named(force, constraints),
)  # fmt: skip
