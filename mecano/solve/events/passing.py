"""Bodies that touch within a step and part again before its end, where both ends of the step show nothing.

A ball that flies past another one, or up to a ceiling and back, moves through it in a step that is longer than the
contact. A step of a motion without forces may be that long, because it has no error. The value of such an event is
therefore interpolated by a cubic from its values and rates at both ends of the step, and evaluated where the cubic is
highest.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from mecano.jit.entry import Indices, Matrix, entry
from mecano.jit.kernel import kernel
from mecano.solve.time.interpolate import interpolate

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.solve.events.events import EventMonitor

SHARE = 1e-3  # of the step: distance of the places at its ends between which rates are differences
START, END, AFTER_START, BEFORE_END = range(4)  # places at which event values are taken
CERTAIN = 1e-6  # of the change of the value to its peak: a lower peak is an error of the interpolation


@entry
def may_pass(events: Indices, values: Matrix) -> bool:
    """Return whether one of the ``events`` is possible, and shows at neither end; ``values`` (4, n_events)."""
    for i in events:
        if -np.inf < values[START, i] < 0.0 and -np.inf < values[END, i] < 0.0:
            return True
    return False


@entry
def place_of_peak(events: Indices, values: Matrix) -> float:
    """Return the share of the step at which the value of one of the ``events`` is highest, or -1 if none is positive.

    ``values`` (4, n_events) are those at START, END, AFTER_START and BEFORE_END.
    """
    best, place = 0.0, -1.0
    for i in events:
        g0, g1 = values[START, i], values[END, i]
        rate0, rate1 = (values[AFTER_START, i] - g0) / SHARE, (g1 - values[BEFORE_END, i]) / SHARE
        if not (-np.inf < g0 < 0.0 and -np.inf < g1 < 0.0 and rate0 > 0.0 > rate1):
            continue
        u, peak = peak_of_cubic(g0, g1, rate0, rate1)
        if peak > best:
            best, place = peak, u
    return place


@kernel
def peak_of_cubic(x0, x1, rate0, rate1):
    """Return (place, value) of the maximum within [0, 1] of the cubic that rises at 0 and falls at 1."""
    c2, c3 = 3.0 * (x1 - x0) - 2.0 * rate0 - rate1, rate0 + rate1 - 2.0 * (x1 - x0)
    root = math.sqrt(max(c2 * c2 - 3.0 * c3 * rate0, 0.0))
    u = rate0 / (root - c2) if root > c2 else 1.0
    return u, x0 + u * (rate0 + u * (c2 + u * c3))


@entry
def passes_at(events: Indices, values: Matrix, at: Matrix) -> bool:
    """Return whether one of the ``events`` has happened within a step: ``at`` (n, n_events) holds in row 0 its values.

    ``values`` (4, n_events) are those at the ends of the step.
    """
    for i in events:
        g0, g1, g = values[START, i], values[END, i], at[0, i]
        if -np.inf < g0 < 0.0 and -np.inf < g1 < 0.0 and g > CERTAIN * (g - min(g0, g1)):
            return True
    return False


def passed(monitor: "EventMonitor", s0: "State", g0: np.ndarray, s1: "State") -> "State | None":
    """Return a state between ``s0`` and ``s1``, the ends of a step, at which a brief event has happened, or None.

    ``g0``: event values at ``s0``.
    """
    values = np.array([g0, monitor.values(s1), g0, g0]) if len(monitor.brief) else np.empty((4, 0))
    if not may_pass(monitor.brief, values):
        return None

    def within(u):
        return interpolate(s0, s1, s0.t + u * (s1.t - s0.t), monitor.system.numbering)

    values[AFTER_START], values[BEFORE_END] = (monitor.values(within(u)) for u in (SHARE, 1.0 - SHARE))
    u = place_of_peak(monitor.brief, values)
    if u < 0.0:
        return None
    s = within(u)
    return s if passes_at(monitor.brief, values, monitor.values(s)[None]) else None
