r"""Relative angle: angle of the second node about an axis, relative to the first, equal to f(t).

Axes mu are carried by the first node, xi by the second. The angle is the rotation about :math:`\mu_3` as long as both
nodes share it, and else that part of the relative rotation which is twist (see carried.py). Its difference to f(t) is
brought to :math:`(-\pi, \pi]`, so that any number of turns needs no memory. The multiplier is the moment on the second
node about :math:`\mu_3`.
"""

from numba import njit

from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.carried import (
    add_twist_curvature,
    carried,
    relative_rotation,
    twist,
    twist_gradient,
    twist_rates,
    wrap,
)  # fmt: skip
from mecano.constraints.target import TARGET, target
from mecano.contract import Kind, Row, record
from mecano.maths.vec import mat, vec

RECORD = record(mu=(3, 3), xi=(3, 3), **TARGET)
MULTIPLIER = 6


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Moments on both nodes."""
    xi = mat(p.xi)
    A = relative_rotation(mat(R[0]), mat(R[1]))
    angle, c, h = twist(A, mat(p.mu), xi)
    b, _ = twist_gradient(A, c, h, xi)
    Phi = wrap(angle - target(p, laws, t)[0])
    g = add_constraint(f, K, MULTIPLIER, k, penalty, Phi, q[MULTIPLIER], ((0, b[0]), (3, b[1])))
    add_twist_curvature(K, g, A, c, h, xi)


@njit
def levels(p, m, mode, t, laws, q, v, a, R, g):
    """Value and rates, those of f(t) included."""
    R_0, omega_0, alpha_0 = mat(R[0]), vec(v, 0), vec(a, 0)
    R_1, omega_1, alpha_1 = mat(R[1]), vec(v, 3), vec(a, 3)
    mu_1, mu_2 = carried(R_0, omega_0, alpha_0, vec(p.mu[0], 0)), carried(R_0, omega_0, alpha_0, vec(p.mu[1], 0))
    xi_1, xi_2 = carried(R_1, omega_1, alpha_1, vec(p.xi[0], 0)), carried(R_1, omega_1, alpha_1, vec(p.xi[1], 0))
    angle, rate, second = twist_rates(mu_1, mu_2, xi_1, xi_2)
    y, y1, y2 = target(p, laws, t)
    put_levels(g, 0, wrap(angle - y), rate - y1, second - y2)


def sample(rng):
    """Axes in general position: nothing is perpendicular or of unit length."""
    mu, xi = rng.normal(size=(2, 3, 3))
    return [({"mu": mu, "xi": xi, "offset": rng.normal(), "law": 0}, 2, "")]


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
