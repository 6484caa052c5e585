"""The results of a run that go into the file: saved times, history of the solver, events, extremes."""

import numpy as np

from mecano.errors import ConvergenceError, NonFiniteError
from mecano.model.watched import ended, watched
from mecano.solve.time.interpolate import interpolate
from mecano.solve.time.ringing import RingingWatch

LOOK = 1000  # saved times of one step between two checks of signals and the wall-clock time
FORCES = ("N", "N m", "Pa")  # units of outputs that are monitored for ringing


class Recorder:
    """Observer that writes saved times, solver history, events and extremes.

    ``look()`` is called after every ``LOOK`` saved times within a step; it may raise Stopped.
    """

    def __init__(self, prepared, writer, sampler, control):
        self.system, self.writer, self.sampler, self.control = prepared.system, writer, sampler, control
        self.deck, values = prepared.deck, prepared.deck.values
        every = values["output"]["every"]
        self.every = None if every == "step" else every
        self.start, self.end = values["time"]["start"], values["time"]["end"]
        self.look = lambda: None
        self.saved = 0  # multiples of the interval, after the start; -1 at the end
        self.row = np.zeros(len(sampler.row))  # at the beginning of the next step, behind the events there
        self.ends = watched(values, sampler, "ends")
        forces = [c for c in sampler.columns if c.unit in FORCES]
        self.ringing = RingingWatch(np.array([c.start + i for c in forces for i in range(c.size)], np.int64))

    def first(self, run):
        """Write the initial state."""
        self.restarted(run)
        self.writer.append(run.motion.t, self.row)

    def restarted(self, run):
        """Begin the next step with the row of ``run``, whose forces differ from those at the end of the last step."""
        self.row[:] = self._sample(run)
        self.ringing.begin()

    def to_plain(self):
        """Return the state from which ``from_plain`` continues at the beginning of the next step."""
        return {"saved": self.saved, "row": self.row, "ringing": self.ringing.to_plain()}

    def from_plain(self, plain):
        """Restore the state of a checkpoint, without writing. Raises ValueError for the row of another model."""
        self.saved, self.row[:] = plain["saved"], plain["row"]
        self.ringing.from_plain(plain["ringing"])

    def __call__(self, accepted):
        """Write one accepted step: its line in the history, the saved times it covers, its events."""
        run, info = accepted.run, accepted.info
        if accepted.h:
            row = self._sample(run)
            share = info.error / self.control.allowed(accepted.h)
            numbers = [accepted.h, info.iterations, info.error, share, accepted.rejected, *info.norms]
            self.writer.append_step(run.motion.t, np.array(numbers, float))
            self._save(accepted, row)
            self.ringing.take(run.motion.t, self.row, row)
            self.row[:] = row
            self._refuse(run.motion.t, row)
        for happening in accepted.happenings:
            self.writer.append_event(
                happening.t, happening.element, happening.name, happening.before, happening.after, happening.impulse,
                happening.unit, happening.lost,
            )  # fmt: skip

    def _sample(self, run):
        """Return the row at ``run.motion``, and update the extremes with it. Raises NonFiniteError."""
        row = self.sampler.take(run)
        if (i := self.writer.extremes.take(run.motion.t, row)) >= 0:
            raise self._not_finite(run.motion.t, i)
        return row

    def _not_finite(self, t, i):
        """Return the error that names the output of number ``i`` of the row, which is not finite."""
        column = next(column for column in self.sampler.columns if column.start <= i < column.start + column.size)
        section, name, output = [*column.path.split("/"), ""][:3]
        entry = self.deck.values.get(section, {}).get(name)
        owner = f"{entry.get('type', 'node')} '{name}': {output}" if entry else column.path
        return NonFiniteError(
            f"no way on from t = {t:.9g} s: {owner} is not finite\nwhat to try: laws that stay finite near this state; "
            "a smaller time.step or time.adaptive, if the motion so far is not what it should be"
        )

    def _refuse(self, t, row):
        """Raise ConvergenceError if an element is at the end of its range; rows already written are kept."""
        if text := ended(self.ends, row):
            raise ConvergenceError(f"no way on from t = {t:.9g} s: {text}")

    def _save(self, accepted, row):
        """Save the end of the step, or the interpolated motion at every multiple of the interval within the step."""
        t = accepted.run.motion.t
        if self.every is None:
            self.writer.append(t, row)
            return
        sliver = 1e-9 * self.every
        while (wanted := self._next()) <= t + sliver and self.saved >= 0:
            self.writer.append(wanted, row if wanted > t - sliver else self._between(accepted, wanted, row))
            self.saved = self.saved + 1 if wanted < self.end else -1
            if not self.saved % LOOK:
                self.look()

    def _between(self, accepted, t, row):
        """Return the row at a time within the step to ``row``, and update the extremes, as motions may peak there."""
        state = interpolate(accepted.before, accepted.run.motion, t, self.system.numbering)
        u = (t - accepted.before.t) / accepted.h
        found = self.sampler.between(state, u, accepted.h, self.row, row)
        self.writer.extremes.take(t, found)
        return found

    def _next(self):
        """Return the next time to be saved; the last one is the end."""
        return min(self.start + (self.saved + 1) * self.every, self.end)
