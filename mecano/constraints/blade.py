r"""Blade: a point of a body on the ground does not move across a direction fixed in the body.

:math:`v \cdot l = 0` with l = (a - s n)/q, the axis a of the body projected onto the plane of the ground. The point is
the node. The multiplier is the force on the body along l.
"""

from mecano.constraints.no_slip import Place, hold, leaning, on_a_plane, put_rates
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import NO_MATRIX, ZERO

RECORD = record(axis=3, normal=3)
AT_THE_NODE = Place(ZERO, (NO_MATRIX, NO_MATRIX))


@kernel
def force(p, at, f, K, C, M):
    """Add the force across the blade."""
    hold(at.k, at.penalty, AT_THE_NODE, on_a_plane(p, at.R)[1:], at.q, at.v, at.R, f, K, C)


@kernel
def constraint_derivatives(p, at, g):
    """Write the velocity across the blade and its rate."""
    put_rates(AT_THE_NODE, on_a_plane(p, at.R)[1:], at.v, at.a, at.R, g)


def sample(rng):
    """Return a leaning blade."""
    return [(*leaning(rng), "")]


BLADE = Kind(
    name="blade",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    multipliers=(Row("force across the blade", "N", "m/s"),),
    force=force,
    constraint_derivatives=constraint_derivatives,
    sample=sample,
)
