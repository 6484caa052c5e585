r"""Blade: a point of a body that touches the ground does not move across a direction carried by the body.

:math:`v \cdot l = 0` with l = (a - s n)/q, the axis a of the body laid into the plane of the ground. The point is the
node. The multiplier is the force on the body along l.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.no_slip import NO_MATRIX, Place, hold, leaning, on_a_plane, put_rates
from mecano.contract import Kind, Row, record
from mecano.maths.vec import ZERO

RECORD = record(axis=3, normal=3)
AT_THE_NODE = Place(ZERO, (NO_MATRIX, NO_MATRIX))


@kernel
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Force across the blade."""
    hold(k, penalty, AT_THE_NODE, on_a_plane(p, R)[1:], q, v, R, f, K, C)


@kernel
def levels(p, m, mode, t, laws, q, v, a, R, g):
    """Velocity across the blade and its rate."""
    put_rates(AT_THE_NODE, on_a_plane(p, R)[1:], v, a, R, g)


def sample(rng):
    """A leaning blade."""
    return [(*leaning(rng), "")]


BLADE = Kind(
    name="blade",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    multipliers=(Row("force across the blade", "N", "m/s"),),
    force=force,
    levels=levels,
    sample=sample,
)
