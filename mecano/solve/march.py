"""The time loop: the only place that accepts a step, commits memories, changes a mode or calls an observer."""

from dataclasses import dataclass, field, replace

import numpy as np

from mecano.errors import ConvergenceError, NonFiniteError
from mecano.solve.events import Watch, locate
from mecano.solve.run_state import RunState
from mecano.solve.step_control import AFTER_FAILURE

REPORTED = 5  # equations named when Newton fails
SLIVER = 1e-6  # of a step: no step is made to cover less
STRETCH = 1.01  # a step is made so much longer rather than leave a very short one before a time to be met


@dataclass(slots=True)
class Accepted:
    """What observers are told of an accepted step."""

    before: object  # State at the beginning of the step
    run: RunState
    info: object  # StepInfo
    h: float
    rejected: int  # trials rejected before it
    work: tuple  # dissipated and given [J] at the beginning of the step
    happenings: tuple = ()  # events at its end

    def at(self, state):
        """The run at a ``state`` within the step, work interpolated."""
        run, (dissipated, given) = self.run, self.work
        u = (state.t - self.before.t) / self.h
        return RunState(
            state, run.history, run.h, run.steps, run.rejected, run.iterations,
            dissipated + u * (run.dissipated - dissipated), given + u * (run.given - given), run.powers,
        )  # fmt: skip


@dataclass
class March:
    """A march of ``system`` by ``method`` with step sizes from ``control``; ``run`` is where it stands."""

    system: object
    method: object
    control: object
    observers: tuple = ()
    breakpoints: tuple = ()  # times that a step must end on: corners of laws of time
    watch: Watch = field(init=False)

    def __post_init__(self):
        self.watch = Watch(self.system)

    def begin(self, s, h):
        """RunState at the start: consistent velocities, accelerations and multipliers."""
        s, history = self.method.start(self.watch.settle(s), h)
        run = RunState(s, history, h)
        self._observe(s)
        return replace(run, powers=self._powers())

    def to(self, end, run):
        """March ``run`` to the time ``end``: the new RunState. Raises ConvergenceError, NonFiniteError."""
        stops = [t for t in sorted(self.breakpoints) if run.motion.t < t < end] + [end]
        for stop in stops:
            while run.motion.t < stop:
                run = self._advance(run, stop, end)
            if stop < end:
                run = self._start_again(run, run.motion)
        return run

    def _advance(self, run, stop, end):
        """One accepted step towards ``stop``."""
        s0, g0, rejected = run.motion, self.watch.values(run.motion), 0
        h, history = self._clip(run, stop), run.history
        iterations = 0
        while True:
            history = self._history_for(run, h)
            trial = self.method.step(s0, history, h)
            iterations += trial[2].iterations
            if not trial[2].ok:
                h = self._smaller(trial[2], s0.t, h)
                rejected += 1
                continue
            if not self.control.accept(trial[2].error, h):
                h = self.control.retry(trial[2].error, h)
                rejected += 1
                continue
            break
        found = locate(self.watch, lambda d: self._step(run, d), s0, g0, trial, h) if len(g0) else None
        counted = run.tried(rejected, iterations)
        if found is None:
            return self._accept(counted, trial, h, rejected, stop)
        if found[1] is None:
            s, happenings = self.watch.apply(s0, found[2])
            run = self._start_again(counted, s)
            self._tell(Accepted(s0, run, trial[2], 0.0, rejected, run.work, tuple(happenings)))
            return run
        return self._accept_event(replace(counted, h=h) if rejected else counted, found, rejected)

    def _step(self, run, h):
        return self.method.step(run.motion, self._history_for(run, h), h)

    def _history_for(self, run, h):
        """The history of the run, carried over to the step size h where it differs."""
        return run.history if run.history.h == h else self.method.restart(run.motion, run.history, h)

    def _clip(self, run, stop):
        """The step to try: the planned one, or what is left to ``stop``."""
        left = stop - run.motion.t
        if left >= STRETCH * run.h:
            return run.h
        if stop not in self.breakpoints:
            return left if SLIVER * run.h < abs(left - run.h) else run.h
        while run.motion.t + left >= stop:  # the law of before a jump holds to the end of the step
            left = np.nextafter(left * (1.0 - 4e-16), 0.0)
        return left

    def _accept(self, run, trial, h, rejected, stop):
        s, history, info = trial
        planned = self.control.after(info.error, h)
        if not rejected and h < run.h:
            planned = max(planned, run.h)  # a step cut short to meet a time does not shorten the next
        new = self._stepped(run, s, history, planned, h)
        if abs(s.t - stop) <= SLIVER * h:
            s.t = stop
        self._tell(Accepted(run.motion, new, info, h, rejected, run.work))
        return new

    def _accept_event(self, run, found, rejected):
        h, (s, history, info), hit = found
        # of a very short step the accelerations and multipliers are rounding of the positions over h^2
        s, _ = self.method.start(s, run.h)
        self.system.assemble(s, 1.0, 0.0, 0.0, 0.0, 0.0)
        new = self._stepped(run, s, history, run.h, h)
        after, happenings = self.watch.apply(s, hit)
        self._tell(Accepted(run.motion, new, info, h, rejected, run.work, tuple(happenings)))
        return self._start_again(new, after)

    def _stepped(self, run, s, history, planned, h):
        """The run after an accepted step to ``s``: memories committed, work added by the trapezoidal rule.

        Afterwards the outputs of the batches are those of ``s``, which the step has just evaluated.
        """
        s.memory = self.system.commit(s)
        self.system.observe(s)
        dissipated, given = powers = self._powers()
        return RunState(
            s, history, planned, run.steps + 1, run.rejected, run.iterations,
            run.dissipated + 0.5 * h * (run.powers[0] + dissipated),
            run.given + 0.5 * h * (run.powers[1] + given),
            powers,
        )  # fmt: skip

    def _start_again(self, run, s):
        """Consistent accelerations and a fresh history at ``s``: after an event or a corner of a law of time."""
        s, history = self.method.start(s, run.h)
        self._observe(s)
        return replace(run, motion=s, history=history, powers=self._powers())

    def _observe(self, s):
        """Outputs at a state that no step has just evaluated."""
        self.system.assemble(s, 1.0, 0.0, 0.0, 0.0, 0.0)
        self.system.observe(s)

    def _powers(self):
        return float(self.system.energy[2]), float(self.system.energy[3])

    def _tell(self, accepted):
        for observer in self.observers:
            observer(accepted)

    def _smaller(self, info, t, h):
        if h * AFTER_FAILURE >= self.control.minimum:
            return h * AFTER_FAILURE
        message = failure(self.system, info, t, h)
        raise (NonFiniteError if "not finite" in info.message else ConvergenceError)(message)


def failure(system, info, t, h):
    """What a user should know when a step cannot be taken: the worst equations by name, and what to try."""
    of = system.numbering
    r, size = np.abs(system.residual[: system.n]), system.size[: system.n]
    scale = np.array([max(size[of.kind[: system.n] == kind].max(initial=0.0), 1e-300) for kind in range(5)])
    order = np.argsort(-np.nan_to_num(r / scale[of.kind[: system.n]], nan=np.inf))[:REPORTED]
    worst = "\n".join(f"  {of.name[i]}: residual {r[i]:.3g}" for i in order)
    force, constraint, increment = info.norms
    return (
        f"no step could be taken at t = {t:.9g} s; the last try was h = {h:.3g} s: {info.message}\n"
        f"over their tolerances: forces {force:.3g}, constraints {constraint:.3g}, increments {increment:.3g}\n"
        f"worst equations:\n{worst}\n"
        "what to try: a smaller time.step; a smaller time.rho_inf; laws without jumps near this state; "
        "`mecano check` for redundant constraints and mechanisms"
    )
