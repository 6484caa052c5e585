r"""Held coordinate: :math:`n \cdot (x - o) - f(t) = 0` for an inertial direction n and a point o.

The multiplier is the force on the node along n.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.target import TARGET, target
from mecano.contract import Kind, Row, record
from mecano.maths.vec import dot, sub, vec

RECORD = record(direction=3, origin=3, **TARGET)
MULTIPLIER = 3


@kernel
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Force along the direction."""
    n = vec(p.direction, 0)
    Phi = dot(n, sub(vec(q, 0), vec(p.origin, 0))) - target(p, laws, t)[0]
    add_constraint(f, K, MULTIPLIER, k, penalty, Phi, q[MULTIPLIER], ((0, n),))


@kernel
def levels(p, m, mode, t, laws, q, v, a, R, g):
    """Value and rates, those of f(t) included."""
    n = vec(p.direction, 0)
    y, y1, y2 = target(p, laws, t)
    Phi = dot(n, sub(vec(q, 0), vec(p.origin, 0))) - y
    put_levels(g, 0, Phi, dot(n, vec(v, 0)) - y1, dot(n, vec(a, 0)) - y2)


def sample(rng):
    """A random direction and origin."""
    return [({"direction": rng.normal(size=3), "origin": rng.normal(size=3), "offset": rng.normal(), "law": 0}, 1, "")]


HELD_COORDINATE = Kind(
    name="held_coordinate",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0",),
    multipliers=(Row("force that prescribes the position", "N", "m"),),
    force=force,
    levels=levels,
    sample=sample,
)
