"""Events that happen within a step and are undone before its end, where both ends of the step show nothing.

A ball that flies past another one, or up to a ceiling and back, moves through it in a step that is longer than the
contact; a spacecraft passes the distance at which it would be gripped. A step of a motion without forces may be that
long, because it has no error. If the value of such an event rises at the beginning of the step and falls at its end,
its peak is at most as high as the point in which the tangents at both ends meet, as long as it bends downward. If
that is positive, the value is evaluated there, and again where the new tangent meets that of the other side (Kelley,
J. SIAM 8 (1960) 703-712, the cutting-plane method).

The values of conditions are signals, whose rates are known at the beginning of a step only. Between the ends they are
solved for, which compiled code cannot do: it leaves a step to Python in which a condition heads for zero.
"""

import numpy as np

from mecano.jit.entry import Indices, Matrix, entry
from mecano.jit.kernel import kernel
from mecano.model.state import State
from mecano.solve.events.events import EventMonitor
from mecano.solve.time.interpolate import interpolate
from mecano.solve.time.signals import solve_signals

SHARE = 1e-3  # of the step: distance of the places between which rates are differences
START, END, AFTER_START, BEFORE_END = range(4)  # places at which event values are taken
MOST_PLACES = 8  # at which a value is evaluated within a step
CERTAIN = 1e-6  # of the rise of the value to its peak: a lower peak is an error of the interpolation


@kernel
def _is_hidden(values, i):
    """Return whether an event is possible, and shows at neither end of the step."""
    return -np.inf < values[START, i] < 0.0 and -np.inf < values[END, i] < 0.0


@kernel
def _rates(values, i):
    """Return the rates of the value of an event at both ends, per step."""
    first = (values[AFTER_START, i] - values[START, i]) / SHARE
    return first, (values[END, i] - values[BEFORE_END, i]) / SHARE


@entry
def may_pass(events: Indices, values: Matrix) -> bool:
    """Return whether one of the ``events`` is possible, and shows at neither end; ``values`` (4, n_events)."""
    for i in events:
        if _is_hidden(values, i):
            return True
    return False


@entry
def heads_for_zero(events: Indices, values: Matrix) -> bool:
    """Return whether one of the ``events`` that shows at neither end would happen at its rate of the beginning."""
    for i in events:
        if _is_hidden(values, i) and values[START, i] + _rates(values, i)[0] > 0.0:
            return True
    return False


@entry
def may_peak(events: Indices, values: Matrix) -> bool:
    """Return whether the tangents to the value of one of the ``events`` at both ends meet above zero.

    ``values`` (4, n_events) are those at START, END, AFTER_START and BEFORE_END.
    """
    for i in events:
        rate0, rate1 = _rates(values, i)
        if _is_hidden(values, i) and rate0 > 0.0 > rate1:
            u = (values[END, i] - values[START, i] - rate1) / (rate0 - rate1)
            if values[START, i] + u * rate0 > 0.0:
                return True
    return False


def passed(monitor: EventMonitor, s0: State, g0: np.ndarray, s1: State, g1: np.ndarray, error: float) -> State | None:
    """Return a state between ``s0`` and ``s1``, the ends of a step, at which an event has happened, or None.

    ``g0``, ``g1`` (n_events,): event values there. Events are those sought within steps: brief ones and conditions. An
    elastic line that is stretched by less than the local ``error`` [m] of the step stays slack: in vibrations that the
    steps do not resolve, rounding would decide which of equal members has such an event.
    """
    events, system = np.concatenate([monitor.brief, monitor.conditions]), monitor.system
    values = np.array([g0, g1, g0, g1])
    if not may_pass(events, values):
        return None

    def within(u):
        return solve_signals(system, interpolate(s0, s1, s0.t + u * (s1.t - s0.t), system.numbering))

    values[AFTER_START] = monitor.values(within(SHARE))
    if not heads_for_zero(events, values):
        return None
    values[BEFORE_END] = monitor.values(within(1.0 - SHARE))
    for i in events:
        if may_peak(np.array([i]), values):
            least = error if monitor.elastic[i] else 0.0
            found = _above_zero(lambda s, i=i: float(monitor.values(s)[i]), within, values[:, i], least)
            if found is not None:
                return found
    return None


def _above_zero(value, within, ends, least):
    """Return a state at which an event value is above zero, and ``least``, sought between ``ends`` (4,), or None."""
    low = 0.0, ends[START], (ends[AFTER_START] - ends[START]) / SHARE
    high = 1.0, ends[END], (ends[END] - ends[BEFORE_END]) / SHARE
    for _ in range(MOST_PLACES):
        (u0, g0, rate0), (u1, g1, rate1) = low, high
        u = (g1 - g0 + u0 * rate0 - u1 * rate1) / (rate0 - rate1)
        if not (u0 < u < u1 and g0 + (u - u0) * rate0 > 0.0):
            return None
        s = within(u)
        g = value(s)
        if g > max(CERTAIN * (g - min(ends[START], ends[END])), least):
            return s
        rate = (value(within(u + SHARE * (u1 - u))) - g) / (SHARE * (u1 - u))
        low, high = ((u, g, rate), high) if rate > 0.0 else (low, (u, g, rate))
    return None
