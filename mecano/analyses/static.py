"""A static run, from a checked deck to the results file: prepare, follow the path, close."""

import os
from collections.abc import Callable, Sequence

import numpy as np

from mecano.analyses.diagnostics import limit_warnings
from mecano.analyses.equilibria import follow
from mecano.analyses.failure_text import locating
from mecano.analyses.not_finite import output_not_finite
from mecano.analyses.prepare import model_facts, prepare, startup_warnings
from mecano.analyses.source import source_of
from mecano.analyses.yielding import yielding_warnings
from mecano.deck.deck import Deck
from mecano.model.sampler import Sampler, StaticSample
from mecano.model.system import System
from mecano.results.file_names import refuse_existing
from mecano.results.layout import Layout, Series
from mecano.results.lock import locked
from mecano.results.reason import with_warnings
from mecano.results.recorded import Event
from mecano.results.whole_file import exists
from mecano.results.writer import Writer
from mecano.solve.statics.continuation import Observer, Point

AXES = {
    "load_factor": Series("load factor", "", "share of the loads and of gravity"),
    "arc_length": Series("length of the path", "", "in load factors at the stiffness of the start"),
    "time": Series("time", "s", "time in the laws"),
}
STEPS = (
    Series("step_size", "", "step of the load factor, of the time, or along the path"),
    Series("iterations", "", "Newton iterations of the accepted step"),
    Series("rejected", "", "attempts rejected before this step was accepted"),
    Series("force_residual", "", "largest residual force over its tolerance"),
    Series("constraint_residual", "", "largest residual constraint over its tolerance"),
    Series("increment", "", "largest last correction over its tolerance"),
)
OF_LOADS = ("N", "N m", "W", "N/m", "N m/m", "Pa")  # units of outputs that are proportional to the load factor
PATH = (
    Series("static/load_factor", "", "share of the loads and of gravity that acts"),
    Series("static/unstable_directions", "", "directions in which the equilibrium is unstable; -1 where unknown"),
    Series("static/neutral_directions", "", "directions without stiffness; -1 where unknown"),
)
REMEDY = "laws that stay finite near this state"


class EquilibriumRecorder:
    """Observer that writes every equilibrium as a saved time, with its iterations and residuals."""

    def __init__(self, system: System, over_time: bool):
        self.system, self.over_time = system, over_time
        self.writer: Writer  # of the results file with the ``series``; set when it is open
        self.sampler = Sampler(system)
        columns = [c for c in self.sampler.columns if not c.path.startswith("energy/") or "potential" in c.path]
        self.series = [Series(c.path, c.unit, c.doc, c.shape) for c in columns] + list(PATH)
        self.places = np.concatenate([np.arange(c.start, c.start + c.size) for c in columns])
        self.loads = _outputs_of_loads(system)

    def __call__(self, point: Point) -> None:
        """Write one Point. Raises NonFiniteError, which names the output, if one is not finite."""
        factor = 1.0 if self.over_time else point.parameter
        stability, row = point.stability, self.sampler.take(StaticSample(point.state), point.observation)
        row[self.sampler.node_size + self.loads] *= factor
        row = np.append(row[self.places], [factor, stability.unstable, stability.neutral])
        if (i := self.writer.extremes.take(point.place, row)) >= 0:
            where = f"t = {point.place:.9g} s" if self.over_time else f"load factor {point.parameter:.6g}"
            raise output_not_finite(self.sampler, point.observation, self.places[i], where, REMEDY)
        self.writer.append(point.place, row)
        if point.step:
            self.writer.append_step(point.place, np.array([point.step, point.iterations, point.rejected, *point.norms]))
        for event in point.event_records:
            self.writer.append_event(Event(point.place, event.element, event.name, event.before, event.after))


def _outputs_of_loads(system):
    """Return the indices of the outputs of a System that are proportional to the load factor."""
    found = np.zeros(system.n_outputs, bool)
    for b in system.batches:
        if b.is_scaled():
            units = [output.unit for output in b.kind.outputs for _ in range(output.size)]
            b.outputs(found)[:] = np.isin(units, OF_LOADS)
    return np.flatnonzero(found)


def resume(
    deck: Deck,
    path: str | os.PathLike[str],
    *,
    observers: "Sequence[Observer]" = (),
    announce: Callable[[str], object] = lambda text: None,
) -> Point | None:
    """Compute the equilibria again unless ``path`` holds all of them, and return the last Point.

    Static runs have no checkpoints. Return None if the file is complete. Raises UsageError if the file belongs to
    another deck, and the errors of ``run``.
    """
    with locked(path):
        if exists(path):
            from mecano.analyses.resume import (  # imports the reader, which is slow and rarely needed
                COMPLETE,
                InterruptedRun,
            )
            from mecano.results.verify import verify

            interrupted = InterruptedRun(path, deck)
            interrupted.close()
            if interrupted.complete:
                verify(path)  # a study must not continue with a file changed afterwards
                announce(COMPLETE.format(path))
                return None
            announce(f"equilibria have no checkpoints: the run in {path} starts again")
        return _follow(deck, path, True, observers, announce)


def run(
    deck: Deck,
    path: str | os.PathLike[str],
    *,
    force: bool = False,
    observers: "Sequence[Observer]" = (),
    announce: Callable[[str], object] = lambda text: None,
) -> Point:
    """Compute the equilibria of a deck with ``static``, write them to ``path``, and return the last Point.

    ``observers`` are called with every Point, ``announce`` with the text of every warning. Raises AssemblyError,
    ConvergenceError, which names the free motion, NonFiniteError, ResultsError; the file keeps all equilibria found.
    """
    with locked(path):
        refuse_existing(path, force)
        return _follow(deck, path, force, observers, announce)


def _follow(
    deck: Deck,
    path: str | os.PathLike[str],
    force: bool,
    observers: "Sequence[Observer]",
    announce: Callable[[str], object],
) -> Point:
    """Do as ``run``, with the lock on the file held."""
    values, prepared = deck.values["static"], prepare(deck)
    over_time = values["over"] == "time"
    recorder, notes = EquilibriumRecorder(prepared.system, over_time), startup_warnings(prepared)
    automatic, model = {"length_scale": prepared.length}, model_facts(prepared)
    source = source_of(deck, automatic=automatic, model=model, warnings=notes)
    axis = AXES["arc_length" if values["method"] == "arc_length" else values["over"]]
    with Writer.create(path, Layout(recorder.series, STEPS, axis), source, force=force) as writer:
        for text in notes:
            announce(text)
        recorder.writer = writer
        with locating(deck):
            result = follow(prepared, (recorder, *observers))
        where = f"{axis.path.replace('_', ' ')} {{:.4g}} {axis.unit}".rstrip()
        limits = limit_warnings(deck, recorder.sampler, writer.extremes, recorder.places, where)
        yielding = yielding_warnings(
            prepared.system, prepared.compliance, prepared.length, recorder.sampler, writer.extremes, recorder.places
        )
        warnings = [*result.warnings, *limits, *yielding]
        for text in warnings:
            announce(text)
        writer.close("complete", with_warnings(result.reason, warnings))
    return result.point
