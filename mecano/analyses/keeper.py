"""Checkpoints of a run: when they are written and what they contain; stopping a run on request."""

import json
import time

from mecano.errors import ResultsError
from mecano.solve.time.run_state import from_plain, to_plain

INTERVAL = 30.0  # s of wall-clock time between checkpoints
SHARE = 100  # least time between checkpoints, in durations of the last one


class Keeper:
    """Callable before and within a step that writes checkpoints when they are due and stops the run on request."""

    def __init__(self, march, recorder, interruption, interval):
        self.march, self.recorder, self.interruption, self.interval = march, recorder, interruption, interval
        self.due = time.monotonic() + interval

    def __call__(self, run):
        """Write a checkpoint of ``run``, the beginning of the step, if it is due. Raises Stopped, ResultsError."""
        now = time.monotonic()
        if self.interruption.wanted(now, self.recorder.writer.closing_time):
            self.keep(run)
            raise self.interruption.stopped(f"at t = {run.motion.t:.9g} s")
        if now >= self.due:
            self.keep(run)
            ended = time.monotonic()
            self.due = ended + max(self.interval, SHARE * (ended - now))

    def look(self):
        """Raise Stopped within a step, on request; no checkpoint of its beginning is written."""
        if self.interruption.wanted(time.monotonic(), self.recorder.writer.closing_time):
            raise self.interruption.stopped("among the saved times of one step")

    def keep(self, run):
        """Write a checkpoint of ``run``. Raises ResultsError."""
        march = json.dumps(self.march.to_plain())
        state = {"run": to_plain(run), "march": march, "recorder": self.recorder.to_plain()}
        self.recorder.writer.checkpoint(state)


def restore(state, march):
    """Return the RunState and the recorder's state of a checkpoint, and restore ``march``. Raises ResultsError."""
    try:
        run = from_plain(state["run"])
        march.from_plain(json.loads(state["march"]))
        recorder = state["recorder"]
    except (KeyError, TypeError, ValueError) as error:
        raise ResultsError(f"the checkpoint cannot be read; it is of another version of mecano: {error}") from error
    expected = march.system.initial_state()
    if any(getattr(run.motion, name).shape != getattr(expected, name).shape for name in ("z", "R", "modes", "memory")):
        raise ResultsError("the checkpoint does not fit the deck; it is of another version of mecano")
    return run, recorder
