"""Checkpoints of a march: when they are written, what is in them, and the end of the march where it is asked for."""

import json
import time

from mecano.errors import ResultsError
from mecano.solve.time.run_state import from_plain, to_plain

INTERVAL = 30.0  # s of wall-clock time between checkpoints
SHARE = 100  # times as long as the last checkpoint took, at least, until the next


class CheckpointWriter:
    """Called before and in a step: writes a checkpoint now and then, and ends the march where that is asked for."""

    def __init__(self, integrator, recorder, interruption, interval):
        self.integrator, self.recorder, self.interruption, self.interval = integrator, recorder, interruption, interval
        self.due = time.monotonic() + interval

    def __call__(self, run):
        """Keep the ``run``, of the beginning of the step, if it is time to; raises Stopped, ResultsError."""
        now = time.monotonic()
        if self.interruption.wanted(now, self.recorder.writer.closing_time):
            self.write(run)
            raise self.interruption.stopped(f"at t = {run.motion.t:.9g} s")
        if now >= self.due:
            self.write(run)
            ended = time.monotonic()
            self.due = ended + max(self.interval, SHARE * (ended - now))

    def poll(self):
        """Raise Stopped in the midst of a step, from whose beginning there is no checkpoint, where it is asked for."""
        if self.interruption.wanted(time.monotonic(), self.recorder.writer.closing_time):
            raise self.interruption.stopped("among the saved times of one step")

    def write(self, run):
        """Write a checkpoint; raises ResultsError."""
        self.recorder.flush()
        integrator = json.dumps(self.integrator.to_plain())
        state = {"run": to_plain(run), "march": integrator, "recorder": self.recorder.to_plain()}
        self.recorder.writer.checkpoint(state)


def restore(state, integrator):
    """(RunState, state of the recorder) of a checkpoint, and ``integrator`` as it was then; raises ResultsError."""
    try:
        run = from_plain(state["run"])
        integrator.from_plain(json.loads(state["march"]))
        recorder = state["recorder"]
    except (KeyError, TypeError, ValueError) as error:
        raise ResultsError(f"the checkpoint cannot be read; it is of another version of mecano: {error}") from error
    expected = integrator.system.initial_state()
    if any(getattr(run.motion, name).shape != getattr(expected, name).shape for name in ("z", "R", "phases", "memory")):
        raise ResultsError("the checkpoint does not fit the deck; it is of another version of mecano")
    return run, recorder
