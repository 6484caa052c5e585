r"""Hinge: node b rotates about an axis that it shares with node a.

Both nodes share one position (Boolean identification: no multiplier). With :math:`\mu_i` fixed in a, :math:`\mu_3`
along the axis, and :math:`\xi_3` the axis fixed in b (equations (11)-(17) of Cardona, Geradin & Doan 1991):

.. math::  \mu_1 \cdot \xi_3 = 0, \qquad \mu_2 \cdot \xi_3 = 0

The multiplier of the first is the moment on b about :math:`+\mu_2`, that of the second about :math:`-\mu_1`. Both
equations also hold for :math:`\xi_3 = -\mu_3`: the assembly rejects that solution. :math:`\mu_1` is ``axis_1``, or the
inertial axis initially most perpendicular to the axis, made perpendicular; :math:`\mu_2 = \mu_3 \times \mu_1`.

``friction`` and ``compliance`` need the reactions along all five axes: the joint then shares no unknowns but has one
multiplier, or the replacing law, for each axis. The outputs force and moment include only what holds b; law and
friction have outputs of their own.
"""

from mecano.constraints.along_coordinate.friction import LENGTH, radius
from mecano.constraints.along_coordinate.measure import TURNING
from mecano.constraints.hinge_friction import HINGE_FRICTION
from mecano.constraints.joint_nodes import check_one_place, one_position
from mecano.constraints.joint_options import ANGLE_ENDS, TURNING_LAW, friction_option
from mecano.constraints.joint_samples import AXIS_1, RUBBING, SPRUNG, STICKING, TURNING_SPRUNG
from mecano.constraints.pair import AXIS_B, bent_place
from mecano.constraints.release import SAMPLE
from mecano.element_interface import Display
from mecano.elements.joints.lower_pair import LowerPair, Shared, sharing_pair
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.vector import mat, put, vec
from mecano.schema import DIRECTION, Field

HELD = ("about_2", "about_1", "along_1", "along_2", "along_axis")
RADIUS = radius("radius", "radius of the bearing")
COLLAR = radius("collar_radius", "mean radius at which the axial force acts", 0.0)


@kernel
def _put_reactions(p, at, F, y, i):
    """Write the force on b that its shared position hides, and the moment of two multipliers."""
    put(y, i, -(mat(p.mu) @ (mat(at.R[0]).T @ vec(F, 6))))
    put(y, i + 3, (-number(at.q[13]), number(at.q[12]), 0.0))


RADII, SKEW = {"radius": 0.3, "collar_radius": 0.4}, {"axis": (1, 0, 0), "axis_b": (1, 0.1, 0)}  # of samples
STOPS = {"lower": -1.0, "upper": 2.0, "restitution": 0.4}
HINGE = sharing_pair(
    "hinge", __doc__,
    LowerPair(
        axis=Field("axis", DIRECTION, "-", "axis at the start, inertial"),
        held=HELD,
        display=Display(pictures=("angles",), force="force", along_axes=True),
        motions=(TURNING,),
        options=(TURNING_LAW, ANGLE_ENDS, friction_option(HINGE_FRICTION, "about_axis", RADIUS, COLLAR, LENGTH)),
        fields=(AXIS_B,),
        place=bent_place,
    ),
    Shared(one_position, ("about_2", "about_1"), _put_reactions, ("force",), check_one_place),
    cases=(
        {},
        *({**SKEW, "latch": {"angle": 1.5, "release": release}} for release in (None, SAMPLE["release"])),
        {**TURNING_SPRUNG, "friction": {**RUBBING, **RADII}},
        {**TURNING_SPRUNG, "natural_angle": "command"},
        {"friction": {**STICKING, **RADII}, "stops": STOPS, "lock": {"while": "time > 0.3"}},
        {"axis_1": AXIS_1, "turning_law": SPRUNG, "compliance": dict.fromkeys(HELD, SPRUNG)},
    ),
)  # fmt: skip
