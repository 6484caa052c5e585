r"""Rolling: the point of a disc nearest to the ground does not slip.

:math:`u \cdot t = 0` and :math:`u \cdot l = 0` with u = v + omega x r c, the driving direction t = a x n/q and the
lateral direction l = n x t, all at the contact C of surface.py, at any inclination. The multipliers are the driving and
the lateral force on the disc, (22)-(24) of Cardona, Geradin & Doan 1991. They are inactive in the phase "air".
"""

from mecano.constraints.ground import GROUND_RECORD, touch
from mecano.constraints.no_slip import AIR, Direction, Place, deactivate, hold, put_rates
from mecano.constraints.rolling_radius import leaning_discs
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.maths.surface import directions, directions_variation, disc_variation
from mecano.maths.vector import NO_MATRIX, mat, skew, vec

RECORD = record(axis=3, radius=(), **GROUND_RECORD)
ROWS = (Row("driving force of the ground", "N", "m/s"), Row("lateral force of the ground", "N", "m/s"))


@kernel
def _geometry(p, laws, q, R):
    """Return the Place of the contact, and the Directions (t, l)."""
    axis = mat(R[0]) @ vec(p.axis, 0)
    g = touch(p, laws, vec(q, 0), axis)
    by_x, by_t = disc_variation(vec(p.direction, 0), axis, g)
    t, l = directions(axis, g)
    t_x, l_x = directions_variation(axis, g, t, by_x, NO_MATRIX)
    t_t, l_t = directions_variation(axis, g, t, by_t, -skew(axis))
    return Place(g.arm, (by_x.arm, by_t.arm)), (Direction(t, (t_x, t_t)), Direction(l, (l_x, l_t)))


@kernel
def force(p, at, f, K, C, M):
    """Add tangential forces at C and their moment."""
    if at.phase == AIR:
        deactivate(2, at.k, at.q, f, K)
        return
    place, along = _geometry(p, at.laws, at.q, at.R)
    hold(at.k, at.penalty, place, along, at.q, at.v, at.R, f, K, C)


@kernel
def constraint_derivatives(p, at, g):
    """Write the velocity of the contact and its rate."""
    if at.phase == AIR:
        g[:] = 0.0
        return
    place, along = _geometry(p, at.laws, at.q, at.R)
    put_rates(place, along, at.v, at.a, at.R, g)


ROLLING = Kind(
    name="rolling",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0"),
    multipliers=ROWS,
    phases=("contact", "air"),
    force=force,
    constraint_derivatives=constraint_derivatives,
    sample=leaning_discs,
)
