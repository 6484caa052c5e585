r"""Upright rolling: the point vertically below the centre of a disc does not slip, however the disc leans.

As rolling.py, but with the contact always at x - radius n: the small-inclination equations (22) and (25) of Cardona,
Geradin & Doan 1991 taken literally. On a plane only.
"""

from mecano.constraints.no_slip import Place, hold, leaning, on_a_plane, put_rates
from mecano.constraints.rolling import ROWS
from mecano.element_interface import Kind, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import NO_MATRIX, vec

RECORD = record(axis=3, radius=(), normal=3)


@kernel
def _below_the_centre(p):
    return Place(-p.radius * vec(p.normal, 0), (NO_MATRIX, NO_MATRIX))


@kernel
def force(p, at, f, K, C, M):
    """Add tangential forces below the centre and their moment."""
    hold(at.k, at.penalty, _below_the_centre(p), on_a_plane(p, at.R), at.q, at.v, at.R, f, K, C)


@kernel
def constraint_derivatives(p, at, g):
    """Write the velocity of the point below the centre and its rate."""
    put_rates(_below_the_centre(p), on_a_plane(p, at.R), at.v, at.a, at.R, g)


def sample(rng):
    """Return a leaning disc."""
    values, nodes = leaning(rng)
    return [({**values, "radius": 0.7}, nodes, "")]


UPRIGHT_ROLLING = Kind(
    name="upright_rolling",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    multipliers=ROWS,
    force=force,
    constraint_derivatives=constraint_derivatives,
    sample=sample,
)
