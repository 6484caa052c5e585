r"""Screw: node b rotates about an axis fixed in node a and advances along it by the pitch in every turn.

Node a is the nut and node b the screw, or the reverse: a cylindrical joint whose sliding s is coupled to its angle,
with the pitch P (> 0 for a right-handed thread):

.. math::  s - \frac{P}{2\pi}\,\theta = 0

The axis is that of a and passes through node b; the axes across it are chosen as for the hinge, and the assembly
rejects :math:`\xi_3 = -\mu_3`. The multipliers are those of the cylindrical joint, then the thrust F of the thread on b
along the axis; it is accompanied by the moment :math:`-P F/(2\pi)` about the axis.

``friction`` gives the thread an efficiency in each direction of the power, also one that locks itself; its force and
moment are added to the reactions. A ``latch`` and ``stops`` act at given displacements.
"""

import math
from dataclasses import replace

from mecano.constraints.along_coordinate.measure import REACTIONS, SLIDING, TURNING, Outputs, put_sliding
from mecano.constraints.body_fixed import follow
from mecano.constraints.coordinates.slide import slide
from mecano.constraints.coordinates.twist import turned
from mecano.constraints.geared_slide import GEARED_SLIDE
from mecano.constraints.joint_options import SLIDE_ENDS, TURNING_LAW, Option
from mecano.constraints.joint_samples import SLIDE_STOPPED, TURNING_SPRUNG
from mecano.constraints.of_coordinates import BOTH
from mecano.constraints.pair import AXES_FIELDS, FIRST_ROW, axis_place
from mecano.constraints.release import FIRST_ROW as FIRST_RELEASED
from mecano.constraints.thread_friction import THREAD_FRICTION, thread_friction_parts
from mecano.constraints.tooth_friction import FRICTION
from mecano.element_interface import Display, Part, record
from mecano.elements.joints.lower_pair import LowerPair, rigid_pair
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.vector import put, vec
from mecano.schema import DIRECTION, NUMBER, Field, requirement

HELD = "about_2", "about_1", "along_1", "along_2"


@kernel
def _put_motion(p, at, F, y, i):
    """Write rotation and sliding; the sliding determines the number of turns of the angle."""
    angle, y[i + 1] = turned(p, at)
    put_sliding(p, at, F, y, i + 2)
    along = slide(at, vec(p.mu[2], 0))[0]
    y[i] = follow((along - p.start[2]) / p.travel, angle)


def _reactions(first):
    """Return the Outputs of the reactions, whose multipliers begin at the local index ``first``."""

    @kernel
    def put_reactions(p, at, F, y, i):
        """Write the force, from three multipliers, and the moment, which includes that of the thread."""
        put(y, i, vec(at.q, first + 2))
        put(y, i + 3, (-number(at.q[first + 1]), number(at.q[first]), -p.travel * number(at.q[first + 4])))

    return Outputs(REACTIONS, put_reactions)


def _thread(d, p, context):
    axes = {"mu": p["mu"], "xi": p["xi"], "sigma": p["mu"][2]}
    thread = {**axes, "offset": p["start"][2], "travel": p["travel"]}
    return [Part(GEARED_SLIDE, BOTH, thread), *thread_friction_parts(d["friction"], thread, len(HELD))]


PAIR = LowerPair(
    axis=Field("axis", DIRECTION, "-", "axis at the start, inertial; it goes through node b"),
    held=HELD,
    display=Display(support=False, pictures=("gears",)),
    motions=(
        Outputs((*TURNING.declared, *SLIDING.declared), _put_motion, measures=TURNING.measures | SLIDING.measures),
    ),
    options=(Option((FRICTION,), _thread, (("friction", THREAD_FRICTION, ""),)), TURNING_LAW, SLIDE_ENDS),
    reactions=_reactions(FIRST_ROW),
    fields=(
        Field(
            "pitch", NUMBER, "m", "advance along the axis in one turn; > 0: right-handed",
            check=requirement(lambda pitch: pitch != 0.0, "must not be zero; without a pitch use a hinge"),
        ),
    ),
    record=record(travel=(), **AXES_FIELDS),
    place=lambda d, nodes, context: {**axis_place(d, nodes, context), "travel": d["pitch"] / (2.0 * math.pi)},
)  # fmt: skip
RELEASED = replace(PAIR, motions=(TURNING, SLIDING), reactions=_reactions(FIRST_RELEASED))
"""The row with a release, after which the sliding does not tell the number of turns."""
SCREW = rigid_pair(
    "screw", __doc__, replace(PAIR, released=RELEASED),
    cases=(
        {},
        {"pitch": -3.0, **TURNING_SPRUNG},
        SLIDE_STOPPED,
        {"friction": {"efficiency": 0.6, "backdriving_efficiency": -0.2, "regularization": 0.5}},
    ),
)  # fmt: skip
