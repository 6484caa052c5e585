r"""Slide law: a force from a law of the sliding of one node along an axis that the other carries.

P > 0 pulls the second node back along the axis; the first node receives the opposite force at the place of the second.
"""

from mecano.constraints.axis_law import LAW_RECORD, axis_law_record, law_kind
from mecano.constraints.slide import slide_along, slide_value
from mecano.contract import Part, record
from mecano.schema import LAW, NUMBER, Field

RECORD = record(mu=3, **LAW_RECORD)


def slide_law_record(mu, law, natural, context):
    """Record: axis (3,) in the axes of the first node, value of mu . R_0^T (x_1 - x_0) where the extension is zero."""
    return {"mu": mu, **axis_law_record(law, natural, context)}


SLIDING_FIELDS = (
    Field("sliding_law", LAW, "-", "force [N] from displacement [m] and velocity [m/s]; > 0 drives b back", None),
    Field("natural_displacement", NUMBER, "m", "displacement at which the extension of the sliding law is zero", 0.0),
)


def sliding_parts(d, place, context):
    """[Part] of the fields ``SLIDING_FIELDS`` of a joint at ``place`` (pair.py)."""
    if d["sliding_law"] is None:
        return []
    natural = place["start"][2] + d["natural_displacement"]
    return [Part(SLIDE_LAW, (0, 1), slide_law_record(place["mu"][2], d["sliding_law"], natural, context))]


SLIDE_LAW = law_kind("slide_law", __doc__, RECORD, ("x0", "R0", "x1"), slide_value, slide_along)
