"""The results of a run that go into the file: saved times, history of the solver, events, extremes."""

import time as clock
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from mecano.analyses.prepare import Prepared
from mecano.errors import ConvergenceError, ResultsError
from mecano.model.output_limits import end_text, ended, watched_outputs
from mecano.model.sampler import Sampler
from mecano.results.writer import Writer
from mecano.solve.events.events import EventRecord
from mecano.solve.time.output import ENDED, FULL, NOT_FINITE, Output
from mecano.solve.time.run_state import RunState
from mecano.solve.time.time_integration import Accepted, TimeIntegrator
from mecano.solve.time.unresolved_oscillation import OscillationMonitor

INTERVAL = 0.2  # s of wall-clock time after which rows go to the writer
FORCES = ("N", "N m", "Pa")  # units of outputs that are monitored for ringing
REMEDY = "laws that stay finite near this state; a smaller time.step or time.adaptive, if the motion so far looks wrong"


class Recorder:
    """Writer of saved times, solver history, events and extremes of a run.

    ``poll()`` is called within a step whose saved times fill the buffers more than once; it may raise Stopped.
    """

    def __init__(self, prepared: Prepared, writer: Writer, sampler: Sampler, integrator: TimeIntegrator):
        self.writer, self.sampler = writer, sampler
        self.control, self._workspace = integrator.control, integrator.method.workspace
        self.observation = integrator.observation
        self.deck, values = prepared.deck, prepared.deck.values
        self.poll = lambda: None
        self.ends = watched_outputs(values, sampler, "end_conditions")
        forces = [c for c in sampler.columns if c.unit in FORCES]
        self.ringing = OscillationMonitor(np.array([c.start + i for c in forces for i in range(c.size)], np.int64))
        every, time = values["output"]["every"], values["time"]
        times = time["start"], time["end"], 0.0 if every == "step" else every
        ends = [(column, required, size) for *_, column, size, _, required in self.ends]
        self.output = Output(sampler, self.observation, writer.extremes, self.ringing, times, ends)
        integrator.method.use_output(self.output)
        self._due = clock.monotonic() + INTERVAL

    @property
    def row(self) -> np.ndarray:
        """The row at the beginning of the next step, after the events there."""
        return self.output.row

    def first(self, run: RunState, events: Iterable[EventRecord]) -> None:
        """Write the initial state, after the ``events`` [EventRecord] of the start."""
        self.restarted(run)
        if text := ended(self.ends, self.row):
            raise self._ended(run.motion.t, text)
        self.writer.append(run.motion.t, self.row)
        self._append(events)

    def restarted(self, run: RunState, passing: bool = False) -> None:
        """Begin the next step with the row of ``run``, whose forces are not those with which the last step ended.

        A state between two events of one instant is ``passing``, and excluded from the extremes: a controller may
        exceed its limit there, for no time.
        """
        row = self.sampler.take(run, self.observation)
        if not passing and (i := self.writer.extremes.take(run.motion.t, row)) >= 0:
            raise self._not_finite(run.motion.t, i)
        self.row[:] = row
        self.ringing.begin()

    def to_plain(self) -> dict[str, Any]:
        """Return plain data from which ``from_plain`` continues at the beginning of the next step."""
        saved = int(self.output.record["saved"][0])
        return {"saved": saved, "row": self.row, "ringing": self.ringing.to_plain()}

    def from_plain(self, plain: Mapping[str, Any]) -> None:
        """Continue at a checkpoint, without writing; raises ValueError if the row belongs to another model."""
        self.row[:], self.output.record["saved"] = plain["row"], plain["saved"]
        self.ringing.from_plain(plain["ringing"])

    def __call__(self, accepted: Accepted) -> None:
        """Write one accepted step: its line in the history, the saved times it covers, its events."""
        t = accepted.run.motion.t
        if accepted.h:
            share = accepted.info.error / self.control.allowed(accepted.h)
            code = self.output.record_step(self._workspace, accepted, share)
            again = False
            while code == FULL:
                self.empty(again)
                again = True
                code = self.output.continue_record(self._workspace)
            self.refuse(t)
        self._append(accepted.event_records)

    def _append(self, events):
        if not events:
            return
        from mecano.results.recorded import Event  # not needed by a run without events

        for e in events:
            self.writer.append_event(Event(e.t, e.element, e.name, e.before, e.after, e.unit, e.impulse, e.lost))

    def report(self, run: RunState) -> None:
        """Pass the contents of the buffers to the writer, at intervals."""
        if clock.monotonic() >= self._due:
            self.flush()

    @contextmanager
    def kept_if_it_fails(self) -> Iterator[None]:
        """Pass the buffers of a run that fails to the writer, unless that failed."""
        try:
            yield
        except ResultsError:
            raise
        except BaseException:
            self.flush()
            raise

    def empty(self, again: bool = False) -> None:
        """Pass the contents of full buffers to the writer; may raise Stopped if one step fills them ``again``."""
        self.flush()
        if again:
            self.poll()

    def flush(self) -> None:
        """Pass the contents of the buffers to the writer."""
        rows, steps = self.output.taken()
        self.writer.extend("output", rows)
        self.writer.extend("solver", steps)
        self._due = clock.monotonic() + INTERVAL

    def refuse(self, t: float) -> None:
        """Raise an error if the run cannot continue from the last step, to the time t [s]."""
        code, which = self.output.outcome()
        if code == NOT_FINITE:
            raise self._not_finite(t, which)
        if code == ENDED:
            raise self._ended(t, end_text(self.ends[which], self.row))

    @staticmethod
    def _ended(t, text):
        return ConvergenceError(f"cannot continue from t = {t:.9g} s: {text}")

    def _not_finite(self, t, i):
        """Return the error that names the output of entry ``i`` of the row, which is not finite."""
        from mecano.analyses.not_finite import output_not_finite  # needed by failed runs only

        return output_not_finite(self.sampler, self.observation, i, f"t = {t:.9g} s", REMEDY)
