"""Constraints and laws of single coordinates, from which joints are composed: each is a use of a coordinate."""

from mecano.constraints.along_coordinate.demand import is_formula, reads_of
from mecano.constraints.along_coordinate.hold import (
    BY_FORMULA,
    drive_kind,
    hold_kind,
    motion_values,
    rate_kind,
    signal_rate_kind,
)
from mecano.constraints.along_coordinate.law import law_kind, law_kind_of_signal, law_values
from mecano.constraints.along_coordinate.stops import latch_kind, lock_kind, releasable_latch_kind, stop_kind
from mecano.constraints.coordinates.displacement import DISPLACEMENT
from mecano.constraints.coordinates.distance import DISTANCE as LENGTH
from mecano.constraints.coordinates.level import LEVEL
from mecano.constraints.coordinates.pin_angle import PIN_ANGLE
from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.tilt import TILT
from mecano.constraints.coordinates.twist import TWIST
from mecano.element_interface import Part

HELD = (
    ("in_plane", r"In plane: :math:`\mu \cdot (x_1 - x_0) - c = 0` for mu fixed in the first node.", SLIDE,
     "force that holds the node in a plane"),
    ("orthogonal", r"Orthogonal: :math:`\mu \cdot \xi = 0` for mu fixed in the first node and xi in the second.", TILT,
     "moment that keeps two axes perpendicular"),
    ("same_angle", "Same angle: constant twist of two nodes.", TWIST, "moment that holds the angle"),
    ("same_distance", "Same distance: constant distance of two nodes.", LENGTH, "force that pushes the nodes apart"),
    ("level_axis", r"Level axis: :math:`a \cdot n = 0` for an axis a fixed in the node and an inertial direction n.",
     LEVEL, "moment that keeps the axis level"),
)  # fmt: skip
"""Name, page, coordinate and name of the multiplier of the constraints that hold a coordinate."""
IN_PLANE, ORTHOGONAL, SAME_ANGLE, SAME_DISTANCE, LEVEL_AXIS = (hold_kind(*row) for row in HELD)

SINES = {kind.multipliers[0].name for kind in (ORTHOGONAL, LEVEL_AXIS)}
"""What the multipliers are called whose constraints are the sine of the angle by which an axis leans."""

DRIVEN = (
    ("relative_angle", "Relative angle: the twist of two nodes is f(t).", TWIST, "moment that holds the angle"),
    ("distance", "Distance of two nodes: it is f(t).", LENGTH, "force that pushes the nodes apart"),
    ("held_coordinate", "Held coordinate: the displacement of a node along a direction is f(t).", DISPLACEMENT,
     "force that prescribes the position"),
    ("driven_slide", "Driven slide: the sliding is f(t).", SLIDE, "force that drives the sliding"),
)  # fmt: skip
RELATIVE_ANGLE, DISTANCE, HELD_COORDINATE, DRIVEN_SLIDE = drives_by_law = [drive_kind(*row) for row in DRIVEN]
DRIVEN_BY_FORMULA = dict(zip(drives_by_law, (drive_kind(*row, BY_FORMULA) for row in DRIVEN), strict=True))
"""The constraints that drive a coordinate by a formula of the time, by those that drive it by a law."""
DRIVEN_RATE = dict(zip(drives_by_law, (rate_kind(*row) for row in DRIVEN), strict=True))
DRIVEN_RATE_BY_SIGNAL = dict(zip(drives_by_law, (signal_rate_kind(*row) for row in DRIVEN), strict=True))
"""The constraints that drive the rate of a coordinate by a law of time or a signal, by the same."""

LAWS = (
    ("slide_law", "Slide law: a force from a law of the sliding; > 0 opposes the sliding.", SLIDE),
    ("twist_law", "Twist law: a moment from a law of the twist; > 0 opposes the twist.", TWIST),
    ("tilt_law", "Tilt law: a moment from a law of the tilt, the sine of an angle.", TILT),
    ("pin_law", "Pin law: a moment from a law of the angle of a pin.", PIN_ANGLE),
)
SLIDE_LAW, TWIST_LAW, TILT_LAW, PIN_LAW = laws_of_time = [law_kind(*row) for row in LAWS]
OF_SIGNAL = dict(zip(laws_of_time, (law_kind_of_signal(*row) for row in LAWS), strict=True))
"""The laws whose set point is a signal, by those whose set point is a law of time."""

ENDS = (
    ("latch", "Latch", latch_kind), ("latch_release", "Latch", releasable_latch_kind), ("lock", "Lock", lock_kind),
    ("stop", "Stops", stop_kind),
)  # fmt: skip


def _ends(name, what, coordinate):
    """Return the Kinds of a latch for good, of one that is released, of a lock and of stops of a coordinate."""
    return tuple(make(f"{name}_{end}", f"{title} of {what}.", coordinate) for end, title, make in ENDS)


ENDS_OF_SLIDE = SLIDE_LATCH, SLIDE_LATCH_RELEASE, SLIDE_LOCK, SLIDE_STOP = _ends("slide", "the sliding", SLIDE)
ENDS_OF_ANGLE = ANGLE_LATCH, ANGLE_LATCH_RELEASE, ANGLE_LOCK, ANGLE_STOP = _ends(
    "angle", "the twist, over any number of turns", TWIST
)
BOTH = (0, 1)


def law_part(kind, axes, law, natural, context, zero=0.0, on=BOTH, label=""):
    """Return the Part of a law along the coordinate of ``kind``; the other arguments are those of ``law_values``."""
    values, chosen = law_values(axes, law, natural, context, zero), OF_SIGNAL[kind] if is_formula(natural) else kind
    return Part(chosen, on, values, label=label, reads=reads_of(natural))


def drive_part(kind, on, axes, given, offset, context, of_rate=False):
    """Return the Part that drives the coordinate of ``kind`` of the nodes ``on``, or its rate, by a law or a formula.

    ``offset`` is the value of the coordinate where the law, or the integral of its rate, is zero.
    """
    if of_rate and is_formula(given):
        return Part(DRIVEN_RATE_BY_SIGNAL[kind], on, axes, reads=(given,))
    chosen = DRIVEN_RATE[kind] if of_rate else DRIVEN_BY_FORMULA[kind] if is_formula(given) else kind
    return Part(chosen, on, {**axes, **motion_values(given, offset, context)})
