r"""Couple: a moment between two nodes, such as that of a motor, about an axis fixed in the first.

With the unit axis s in the axes of node a and :math:`P = R_a^T R_b`, in material axes

.. math::  f_a = M s, \qquad f_b = -M P^T s

so that node b is turned about +axis and node a about -axis; the surroundings (the motor) supply the power
:math:`M\, \mu \cdot (\omega_b - \omega_a)`.
"""

from mecano.constraints.along_coordinate.demand import law_of, on_demand
from mecano.constraints.triads import carried_axis
from mecano.element_interface import Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import add_vec, dot, mat, vec
from mecano.schema import DIRECTION, DRIVE, NODE_PAIR, Field

RECORD = record(axis=3, law="i")


def _functions(demand):
    """Return ``residual`` and ``observe`` of a couple with this demanded moment."""

    @kernel
    def residual(p, at, f):
        size, s = demand(p, at), vec(p.axis, 0)
        add_vec(f, 0, size, s)
        add_vec(f, 3, -size, mat(at.R[1]).T @ (mat(at.R[0]) @ s))

    @kernel
    def observe(p, at, F, y, e):
        size, s = demand(p, at), vec(p.axis, 0)
        rate = dot(mat(at.R[1]).T @ (mat(at.R[0]) @ s), vec(at.v, 3)) - dot(s, vec(at.v, 0))
        y[0], y[1], y[2] = size, rate, size * rate
        e[3] = size * rate

    return named(residual, observe)


COUPLE = on_demand(
    Kind(
        name="couple", section="loads", doc=__doc__, dtype=RECORD, layout=("R0", "R1"),
        fields=(
            Field("nodes", NODE_PAIR, "-", "nodes a (in which the axis is fixed) and b; either may be ground"),
            Field("axis", DIRECTION, "-", "axis at the start, inertial"),
            Field("value", DRIVE, "N m", "moment on b about the axis, and on a against it"),
        ),
        outputs=(
            Output("moment", "N m", "moment on b about the axis"),
            Output("rate", "rad/s", "angular velocity of b relative to a about the axis"),
            Output("power", "W", "power given to both nodes"),
        ),
        prepare=lambda d, nodes, context: {"law": law_of(d["value"], context), "axis": carried_axis(d, nodes)},
        counts_angles=lambda d: [("axis", d["axis"], d["nodes"])],
    ),
    _functions, "value",
)  # fmt: skip
