r"""Rolling: the point of a disc nearest to the ground does not slip.

:math:`u \cdot t = 0` and :math:`u \cdot l = 0` with u = v + omega x r c, the driving direction t = a x n/q and the
lateral direction l = n x t, all at the contact C of surface.py, at any inclination. The multipliers are the driving and
the lateral force on the disc, (22)-(24) of Cardona, Geradin & Doan 1991. They are inactive in the phase "air".
"""

from dataclasses import replace

from mecano.constraints.ground import GROUND_RECORD
from mecano.constraints.no_slip import no_slip
from mecano.constraints.rolling_radius import leaning_discs
from mecano.constraints.tread import flat_on_ground, rounded_on_ground
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.maths.surface import directions
from mecano.maths.vector import mat, vec

RECORD = record(axis=3, radius=(), **GROUND_RECORD)
ROWS = (Row("driving force of the ground", "N", "m/s"), Row("lateral force of the ground", "N", "m/s"))


def rolls_on(tread_on_ground):
    """Return the functions of the constraint for a tread of tread.py."""

    @kernel
    def contact(p, at):
        """Return the arm of the contact and the directions t and l."""
        axis = mat(at.R[0]) @ vec(p.axis, 0)
        g = tread_on_ground(p, at.laws, vec(at.q, 0), axis).g
        return g.arm, directions(axis, g)

    return no_slip(contact, len(ROWS))


ROLLING = Kind(
    name="rolling", doc=__doc__, dtype=RECORD, layout=("x0", "R0"),
    multipliers=ROWS,
    phases=("contact", "air"),
    **rolls_on(flat_on_ground),
    sample=leaning_discs,
)  # fmt: skip
ROUND_ROLLING = replace(ROLLING, name="rolling_crowned", **rolls_on(rounded_on_ground))
