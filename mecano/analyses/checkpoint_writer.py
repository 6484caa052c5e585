"""Checkpoints of a run: their times and contents; stopping a run on request."""

import json
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from mecano.errors import ResultsError
from mecano.solve.time.run_state import RunState, from_plain, to_plain

if TYPE_CHECKING:
    from mecano.analyses.recorder import Recorder
    from mecano.process.interrupt import Interruption
    from mecano.solve.time.time_integration import TimeIntegrator

INTERVAL = 30.0  # s of wall-clock time between checkpoints
SHARE = 100  # least time between checkpoints, in durations of the last one


class CheckpointWriter:
    """Writes checkpoints when they are due, and stops the run on request; called before and within a step."""

    def __init__(
        self, integrator: "TimeIntegrator", recorder: "Recorder", interruption: "Interruption", interval: float
    ):
        self.integrator, self.recorder, self.interruption, self.interval = integrator, recorder, interruption, interval
        self.due = time.monotonic() + interval

    def __call__(self, run: RunState) -> None:
        """Write a checkpoint of ``run``, the beginning of the step, if it is due. Raises Stopped, ResultsError."""
        now = time.monotonic()
        if self.interruption.wanted(now, self.recorder.writer.closing_time):
            self.write(run)
            raise self.interruption.stopped(f"at t = {run.motion.t:.9g} s")
        if now >= self.due:
            self.write(run)
            ended = time.monotonic()
            self.due = ended + max(self.interval, SHARE * (ended - now))

    def poll(self) -> None:
        """Raise Stopped within a step, on request; no checkpoint of its beginning is written."""
        if self.interruption.wanted(time.monotonic(), self.recorder.writer.closing_time):
            raise self.interruption.stopped("between two saved times of a step")

    def write(self, run: RunState) -> None:
        """Write a checkpoint; raises ResultsError."""
        self.recorder.flush()
        integrator = json.dumps(self.integrator.to_plain())
        state = {"run": to_plain(run), "integrator": integrator, "recorder": self.recorder.to_plain()}
        self.recorder.writer.checkpoint(state)


def restore(state: Mapping[str, Any], integrator: "TimeIntegrator") -> tuple[RunState, dict[str, Any]]:
    """Restore ``integrator`` from a checkpoint; return its RunState and the recorder's state. Raises ResultsError."""
    try:
        run = from_plain(state["run"])
        integrator.from_plain(json.loads(state["integrator"]))
        recorder = state["recorder"]
    except (KeyError, TypeError, ValueError) as error:
        text = "the checkpoint cannot be read; it was written by another version of mecano"
        raise ResultsError(f"{text}: {error}") from error
    expected = integrator.system.initial_state()
    if any(getattr(run.motion, name).shape != getattr(expected, name).shape for name in ("z", "R", "phases", "memory")):
        raise ResultsError("the checkpoint does not fit the deck; it was written by another version of mecano")
    return run, recorder
