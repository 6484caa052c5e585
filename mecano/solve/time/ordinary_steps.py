"""Ordinary steps of generalized-alpha: inputs of the compiled loop (stride.py), and the handling of its results."""

from typing import TYPE_CHECKING

from mecano.solve.time.run_state import RunState
from mecano.solve.time.step import attempt
from mecano.solve.time.step_info import StepInfo, Trial
from mecano.solve.time.stride import DECIDE, ENOUGH, REPEAT, STRETCH, WAIT, stride
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
        if control.adaptive:
            self._change_steps()
            self._bound_errors()

    def advance(self, run: RunState, stop: float, most: int) -> "tuple[RunState, Trial | None, bool]":
        """Make at most ``most`` steps towards ``stop`` [s]; return (run, trial, whether Python makes the next step).

        The trial is a step from the returned run, still to be accepted or rejected, or None.
        """
        if stop - run.motion.t < STRETCH * run.h:
            return run, None, True
        if self.workspace.held is not run:
            self._load(run)
        code, advanced = self.arrays.steps(self._make_steps, stop, most, self.method.patience)
        if advanced:
            run = self.arrays.run(run, self.workspace.last_history(self._tangent))
        # after ENOUGH a step of another size needs a history that is not there
        self.workspace.held = run if code == WAIT or run.h == self.workspace.record["h"][0] else None
        if code == DECIDE:
            return run, self._trial(run), True
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

    def _load(self, run):
        """Enter the run, with a history for its step size, into the workspace."""
        history = run.history
        if history.h != run.h:
            history = self.method.restart(run.motion, history, run.h)
            self._change_steps()
        self.method.prepare(run.motion, history, run.h)
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
