"""Options of joints with an axis: the fields of the deck, and the parts that are added where they are given."""

from collections.abc import Callable

from mecano.constraints.along_coordinate.friction import check_friction, friction_fields
from mecano.constraints.along_coordinate.law import SLIDING_FIELDS, TURNING_FIELDS
from mecano.constraints.along_coordinate.stops import check_ends, end_fields, end_parts
from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.twist import TWIST
from mecano.constraints.of_coordinates import (
    ANGLE_LATCH,
    ANGLE_LATCH_RELEASE,
    ANGLE_STOP,
    BOTH,
    SLIDE_LATCH,
    SLIDE_LATCH_RELEASE,
    SLIDE_LAW,
    SLIDE_STOP,
    TWIST_LAW,
    law_part,
)
from mecano.element_interface import Part
from mecano.immutable import immutable

ANGLE_LATCHES = ANGLE_LATCH, ANGLE_LATCH_RELEASE
SLIDE_LATCHES = SLIDE_LATCH, SLIDE_LATCH_RELEASE
NOT_GIVEN = 0.0, (("constant", {"value": 0.0}),)  # set points


@immutable
class Option:
    """An option of a joint."""

    fields: tuple
    parts: Callable  # (deck values, place of the joint (pair.py), Context) -> [Part]
    optional: tuple = ()  # see Kind.optional
    check: Callable = lambda d: []  # deck values -> texts
    needs_reactions: bool = False  # along all axes that the joint holds


def _needs(law, set_point):
    """Return the check that the set point of a law stands beside the law."""

    def check(d):
        alone = d[law] is None and d[set_point] not in NOT_GIVEN
        return [f"{set_point!r} is that of a {law!r}, which is missing"] if alone else []

    return check


def _turning_parts(d, place, context):
    if d["turning_law"] is None:
        return []
    axes = {"mu": place["mu"], "xi": place["xi"]}
    return [law_part(TWIST_LAW, axes, d["turning_law"], d["natural_angle"], context)]


def _sliding_parts(d, place, context):
    if d["sliding_law"] is None:
        return []
    axes, natural = {"mu": place["mu"][2]}, d["natural_displacement"]
    return [law_part(SLIDE_LAW, axes, d["sliding_law"], natural, context, place["start"][2])]


def _angle_end_parts(d, place, context):
    return end_parts(d, TWIST, {"mu": place["mu"], "xi": place["xi"]}, 0.0, ANGLE_LATCHES, ANGLE_STOP)


def _slide_end_parts(d, place, context):
    return end_parts(d, SLIDE, {"mu": place["mu"][2]}, place["start"][2], SLIDE_LATCHES, SLIDE_STOP)


def _ends(latches, stop):
    return (*(("latch", latch, "") for latch in latches), ("stops", stop, ""))


def friction_option(kind, values, *geometry):
    """Return the Option of friction driven by the reactions of all axes that the joint holds.

    ``kind`` is coupled to their multipliers, ``values(place, friction, context)`` returns its record, ``geometry`` are
    its fields beside those of every friction.
    """
    coupled_to = tuple(range(len(kind.coupled_multipliers)))

    def parts(d, place, context):
        given = d["friction"]
        return [Part(kind, BOTH, values(place, given, context), coupled_to)] if given else []

    return Option((friction_fields(*geometry),), parts, (("friction", kind, ""),), check_friction, True)


TURNING_LAW = Option(
    TURNING_FIELDS, _turning_parts, (("turning_law", TWIST_LAW, ""),), _needs("turning_law", "natural_angle")
)
SLIDING_LAW = Option(
    SLIDING_FIELDS, _sliding_parts, (("sliding_law", SLIDE_LAW, ""),), _needs("sliding_law", "natural_displacement")
)
ANGLE_ENDS = Option(end_fields(TWIST), _angle_end_parts, _ends(ANGLE_LATCHES, ANGLE_STOP), check_ends)
SLIDE_ENDS = Option(end_fields(SLIDE), _slide_end_parts, _ends(SLIDE_LATCHES, SLIDE_STOP), check_ends)
