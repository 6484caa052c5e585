r"""Rigid offset: :math:`x_1 - x_0 - R_0 d = 0`, for d carried by the first node.

Three rows in inertial axes; the multipliers are the force on the second node.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.augmented import put_levels
from mecano.constraints.carried import carried
from mecano.contract import Kind, Row, record
from mecano.maths.vec import (
    EYE,
    add_mat,
    add_vec,
    cross,
    madd,
    mat,
    matmul,
    mscale,
    mul,
    scale,
    skew,
    sub,
    tmul,
    transpose,
    vec,
)  # fmt: skip

RECORD = record(d=3)
MULTIPLIERS = 9


@kernel
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Forces on both nodes and the moment on the first."""
    d, A = vec(p.d, 0), mat(R[0])
    Phi = sub(sub(vec(q, 6), vec(q, 0)), mul(A, d))
    g = sub(scale(penalty, Phi), vec(q, MULTIPLIERS))
    g_body, hat_d = tmul(A, g), skew(d)
    add_vec(f, 0, -1.0, g)
    add_vec(f, 3, -1.0, cross(d, g_body))
    add_vec(f, 6, 1.0, g)
    add_vec(f, MULTIPLIERS, -k, Phi)
    _add_gradient(K, k, penalty, A, hat_d)
    add_mat(K, 3, 3, -1.0, matmul(hat_d, madd(skew(g_body), mscale(penalty, hat_d))))


@kernel
def _add_gradient(K, k, penalty, A, hat_d):
    """The blocks -k B^T, -k B and penalty B^T B but that of the rotation; B = (-I, A hat(d), I)."""
    turn, arm = matmul(A, hat_d), matmul(hat_d, transpose(A))
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
def levels(p, m, mode, t, laws, q, v, a, R, g):
    """Value and rates, inertial."""
    d = carried(mat(R[0]), vec(v, 3), vec(a, 3), vec(p.d, 0))
    Phi = sub(sub(vec(q, 6), vec(q, 0)), d[0])
    rate = sub(sub(vec(v, 6), vec(v, 0)), d[1])
    second = sub(sub(vec(a, 6), vec(a, 0)), d[2])
    for i in range(3):
        put_levels(g, i, Phi[i], rate[i], second[i])


def sample(rng):
    """A random offset."""
    return [({"d": rng.normal(size=3)}, 2, "")]


RIGID_OFFSET = Kind(
    name="rigid_offset",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1"),
    multipliers=tuple(Row(f"force {axis} of the rigid offset", "N", "m") for axis in "xyz"),
    force=force,
    levels=levels,
    sample=sample,
)
