"""What of a march goes into the results file: saved times, history of the solver, events, extremes."""

import numpy as np

from mecano.errors import ConvergenceError, NonFiniteError
from mecano.model.watched import ended, watched
from mecano.solve.time.interpolate import interpolate
from mecano.solve.time.ringing import RingingWatch

LOOK = 1000  # saved times of one step between two looks at signals and the wall-clock time
FORCES = ("N", "N m", "Pa")  # units of outputs that are watched for ringing


class Recorder:
    """Observer that writes saved times, solver history, events and extremes.

    ``look()`` is called among the many saved times that one long step may have; it may raise Stopped.
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
        """Write the start itself."""
        self.restarted(run)
        self.writer.append(run.motion.t, self.row)

    def restarted(self, run):
        """Begin the next step with the row of ``run``, whose forces are not those with which the last step ended."""
        self.row[:] = self._sample(run)
        self.ringing.begin()

    def to_plain(self):
        """Return what ``from_plain`` needs to go on at the beginning of the next step."""
        return {"saved": self.saved, "row": self.row, "ringing": self.ringing.to_plain()}

    def from_plain(self, plain):
        """Go on at a checkpoint: nothing is written. Raises ValueError where the row is of another model."""
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
        """Return the row at ``run.motion``, which enters the extremes; raises NonFiniteError, see ``_not_finite``."""
        row = self.sampler.take(run)
        if (i := self.writer.extremes.take(run.motion.t, row)) >= 0:
            raise self._not_finite(run.motion.t, i)
        return row

    def _not_finite(self, t, i):
        """Return the error for number i of the row: it would stand in the file as if it were one."""
        column = next(column for column in self.sampler.columns if column.start <= i < column.start + column.size)
        section, name, output = [*column.path.split("/"), ""][:3]
        entry = self.deck.values.get(section, {}).get(name)
        owner = f"{entry.get('type', 'node')} '{name}': {output}" if entry else column.path
        return NonFiniteError(
            f"no way on from t = {t:.9g} s: {owner} is not finite\nwhat to try: laws that stay finite near this state; "
            "a smaller time.step or time.adaptive, if the motion so far is not what it should be"
        )

    def _refuse(self, t, row):
        """Raise ConvergenceError where an element can go no further; what was written stays."""
        if text := ended(self.ends, row):
            raise ConvergenceError(f"no way on from t = {t:.9g} s: {text}")

    def _save(self, accepted, row):
        """Save the step, or the motion at every multiple of the interval in it: interpolated, no step is shortened."""
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
        """The row at a time within the step that led to ``row``: motions may peak there."""
        state = interpolate(accepted.before, accepted.run.motion, t, self.system.numbering)
        u = (t - accepted.before.t) / accepted.h
        found = self.sampler.between(state, u, accepted.h, self.row, row)
        self.writer.extremes.take(t, found)
        return found

    def _next(self):
        """The next time to be saved; the last one is the end."""
        return min(self.start + (self.saved + 1) * self.every, self.end)
