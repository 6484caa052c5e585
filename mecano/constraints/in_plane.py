r"""In plane: :math:`\mu \cdot (x_1 - x_0) - f(t) = 0` for mu carried by the first node.

The multiplier is the force on the second node along mu; f(t) is a constant offset plus, where given, a law of time.
"""

from numba import njit

from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.carried import carried, product_rates
from mecano.constraints.slide import add_slide_curvature, slide_gradient
from mecano.constraints.target import TARGET, target
from mecano.contract import Kind, Row, record
from mecano.maths.vec import dot, mat, sub, tmul, vec

RECORD = record(mu=3, **TARGET)
MULTIPLIER = 9


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Forces on both nodes and the moment on the first."""
    mu, A = vec(p.mu, 0), mat(R[0])
    b_0, b_R, b_1 = slide_gradient(q, A, mu)
    Phi = dot(mu, tmul(A, sub(vec(q, 6), vec(q, 0)))) - target(p, laws, t)[0]
    g = add_constraint(f, K, MULTIPLIER, k, penalty, Phi, q[MULTIPLIER], ((0, b_0), (3, b_R), (6, b_1)))
    add_slide_curvature(K, g, q, A, mu)


@njit
def levels(p, m, mode, t, laws, q, v, a, R, g):
    """Value and rates, those of f(t) included."""
    mu = carried(mat(R[0]), vec(v, 3), vec(a, 3), vec(p.mu, 0))
    d = (sub(vec(q, 6), vec(q, 0)), sub(vec(v, 6), vec(v, 0)), sub(vec(a, 6), vec(a, 0)))
    y, y1, y2 = target(p, laws, t)
    Phi, rate, second = product_rates(mu, d)
    put_levels(g, 0, Phi - y, rate - y1, second - y2)


def sample(rng):
    """A plane through a point off the first node."""
    return [({"mu": rng.normal(size=3), "offset": rng.normal(), "law": 0}, 2, "")]


IN_PLANE = Kind(
    name="in_plane",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1"),
    multipliers=(Row("force that holds the node in a plane", "N", "m"),),
    force=force,
    levels=levels,
    sample=sample,
)
