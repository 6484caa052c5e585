"""The time loop: the only place that accepts a step, commits memories, changes a mode or calls an observer."""

import math
from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from mecano.errors import AssemblyError, NonFiniteError
from mecano.solve.diagnostics import failure
from mecano.solve.events.events import EventMonitor, locate
from mecano.solve.events.shocks import Shocks
from mecano.solve.time.run_state import RunState
from mecano.solve.time.signals import solve_signals
from mecano.solve.time.step_control import AFTER_FAILURE, HOLD
from mecano.solve.time.stride import PROBE, STRETCH, Strides

STANDSTILL = 1e-3  # of a step: time that goes on by less stands still
MOST_REBOUNDS = 10  # of one contact while time stands still: what rebounds so quickly has come to rest
MOST_AT_ONCE = 20  # times that one event of one element may happen while time stands still
NEGLIGIBLE_TIME = 1e-6  # of a step: no step is made to cover less
LEAST_ULPS = 1e4  # spacings of floating-point numbers in a step: those between times so near tell them apart too badly
MOST_STEPS = 2**62  # in one call of compiled code: any number
MOST_NAMES = 8  # named in a remark
SHORT = 1e-3  # of a step: what a shorter one tells of reactions is rounding


@dataclass(slots=True)
class Accepted:
    """What observers are told of an accepted step."""

    before: object  # State at the beginning of the step
    run: RunState
    info: object  # StepInfo
    h: float
    rejected: int  # trials rejected before it
    event_records: tuple = ()  # events at its end


@dataclass
class TimeIntegrator:
    """A march of ``system`` by ``method`` with step sizes from ``control``; ``run`` is where it stands."""

    system: object
    method: object
    control: object
    observers: tuple = ()  # called with Accepted at every step
    breakpoints: tuple = ()  # times that a step must end on: corners of laws of time
    rest: float = 1e-4  # of the length scale, or rad, per second: an approach that is slower does not rebound
    pause: object = lambda run: None  # called in a step with the RunState before it; may raise
    recorder: object = None  # takes steps from compiled code, see ``Strides``; and, called with Accepted, from Python
    reporters: tuple = ()  # called with the RunState now and then
    monitor: EventMonitor = field(init=False)
    shocks: Shocks = field(init=False)
    warnings: list = field(init=False, default_factory=list)  # what a user should know at the end
    cuts: list = field(init=False, default_factory=list)  # (time, step size) of trials that failed and were cut
    _strides: Strides = field(init=False, default=None)
    _before: RunState = field(init=False, default=None)  # at the beginning of the step
    _since: float = field(init=False, default=-np.inf)  # time from which on it stands still [s]
    _at_once: Counter = field(init=False, default_factory=Counter)  # events since then

    def __post_init__(self):
        self.monitor = EventMonitor(self.system)
        self.shocks = Shocks(self.system, self.method, self.monitor, self.rest)

    def begin(self, s, h):
        """RunState at the start: consistent velocities, accelerations and multipliers."""
        s = replace(s, memory=self.system.commit(solve_signals(self.system, s.copy())))
        s, history = self.method.start(self.monitor.settle(s), h)
        run = RunState(s, history, h, compliance=self.method.compliance)
        self._observe(s)
        return replace(run, powers=self._powers())

    def to(self, end, run):
        """March ``run`` to the time ``end``: the new RunState. Raises ConvergenceError, NonFiniteError."""
        try:
            return self._to(end, run)
        except AssemblyError as error:
            raise failure.no_restart(error, self._before.motion.t) from error
        except NonFiniteError as error:
            raise failure.with_sources(error, self.system, self._before.motion) from error

    def _to(self, end, run):
        if run.compliance is not self.method.compliance:
            self.method.use(run.compliance)
        self._before, self.method.pause = run, lambda: self.pause(self._before)
        stops = [t for t in sorted(self.breakpoints) if run.motion.t < t < end] + [end]
        for stop in stops:
            while run.motion.t < stop:
                if stop - run.motion.t < self._shortest(stop):  # an event may lie so near before it
                    run = replace(run, motion=replace(run.motion, t=stop))
                    break
                run = self._onward(run, stop)
                for report in self.reporters:
                    report(run)
            if stop < end:
                run = self._start_again(run, run.motion)
        return run

    def _shortest(self, stop):
        """Time to a ``stop`` below which none is left for a step: its size is rounding, or its square nothing."""
        return max(LEAST_ULPS * math.ulp(stop), NEGLIGIBLE_TIME * self.control.minimum)

    def to_plain(self):
        """What the march keeps besides the run, as dicts, lists, texts and numbers."""
        at_once = [[*key, count] for key, count in self._at_once.items()]
        return {"remarks": list(self.warnings), "cuts": list(self.cuts), "since": self._since, "at_once": at_once}

    def from_plain(self, plain):
        """Keep what ``to_plain`` told of another march."""
        self.warnings, self.cuts = list(plain["remarks"]), [tuple(cut) for cut in plain["cuts"]]
        self._since = plain["since"]
        self._at_once = Counter({(element, name): count for element, name, count in plain["at_once"]})
        self._suppress_rebound()

    def _onward(self, run, stop):
        """Ordinary steps towards ``stop`` in compiled code; if none can be made, or the next is not, one by Python."""
        self._before = run
        self.pause(run)
        run, trial, decide = self.ordinary(run, stop)
        self._before = run
        return self._advance(run, stop, trial) if decide else run

    def ordinary(self, run, stop):
        """Make ordinary steps towards ``stop``: see ``Strides.advance``; one at a time where each is observed."""
        if self._strides is None:
            self._strides = Strides(self.system, self.method, self.control, self.shocks, self.recorder)
        if not self.observers:
            return self._strides.advance(run, stop, MOST_STEPS)
        new, trial, decide = self._strides.advance(run, stop, 1)
        if new is not run:
            self._observed(Accepted(run.motion, new, self._strides.info(run), run.h, 0))
        return new, trial, decide

    def _advance(self, run, stop, trial=None):
        """One accepted step towards ``stop``, or an event at the beginning of it; ``trial``, if given, is that step."""
        g0 = self.shocks.departing(run.motion, self.monitor.values(run.motion))
        h, rejected, iterations, found, cuts = self._clip(run, stop), 0, 0, None, []
        while True:
            trial = trial if trial and not rejected else self._step(run, h)
            iterations += trial[2].iterations
            smaller = self._instead(run, trial, h, cuts)
            if smaller is None:
                found = (
                    locate(self.monitor, lambda d: self._step(run, d), run.motion, g0, trial, h) if len(g0) else None
                )
                if found is None or found.ok:
                    break
                smaller = self._smaller(found.trial[2], run.motion.t, h, cuts)
            h, rejected = smaller, rejected + 1
        self.cuts += cuts  # not before: until now ``pause`` may have ended the march, and the step is tried again
        counted = run.tried(rejected, iterations)
        if found is None:
            return self._accept(counted, trial, h, rejected, stop)
        if found.trial is None:
            return self._change_phases(counted, trial[2], found, rejected)
        return self._accept_event(replace(counted, h=h) if rejected else counted, found, rejected)

    def _instead(self, run, trial, h, cuts):
        """The step size to try instead of h, noted in ``cuts``, or None where the trial with h can be accepted."""
        _, history, info = trial
        if not info.ok:
            return self._smaller(info, run.motion.t, h, cuts)
        info.error = self._judged(trial, h)
        if self.control.accept(info.error, h):
            return None
        if h <= self.control.minimum:
            share = info.error / self.control.allowed(h)
            raise failure.minimum_step(self.system, run.history.a, history.a, share, run.motion.t, h)
        return self.control.retry(info.plain, h)  # only steps that resolve what swings make its error smaller

    def _judged(self, trial, h):
        """The error of the ``trial``; with what swings bounded where the plain estimate is not accepted."""
        plain = trial[2].plain
        return plain if self.control.accept(plain, h) else self._bounded(trial, h)

    def _bounded(self, trial, h):
        info = trial[2]
        return max(self.method.bounded_error(*trial), self.control.forgotten(info.lag, h), info.turning)

    def _step(self, run, h):
        s, history, info = self.method.step(run.motion, self._history_for(run, h), h)
        info.error = info.plain = max(info.error, self.control.forgotten(info.lag, h), info.turning)
        return s, history, info

    def _history_for(self, run, h):
        """The history of the run, carried over to the step size h where it differs."""
        return run.history if run.history.h == h else self.method.restart(run.motion, run.history, h)

    def _clip(self, run, stop):
        """The step to try: the planned one, or what is left to ``stop``."""
        left = stop - run.motion.t
        if left >= STRETCH * run.h:
            return run.h
        if stop not in self.breakpoints:
            return left if NEGLIGIBLE_TIME * run.h < abs(left - run.h) else run.h
        left = np.nextafter(stop, run.motion.t) - run.motion.t  # the law of before a jump holds to the end of the step
        return left if run.motion.t + left < stop else np.nextafter(left, 0.0)  # unless its sum was rounded up

    def _accept(self, run, trial, h, rejected, stop):
        s, history, info = trial
        if run.steps % PROBE == PROBE - 1 and self.control.holds(info.error, h):
            info.error = self._bounded(trial, h)
        planned = self.control.after(info.error, h)
        if not rejected and h < run.h:
            planned = max(planned, run.h)  # a step cut short to meet a time does not shorten the next
        if planned > h:
            longest = self.method.longest(s)
            planned = min(planned, longest) if longest >= HOLD * h else h
        met = abs(s.t - stop) <= max(NEGLIGIBLE_TIME * h, math.ulp(stop))
        if met and h <= SHORT * run.h and stop in self.breakpoints:
            s = self._consistent(s, run.h)
        new = self._stepped(run, s, history, planned, h)
        if met:
            s.t = stop
        self._notify(Accepted(run.motion, new, info, h, rejected))
        return new

    def _change_phases(self, run, info, found, rejected):
        """Events at the beginning of a step: no time goes by."""
        run, s, event_records, consistent = self._apply_events(run, run.motion, found.hit, at_once=True)
        new = self._start_again(run, s, consistent)
        self._notify(Accepted(run.motion, new, info, 0.0, rejected, tuple(event_records)))
        return new

    def _apply_events(self, run, s, hit, at_once=False):
        """Events ``hit`` at ``s``: (run with the energy of shocks, state after, [EventRecord], Consistent or None)."""
        if not self.shocks.among(hit):
            before, compliance, consistent = s.phases, self.method.compliance, None
            s, event_records = self.monitor.apply(s, hit)
            self._guard(run, event_records)
            if compliance and len(compliance.released) and not np.array_equal(before, s.phases):
                consistent, compliance, redundant = self.shocks.consistent(s, compliance)
                self._soften(compliance, s.t, event_records, redundant)
            return replace(run, compliance=compliance), s, event_records, consistent
        hit = self.shocks.together(s, hit, run.h)
        shock = self.shocks.solve_impact(s, hit, self.method.compliance, run.h, at_once)
        self._guard(
            run, shock.event_records or self.monitor.apply(s, hit)[1]
        )  # or what cannot happen: a contact would pull
        self._soften(shock.compliance, s.t, shock.event_records, shock.redundant)
        work = {"dissipated": run.dissipated + shock.lost, "given": run.given + shock.given}
        return replace(run, compliance=shock.compliance, **work), shock.state, shock.event_records, shock.consistent

    def _soften(self, compliance, t, event_records, redundant):
        """Use a ``compliance`` that may be new, and keep what is to be told of the ``redundant`` Groups."""
        if compliance is not self.method.compliance:
            self.method.use(compliance)
        self.warnings += [_redundant(t, event_records, group) for group in redundant]

    def _accept_event(self, run, found, rejected):
        h, trial, hit = found
        s, history, info = trial
        info.error = self._judged(trial, h)
        reached = self._powers_before(run, s, h)
        s = self._consistent(s, run.h)
        here = self.monitor.values(s)
        new = self._stepped(run, s, history, run.h, h, reached)
        hit = self.monitor.together(hit, self.monitor.values(run.motion), here, self.monitor.values(s))
        after, s, event_records, consistent = self._apply_events(new, s, hit)
        self._notify(Accepted(run.motion, new, info, h, rejected, tuple(event_records)))
        return self._start_again(after, s, consistent)

    def _consistent(self, s, h):
        """``s`` with consistent accelerations and multipliers, evaluated: those of a very short step are rounding.

        They have that of the positions over the square of the step size.
        """
        s, _ = self.method.start(s, h)
        self.system.assemble(s, 1.0, 0.0, 0.0, 0.0, 0.0)
        return s

    def _guard(self, run, event_records):
        """Refuse events that happen again and again while time stands still."""
        t = run.motion.t
        if t - self._since > STANDSTILL * run.h:
            self._since = t
            self._at_once.clear()
        for event in event_records:
            self._at_once[event.element, event.name] += 1
            count = self._at_once[event.element, event.name]
            if count > MOST_AT_ONCE:
                raise failure.standstill(event, count, t)
        self._suppress_rebound()

    def _suppress_rebound(self):
        self.shocks.suppress_rebound(
            {element for (element, _), count in self._at_once.items() if count >= MOST_REBOUNDS}
        )

    def _stepped(self, run, s, history, planned, h, reached=None):
        """The run after an accepted step to ``s``: memories committed, work added by the trapezoidal rule.

        ``reached`` are the powers to which the step itself came where ``s`` is a start of its own. Afterwards the
        outputs of the batches are those of ``s``, which has just been evaluated.
        """
        s.memory = self.system.commit(s)
        self.system.observe(s)
        powers = self._powers()
        dissipated, given = powers if reached is None else reached
        return RunState(
            motion=s, history=history, h=planned, steps=run.steps + 1, powers=powers, compliance=run.compliance,
            rejected=run.rejected, iterations=run.iterations,
            dissipated=run.dissipated + 0.5 * h * (run.powers[0] + dissipated),
            given=run.given + 0.5 * h * (run.powers[1] + given),
        )  # fmt: skip

    def _start_again(self, run, s, consistent=None):
        """Consistent accelerations and a fresh history at ``s``: after an event or a corner of a law of time."""
        s, history = self.method.start(s, run.h, consistent)
        self._observe(s)
        new = replace(run, motion=s, history=history, powers=self._powers())
        if self.recorder is not None:
            self.recorder.restarted(new)  # forces may have jumped
        return new

    def _observe(self, s):
        """Outputs at a state that no step has just evaluated."""
        self.system.assemble(s, 1.0, 0.0, 0.0, 0.0, 0.0)
        self.system.observe(s)

    def _powers_before(self, run, s, h):
        """Powers as far as a step of size h came towards an event, as the motion had them on the way.

        Consistent accelerations are those behind it where they jump, and begin with none of scalars without inertia.
        """
        if h <= SHORT * run.h:
            return run.powers
        self._observe(s)
        return self._powers()

    def _powers(self):
        return float(self.system.energy[2]), float(self.system.energy[3])

    def _notify(self, accepted):
        if self.recorder is not None:
            self.recorder(accepted)
        self._observed(accepted)

    def _observed(self, accepted):
        for observer in self.observers:
            observer(accepted)

    def _smaller(self, info, t, h, cuts):
        if h * AFTER_FAILURE >= self.control.minimum:
            cuts.append((t, h * AFTER_FAILURE))
            return h * AFTER_FAILURE
        raise failure.no_step(self.system, info, t, h)


def _redundant(t, event_records, group):
    """What a user is told of constraints that repeat one another from an event on."""
    names = "; ".join(group.names[:MOST_NAMES]) + (" and more" if len(group.names) > MOST_NAMES else "")
    which = ", ".join(dict.fromkeys(f"{h.element} {h.name}" for h in event_records[:MOST_NAMES]))
    return (
        f"since t = {t:.6g} s ({which}) {group.count} constraint(s) are redundant among: {names}; the motion is not "
        "affected, but the reactions, and the impulses of the shock, are not unique: those of least size are given"
    )
