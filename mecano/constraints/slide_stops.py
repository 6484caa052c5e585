"""Latch and stops of the sliding of a node along an axis that another one carries."""

from mecano.compiled.kernel import kernel
from mecano.constraints.end_stops import LATCH_RECORD, STOP_RECORD, end_fields, end_parts, latch_kind, stop_kind
from mecano.constraints.in_plane import MULTIPLIER, hold_slide, slide_levels
from mecano.constraints.slide import slide
from mecano.contract import record
from mecano.maths.vector import mat, vec

AXES = {"mu": 3}
LAYOUT = ("x0", "R0", "x1")
SLIDE_END_FIELDS = end_fields("displacement", "m")


@kernel
def _slid(p, m, q, v, R):
    return slide(q, v, mat(R[0]), vec(p.mu, 0))[0]


@kernel
def _hold(p, sign, wanted, k, penalty, q, R, f, K):
    hold_slide(sign, vec(p.mu, 0), wanted, k, penalty, q, R, f, K)


@kernel
def _levels(p, sign, wanted, q, v, a, R, g):
    slide_levels(sign, vec(p.mu, 0), (wanted, 0.0, 0.0), q, v, a, R, g)


def _sample(rng):
    """An axis in general position."""
    return {"mu": rng.normal(size=3)}


def slide_end_parts(d, place):
    """[Part] of the fields ``SLIDE_END_FIELDS`` of a joint at ``place`` (pair.py)."""
    return end_parts(d, "displacement", {"mu": place["mu"][2]}, place["start"][2], SLIDE_LATCH, SLIDE_STOP)


_FUNCTIONS = MULTIPLIER, _slid, _hold, _levels, _sample
SLIDE_LATCH = latch_kind("slide_latch", __doc__, record(**AXES, **LATCH_RECORD), LAYOUT, *_FUNCTIONS)
SLIDE_STOP = stop_kind("slide_stop", __doc__, record(**AXES, **STOP_RECORD), LAYOUT, *_FUNCTIONS)
