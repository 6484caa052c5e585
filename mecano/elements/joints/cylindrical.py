r"""Cylindrical joint: node b slides along an axis fixed in node a and rotates about it.

With :math:`\mu_i` fixed in a and :math:`\xi_3` the axis fixed in b:

.. math::  \mu_i \cdot \xi_3 = 0, \qquad \mu_i \cdot (x_b - x_a) - c_i = 0, \qquad i = 1, 2

The constants c_i are the initial values: the axis passes through node b. The multipliers are the moments on b about
:math:`+\mu_2` and :math:`-\mu_1`, then the forces on b along :math:`\mu_1` and :math:`\mu_2`; these axes are chosen as
for the hinge, and the assembly rejects :math:`\xi_3 = -\mu_3`.

``latch`` and ``stops`` act on the sliding. ``friction`` is driven by the four multipliers. The outputs force and moment
include only what holds b; laws and friction have outputs of their own.
"""

from mecano.constraints.along_coordinate.friction import LENGTH, radius
from mecano.constraints.along_coordinate.measure import SLIDING, TURNING
from mecano.constraints.guide_friction import ROUND_FRICTION
from mecano.constraints.joint_options import SLIDE_ENDS, SLIDING_LAW, TURNING_LAW, friction_option
from mecano.constraints.joint_samples import AXIS_1, RUBBING, SLIDE_STOPPED, SPRUNG, STICKING, TURNING_SPRUNG
from mecano.element_interface import Display
from mecano.elements.joints.lower_pair import LowerPair, lower_pair
from mecano.schema import DIRECTION, Field

RADIUS = radius("radius", "radius at which turning slides", 0.0)


CYLINDRICAL = lower_pair(
    "cylindrical", __doc__,
    LowerPair(
        axis=Field("axis", DIRECTION, "-", "axis at the start, inertial; it goes through node b"),
        held=("about_2", "about_1", "along_1", "along_2"),
        display=Display(support=False, pictures=("angles", "slides"), force="force", along_axes=True),
        motions=(TURNING, SLIDING),
        options=(TURNING_LAW, SLIDING_LAW, SLIDE_ENDS, friction_option(ROUND_FRICTION, "about_axis", RADIUS, LENGTH)),
    ),
    cases=(
        {},
        SLIDE_STOPPED,
        {**TURNING_SPRUNG, "sliding_law": SPRUNG, "friction": {**RUBBING, "radius": 0.3}},
        {"friction": {**STICKING, "radius": 0.0}},
        {"axis_1": AXIS_1, "compliance": {"along_1": SPRUNG, "about_1": SPRUNG}},
    ),
)  # fmt: skip
