"""Ordinary steps of generalized-alpha: inputs of the compiled loop (stride.py), and the handling of its results."""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence, Set
from typing import TYPE_CHECKING

import numpy as np

from mecano.solve.time.run_state import RunState
from mecano.solve.time.step import attempt
from mecano.solve.time.step_control import SHORT, STRETCH, first_size
from mecano.solve.time.step_info import StepInfo, Trial
from mecano.solve.time.stride import DECIDE, ENOUGH, REPEAT, WAIT, stride
from mecano.solve.time.stride_arrays import Recorder, StrideArrays
from mecano.solve.time.workspace import BEGIN, RENEWED, TANGENT

if TYPE_CHECKING:
    from mecano.model.assembly import Observation
    from mecano.model.state import State
    from mecano.solve.events.shocks import Shocks
    from mecano.solve.time.generalized_alpha import GeneralizedAlpha
    from mecano.solve.time.step_control import StepControl


class OrdinarySteps:
    """Ordinary steps of generalized-alpha, in compiled code.

    Parameters
    ----------
    method : GeneralizedAlpha
    control, shocks :
        Those of the TimeIntegrator.
    observation : Observation
        Written at the end of each step.
    recorder : Recorder or None
    """

    def __init__(
        self,
        method: "GeneralizedAlpha",
        control: "StepControl",
        shocks: "Shocks",
        observation: "Observation",
        recorder: Recorder | None,
    ):
        self.method, self.control = method, control
        self.workspace, self.linear = method.workspace, method.linear
        packed = attempt.call_from_compiled_code(self.workspace.record)
        self.arrays = StrideArrays(
            method.system, control, shocks, self.workspace, method.turn, packed, observation, recorder
        )
        self.record = self.arrays.record
        self._stride = stride.bind(self.record, self.workspace.record, self.arrays.output)
        self._tangent: State | None = None  # of the tangent in the workspace
        self._samples: np.ndarray | None = None  # times [s], if compiled code restarts there
        self._corners: Set[float] = frozenset()
        if control.adaptive:
            self._change_steps()
            self._bound_errors()

    def end_at(self, samples: Sequence[float], corners: Set[float], longest_restart: float) -> None:
        """Let compiled code end steps at ``samples`` [s], ascending, and restart there.

        ``corners`` are all times at which forces jump; no restart begins with a step above ``longest_restart`` [s].
        """
        restarting, w, r = self.method.compiled_restart, self.workspace, self.record
        if restarting is None:
            return
        from mecano.solve.time.sampled_restart import restart_at_sample  # few runs sample signals

        self._samples, self._corners = np.array(samples), corners
        places = self.method.system.places_of_arrivals
        self.arrays.point_to(n_arrivals=len(places), arrivals=places)
        self._at_sample = restart_at_sample.call_from_compiled_code(r, restarting.record, w.record, self.arrays.output)
        r["at_sample"], r["at_sample_words"] = self._at_sample.function, self._at_sample.words.ctypes.data
        r["longest_restart"] = longest_restart
        self._change_steps()

    def advance(self, run: RunState, stop: float, most: int) -> "tuple[RunState, Trial | None, bool]":
        """Make at most ``most`` steps towards ``stop`` [s]; return (run, trial, whether Python makes the next step).

        The trial is a step from the returned run, still to be accepted or rejected, or None.
        """
        first = stop if self._samples is None else self._first_restart(self._samples, run.motion, stop)
        if stop - run.motion.t < STRETCH * run.h or first - run.motion.t <= SHORT * run.h:
            return run, None, True
        if self.workspace.held is not run:
            self._load(run, first)
        if self._samples is not None:
            self._enter_samples(self._samples, run.motion.t, stop)
        code, advanced = self.arrays.steps(self._make_steps, stop, most, self.method.patience)
        if advanced:
            run = self.arrays.run(run, self.workspace.last_history(self._tangent))
        # after ENOUGH a step of another size needs a history that is not there
        self.workspace.held = run if code == WAIT or run.h == self.workspace.record["h"][0] else None
        if code == DECIDE:
            return run, self._trial(run), True
        if code == ENOUGH and self._samples is not None:
            stop = self._first_restart(self._samples, run.motion, stop)
        return run, None, code == REPEAT or (code == ENOUGH and stop - run.motion.t < STRETCH * run.h)

    def _make_steps(self):
        """Make steps in compiled code; keep the States of tangents that it evaluated, for the factor in the solver."""
        r, w = self.record, self.workspace
        before = r["renewed_tangents"][0]
        code = self._stride()
        if r["renewed_tangents"][0] != before:
            self._tangent = w.state(TANGENT, self._phases) if w.record["usable"][0] else None
            self.linear.solved(self._tangent)
        if w.record["renewed"][0]:
            self.linear.solved(w.state(RENEWED, self._phases))
        return code

    def _first_restart(self, samples, s, stop):
        """Return the first time behind ``s`` [s] at which compiled code restarts, or ``stop`` if that is earlier."""
        i = bisect_right(samples, s.t)
        times = *samples[i : i + 1], *self.method.system.arrivals(s.memory)
        return min([stop, *(t for t in times if t > s.t)])

    def _enter_samples(self, samples, t, stop):
        """Enter the sampling times between t and ``stop`` [s]."""
        first, last = bisect_right(samples, t), bisect_left(samples, stop)
        self.arrays.point_to(
            n_samples=last - first, samples=samples.ctypes.data + 8 * first, next_sample=0,
            jumps_at_end=stop in self._corners,
        )  # fmt: skip

    def _load(self, run, stop):
        """Enter the run, with a history for the size of its next step, into the workspace."""
        history, size = run.history, run.h
        if history.h != size:  # a history for a first step that ends at a given time is kept
            size = first_size(run.motion.t, run.h, stop, stop in self._corners)
        if history.h != size:
            history = self.method.restart(run.motion, history, size)
            self._change_steps()
        self.method.prepare(run.motion, history, size)
        if history.tangent is not None:
            self.workspace.put_state(TANGENT, history.tangent)
        if history is not run.history:
            self.workspace.put_unchanged(run.history)
        self._phases, self._tangent = run.motion.phases, history.tangent
        self.arrays.put_run(run, self.method.contradictions)

    def _change_steps(self):
        """Let compiled code change the step size from now on; the code is not loaded before it is needed."""
        if not self.record["change_step"][0]:
            packed = self.method.change_step
            self.record["change_step"], self.record["change_step_words"] = packed.function, packed.words.ctypes.data

    def _bound_errors(self):
        """Let compiled code bound the errors of oscillations."""
        bound = self.method.error_bound
        self.record["bound"], self.record["bound_error"] = bound.record.ctypes.data, bound.call.function
        self.record["bound_error_words"] = bound.call.words.ctypes.data

    def last(self, run: RunState) -> tuple[StepInfo, float]:
        """Return StepInfo and size of the last step, made from ``run``."""
        return self.arrays.last(run)

    def _trial(self, run):
        """Return the step at TRIAL as ``method.step`` does, with its error."""
        history = self.workspace.new_history(BEGIN, self.workspace.v_shift.copy(), self._tangent)
        iterations = int(self.record["in_vain"][0] + self.workspace.report[0])
        s, new, info = self.method.trial(run.motion, history, iterations)
        h = float(self.workspace.record["h"][0])
        info.error = info.plain = max(info.error, self.control.forgotten(info.lag, h), info.signalled)
        return s, new, info
