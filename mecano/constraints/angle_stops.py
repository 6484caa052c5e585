"""Latch and stops of the angle between two nodes about an axis that both carry, over any turns."""

from mecano.compiled.kernel import kernel
from mecano.constraints.end_stops import LATCH_RECORD, STOP_RECORD, end_fields, end_parts, latch_kind, stop_kind
from mecano.constraints.joint_frame import triad
from mecano.constraints.relative_angle import MULTIPLIER, angle_levels, hold_angle
from mecano.constraints.twist_law import followed
from mecano.contract import record
from mecano.maths.vector import mat

AXES = {"mu": (3, 3), "xi": (3, 3)}
LAYOUT = ("R0", "R1")
ANGLE_END_FIELDS = end_fields("angle", "rad")


@kernel
def _angle(p, m, q, v, R):
    return followed(p, m, q, v, R)[0]


@kernel
def _hold(p, sign, wanted, k, penalty, q, R, f, K):
    hold_angle(sign, mat(p.mu), mat(p.xi), wanted, k, penalty, q, R, f, K)


@kernel
def _levels(p, sign, wanted, q, v, a, R, g):
    angle_levels(sign, mat(p.mu), mat(p.xi), (wanted, 0.0, 0.0), v, a, R, g)


def _sample(rng):
    """Axes in general position."""
    return {"mu": triad(rng.normal(size=3)), "xi": triad(rng.normal(size=3))}


def angle_end_parts(d, place):
    """[Part] of the fields ``ANGLE_END_FIELDS`` of a joint at ``place`` (pair.py)."""
    return end_parts(d, "angle", {"mu": place["mu"], "xi": place["xi"]}, 0.0, ANGLE_LATCH, ANGLE_STOP)


_FUNCTIONS = MULTIPLIER, _angle, _hold, _levels, _sample
ANGLE_LATCH = latch_kind("angle_latch", __doc__, record(**AXES, **LATCH_RECORD), LAYOUT, *_FUNCTIONS)
ANGLE_STOP = stop_kind("angle_stop", __doc__, record(**AXES, **STOP_RECORD), LAYOUT, *_FUNCTIONS)
