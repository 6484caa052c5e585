r"""Screw: node b rotates about an axis fixed in node a and advances along it by the pitch in every turn.

A cylindrical joint whose sliding s is coupled to its angle, with the pitch P (> 0 for a right-handed thread):

.. math::  s - \frac{P}{2\pi}\,\theta = 0

The axis is that of a and passes through node b; the axes across it are chosen as for the hinge, and the assembly
rejects :math:`\xi_3 = -\mu_3`. The multipliers are those of the cylindrical joint, then the thrust F of the thread on b
along the axis; it is accompanied by the moment :math:`-P F/(2\pi)` about the axis, since the thread has no friction.

Options: ``turning_law`` gives a moment about the axis from the angle and its rate; a ``latch`` and
``stops`` act at given displacements (docs/shocks.md).
"""

import math

from mecano.constraints.along_coordinate.law import TURNING_FIELDS
from mecano.constraints.along_coordinate.measure import REACTIONS, SLIDING, TURNING, angle_in_turn, put_sliding
from mecano.constraints.body_fixed import follow
from mecano.constraints.geared_slide import GEARED_SLIDE
from mecano.constraints.joint_frame import not_across, not_flipped
from mecano.constraints.joint_samples import SLIDE_ENDS, SPRUNG, two_places
from mecano.constraints.of_coordinates import (
    SLIDE_END_FIELDS,
    SLIDE_LATCH,
    SLIDE_STOP,
    TWIST_LAW,
    slide_end_parts,
    turning_parts,
)
from mecano.constraints.pair import AXES_FIELDS, AXIS_1, axis_place, pair_parts
from mecano.element_interface import Display, Kind, Part, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import put
from mecano.schema import DIRECTION, NODE_PAIR, NUMBER, Field

HELD = ("about_2", "about_1", "along_1", "along_2")
RECORD = record(travel=(), **AXES_FIELDS)


@kernel
def observe(p, at, F, y, e):
    """Write rotation, sliding and reactions; the sliding determines the turn."""
    angle, y[1] = angle_in_turn(p, at.v, at.R)
    put_sliding(p, at.q, at.v, at.R, y, 2)
    y[0] = follow(y[2] / p.travel, angle)
    put(y, 4, (at.q[14], at.q[15], at.q[16]))
    put(y, 7, (-at.q[13], at.q[12], -p.travel * at.q[16]))


def prepare(d, nodes, context):
    """Return axes of both nodes, the initial position of b in those of a, the travel per radian."""
    return {**axis_place(d, nodes, context), "travel": d["pitch"] / (2.0 * math.pi)}


def parts(d, nodes, context):
    """Return the Parts of a cylindrical joint and the thread; the law of the angle, latch and stops."""
    p = prepare(d, nodes, context)
    thread = {"mu": p["mu"], "xi": p["xi"], "sigma": p["mu"][2], "offset": p["start"][2], "travel": p["travel"]}
    guide = pair_parts(p, HELD, None, context)
    thread = Part(GEARED_SLIDE, (0, 1), thread)
    return [*guide, thread, *turning_parts(d, p, context), *slide_end_parts(d, p)]


def not_zero(value):
    """Check that the pitch is not zero; a thread without pitch would be a hinge."""
    return None if value != 0.0 else "must not be zero; without a pitch use a hinge"


def sample(rng):
    """Return a random axis next to the first node, either hand, the options."""
    nodes, d = two_places(rng), {"axis": rng.normal(size=3), "pitch": 4.0}
    return [
        (d, nodes, ""),
        ({**d, "pitch": -3.0, "turning_law": SPRUNG, "natural_angle": 0.2}, nodes, ""),
        ({**d, **SLIDE_ENDS}, nodes, ""),
    ]


SCREW = Kind(
    name="screw",
    section="joints",
    doc=__doc__,
    display=Display(support=False, pictures=("gears",)),
    dtype=RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "nodes a (nut) and b (screw), or the reverse; either may be ground"),
        Field("axis", DIRECTION, "-", "axis at the start, inertial; it goes through node b"),
        Field("pitch", NUMBER, "m", "advance along the axis in one turn; > 0: right-handed", check=not_zero),
        AXIS_1,
        *TURNING_FIELDS,
        *SLIDE_END_FIELDS,
    ),
    outputs=(*TURNING, *SLIDING, *REACTIONS),
    optional=(("turning_law", TWIST_LAW, ""), ("latch", SLIDE_LATCH, ""), ("stops", SLIDE_STOP, "")),
    prepare=prepare,
    parts=parts,
    check=not_across,
    observe=observe,
    admissible=not_flipped,
    sample=sample,
)
