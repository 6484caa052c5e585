r"""Relative angle: angle of the second node about an axis, relative to the first, equal to f(t).

The angle is that of xi (carried by the second node) from mu_1 towards mu_2 (carried by the first), which is the
rotation about the axis as long as both nodes share it. Its difference to f(t) is brought to :math:`(-\pi, \pi]`, so
that any number of turns needs no memory. The multiplier is the moment on the second node about
:math:`\mu_1 \times \mu_2`.
"""

from numba import njit

from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.carried import (
    add_angle_curvature,
    angle_gradient,
    angle_rates,
    carried,
    product_gradient,
    relative_rotation,
    wrap,
)  # fmt: skip
from mecano.constraints.target import TARGET, target
from mecano.contract import Kind, Row, record
from mecano.maths.vec import mat, vec

RECORD = record(mu_1=3, mu_2=3, xi=3, **TARGET)
MULTIPLIER = 6


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Moments on both nodes."""
    xi = vec(p.xi, 0)
    A = relative_rotation(mat(R[0]), mat(R[1]))
    angle, c, c_h = angle_gradient(A, vec(p.mu_1, 0), vec(p.mu_2, 0), xi)
    b_0, b_1 = product_gradient(A, c, xi)
    Phi = wrap(angle - target(p, laws, t)[0])
    g = add_constraint(f, K, MULTIPLIER, k, penalty, Phi, q[MULTIPLIER], ((0, b_0), (3, b_1)))
    add_angle_curvature(K, 0, 3, g, A, c, c_h, xi)


@njit
def levels(p, m, mode, t, laws, q, v, a, R, g):
    """Value and rates, those of f(t) included."""
    R_0, omega, alpha = mat(R[0]), vec(v, 0), vec(a, 0)
    mu_1, mu_2 = carried(R_0, omega, alpha, vec(p.mu_1, 0)), carried(R_0, omega, alpha, vec(p.mu_2, 0))
    xi = carried(mat(R[1]), vec(v, 3), vec(a, 3), vec(p.xi, 0))
    angle, rate, second = angle_rates(mu_1, mu_2, xi)
    y, y1, y2 = target(p, laws, t)
    put_levels(g, 0, wrap(angle - y), rate - y1, second - y2)


def sample(rng):
    """Vectors in general position: nothing is perpendicular or of unit length."""
    vectors = {name: rng.normal(size=3) for name in ("mu_1", "mu_2", "xi")}
    return [({**vectors, "offset": rng.normal(), "law": 0}, 2, "")]


RELATIVE_ANGLE = Kind(
    name="relative_angle",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("R0", "R1"),
    multipliers=(Row("moment that holds the angle", "N m", "rad"),),
    force=force,
    levels=levels,
    sample=sample,
)
