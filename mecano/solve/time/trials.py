"""Trial steps from a state, until one has an admissible error and ends at its first event, if it has any."""

from collections.abc import Set

import numpy as np

from mecano.immutable import mutable
from mecano.model.system import System
from mecano.solve.diagnostics import failure
from mecano.solve.events.capture import EventCapture
from mecano.solve.events.events import EventMonitor
from mecano.solve.events.location import Located, locate
from mecano.solve.events.passing import passed
from mecano.solve.events.shocks import Shocks
from mecano.solve.time.binding import refuse_binding
from mecano.solve.time.rounding_limit import below_rounding
from mecano.solve.time.run_state import Method, RunState
from mecano.solve.time.step_control import AFTER_FAILURE, StepControl, clipped
from mecano.solve.time.step_info import Trial

BEYOND = 2.0  # times to an impact that a long step would not show, at the present rate, at which it is sought
OVERLAP = 1e-3  # of the gap up to which contacts touch: one that has opened closes again where it overlaps by more


@mutable
class Trials:
    """Trial steps of ``system`` by ``method``, judged by ``control``; steps end at ``corners`` of laws of time.

    A trial is (state at its end, history there, StepInfo).
    """

    system: System
    method: "Method"
    control: StepControl
    monitor: EventMonitor
    capture: EventCapture
    shocks: Shocks
    corners: Set[float]

    def first(self, run: RunState, stop: float) -> "Trial":
        """Return the first trial of a step towards ``stop``."""
        return self._step(run, clipped(run.motion.t, run.h, stop, stop in self.corners))

    def acceptable(
        self, run: RunState, stop: float, trial: "Trial | None", cuts: list[tuple[float, float]]
    ) -> "tuple[float, Trial, Located | None, int, int]":
        """Return the first acceptable step towards ``stop``: (h, trial, first event in it, rejected, iterations).

        Failed trials are added to ``cuts``; after one, convergence requires more of the residual (``insist``).
        """
        h, rejected, iterations = clipped(run.motion.t, run.h, stop, stop in self.corners), 0, 0
        while True:
            if cuts:
                self.method.insist(True)  # in a shorter step any correction is rounding
            trial = trial if trial and not rejected else self._step(run, h)
            iterations += trial[2].iterations
            smaller = self._size_to_retry(run, trial, h, cuts)
            if smaller is None:
                raw = self.monitor.values(run.motion)
                g0 = self.shocks.departing(run.motion, raw)
                within = self._event_within(run, g0, trial, sought=not rejected)
                if within is not None and h > self.control.minimum:
                    smaller = max(within.t - run.motion.t, self.control.minimum)
            if smaller is None:
                found = self._locate(run, g0, trial, h, raw)
                if found is None or found.ok:
                    return h, trial, found, rejected, iterations
                smaller = self._smaller(found.trial[2], run.motion, h, cuts)
            h, rejected = smaller, rejected + 1

    def _locate(self, run, g0, trial, h, raw):
        """Return the first event in a ``trial`` step as Located, or None.

        ``g0`` (n_events,) are the ``raw`` event values at its beginning, with those of departing contacts. If such a
        contact seems to close at once, it closes where it overlaps by more than at the beginning, and than rounding.
        """
        if not len(g0):
            return None
        if self.monitor.captures:

            def step(d):
                return self._step(run, d)
        else:
            repeated = self.method.repeated(run.motion, run.history, trial[0])

            def step(d):
                return self._with_error(repeated(d), d)

        approaching = self.shocks.approaching(run.motion, g0)
        found = self._returning(run, g0, trial[0], h, step, approaching) if approaching else None
        if found is None:
            decided = self._decided(run, g0, trial[0])
            found = locate(self.monitor, step, run.motion, decided, trial, h)
            if found and found.trial is None and np.any(found.hit & (g0 < raw)):
                found = locate(self.monitor, step, run.motion, decided, trial, h, _closing_levels(raw, g0))
        return found

    def _returning(self, run, g0, s, h, step, approaching):
        """Return the first event as Located if one of the contacts ``approaching`` is open at the end ``s``, or None.

        Contacts that touch close at the beginning. The others are sought in a step to twice the time after which they
        close at their present rates.
        """
        g, near = self.monitor.values(s), self.shocks.near
        back = {c: g0[c.event] / rate for c, rate in approaching.items() if g[c.event] < 0.0}
        if not back:
            return None
        hit = np.zeros(len(g), bool)
        hit[[c.event for c in back if -g0[c.event] <= near[c.lead]]] = True
        if hit.any():
            return Located(0.0, None, hit)
        sooner = BEYOND * min(back.values())
        trial = step(sooner) if sooner < h else None
        if trial is None or not trial[2].ok:
            return None
        return locate(self.monitor, step, run.motion, self._decided(run, g0, trial[0]), trial, sooner)

    def _decided(self, run, g0, s):
        """Return the event values ``g0`` with nan for those that rounding decides in a step to ``s``: no event."""
        return np.where(self.shocks.undecided(g0, run.motion, s, run.history.k), np.nan, g0)

    def _event_within(self, run, g0, trial, sought):
        """Return a state within a trial at which an event has happened that its end does not show, or None.

        It is the first stage of such a kind; without one, brief events are looked for between the ends if ``sought``.
        """
        s, _, info = trial
        if not len(g0) or np.any((g1 := self.monitor.values(s)) > 0.0):
            return None
        for stage in info.stages:
            if np.any((self._decided(run, g0, stage) < 0.0) & (self.monitor.values(stage) >= 0.0)):
                return stage
        if not sought:
            return None
        return passed(self.monitor, run.motion, self._decided(run, g0, s), s, g1, info.error * self.method.length)

    def _size_to_retry(self, run, trial, h, cuts):
        """Return the step size to try instead of h, or None if the trial is accepted; add failures to ``cuts``."""
        _, history, info = trial
        if not info.ok:
            return self._smaller(info, run.motion, h, cuts)
        if self.control.accept(info.plain, h):
            return None
        info.error = self.bounded(trial, h)
        if self.control.accept(info.error, h):
            return None
        if h <= self.control.minimum:
            share = info.error / self.control.allowed(h)
            self._refuse_singular(run.motion)
            rounded = self.method.order == 2 and below_rounding(info.error, run.motion, self.method)
            raise failure.minimum_step(self.system, run.history.a, history.a, share, run.motion.t, h, rounded)
        return self.control.retry(info.plain, h)  # the bounded one falls only once steps resolve oscillations

    def judged(self, trial: "Trial", h: float) -> float:
        """Return the error of the ``trial``, with that of oscillations bounded if the plain estimate is too large."""
        plain = trial[2].plain
        return plain if self.control.accept(plain, h) else self.bounded(trial, h)

    def bounded(self, trial: "Trial", h: float) -> float:
        """Return the error of the ``trial``, with that of oscillations bounded."""
        info = trial[2]
        return max(self.method.bounded_error(*trial), self.control.forgotten(info.lag, h), info.signalled)

    def _step(self, run, h):
        history = self._history_for(run, h)
        if not self.monitor.captures:
            return self._with_error(self.method.step(run.motion, history, h), h)
        trial = self.capture.step(lambda s: self.method.step(s, history, h), run.motion)
        if trial is None:
            self.monitor.captures = False  # the events of this step are located
            trial = self.method.step(run.motion, history, h)
        return self._with_error(trial, h)

    def _with_error(self, trial, h):
        """Return a ``trial`` step of size h with all its errors."""
        info = trial[2]
        info.error = info.plain = max(info.error, self.control.forgotten(info.lag, h), info.signalled)
        return trial

    def _history_for(self, run, h):
        """Return the history of the run for the step size h."""
        return run.history if run.history.h == h else self.method.restart(run.motion, run.history, h)

    def _refuse_singular(self, s):
        from mecano.solve.time.singular_position import refuse_singular  # no run that ends well needs it

        refuse_singular(self.method, s)

    def _smaller(self, info, s, h, cuts):
        smaller = h * AFTER_FAILURE
        if smaller < self.control.minimum:
            refuse_binding(self.method, s)
            self._refuse_singular(s)
            raise failure.no_step(self.system, self.method.assembly, info, s.t, h)
        cuts.append((s.t, smaller))
        return smaller


def _closing_levels(raw, g0):
    """Return the event values (n_events,) at which departing contacts, with values ``g0`` below ``raw``, close."""
    level, departing = np.zeros(len(raw)), g0 < raw
    level[departing] = raw[departing] - OVERLAP * g0[departing]
    return level
