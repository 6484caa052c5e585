r"""Orthogonal: :math:`\mu \cdot \xi = 0` for mu carried by the first node and xi by the second.

The multiplier is the moment on the second node about :math:`\xi \times \mu` (equations
(12)-(17) of Cardona, Geradin & Doan 1991).
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.carried import (
    add_blocks,
    carried,
    product_curvature,
    product_gradient,
    product_rates,
    relative_rotation,
)  # fmt: skip
from mecano.contract import Kind, Row, record
from mecano.maths.vector import dot, mat, vec

RECORD = record(mu=3, xi=3)
MULTIPLIER = 6


@kernel
def force(p, at, f, K, C, M):
    """Moments of the constraint."""
    mu, xi = vec(p.mu, 0), vec(p.xi, 0)
    A = relative_rotation(mat(at.R[0]), mat(at.R[1]))
    b_0, b_1 = product_gradient(A, mu, xi)
    Phi = dot(mu, A @ xi)
    g = add_constraint(f, K, MULTIPLIER, at.k, at.penalty, Phi, at.q[MULTIPLIER], ((0, b_0), (3, b_1)))
    add_blocks(K, 0, 3, g, product_curvature(A, mu, xi))


@kernel
def levels(p, at, g):
    """Value and rates of the product."""
    mu = carried(mat(at.R[0]), vec(at.v, 0), vec(at.a, 0), vec(p.mu, 0))
    xi = carried(mat(at.R[1]), vec(at.v, 3), vec(at.a, 3), vec(p.xi, 0))
    Phi, rate, second = product_rates(mu, xi)
    put_levels(g, 0, Phi, rate, second)


def sample(rng):
    """Two vectors, not of unit length."""
    return [({"mu": rng.normal(size=3), "xi": rng.normal(size=3)}, 2, "")]


ORTHOGONAL = Kind(
    name="orthogonal",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("R0", "R1"),
    multipliers=(Row("moment that keeps two axes perpendicular", "N m", "rad"),),
    force=force,
    levels=levels,
    sample=sample,
)
