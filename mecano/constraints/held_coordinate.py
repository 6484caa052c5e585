r"""Held coordinate: :math:`n \cdot (x - o) - f(t) = 0` for an inertial direction n and a point o.

The multiplier is the force on the node along n.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.target import TARGET, target
from mecano.contract import Kind, Row, record
from mecano.maths.vector import dot, vec

RECORD = record(direction=3, origin=3, **TARGET)
MULTIPLIER = 3


@kernel
def force(p, at, f, K, C, M):
    """Force along the direction."""
    n = vec(p.direction, 0)
    Phi = dot(n, vec(at.q, 0) - vec(p.origin, 0)) - target(p, at.laws, at.t)[0]
    add_constraint(f, K, MULTIPLIER, at.k, at.penalty, Phi, at.q[MULTIPLIER], ((0, n),))


@kernel
def levels(p, at, g):
    """Value and rates, those of f(t) included."""
    n = vec(p.direction, 0)
    y, y1, y2 = target(p, at.laws, at.t)
    Phi = dot(n, vec(at.q, 0) - vec(p.origin, 0)) - y
    put_levels(g, 0, Phi, dot(n, vec(at.v, 0)) - y1, dot(n, vec(at.a, 0)) - y2)


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
