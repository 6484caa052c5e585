r"""Upright rolling: the point vertically below the centre of a disc does not slip, however the disc leans.

As rolling.py, but with the contact always at x - radius n: the small-inclination equations (22) and (25) of Cardona,
Geradin & Doan 1991 taken literally. On a plane only.
"""

from mecano.constraints.no_slip import add_slip_reactions, leaning, on_a_plane, put_slip
from mecano.constraints.rolling import ROWS
from mecano.element_interface import Kind, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import vec

RECORD = record(axis=3, radius=(), normal=3)


@kernel
def residual(p, at, f):
    """Add tangential forces below the centre and their moment."""
    add_slip_reactions(at, -p.radius * vec(p.normal, 0), on_a_plane(p, at.R), f)


@kernel
def constraints(p, at, g):
    """Write the velocity of the point below the centre."""
    put_slip(at, -p.radius * vec(p.normal, 0), on_a_plane(p, at.R), g)


def sample(rng):
    """Return a leaning disc."""
    values, nodes = leaning(rng)
    return [({**values, "radius": 0.7}, nodes, "")]


UPRIGHT_ROLLING = Kind(
    name="upright_rolling",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    multipliers=ROWS,
    residual=residual,
    constraints=constraints,
    sample=sample,
)
