r"""Planar joint: node b slides in a plane fixed in node a and rotates about its normal.

With :math:`\mu_3` the normal fixed in a and :math:`\xi_3` the one fixed in b:

.. math::  \mu_1 \cdot \xi_3 = 0, \qquad \mu_2 \cdot \xi_3 = 0, \qquad \mu_3 \cdot (x_b - x_a) - c = 0

The constant c is the initial value: the plane passes through node b. The multipliers are the moments on b about
:math:`+\mu_2` and :math:`-\mu_1`, then the force on b along the normal, of either sign: b cannot leave the plane. The
axes in the plane are chosen as for the hinge, and the assembly rejects :math:`\xi_3 = -\mu_3`.
"""

from dataclasses import replace

from mecano.constraints.along_coordinate.measure import MOMENT, TURNING, Outputs, translation
from mecano.constraints.joint_options import TURNING_LAW
from mecano.constraints.joint_samples import AXIS_1, TURNING_SPRUNG
from mecano.constraints.pair import FIRST_ROW
from mecano.constraints.release import FIRST_ROW as FIRST_RELEASED
from mecano.element_interface import Display, Output
from mecano.elements.joints.lower_pair import LowerPair, rigid_pair
from mecano.jit.kernel import kernel
from mecano.maths.vector import put
from mecano.schema import DIRECTION, Field


def _reactions(first):
    """Return the Outputs of the reactions, whose multipliers begin at the local index ``first``."""

    @kernel
    def put_reactions(p, at, F, y, i):
        """Write the force of one multiplier, the moment of the other two."""
        y[i] = at.q[first + 2]
        put(y, i + 1, (-at.q[first + 1], at.q[first], 0.0))

    return Outputs((Output("force", "N", "force of a on b along the normal"), MOMENT), put_reactions)


PAIR = LowerPair(
    axis=Field("axis", DIRECTION, "-", "normal of the plane at the start, inertial; carried by a"),
    held=("about_2", "about_1", "along_axis"),
    display=Display(support=False, pictures=("planes",)),
    motions=(translation("mu_1, mu_2 and the normal"), TURNING),
    options=(TURNING_LAW,),
    reactions=_reactions(FIRST_ROW),
)
PLANAR = rigid_pair(
    "planar", __doc__, replace(PAIR, released=replace(PAIR, reactions=_reactions(FIRST_RELEASED))),
    cases=({}, {"axis_1": AXIS_1, **TURNING_SPRUNG}),
)  # fmt: skip
