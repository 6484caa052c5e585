"""Location of the first event in a step.

A step has no side effects, so it is repeated with the size with which it ends at the event: where the motion between
two trial steps, interpolated, crosses zero. Two repetitions suffice where the event value is smooth. An elastic event
from which the motion departs at the beginning of a step is sought later in that step (``look_ahead``).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from mecano.maths.root import chandrupatla
from mecano.model.state import State
from mecano.solve.events.events import EventMonitor, some_happened
from mecano.solve.time.increments import moved
from mecano.solve.time.interpolate import interpolate
from mecano.solve.time.step_info import Trial

TIME_TOLERANCE = 1e-10  # of the step in which the event lies
SMOOTH_TOLERANCE = 1e-8  # the same if velocities do not jump: the relative error of the force is of this order
AT_ONCE = 1e-7  # of a step: an event before this happens at its beginning
BRIEFLY = 1e-3  # of a step: a one-sided event from which the motion departs within this time does not happen
PAST = 0.01  # of the tolerance: after a step that just misses the event, the next one aims past it by this
MIDDLE = 0.5  # of the tolerance: the same for events without a jump of velocities, in every step
TOGETHER = 1e-6  # of its change in the step: event values nearer to zero cross with the located one
UNSEEN = 1e-3  # of the gap at the beginning: a smaller overlap of a contact may be rounding
MOST_INTERPOLATED = 2  # steps that end where the interpolated motion crosses zero
MOST_GUESSES = 6  # with those that end where a line through the last two crosses zero
MOST_STEPS = 60
MOST_EVALUATIONS = 20  # of an event value along the interpolated motion


class Located(NamedTuple):
    """Location of the first event in a step."""

    h: float  # size of the step that ends at it [s]; nearly zero when it happens at the beginning
    trial: "Trial | None"  # that step, or the one in which Newton failed, which ends the search; None at the beginning
    hit: np.ndarray  # (n_events,) bool, events that happen there

    @property
    def ok(self) -> bool:
        """False if Newton failed in a step of the search."""
        return self.trial is None or self.trial[2].ok


class Point(NamedTuple):
    """The largest event value, and the state, at the end of a step of size h; ``trial`` is that step, if made."""

    h: float
    value: float
    state: State
    trial: "Trial | None" = None


def locate(
    monitor: EventMonitor,
    step: "Callable[[float], Trial]",
    s0: State,
    g0: np.ndarray,
    trial: "Trial",
    h: float,
    level: np.ndarray | float = 0.0,
) -> Located | None:
    """Return the first event in a trial step as Located, or None if there is none.

    step(h) -> trial, whose first item is the state; trial = step(h); g0: event values at s0. An event happens where its
    value reaches its ``level`` (n_events,).
    """
    g1 = monitor.values(trial[0]) - level
    if not some_happened(g0, g1):
        return None
    later, ahead = look_ahead(monitor, s0, g0, h)
    g0 = np.where(ahead < 0.0, ahead, g0)
    before = (g0 > 0) & ((g1 > 0) | monitor.one_sided & (g0 > BRIEFLY * np.abs(g1)))
    if np.any(before):  # already crossed at the start of the step
        return Located(0.0, None, before)
    crossed = ((g0 < 0) & (g1 >= 0)) | ((g0 == 0) & (g1 > 0))
    if not np.any(crossed):
        return None
    behind, largest = np.all((monitor.elastic & (ahead < 0.0))[crossed]), float(g0[crossed].max())
    early = Point(AT_ONCE * h, largest, later) if behind else Point(0.0, largest, s0)
    search = Search(monitor, step, crossed, early, trial, h, level)
    if not search.succeeds():
        assert search.failed is not None, "Newton's iteration has failed in a step"
        return Located(search.failed[0].t - s0.t, search.failed, crossed)
    if search.beginning is not None:
        return search.beginning
    late, hit = search.late, crossed.copy()
    assert late.trial is not None, "the late end is that of a step"
    reached = monitor.values(late.state) - level
    rise = g1[crossed] - np.maximum(g0[crossed], -g1[crossed])
    hit[crossed] = reached[crossed] >= np.where(monitor.within[crossed], 0.0, -TOGETHER * rise)
    # an event within a phase is recorded only by the memory that a step commits: it needs a step, however short
    if late.h <= AT_ONCE * h and not monitor.within_a_phase(hit):
        return Located(0.0, None, hit)
    least = np.where(monitor.impacts, UNSEEN * np.abs(g0), 0.0)  # of contacts that have just opened, above rounding
    unseen = (monitor.elastic | monitor.impacts) & ~crossed  # values of others are reactions, rounded in short steps
    if np.any(unseen & (g0 < 0.0) & (reached > least)):
        return locate(monitor, step, s0, g0, late.trial, late.h, level)
    return Located(late.h, late.trial, hit)


def look_ahead(monitor: EventMonitor, s: State, g: np.ndarray, h: float) -> tuple[State, np.ndarray]:
    """Return a state just after the beginning ``s`` of a step of size h, and its event values; ``g``: those at ``s``.

    At a located event, rounding decides the sign of the event value. Elastic events are therefore evaluated after the
    motion has continued, with the velocities and accelerations of ``s``, for the time within which events count as
    happening at the beginning of a step: a negative value shows that the motion departs from the event. Other events
    keep their values.
    """
    elastic = monitor.elastic & np.isfinite(g)
    if not elastic.any():
        return s, g
    later = moved(s, AT_ONCE * h, monitor.system.numbering)
    return later, np.where(elastic, monitor.values(later), g)


class Search:
    """Search for the step size at whose end the largest event value is zero, between the Points early and late.

    ``failed`` is a trial in which Newton's iteration failed, which ends the search.
    """

    def __init__(
        self,
        monitor: EventMonitor,
        step: "Callable[[float], Trial]",
        crossed: np.ndarray,
        early: Point,
        trial: "Trial",
        h: float,
        level: np.ndarray | float = 0.0,
    ):
        self.level = np.broadcast_to(level, crossed.shape)[crossed]
        self.monitor, self.step, self.crossed = monitor, step, crossed
        self.failed: Trial | None = None
        self.beginning: Located | None = None  # of a condition so near that no step to it converges beyond rounding
        self.smooth = bool(np.all(monitor.smooth[crossed]))
        self.of_conditions = monitor.are_conditions(crossed) and not monitor.within_a_phase(crossed)
        self.tolerance = h * (SMOOTH_TOLERANCE if self.smooth else TIME_TOLERANCE)
        self.at_once = AT_ONCE * h
        self.early, self.late = early, self._point(h, trial)
        self.last = self.early, self.late

    def succeeds(self) -> bool:
        """Narrow the interval to the tolerance; return False if Newton's iteration failed on the way."""
        for tried in range(MOST_GUESSES):
            if self._is_over(self.early, self.late):
                return True
            root = self._interpolated() if tried < MOST_INTERPOLATED else self._secant()
            if not self.early.h < root <= self.late.h:
                break
            if not tried and root <= self.at_once and self.of_conditions:
                self.beginning = self._at_the_beginning(root)
                return True
            if self.late.h - root <= self.tolerance:
                return True
            if not self._narrow(self._try(root + self._past(root))):
                return False
        found = chandrupatla(self._try, self.early, self.late, self._is_over, self.tolerance, MOST_STEPS)
        self.early, self.late = found or (self.early, self.late)
        return found is not None

    def _is_over(self, early, late):
        """Return whether the event is known to the tolerance or the rounding of time, or happens at the beginning."""
        known = late.h - early.h <= self.tolerance or late.state.t <= early.state.t
        return known or late.h <= self.at_once or late.value == 0.0

    def _past(self, root):
        """Return how far past the ``root`` the next step aims: a step that just misses the event must be repeated."""
        share = MIDDLE if self.smooth else PAST if root - self.early.h <= self.tolerance else 0.0
        return share * min(self.tolerance, self.late.h - root)

    def _interpolated(self):
        """Return the step size at which the motion interpolated between the two points crosses zero, or nan."""
        early, late, of = self.early, self.late, self.monitor.system.numbering
        if not np.isfinite(early.value):
            return np.nan

        def at(h):
            return h, self._value(interpolate(early.state, late.state, early.state.t + (h - early.h), of))

        near = 0.05 * self.tolerance
        found = chandrupatla(at, early[:2], late[:2], lambda a, b: b[0] - a[0] <= near, near, MOST_EVALUATIONS)
        return np.nan if found is None else found[1][0]

    def _at_the_beginning(self, root):
        """Return the events that the motion of the beginning reaches until the ``root``."""
        values = self.monitor.values(moved(self.early.state, root, self.monitor.system.numbering))[self.crossed]
        hit = self.crossed.copy()
        hit[self.crossed] = values - self.level >= min(0.0, float((values - self.level).max()))
        return Located(root, None, hit)

    def _secant(self):
        """Return the step size at which the line through the last two trials crosses zero, or nan."""
        (a, f_a), (b, f_b) = (point[:2] for point in self.last)
        return b - f_b * (b - a) / (f_b - f_a) if f_a != f_b else np.nan

    def _try(self, h):
        """Return the Point of a step of size h, or None if Newton's iteration failed."""
        trial = self.step(h)
        if not trial[2].ok:
            self.failed = trial
            return None
        point = self._point(h, trial)
        self.last = self.last[1], point
        return point

    def _narrow(self, point):
        """Replace one end of the interval by a Point inside; return whether there is one."""
        if point is not None and point.value >= 0.0:
            self.late = point
        elif point is not None:
            self.early = point
        return point is not None

    def _point(self, h, trial):
        return Point(h, self._value(trial[0]), trial[0], trial)

    def _value(self, s):
        """Return the largest of the event values that crossed zero."""
        return float((self.monitor.values(s)[self.crossed] - self.level).max())
