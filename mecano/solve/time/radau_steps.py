"""Ordinary steps of Radau IIA: inputs of the compiled loop (radau_stride.py), and the handling of its results."""

from collections.abc import Sequence, Set
from typing import TYPE_CHECKING

from mecano.model.state import RadauHistory
from mecano.solve.time.radau_step import attempt
from mecano.solve.time.radau_stride import stride
from mecano.solve.time.run_state import RunState
from mecano.solve.time.step_control import STRETCH
from mecano.solve.time.step_info import StepInfo, Trial
from mecano.solve.time.stride import DECIDE, ENOUGH, REPEAT
from mecano.solve.time.stride_arrays import Recorder, StrideArrays
from mecano.solve.time.workspace import BEGIN

if TYPE_CHECKING:
    from mecano.model.assembly import Observation
    from mecano.solve.events.shocks import Shocks
    from mecano.solve.time.radau import Radau


class RadauSteps:
    """Ordinary steps of Radau IIA, in compiled code; parameters as those of OrdinarySteps."""

    def __init__(self, method: "Radau", shocks: "Shocks", observation: "Observation", recorder: Recorder | None):
        self.method, self.workspace, self.stages = method, method.workspace, method.stages
        packed = attempt.call_from_compiled_code(self.workspace.record, self.stages.record)
        self.arrays = StrideArrays(
            method.system, method.control, shocks, self.workspace, method.turn, packed, observation, recorder
        )
        self.record = self.arrays.record
        self._stride = stride.bind(self.record, self.workspace.record, self.stages.record, self.arrays.output)

    def end_at(self, samples: Sequence[float], corners: Set[float], longest_restart: float) -> None:
        """Do nothing: Python restarts at sampling times."""

    def advance(self, run: RunState, stop: float, most: int) -> "tuple[RunState, Trial | None, bool]":
        """Make at most ``most`` steps towards ``stop`` [s]; return as ``OrdinarySteps.advance``."""
        if not self.stages.record["projects"][0] or stop - run.motion.t < STRETCH * run.h:
            return run, None, True
        history = run.history
        assert isinstance(history, RadauHistory), "a run has the history of its method"
        if self.workspace.held is not run:
            self.method.prepare(run.motion, history, run.h)
            self.arrays.put_run(run, self.method.contradictions)
        self.stages.mass.use(self.method.compliance)
        code, advanced = self.arrays.steps(self._make_steps, stop, most, self.method.patience)
        if advanced:
            history = self.stages.history(self.workspace.parts(BEGIN)[2].copy(), history.k)
            run = self.arrays.run(run, history)
        self.workspace.held = None if code == DECIDE else run
        if code == DECIDE:
            return run, self.method.trial(run.motion, history), True
        return run, None, code == REPEAT or (code == ENOUGH and stop - run.motion.t < STRETCH * run.h)

    def _make_steps(self):
        code = self._stride()
        self.method.factored()
        return code

    def last(self, run: RunState) -> tuple[StepInfo, float]:
        """Return StepInfo and size of the last step, made from ``run``."""
        info, h = self.arrays.last(run)
        info.stages, info.work = tuple(self.stages.stage(i, run.motion) for i in range(2)), self.stages.work.copy()
        return info, h
