r"""Rollers on the rim of a disc: the point nearest to the ground does not slip along the axis of the roller there.

:math:`u \cdot e = 0` with u = v + omega x r c and e = cos(gamma) l + sin(gamma) t, the directions t and l of rolling.py
at the contact and the angle gamma of the axis of a roller from that of the disc. The multiplier is the force on the
disc along e: a roller turns freely about its axis.
"""

import numpy as np

from mecano.constraints.ground import GROUND_RECORD, touch
from mecano.constraints.no_slip import no_slip
from mecano.constraints.rolling_radius import leaning_discs
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.maths.surface import directions
from mecano.maths.vector import mat, vec

RECORD = record(axis=3, radius=(), along=2, **GROUND_RECORD)


@kernel
def roller_axis(p, axis, g):
    """Return the direction e of the roller at the Contact ``g``; p.along is (sin gamma, cos gamma)."""
    t, l = directions(axis, g)
    return p.along[0] * t + p.along[1] * l


@kernel
def _contact(p, at):
    """Return the arm of the contact and the direction e."""
    axis = mat(at.R[0]) @ vec(p.axis, 0)
    g = touch(p, at.laws, vec(at.q, 0), axis)
    return g.arm, (roller_axis(p, axis, g),)


def sample(rng):
    """Return leaning discs with rollers at an angle."""
    found = []
    for values, nodes, _ in leaning_discs(rng):
        angle = rng.uniform(-1.5, 1.5)
        found.append(({**values, "along": np.array([np.sin(angle), np.cos(angle)])}, nodes, ""))
    return found


ROLLER = Kind(
    name="roller", doc=__doc__, dtype=RECORD, layout=("x0", "R0"),
    multipliers=(Row("force of the ground along the roller", "N", "m/s"),),
    **no_slip(_contact, 1),
    sample=sample,
)  # fmt: skip
