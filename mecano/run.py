"""One run, from a checked deck to the results file: prepare, begin, march, close."""

import numpy as np

from mecano.contract import SECTIONS
from mecano.elements import KINDS
from mecano.errors import ConvergenceError
from mecano.model.sampler import Sampler
from mecano.prepare import chosen, march_of, prepare, remarks, some
from mecano.results.layout import Layout, Series
from mecano.results.provenance import Source
from mecano.results.writer import Writer, refuse_existing
from mecano.solve.interpolate import interpolate
from mecano.start import bring_to_start


class Recorder:
    """Observer that writes saved times, solver history, events and extremes."""

    def __init__(self, prepared, writer, sampler, control):
        self.system, self.writer, self.sampler, self.control = prepared.system, writer, sampler, control
        values = prepared.deck.values
        every = values["output"]["every"]
        self.every = None if every == "step" else every
        self.start, self.end, self.saved = values["time"]["start"], values["time"]["end"], 0
        self.ends = watched(prepared.deck, sampler, "ends")

    def first(self, run):
        """Write the start itself."""
        row = self.sampler.take(run)
        self.writer.extremes.take(run.motion.t, row)
        self.writer.append(run.motion.t, row)

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
        self.system.assemble(state, 1.0, 0.0, 0.0, 0.0, 0.0)
        self.system.observe(state)
        return self.sampler.take(accepted.at(state))

    def _next(self):
        """The next time to be saved; the last one is the end."""
        return min(self.start + (self.saved + 1) * self.every, self.end)


def run(deck, path, *, force=False, observers=(), announce=lambda text: None):
    """Run a checked deck into the results file ``path``; returns the final RunState.

    ``observers`` are told of every accepted step, ``announce`` of what a user should know before the march. Whatever
    stops the run, the file keeps every acknowledged step and says why it ended. Raises AssemblyError (the start),
    ConvergenceError, NonFiniteError (the march, the equilibrium it starts from), ResultsError (the file).
    """
    refuse_existing(path, force)
    values, prepared = deck.values["time"], prepare(deck)
    found = bring_to_start(prepared)
    march, sampler = march_of(prepared), Sampler(prepared.system)
    start = march.begin(prepared.state, values["step"])
    notes = [*remarks(prepared, start), *found]
    source = Source(
        deck.text, deck.resolved(), deck.file, deck.values["title"], deck.overrides, deck.files,
        automatic=chosen(prepared, march, start), remarks=notes,
    )  # fmt: skip
    layout = Layout([Series(c.path, c.unit, c.doc, c.shape) for c in sampler.columns])
    with Writer.create(path, layout, source, force=force) as writer:
        for text in notes:
            announce(text)
        recorder = Recorder(prepared, writer, sampler, march.control)
        march.observers = (recorder, *observers)
        recorder.first(start)
        try:
            final = march.to(values["end"], start)
        except ConvergenceError as error:
            raise ConvergenceError("\n".join([str(error), *open_latches(deck, sampler.row, sampler)])) from error
        warnings = [*march.remarks, *cut_short(values, march.cuts, final), *exceeded(deck, sampler, writer.extremes)]
        warnings += open_latches(deck, sampler.take(final), sampler)
        for text in warnings:
            announce(text)
        writer.close("complete", "; ".join(["the end was reached", *warnings]))
    return final


MOST_LATCHES = 8  # named in a warning
NOTED = 0.01  # trials that failed, of the steps, from which on a fixed step is said to be too large


def cut_short(values, cuts, final):
    """Warning that a fixed step was too large, from the ``cuts`` of the march and the final RunState; or nothing."""
    if values["adaptive"] or len(cuts) <= NOTED * final.steps:
        return
    since, smallest = cuts[0][0], min(h for _, h in cuts)
    yield (
        f"the fixed step of {values['step']:g} s is too large: Newton's method failed in {len(cuts)} trials, first at "
        f"t = {since:.4g} s, and steps were cut to as little as {smallest:.3g} s ({final.steps} steps in all); without "
        "control of the error the result may be far off: take a smaller 'time.step', or 'time.adaptive'"
    )


def exceeded(deck, sampler, extremes):
    """Warnings on outputs that went beyond what the deck says an element is good for, one text each."""
    high, when = extremes.high, extremes.high_time
    return [
        f"{d['type']} '{name}': {output} reached {high[i]:.4g} at t = {when[i]:.4g} s, but {text}"
        for name, d, output, i, limit, text in watched(deck, sampler, "limits")
        if high[i] > limit
    ]


def open_latches(deck, row, sampler):
    """Text that names latches that have not closed, and where their joints stand in a row of outputs; or nothing."""
    columns, found = {column.path: column.start for column in sampler.columns}, []
    latched = {name: d for name, d in deck.values["joints"].items() if d.get("latch")}
    for name, d in latched.items():
        if not row[columns[f"joints/{name}/latched"]]:
            ((quantity, wanted),) = d["latch"].items()
            rate, unit = ("rate", "rad") if quantity == "angle" else ("velocity", "m")
            at, moving = (row[columns[f"joints/{name}/{output}"]] for output in (quantity, rate))
            found.append(f"{d['type']} '{name}' at {at:.4g} of {wanted:.4g} {unit}, moving at {moving:.3g} {unit}/s")
    if found:
        yield f"{len(found)} of {len(latched)} latches never closed: {some(found, MOST_LATCHES)}"


def watched(deck, sampler, what):
    """What the kinds of the elements watch, "limits" or "ends": [(name, values, output, its column, value, text)]."""
    columns = {column.path: column.start for column in sampler.columns}
    return [
        (name, d, output, columns[f"{section}/{name}/{output}"], value, text)
        for section in SECTIONS
        for name, d in deck.values[section].items()
        for output, value, text in getattr(KINDS[d["type"]], what)(d)
    ]
