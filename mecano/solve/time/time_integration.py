"""The time loop: the only place that accepts a step, commits memories, changes a phase or calls an observer."""

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from mecano.errors import AssemblyError, NonFiniteError
from mecano.immutable import mutable
from mecano.model.assembly import Observation
from mecano.solve.diagnostics import failure
from mecano.solve.events.application import EventApplication
from mecano.solve.events.capture import EventCapture
from mecano.solve.events.events import EventMonitor, EventRecord
from mecano.solve.events.location import look_ahead
from mecano.solve.events.shocks import Shocks
from mecano.solve.time.beginning import Beginning
from mecano.solve.time.binding import refuse_binding
from mecano.solve.time.contradictions import stiffened
from mecano.solve.time.increments import longest_step
from mecano.solve.time.rounding_limit import RoundingLimit
from mecano.solve.time.run_state import Method, RunState
from mecano.solve.time.step_control import HOLD, NEGLIGIBLE_TIME, SHORT, StepControl, first_size
from mecano.solve.time.stride import PROBE
from mecano.solve.time.stride_arrays import Recorder
from mecano.solve.time.trials import Trials

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.time.consistent import Consistent
    from mecano.solve.time.ordinary_steps import OrdinarySteps
    from mecano.solve.time.radau_steps import RadauSteps
    from mecano.solve.time.step_info import StepInfo, Trial

LEAST_ULPS = 1e4  # spacings of floating-point numbers of time in a step: a shorter step has too much rounding
MOST_STEPS = 2**62  # in one call of compiled code: any number
MOST_CUTS = 500  # while time advances by less than the largest step: then the run crawls


@dataclass(slots=True)
class Accepted:
    """An accepted step, as reported to observers."""

    before: "State"  # at the beginning of the step
    run: RunState
    info: "StepInfo"
    h: float
    rejected: int  # trials rejected before it
    event_records: tuple[EventRecord, ...] = ()  # events at its end


@mutable
class TimeIntegrator:
    """Time integration of ``system`` by ``method`` with step sizes from ``control``; a RunState is its state."""

    system: "System"
    method: Method
    control: StepControl
    observers: tuple[Callable[[Accepted], object], ...] = ()  # called with Accepted at every step
    breakpoints: Sequence[float] = ()  # times that a step must end on: corners of laws of time
    rest: float = 1e-4  # of the length scale, or rad, per second: slower approaches do not rebound
    most_located: int = 100  # instants with elastic events, beyond one in each step, that are located (capture.py)
    longest_restart: float = math.inf  # step [s] with which adaptive steps restart where functions of time may begin
    landmarks: Sequence[float] = ()  # further times that a step must end on: of pulses of laws of time
    samples: Sequence[float] = ()  # of the breakpoints, those at which nothing but sampled signals jumps
    pause: Callable[[RunState], object] = lambda run: None  # called within a step with the run before it; may raise
    recorder: Recorder | None = None  # takes steps from compiled code and, called with Accepted, from Python
    reporters: tuple[Callable[[RunState], object], ...] = ()  # called with the RunState between calls of compiled code
    observation: Observation = field(init=False)  # outputs and energies at the end of the last step, or after an event
    monitor: EventMonitor = field(init=False)
    capture: EventCapture = field(init=False)
    shocks: Shocks = field(init=False)
    events: EventApplication = field(init=False)
    trials: Trials = field(init=False)
    rounding: RoundingLimit = field(init=False)
    start_events: list[EventRecord] = field(init=False, default_factory=list)  # [EventRecord] before the first step
    cuts: list[tuple[float, float]] = field(init=False, default_factory=list)  # (time, step size) after failed trials
    _ordinary_steps: "OrdinarySteps | RadauSteps | None" = field(init=False, default=None)
    _before: RunState = field(init=False)  # at the beginning of the step

    def __post_init__(self):
        self._corners = sorted(self.breakpoints)  # of a sampled signal there may be very many
        self._is_corner = set(self._corners)  # with those that follow from the memory
        self._stops, self._is_sample = sorted(self._is_corner.union(self.landmarks)), set(self.samples)
        self._others = [t for t in self._stops if t not in self._is_sample] if self.samples else self._stops
        self.observation, self.monitor = Observation(self.system), EventMonitor(self.system)
        self.capture = EventCapture(self.monitor, self.most_located)
        self.shocks = Shocks(self.system, self.method, self.monitor, self.rest)
        self.events = EventApplication(self.system, self.method, self.monitor, self.capture, self.shocks)
        self.trials = Trials(
            self.system, self.method, self.control, self.monitor, self.capture, self.shocks, self._is_corner
        )
        self.rounding = RoundingLimit(self.control, self.method)
        if self.system.is_sampled():
            self.method.use_compiled_restarts()

    @property
    def warnings(self) -> list[str]:
        """The warnings (list of str) to be reported at the end of the run."""
        return self.events.warnings

    def begin(self, s: "State", h: float) -> RunState:
        """Return the RunState at the start, with consistent velocities, accelerations and multipliers.

        ``start_events`` are the events there, see ``Beginning``.
        """
        run, self.start_events = Beginning(self).of(s, h)
        return run

    def to(self, end: float, run: RunState, memory: np.ndarray | None = None) -> RunState:
        """Integrate from ``run`` to the time ``end``, or to an event that ends the run, and return the new RunState.

        ``memory`` (n_memory,) replaces that of ``run``: forces jump at its time. Raises ConvergenceError,
        NonFiniteError.
        """
        self._before = run
        try:
            return self._to(end, run, memory)
        except AssemblyError as error:
            raise failure.no_restart(error, self._before.motion.t) from error
        except NonFiniteError as error:
            raise failure.with_sources(error, self.system, self._before.motion) from error

    def _to(self, end, run, memory):
        if run.compliance is not self.method.compliance:
            self.method.use(run.compliance)
        self.method.pause = lambda: self.pause(self._before)
        if run.motion.t in self.system.arrivals(run.motion.memory):
            self._is_corner.add(run.motion.t)
        before_corner = run.motion.t in self._is_corner and run.history.known  # the last call ended there
        if memory is not None:
            run = replace(run, motion=replace(run.motion, memory=memory))
        for corner in self._corners[bisect_right(self._corners, end) :][:1]:
            end = corner if corner - end < self._shortest(corner) else end  # rounding is no step
        if before_corner:
            run = self._start_behind_corner(run, end)
        elif memory is not None:
            run = self.start_again(run, run.motion)
        while run.motion.t < end and not (self.monitor.final and self.monitor.ended(run.motion)):
            stop = self._next_stop(run, end)
            if stop - run.motion.t < self._shortest(stop):  # an event may be that close before it
                run = replace(run, motion=replace(run.motion, t=stop))
            else:
                run = self._steps_towards(run, stop, end)
                self.rounding.refuse(run, len(self.cuts))
                for report in self.reporters:
                    report(run)
            t, met = run.motion.t, run.motion.t == stop or run.history.known  # compiled code may have restarted at t
            if met and t < end and t in self._is_corner:
                run = self._start_behind_corner(run, end)
        return run

    def _next_stop(self, run, end):
        """Return the next time at which a step must end, ``end`` at the latest."""
        i = bisect_right(self._stops, run.motion.t)
        stop = min(self._stops[i], end) if i < len(self._stops) else end
        for arrival in self.system.arrivals(run.motion.memory):
            if run.motion.t < arrival < stop:
                self._is_corner.add(arrival)
                stop = arrival
        return stop

    def _shortest(self, stop):
        """Return the least remaining time [s] to ``stop`` for which a step is made: less is rounding error."""
        return max(LEAST_ULPS * math.ulp(stop), NEGLIGIBLE_TIME * self.control.minimum)

    def to_plain(self) -> dict[str, Any]:
        """Return the state of the time loop itself, without the run, as dicts, lists, texts and numbers."""
        own = {"warnings": list(self.warnings), "cuts": list(self.cuts)}
        return {**own, **self.events.to_plain(), "capture": self.capture.to_plain()}

    def from_plain(self, plain: Mapping[str, Any]) -> None:
        """Restore the state returned by ``to_plain``."""
        self.warnings[:], self.cuts = plain["warnings"], [tuple(cut) for cut in plain["cuts"]]
        self.events.from_plain(plain)
        self.capture.from_plain(plain["capture"])

    def _beyond_samples(self, run, stop, end):
        """Return the time up to which compiled code may step beyond ``stop``, where it restarts, or ``stop`` itself.

        The first step after a restart of a model with several contacts is made by ``ordinary``.
        """
        one_by_one = self.observers or len(self.shocks.impact_candidates.opening) > 1
        if one_by_one or not self.method.restarts_in_compiled_code():
            return stop
        i = bisect_right(self._others, run.motion.t)
        return min(self._others[i], end) if i < len(self._others) else end

    def _steps_towards(self, run, stop, end):
        """Make ordinary steps towards ``stop`` in compiled code, then one in Python if the next is not ordinary.

        Compiled code may pass times of samples, and at which late jumps arrive, up to ``end``.
        """
        self._before = run
        self.pause(run)
        restarts = self.samples and (stop in self._is_sample or stop in self.system.arrivals(run.motion.memory))
        until = self._beyond_samples(run, stop, end) if restarts else stop
        run, trial, decide = self.ordinary(run, until)
        self._before = run
        if decide and run.motion.t >= stop:
            stop = self._next_stop(run, end)
            decide = stop - run.motion.t >= self._shortest(stop)
        return self._advance(run, stop, trial) if decide else run

    def ordinary(self, run: RunState, stop: float) -> "tuple[RunState, Trial | None, bool]":
        """Make ordinary steps towards ``stop`` (``OrdinarySteps.advance``), one at a time if there are observers."""
        starts = not run.history.known and len(self.shocks.impact_candidates.opening) > 1
        if self.monitor.captures or starts and self.shocks.approaching(run.motion, self.monitor.values(run.motion)):
            return run, None, True  # a contact might close and open again within a first step
        if self._ordinary_steps is None:
            given = self.control, self.shocks, self.observation, self.recorder
            self._ordinary_steps = self.method.ordinary_steps(*given)
            if self.samples:
                self._ordinary_steps.end_at(self.samples, self._is_corner, self.longest_restart)
        if not self.observers:
            return self._ordinary_steps.advance(run, stop, MOST_STEPS)
        new, trial, decide = self._ordinary_steps.advance(run, stop, 1)
        if new is not run:
            info, h = self._ordinary_steps.last(run)
            self._observed(Accepted(run.motion, new, info, h, new.rejected - run.rejected))
        return new, trial, decide

    def _advance(self, run, stop, trial=None):
        """Make one accepted step towards ``stop``, or an event at its beginning, from its first ``trial`` if made."""
        cuts: list[tuple[float, float]] = []
        if self.method.compliance is not None:
            trial = trial or self.trials.first(run, stop)
            if displacement := self.method.contradictions.yielding(trial):
                new = stiffened(self.method, run.tried(1, trial[2].iterations), displacement)
                return new if new.motion is run.motion else replace(new, powers=self.observe(new.motion).powers)
        try:
            h, trial, found, rejected, iterations = self.trials.acceptable(run, stop, trial, cuts)
        finally:
            if cuts:
                self.method.insist(False)  # also for a caller that catches what ``pause`` raises, and continues
        self.cuts += cuts  # only now: ``pause`` may raise during the trials, and the resumed run repeats them
        if cuts and len(self.cuts) > MOST_CUTS and cuts[-1][0] - self.cuts[-MOST_CUTS][0] < self.control.maximum:
            refuse_binding(self.method, run.motion)
        counted = run.tried(rejected, iterations)
        if found is None:
            return self._accept(counted, trial, h, rejected, stop, failed=bool(cuts))
        if found.trial is None:
            return self._change_phases(counted, trial[2], found, rejected)
        return self._accept_event(replace(counted, h=h) if rejected else counted, found, rejected)

    def _accept(self, run, trial, h, rejected, stop, failed):
        s, history, info = trial
        if run.steps % PROBE == PROBE - 1 and self.control.holds(info.error, h):
            info.error = self.trials.bounded(trial, h)
        planned = self.control.after(info.error, h, info.iterations)
        if not rejected and h < run.h:
            planned = max(planned, run.h)  # a step shortened to end at a given time does not shorten the next
        if failed:
            planned = min(planned, h)  # what Newton's iteration did not solve would fail again
        if planned > h:
            longest = longest_step(s.v, self.system.numbering, self.method.turn)
            planned = min(planned, longest) if longest >= HOLD * h else h
        met = abs(s.t - stop) <= max(NEGLIGIBLE_TIME * h, math.ulp(stop))
        if met and h <= SHORT * run.h and stop in self._is_corner:
            s = self._consistent(s, run.h)
            info = replace(info, forces=None)
        new = self._stepped(run, s, history, planned, h, info)
        if met:
            s.t = stop
        if self.monitor.captures:
            self.capture.accepted(info.event_records, whole=h >= run.h)
        self._notify(Accepted(run.motion, new, info, h, rejected, info.event_records))
        return new

    def _change_phases(self, run, info, found, rejected):
        """Apply events at the start of a step, where time advances by rounding; impacts at consistent velocities."""
        s = replace(run.motion, t=run.motion.t + found.h)
        if self.shocks.impact_candidates.among(found.hit):
            s = self._consistent(s, run.h, impact=True)
        run = self._slowed(run, found.hit)
        run, s, event_records, consistent = self.events.apply(run, s, found.hit, at_once=True)
        new = self._start_behind_event(run, s, consistent)
        self._notify(Accepted(run.motion, new, info, 0.0, rejected, tuple(event_records)))
        return new

    def _accept_event(self, run, found, rejected):
        h, trial, hit = found
        s, history, info = trial
        info.error = self.trials.judged(trial, h)
        reached = self._powers_before(run, s, h)
        s = self._consistent(s, run.h, impact=self.shocks.impact_candidates.among(hit))
        info = replace(info, forces=None)
        here = self.monitor.values(s)
        new = self._stepped(run, s, history, run.h, h, info, reached)
        hit = self.monitor.together(hit, self.monitor.values(run.motion), here, self.monitor.values(s))
        after, s, event_records, consistent = self.events.apply(self._slowed(new, hit), s, hit)
        if self.monitor.captures:
            self.capture.accepted(info.event_records, whole=False)
        self._notify(Accepted(run.motion, new, info, h, rejected, (*info.event_records, *event_records)))
        return self._start_behind_event(after, s, consistent)

    def _start_behind_event(self, run, s, consistent):
        """Restart the run at ``s``; what rates that depend on velocities change after a shock, their drives give."""
        new, driven = self.start_again(run, s, consistent), len(self.system.driving_signals) > 0
        before, after = (float(self.observe(one).energy[0]) if driven else 0.0 for one in (s, new.motion))
        return replace(new, given=new.given + after - before)

    def _slowed(self, run, hit):
        """Return the run with a step no longer than a restart allows if some events ``hit`` are conditions.

        They may switch on what is zero at the ends of a long step, such as a wave.
        """
        return replace(run, h=min(run.h, self.longest_restart)) if np.any(hit[self.monitor.conditions]) else run

    def _consistent(self, s, h, impact=False):
        """Return ``s`` with consistent accelerations and multipliers.

        Accelerations and multipliers of a very short step have the rounding error of the positions over the square of
        the step size. Before an ``impact`` the positions are those without the deflection of compliances.
        """
        method = self.method
        s, consistent = method.consistent(s, h)
        if impact and method.compliance is not None:
            s = consistent.without_compliance(s)
        return s

    def _stepped(self, run, s, history, planned, h, info, reached=None):
        """Return the run after an accepted step to ``s``: memories committed, outputs observed, work added.

        The work of a step without stages is that of the trapezoidal rule; ``reached`` are the powers at the end of the
        step if ``s`` has new accelerations.
        """
        forces = self.system.forces(s) if info.forces is None else info.forces
        s.memory = self.system.commit(s)
        powers, work = self.observe(s, forces).powers, info.work
        if work is None:
            reached = powers if reached is None else reached
            work = [[0.5 * h * (power0 + power) for power0, power in zip(run.powers, reached, strict=True)]]
        return RunState(
            motion=s, history=history, h=planned, steps=run.steps + 1, powers=powers, compliance=run.compliance,
            rejected=run.rejected, iterations=run.iterations,
            dissipated=run.dissipated + float(work[-1][0]), given=run.given + float(work[-1][1]),
        )  # fmt: skip

    def start_again(
        self, run: RunState, s: "State", consistent: "Consistent | None" = None, size: float | None = None
    ) -> RunState:
        """Return the run with consistent accelerations and a new history at ``s``, after an event or a corner.

        ``size`` is that of the first step, if it is not the planned one.
        """
        s, history = self.method.start(s, size or run.h, consistent)
        s = replace(s, memory=self.system.commit_jumps(s))
        new = replace(run, motion=s, history=history, powers=self.observe(s).powers)
        if self.recorder is not None:
            self.recorder.restarted(new, passing=self._passes(s, run.h))  # forces may jump
        return new

    def _start_behind_corner(self, run, end):
        """Restart the run just after the corner at its end, with the slopes of the laws there, for steps to ``end``.

        At the corner itself a table that holds its last value still has the slope before it.
        """
        from mecano.solve.time.driven_jumps import work_of_jumps  # few runs need it

        behind, h = replace(run.motion, t=np.nextafter(run.motion.t, math.inf)), min(run.h, self.longest_restart)
        given = run.given + work_of_jumps(self.system, self.method, run.motion, behind, h)
        run = replace(run, motion=behind, h=h, given=given)
        stop = self._next_stop(run, end)
        return self.start_again(run, behind, size=first_size(behind.t, h, stop, stop in self._is_corner))

    def _passes(self, s, h):
        """Return whether another event follows at the same instant."""
        values = self.shocks.departing(s, self.monitor.values(s))
        due = values > 0.0
        return bool(due.any()) and bool(np.any(due & (look_ahead(self.monitor, s, values, h)[1] >= 0.0)))

    def _powers_before(self, run, s, h):
        """Return the powers at the end of a step of size h to an event, before the accelerations jump there."""
        return run.powers if h <= SHORT * run.h else self.system.observe(s).powers

    def observe(self, s: "State", forces: "np.ndarray | None" = None) -> Observation:
        """Return the outputs and powers at ``s``."""
        return self.system.observe(s, forces, self.observation)

    def _notify(self, accepted):
        if self.recorder is not None:
            self.recorder(accepted)
        self._observed(accepted)

    def _observed(self, accepted):
        for observer in self.observers:
            observer(accepted)
