r"""Relative angle: angle of the second node about an axis, relative to the first, equal to f(t).

Axes mu are carried by the first node, xi by the second. The angle is the rotation about :math:`\mu_3` as long as both
nodes share it, and else that part of the relative rotation which is twist (see carried.py). Its difference to f(t) is
brought to :math:`(-\pi, \pi]`, so that any number of turns needs no memory. The multiplier is the moment on the second
node about :math:`\mu_3`.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.carried import (
    add_blocks,
    carried,
    product_rates,
    relative_rotation,
    twist,
    twist_curvature,
    twist_gradient,
    wrap,
)  # fmt: skip
from mecano.constraints.joint_frame import triad
from mecano.constraints.target import TARGET, target
from mecano.contract import Kind, Row, record
from mecano.maths.vector import dot, mat, vec

RECORD = record(mu=(3, 3), xi=(3, 3), **TARGET)
MULTIPLIER = 6


@kernel
def hold_angle(sign, mu, xi, wanted, k, penalty, q, R, f, K):
    """Add the constraint sign (angle - wanted) = 0."""
    A = relative_rotation(mat(R[0]), mat(R[1]))
    Phi = sign * wrap(twist(A, mu, xi) - wanted)
    b_0, b_1 = twist_gradient(A, mu[2], xi[2])
    blocks = ((0, sign * b_0), (3, sign * b_1))
    g = add_constraint(f, K, MULTIPLIER, k, penalty, Phi, q[MULTIPLIER], blocks)
    add_blocks(K, 0, 3, sign * g, twist_curvature(A, mu[2], xi[2]))


@kernel
def turning_levels(mu, xi, first, second):
    """The angle of ``twist`` [rad] and its two rates; of each node (R, omega, alpha), the latter two material."""
    mu_3, xi_3 = carried(first[0], first[1], first[2], mu[2]), carried(second[0], second[1], second[2], xi[2])
    spin = second[0] @ second[1] - first[0] @ first[1]
    spin_rate = second[0] @ second[2] - first[0] @ first[2]
    cosine, cosine_rate, _ = product_rates(mu_3, xi_3)
    G = (mu_3[0] + xi_3[0]) / (1.0 + cosine)
    G_rate = (mu_3[1] + xi_3[1] - cosine_rate * G) / (1.0 + cosine)
    return twist(relative_rotation(first[0], second[0]), mu, xi), dot(G, spin), dot(G_rate, spin) + dot(G, spin_rate)


@kernel
def angle_levels(sign, mu, xi, wanted, v, a, R, g):
    """Write the levels of that constraint; ``wanted`` with its two rates."""
    nodes = (mat(R[0]), vec(v, 0), vec(a, 0)), (mat(R[1]), vec(v, 3), vec(a, 3))
    angle, rate, second = turning_levels(mu, xi, nodes[0], nodes[1])
    put_levels(g, 0, sign * wrap(angle - wanted[0]), sign * (rate - wanted[1]), sign * (second - wanted[2]))


@kernel
def force(p, at, f, K, C, M):
    """Moments on both nodes."""
    hold_angle(1.0, mat(p.mu), mat(p.xi), target(p, at.laws, at.t)[0], at.k, at.penalty, at.q, at.R, f, K)


@kernel
def levels(p, at, g):
    """Value and rates, those of f(t) included."""
    angle_levels(1.0, mat(p.mu), mat(p.xi), target(p, at.laws, at.t), at.v, at.a, at.R, g)


def sample(rng):
    """Axes in general position."""
    mu, xi = triad(rng.normal(size=3)), triad(rng.normal(size=3))
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
