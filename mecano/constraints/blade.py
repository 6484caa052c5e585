r"""Blade: a point of a body on the ground does not move across a direction fixed in the body.

:math:`v \cdot l = 0` with l = (a - s n)/q, the axis a of the body projected onto the plane of the ground. The point is
the node. The multiplier is the force on the body along l.
"""

from mecano.constraints.no_slip import add_slip_reactions, leaning, on_a_plane, put_slip
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import ZERO

RECORD = record(axis=3, normal=3)


@kernel
def residual(p, at, f):
    """Add the force across the blade."""
    add_slip_reactions(at, ZERO, on_a_plane(p, at.R)[1:], f)


@kernel
def constraints(p, at, g):
    """Write the velocity across the blade."""
    put_slip(at, ZERO, on_a_plane(p, at.R)[1:], g)


def sample(rng):
    """Return a leaning blade."""
    return [(*leaning(rng), "")]


BLADE = Kind(
    name="blade",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    multipliers=(Row("force across the blade", "N", "m/s"),),
    residual=residual,
    constraints=constraints,
    sample=sample,
)
