"""The arrays of a compiled loop over steps (stride.py, radau_stride.py), and the work of Python between its calls."""

import time as clock
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

import numpy as np

from mecano.model import loops
from mecano.model.loop_records import Pointers, record
from mecano.solve.time.output import FULL, OUTPUT, Output, record_step
from mecano.solve.time.run_state import RunState
from mecano.solve.time.step_info import StepInfo
from mecano.solve.time.stride import READY, RECORDED, REPEAT, STRIDE
from mecano.solve.time.workspace import BEGIN, Workspace

if TYPE_CHECKING:
    from mecano.jit.entry import PackedCall
    from mecano.model.assembly import Observation
    from mecano.model.state import History, RadauHistory
    from mecano.model.system import System
    from mecano.solve.events.shocks import Shocks
    from mecano.solve.time.contradictions import Contradictions
    from mecano.solve.time.step_control import StepControl
    from mecano.solve.time.time_integration import Accepted


class Recorder(Protocol):
    """Receives the steps of a time integration (analyses/recorder.py)."""

    output: Output  # the buffers for the steps of compiled code

    def __call__(self, accepted: "Accepted") -> None:
        """Take a step that Python made."""

    def restarted(self, run: RunState, passing: bool = False) -> None:
        """Begin the next step with ``run``, whose forces may have jumped; ``passing``: an event follows at once."""

    def empty(self, again: bool = False) -> None:
        """Empty full buffers, possibly ``again`` in one step."""

    def refuse(self, t: float) -> None:
        """Raise an error if the run cannot continue from the last step, which ended at ``t`` [s]."""


class StrideArrays(Pointers):
    """The record STRIDE of a time integration, and the arrays to which it points.

    Parameters
    ----------
    system, control, shocks :
        Those of the TimeIntegrator.
    workspace : Workspace
        That of the method.
    turn : float
        Largest angle [rad] by which a body may turn in a step that grows.
    attempt : PackedCall
        A trial of a step.
    observation : Observation
        Written at the end of each step.
    recorder : Recorder or None
    """

    def __init__(
        self,
        system: "System",
        control: "StepControl",
        shocks: "Shocks",
        workspace: "Workspace",
        turn: float,
        attempt: "PackedCall",
        observation: "Observation",
        recorder: Recorder | None,
    ):
        super().__init__(STRIDE)
        self.recorder, self.workspace = recorder, workspace
        self.output = record(OUTPUT) if recorder is None else recorder.output.record
        departing = shocks.impact_candidates.opening.events
        self._kept = observation, attempt  # with arrays whose addresses stand in the record
        self.point_to(
            tolerance=control.tolerance, duration=control.duration, minimum=control.minimum, maximum=control.maximum,
            turn=turn, attempt=attempt.function, attempt_words=attempt.words, observation=observation.record,
            n_departing=len(departing), departing=departing, n_events=system.n_events,
            before_values=np.zeros((4, system.n_events)),
            n_brief=len(shocks.monitor.brief), brief=shocks.monitor.brief,
            n_conditions=len(shocks.monitor.conditions), conditions=shocks.monitor.conditions,
        )  # fmt: skip
        self.point_to_loops(
            event=system.loops(loops.event_values), observe=system.loops(loops.observe),
            commit=system.loops(loops.commit),
        )  # fmt: skip
        if recorder is not None:
            self._record = record_step.call_from_compiled_code(self.output, workspace.record)
            self.point_to(records=True, record=self._record.function, record_words=self._record.words)

    def put_run(self, run: RunState, contradictions: "Contradictions") -> None:
        """Enter the counters of a run, and its planned step."""
        r = self.record[0]
        r["phase"], r["planned"], r["steps"], r["iterations"] = READY, run.h, run.steps, run.iterations
        r["rejected"] = run.rejected
        r["dissipated"], r["given"] = run.dissipated, run.given
        r["power_dissipated"], r["power_given"] = run.powers
        for name, value in contradictions.fields:
            r[name] = value

    def run(self, before: RunState, history: "History | RadauHistory") -> RunState:
        """Return the RunState at BEGIN with this history, after steps from the one ``before``."""
        r, s = self.record[0], before.motion
        return RunState(
            motion=self.workspace.state(BEGIN, s.phases, None if len(s.memory) else s.memory),
            history=history, h=float(r["planned"]),
            steps=int(r["steps"]), rejected=int(r["rejected"]), iterations=int(r["iterations"]),
            dissipated=float(r["dissipated"]), given=float(r["given"]),
            powers=(float(r["power_dissipated"]), float(r["power_given"])), compliance=before.compliance,
        )  # fmt: skip

    def steps(self, stride: "Callable[[], int]", stop: float, most: int, patience: float) -> tuple[int, bool]:
        """Make at most ``most`` steps towards ``stop`` [s] by ``stride``; return its code, and whether it made any.

        The buffers of the output are emptied as often as they are full.
        """
        full_at, r = -1, self.record[0]
        r["until"], r["most"], r["done"] = stop, most, 0
        self.workspace.record["due"] = clock.monotonic() + patience
        while (code := stride()) == RECORDED:
            assert self.recorder is not None, "steps are recorded only for a recorder"
            if self.output["code"][0] != FULL:
                self.recorder.refuse(float(self.workspace.states[BEGIN, -1]))
            self.recorder.empty(again=full_at == r["done"])
            full_at = int(r["done"])
        if code == REPEAT:
            r["phase"] = READY
        return code, r["done"] > 0

    def last(self, run: RunState) -> tuple[StepInfo, float]:
        """Return StepInfo and size of the last step, made from ``run``."""
        o = self.output[0]
        norms, error = (float(o["forces"]), float(o["constraints"]), float(o["increment"])), float(o["error"])
        return StepInfo(True, int(o["iterations"]), norms, error, run.history, plain=error), float(o["h"])
