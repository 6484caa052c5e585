"""Ordinary steps of a time integration: their arrays, handed to the compiled loop (stride.py), and its answers."""

import time as clock
from typing import TYPE_CHECKING, Protocol

import numpy as np

from mecano.model import loops
from mecano.model.loop_records import record
from mecano.solve.time.output import FULL, OUTPUT, Output, record_step
from mecano.solve.time.run_state import RunState
from mecano.solve.time.step import attempt
from mecano.solve.time.step_info import StepInfo, Trial
from mecano.solve.time.stride import DECIDE, ENOUGH, READY, RECORDED, REPEAT, STRETCH, STRIDE, WAIT, stride
from mecano.solve.time.workspace import BEGIN, RENEWED, TANGENT

if TYPE_CHECKING:
    from mecano.model.assembly import Observation
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.events.shocks import Shocks
    from mecano.solve.time.generalized_alpha import GeneralizedAlpha
    from mecano.solve.time.step_control import StepControl
    from mecano.solve.time.time_integration import Accepted


class Recorder(Protocol):
    """Receives the steps of a time integration (analyses/recorder.py)."""

    output: Output  # the buffers for the steps of compiled code

    def __call__(self, accepted: "Accepted") -> None:
        """Take a step that Python made."""

    def restarted(self, run: RunState, passing: bool = False) -> None:
        """Begin the next step with ``run``, whose forces may have jumped; it may be ``passing``, left at once."""

    def empty(self, again: bool = False) -> None:
        """Empty full buffers, possibly ``again`` in one step."""

    def refuse(self, t: float) -> None:
        """Raise an error where the run cannot go on from the last step, to the time ``t`` [s]."""


class OrdinarySteps:
    """Ordinary steps of a time integration, in compiled code.

    Parameters
    ----------
    system, method, control, shocks :
        Those of the TimeIntegrator.
    observation : Observation
        Written at the end of each step.
    recorder : Recorder or None
    """

    def __init__(
        self,
        system: "System",
        method: "GeneralizedAlpha",
        control: "StepControl",
        shocks: "Shocks",
        observation: "Observation",
        recorder: Recorder | None = None,
    ):
        self.system, self.method, self.control, self.recorder = system, method, control, recorder
        self.workspace, self.linear = method.workspace, method.linear
        self._output = record(OUTPUT) if recorder is None else recorder.output.record
        departing = np.array([c.event for c in shocks.impact_candidates if c.opened >= 0], np.int64)
        self._values = np.zeros((2, system.n_events))
        found = {
            "events": system.loops(loops.event_values), "observed": system.loops(loops.observe),
            "committed": system.loops(loops.commit),
        }  # fmt: skip
        calls = {"attempt": attempt.call_from_compiled_code(self.workspace.record)}
        if recorder is not None:
            calls["record"] = record_step.call_from_compiled_code(self._output, self.workspace.record)
        self._kept: tuple = departing, observation, found, calls  # their addresses stand in the record
        addresses = {"departing": departing, "before_values": self._values, "observation": observation.record}
        addresses |= {name: addressed for name, (addressed, _) in found.items()}
        addresses |= {f"{name[:-1] if name[-1] == 's' else name}_batches": b for name, (_, b) in found.items()}
        addresses |= {f"{name}_words": packed.words for name, packed in calls.items()}
        self.record = record(
            STRIDE, tolerance=control.tolerance, duration=control.duration, minimum=control.minimum,
            maximum=control.maximum, records=recorder is not None, n_departing=len(departing),
            n_events=self._values.shape[1], n_event_batches=len(found["events"][0]),
            n_observed=len(found["observed"][0]), n_committed=len(found["committed"][0]),
            **{name: packed.function for name, packed in calls.items()},
            **{name: array.ctypes.data for name, array in addresses.items()},
        )  # fmt: skip
        self._stride = stride.bind(self.record, self.workspace.record, self._output)
        self._tangent: State | None = None  # of the tangent in the workspace
        if control.adaptive:
            self._change_steps()
            self._bound_errors()

    def advance(self, run: RunState, stop: float, most: int) -> "tuple[RunState, Trial | None, bool]":
        """Make at most ``most`` steps towards ``stop`` [s]; return (run, trial, whether Python makes the next step).

        The trial is a step from the returned run, still to be accepted or rejected, or None.
        """
        if len(self.method.released) or stop - run.motion.t < STRETCH * run.h:
            return run, None, True
        if self.workspace.held is not run:
            self._load(run)
        r = self.record[0]
        r["until"], r["most"], r["done"] = stop, most, 0
        code = self._make_steps()
        if r["done"]:
            run = self._run(run)
        # after ENOUGH a step of another size needs a history that is not there
        self.workspace.held = run if code == WAIT or run.h == self.workspace.record["h"][0] else None
        if code == DECIDE:
            return run, self._trial(run), True
        if code == REPEAT:
            r["phase"] = READY
        return run, None, code == REPEAT or (code == ENOUGH and stop - run.motion.t < STRETCH * run.h)

    def _make_steps(self):
        """Step on, and empty the buffers of the output as often as they are full; a code above."""
        full_at = -1
        self.workspace.record["due"] = clock.monotonic() + self.method.patience
        while True:
            before = int(self.record["renewed_tangents"][0])
            code = self._stride()
            self._note_tangents(before)
            if code != RECORDED:
                return code
            assert self.recorder is not None, "steps are recorded only for a recorder"
            if self._output["code"][0] != FULL:
                self.recorder.refuse(float(self.workspace.states[BEGIN, -1]))
            self.recorder.empty(again=full_at == self.record["done"][0])
            full_at = int(self.record["done"][0])

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
        r = self.record[0]
        r["phase"], r["planned"], r["steps"], r["iterations"] = READY, run.h, run.steps, run.iterations
        r["rejected"] = run.rejected
        r["dissipated"], r["given"] = run.dissipated, run.given
        r["power_dissipated"], r["power_given"] = run.powers
        r["checks_gaps"] = self.method.contradictions.possible
        r["share_of_gap"] = self.method.contradictions.share_of_gap.ctypes.data

    def _change_steps(self):
        """Let compiled code change the step size from now on; runs that never do need no code for it."""
        if not self.record["change_step"][0]:
            packed = self.method.change_step
            self._kept += (packed,)
            self.record["change_step"], self.record["change_step_words"] = packed.function, packed.words.ctypes.data

    def _bound_errors(self):
        """Let compiled code bound the errors of oscillations."""
        bound = self.method.error_bound
        self.record["bound"], self.record["bound_error"] = bound.record.ctypes.data, bound.call.function
        self.record["bound_error_words"] = bound.call.words.ctypes.data

    def _note_tangents(self, before):
        """Keep the States of tangents that were evaluated, for the factor that the solver holds."""
        if self.record["renewed_tangents"][0] != before:
            self._tangent = self.workspace.state(TANGENT, self._phases) if self.workspace.record["usable"][0] else None
            self.linear.solved(self._tangent)
        if self.workspace.record["renewed"][0]:
            self.linear.solved(self.workspace.state(RENEWED, self._phases))

    def _run(self, run):
        """The RunState at BEGIN, after steps from ``run``."""
        r, w = self.record[0], self.workspace
        s = w.state(BEGIN, self._phases, None if len(run.motion.memory) else run.motion.memory)
        return RunState(
            motion=s, history=w.last_history(self._tangent), h=float(r["planned"]),
            steps=int(r["steps"]), rejected=int(r["rejected"]), iterations=int(r["iterations"]),
            dissipated=float(r["dissipated"]), given=float(r["given"]),
            powers=(float(r["power_dissipated"]), float(r["power_given"])), compliance=run.compliance,
        )  # fmt: skip

    def last(self, run: RunState) -> tuple[StepInfo, float]:
        """Return StepInfo and size of the last step, made from ``run``."""
        o = self._output[0]
        norms, error = (float(o["forces"]), float(o["constraints"]), float(o["increment"])), float(o["error"])
        return StepInfo(True, int(o["iterations"]), norms, error, run.history, plain=error), float(o["h"])

    def _trial(self, run):
        """The step at TRIAL as ``method.step`` gives it, with its error."""
        history = self.workspace.new_history(BEGIN, self.workspace.v_shift.copy(), self._tangent)
        iterations = int(self.record["in_vain"][0] + self.workspace.report[0])
        s, new, info = self.method.trial(run.motion, history, iterations)
        h = float(self.workspace.record["h"][0])
        info.error = info.plain = max(info.error, self.control.forgotten(info.lag, h), info.signalled)
        return s, new, info
