"""What of a march goes into the results file: saved times, history of the solver, events, extremes."""

import numpy as np

from mecano.contract import SECTIONS
from mecano.elements import KINDS
from mecano.errors import ConvergenceError
from mecano.solve.interpolate import interpolate


class Recorder:
    """Observer that writes saved times, solver history, events and extremes."""

    def __init__(self, prepared, writer, sampler, control):
        self.system, self.writer, self.sampler, self.control = prepared.system, writer, sampler, control
        values = prepared.deck.values
        every = values["output"]["every"]
        self.every = None if every == "step" else every
        self.start, self.end = values["time"]["start"], values["time"]["end"]
        self.saved = 0  # multiples of the interval, after the start; -1 at the end
        self.ends = watched(prepared.deck, sampler, "ends")

    def first(self, run):
        """Write the start itself."""
        row = self.sampler.take(run)
        self.writer.extremes.take(run.motion.t, row)
        self.writer.append(run.motion.t, row)

    def go_on(self, run, saved):
        """Go on at a checkpoint, where so many times had been ``saved``: nothing is written."""
        self.saved = saved
        self._observe(run.motion)
        self.sampler.take(run)

    def __call__(self, accepted):
        """Write one accepted step: its line in the history, the saved times it covers, its events."""
        run, info = accepted.run, accepted.info
        if accepted.h:
            row = self.sampler.take(run)
            self.writer.extremes.take(run.motion.t, row)
            share = info.error / self.control.allowed(accepted.h)
            numbers = [accepted.h, info.iterations, info.error, share, accepted.rejected, *info.norms]
            self.writer.append_step(run.motion.t, np.array(numbers, float))
            self._save(accepted, row)
            self._refuse(run.motion.t, row)
        for happening in accepted.happenings:
            self.writer.append_event(
                happening.t, happening.element, happening.name, happening.before, happening.after, happening.impulse,
                happening.unit, happening.lost,
            )  # fmt: skip

    def _refuse(self, t, row):
        """Raise ConvergenceError where an element can go no further; what was written stays."""
        for name, d, _, i, size, text in self.ends:
            if abs(row[i]) > size:
                raise ConvergenceError(f"no way on from t = {t:.9g} s: {d['type']} '{name}' {text}")

    def _save(self, accepted, row):
        """Save the step, or the motion at every multiple of the interval in it: interpolated, no step is shortened."""
        t = accepted.run.motion.t
        if self.every is None:
            self.writer.append(t, row)
            return
        here, sliver = row.copy(), 1e-9 * self.every
        while (wanted := self._next()) <= t + sliver and self.saved >= 0:
            self.writer.append(wanted, here if wanted > t - sliver else self._between(accepted, wanted))
            self.saved = self.saved + 1 if wanted < self.end else -1

    def _between(self, accepted, t):
        state = interpolate(accepted.before, accepted.run.motion, t, self.system.numbering)
        self._observe(state)
        return self.sampler.take(accepted.at(state))

    def _observe(self, state):
        self.system.assemble(state, 1.0, 0.0, 0.0, 0.0, 0.0)
        self.system.observe(state)

    def _next(self):
        """The next time to be saved; the last one is the end."""
        return min(self.start + (self.saved + 1) * self.every, self.end)


def watched(deck, sampler, what):
    """What the kinds of the elements watch, "limits" or "ends": [(name, values, output, its column, value, text)]."""
    columns = {column.path: column.start for column in sampler.columns}
    return [
        (name, d, output, columns[f"{section}/{name}/{output}"], value, text)
        for section in SECTIONS
        for name, d in deck.values[section].items()
        for output, value, text in getattr(KINDS[d["type"]], what)(d)
    ]
