r"""Prismatic joint: node b slides along an axis fixed in node a and does not rotate relative to it.

Both nodes share one rotation (Boolean identification); nodes with different orientations at the start keep their
relative rotation, each axis by a multiplier. With :math:`\mu_1, \mu_2` fixed in a and perpendicular to the axis:

.. math::  \mu_i \cdot (x_b - x_a) - c_i = 0, \qquad i = 1, 2

The constants c_i are the initial values: the line of sliding passes through node b. The multipliers are the forces on
b along :math:`\mu_1` and :math:`\mu_2`, which are chosen as for the hinge; the moments follow from the balance of b.

``friction`` and ``compliance`` need the reactions along all five axes: the joint then shares no unknowns but has one
multiplier, or the replacing law, for each axis. The outputs force and moment include only what holds b; law and
friction have outputs of their own.
"""

from mecano.constraints.along_coordinate.friction import LENGTH
from mecano.constraints.along_coordinate.measure import SLIDING
from mecano.constraints.guide_friction import KEYED_FRICTION
from mecano.constraints.joint_nodes import one_rotation, turned_apart
from mecano.constraints.joint_options import SLIDE_ENDS, SLIDING_LAW, friction_option
from mecano.constraints.joint_samples import AXIS_1, RUBBING, SLIDE_STOPPED, SPRUNG, STICKING
from mecano.element_interface import Display
from mecano.elements.joints.lower_pair import LowerPair, Shared, sharing_pair
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.vector import mat, put, vec
from mecano.schema import DIRECTION, NUMBER, Field, positive

HELD = ("about_2", "about_1", "about_axis", "along_1", "along_2")
KEY_RADIUS = Field(
    "key_radius", NUMBER, "m",
    "radius at which a key holds the moment about the axis; when absent that moment causes no friction", None, positive,
)  # fmt: skip


@kernel
def _put_reactions(p, at, F, y, i):
    """Write the force of two multipliers, and the moment on b that its shared rotation hides."""
    put(y, i, (number(at.q[12]), number(at.q[13]), 0.0))
    put(y, i + 3, -(mat(p.mu) @ vec(F, 9)))


PRISMATIC = sharing_pair(
    "prismatic", __doc__,
    LowerPair(
        axis=Field("axis", DIRECTION, "-", "direction of sliding at the start, inertial; carried by a"),
        held=HELD,
        display=Display(support=False, pictures=("slides",), force="force", along_axes=True),
        motions=(SLIDING,),
        options=(SLIDING_LAW, SLIDE_ENDS, friction_option(KEYED_FRICTION, "along_axis", LENGTH, KEY_RADIUS)),
    ),
    Shared(one_rotation, ("along_1", "along_2"), _put_reactions, ("moment",), apart=turned_apart),
    cases=(
        {},
        {"sliding_law": SPRUNG, "natural_displacement": 0.2, "friction": {**RUBBING, "key_radius": 0.3}},
        {"friction": {**STICKING, "key_radius": None}},
        SLIDE_STOPPED,
        {"axis_1": AXIS_1, "compliance": dict.fromkeys(HELD, SPRUNG)},
    ),
)  # fmt: skip
