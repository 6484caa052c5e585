"""Options of joints with an axis: the fields of the deck, and the parts that they add."""

from collections.abc import Callable

from mecano.constraints.along_coordinate.friction import check_friction, friction_fields, friction_record
from mecano.constraints.along_coordinate.law import SLIDING_FIELDS, TURNING_FIELDS, check_set_point
from mecano.constraints.along_coordinate.stops import check_ends, end_fields, end_parts
from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.twist import TWIST
from mecano.constraints.of_coordinates import BOTH, ENDS_OF_ANGLE, ENDS_OF_SLIDE, SLIDE_LAW, TWIST_LAW, law_part
from mecano.constraints.pair import coordinate_of
from mecano.element_interface import Part
from mecano.immutable import immutable


@immutable
class Option:
    """An option of a joint."""

    fields: tuple
    parts: Callable  # (deck values, place of the joint (pair.py), Context) -> [Part]
    optional: tuple = ()  # see Kind.optional
    check: Callable = lambda d: []  # deck values -> texts
    needs_reactions: bool = False  # along all axes that the joint holds


def _law_option(fields, kind, axis):
    """Return the Option of a law about or along an ``axis`` (pair.py); ``fields``: of the law and of its set point."""
    law, set_point = (field.name for field in fields)

    def parts(d, place, context):
        axes, start = coordinate_of(axis, place)
        return [] if d[law] is None else [law_part(kind, axes, d[law], d[set_point], context, start)]

    return Option(fields, parts, ((law, kind, ""),), lambda d: check_set_point(d, law, set_point))


def _end_option(coordinate, ends, axis):
    """Return the Option of the ends of a coordinate; ``ends``: their Kinds, as of ``end_parts``."""

    def parts(d, place, context):
        return end_parts(d, coordinate, *coordinate_of(axis, place), ends)

    optional = zip(("latch", "latch", "lock", "stops"), ends, ("",) * len(ends), strict=True)
    return Option(end_fields(coordinate), parts, tuple(optional), check_ends)


def friction_option(kind, axis, *geometry):
    """Return the Option of friction driven by the reactions of all axes that the joint holds.

    ``kind`` is coupled to their multipliers, and has the axes of the coordinate along or about ``axis`` (pair.py);
    ``geometry`` are its fields in addition to those of every friction.
    """
    coupled_to = tuple(range(len(kind.coupled_multipliers)))

    def parts(d, place, context):
        if d["friction"] is None:
            return []
        values = friction_record(d["friction"], context, kind.dtype.names)
        return [Part(kind, BOTH, {**coordinate_of(axis, place)[0], **values}, coupled_to)]

    return Option((friction_fields(*geometry),), parts, (("friction", kind, ""),), check_friction, True)


TURNING_LAW = _law_option(TURNING_FIELDS, TWIST_LAW, "about_axis")
SLIDING_LAW = _law_option(SLIDING_FIELDS, SLIDE_LAW, "along_axis")
ANGLE_ENDS = _end_option(TWIST, ENDS_OF_ANGLE, "about_axis")
SLIDE_ENDS = _end_option(SLIDE, ENDS_OF_SLIDE, "along_axis")
