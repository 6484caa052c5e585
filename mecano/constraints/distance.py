r"""Distance: :math:`|x_1 - x_0| - L - f(t) = 0`. The multiplier is the force that pushes the two nodes apart."""

from mecano.compiled.kernel import kernel
from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.target import TARGET, target
from mecano.contract import Kind, Row, record
from mecano.maths.vector import EYE, add_mat, dot, norm, outer, vec

RECORD = record(**TARGET)
MULTIPLIER = 6


@kernel
def force(p, at, f, K, C, M):
    """Forces along the line between the nodes."""
    d = vec(at.q, 3) - vec(at.q, 0)
    length = norm(d)
    n = d / length
    blocks = ((0, -n), (3, n))
    Phi = length - target(p, at.laws, at.t)[0]
    g = add_constraint(f, K, MULTIPLIER, at.k, at.penalty, Phi, at.q[MULTIPLIER], blocks)
    across = g / length * (EYE - outer(n, n))
    for i, s in ((0, -1.0), (3, 1.0)):
        for j, s_j in ((0, -1.0), (3, 1.0)):
            add_mat(K, i, j, s * s_j, across)


@kernel
def levels(p, at, g):
    """Value and rates of the length, those of f(t) included."""
    d, d1, d2 = vec(at.q, 3) - vec(at.q, 0), vec(at.v, 3) - vec(at.v, 0), vec(at.a, 3) - vec(at.a, 0)
    length = norm(d)
    rate = dot(d, d1) / length
    y, y1, y2 = target(p, at.laws, at.t)
    put_levels(g, 0, length - y, rate - y1, (dot(d1, d1) + dot(d, d2) - rate * rate) / length - y2)


def sample(rng):
    """A random length."""
    return [({"offset": rng.uniform(0.5, 2.0), "law": 0}, 2, "")]


DISTANCE = Kind(
    name="distance",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "x1"),
    multipliers=(Row("force that pushes the nodes apart", "N", "m"),),
    force=force,
    levels=levels,
    sample=sample,
)
