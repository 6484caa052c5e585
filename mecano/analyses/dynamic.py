"""A dynamic run, from a checked deck to the results file: prepare, start or resume, integrate, close."""

import time as clock
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from mecano.analyses.checkpoint_writer import INTERVAL, CheckpointWriter, restore
from mecano.analyses.circle_accuracy import circle_warnings, unstable_turning_warnings
from mecano.analyses.compilation import compile_time_integration
from mecano.analyses.diagnostics import (
    capture_warnings,
    energy_warnings,
    limit_warnings,
    open_latch_warnings,
    oscillation_warnings,
    step_cut_warnings,
    undeveloped_friction_warnings,
    until_warnings,
    untouched_ground_warnings,
    waiting_warnings,
    wrap_warnings,
)
from mecano.analyses.failure_text import failure_text, locating
from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.initial_velocities import set_in_motion
from mecano.analyses.prepare import chosen_values, integrator_of, mass_of, model_facts, prepare, startup_warnings
from mecano.analyses.recorder import Recorder
from mecano.analyses.source import source_of
from mecano.analyses.yielding import yielding_warnings
from mecano.errors import ConvergenceError, MecanoError, NonFiniteError, ResultsError
from mecano.model.model import title_of
from mecano.model.sampler import Sampler
from mecano.process.interrupt import Interruption, call_interruptibly
from mecano.results.disk import deferring_signals
from mecano.results.file_names import refuse_existing
from mecano.results.layout import Layout, Series
from mecano.results.lock import locked
from mecano.results.reason import ENDED, UNTIL, with_warnings
from mecano.results.whole_file import exists
from mecano.results.writer import Writer

if TYPE_CHECKING:
    import os

    from mecano.analyses.outlook import Outlook
    from mecano.analyses.prepare import Prepared
    from mecano.deck.deck import Deck
    from mecano.solve.time.run_state import RunState
    from mecano.solve.time.short_steps import ShortSteps
    from mecano.solve.time.time_integration import Accepted, TimeIntegrator

BLOCK = 200  # steps judged together, at least
AT_ONCE = 5.0  # s of wall-clock time: the pace of runs that take longer is watched
VERY_SHORT = 5e-5  # of the duration: mean step of a stretch that is watched


class Supervision:
    """Observers, reporters and interruption of a run.

    Attributes
    ----------
    observers : sequence of callables
        Called with every accepted step, an Accepted.
    reporters : sequence of callables
        Called with the RunState between calls of compiled code.
    announce : callable
        Called with the text of every warning.
    interruption : Interruption
        Ends the run by raising Stopped, after a checkpoint; default: never.
    interval : float
        Wall-clock time between checkpoints [s].
    """

    def __init__(
        self,
        observers: "Sequence[Callable[[Accepted], object]]" = (),
        reporters: "Sequence[Callable[[RunState], object]]" = (),
        announce: Callable[[str], object] = lambda text: None,
        interruption: Interruption | None = None,
        interval: float = INTERVAL,
    ):
        self.observers, self.reporters, self.announce = observers, reporters, announce
        self.interruption, self.interval = interruption or Interruption(), interval


def run(deck: "Deck", path: "str | os.PathLike[str]", *, force: bool = False, **supervision: Any) -> "RunState":
    """Run a checked deck, write its results file ``path``, and return the final RunState.

    ``supervision`` are the attributes of Supervision. However the run ends, the file keeps every acknowledged step and
    the reason of the end. Raises AssemblyError (start), ConvergenceError, NonFiniteError (time integration, initial
    equilibrium), ResultsError (file).
    """
    with begun(deck, path, force, **supervision) as ongoing:
        return ongoing.to_the_end()


@contextmanager
def begun(deck: "Deck", path: "str | os.PathLike[str]", force: bool, **supervision: Any) -> "Iterator[Ongoing]":
    """Find the initial state of a checked deck, open its results file, and yield an Ongoing run; see ``run``."""
    with locked(path):
        _refuse_existing(path, force)
        with _from_the_start(deck, path, force, Supervision(**supervision)) as ongoing:
            yield ongoing


@contextmanager
def continued(deck: "Deck", path: "str | os.PathLike[str]", **supervision: Any) -> "Iterator[Ongoing | None]":
    """Continue the run in a results file, and yield an Ongoing run, or None if it is complete; see ``resume``."""
    with locked(path), _resumed(deck, path, Supervision(**supervision)) as ongoing:
        yield ongoing


@contextmanager
def _announce_warnings(prepared, supervision):
    """Announce the warnings about a model whose start fails: one of them may name the cause."""
    try:
        yield
    except MecanoError:
        for text in startup_warnings(prepared):
            supervision.announce(text)
        raise


@contextmanager
def _from_the_start(deck, path, force, supervision):
    """Yield an Ongoing run from its initial state; the caller holds the lock of the file."""
    prepared = prepare(deck, partial(compile_time_integration, time=deck.values["time"]))
    with locating(deck), _announce_warnings(prepared, supervision):
        found = call_interruptibly(set_initial_state, prepared, True, supervision.announce)
    integrator, sampler = integrator_of(prepared), Sampler(prepared.system)
    with locating(deck):
        start = call_interruptibly(integrator.begin, prepared.state, deck.values["time"]["step"])
    notes = [*startup_warnings(prepared, start), *found, *_unstable_control(prepared, start)]
    automatic, model = chosen_values(prepared, integrator, start), model_facts(prepared)
    if moved := set_in_motion(deck, prepared.system, prepared.state, start.motion, prepared.length):
        model["set_in_motion"] = moved
    source = source_of(deck, automatic=automatic, model=model, warnings=notes)
    postponed = supervision.interruption.postponed()
    with postponed, Writer.create(path, layout_of(sampler), source, force=force) as writer:
        for text in notes:
            supervision.announce(text)
        recorder = Recorder(prepared, writer, sampler, integrator)
        recorder.first(start, integrator.start_events)
        yield Ongoing(prepared, start, integrator, recorder, supervision, notes)


def _unstable_control(prepared, start):
    """Return the warnings about controllers that make the mechanism unstable at its ``start``."""
    if not prepared.system.signals.any():
        return []
    from mecano.analyses.control_stability import instability_warnings  # few models have signals

    return call_interruptibly(lambda: list(instability_warnings(prepared, start)))


def _refuse_existing(path, force):
    """Raise ResultsError for an existing file unless ``force``, suggesting --resume if its run can be resumed."""
    try:
        refuse_existing(path, force)
    except ResultsError as error:
        if _resumable(path):
            raise ResultsError(f"{error}, or --resume (in Python resume=True) to continue it") from None
        raise


def _resumable(path):
    from mecano.results.reader import open_results  # slow to import, and rarely needed

    try:
        with open_results(path) as results:
            return results.resumable
    except ResultsError:
        return False


def resume(deck: "Deck", path: "str | os.PathLike[str]", **supervision: Any) -> "RunState | None":
    """Resume the run in the results file ``path`` from its last checkpoint; return the final RunState.

    ``supervision`` are the attributes of Supervision. Without such a file, or without a checkpoint in it, the run
    starts again. Return None if the run is complete. The results are bit for bit those of an uninterrupted run on the
    same machine with the same versions and number of threads; otherwise a warning in the file names the differences.
    The old file is kept until the new one is written up to the checkpoint. Raises UsageError if the file belongs to
    another deck, ResultsError if it is damaged or still being written, and all errors of ``run``.
    """
    with continued(deck, path, **supervision) as ongoing:
        return None if ongoing is None else ongoing.to_the_end()


@contextmanager
def _resumed(deck, path, supervision):
    """Yield the resumed run as ``continued`` does; the caller holds the lock of the file."""
    if not exists(path):
        with _from_the_start(deck, path, False, supervision) as ongoing:
            yield ongoing
        return
    from mecano.analyses.resume import COMPLETE, InterruptedRun  # imports the reader, which is slow and rarely needed
    from mecano.results.verify import verify

    with deferring_signals():
        interrupted = InterruptedRun(path, deck)
    with closing(interrupted):
        if interrupted.checkpoint is not None and not interrupted.complete:
            with _from_the_checkpoint(deck, interrupted, supervision) as ongoing:
                yield ongoing
            return
    if interrupted.complete:
        verify(path)  # a file changed afterwards is not complete, and a study must not continue with it
        supervision.announce(COMPLETE.format(path))
        yield None
        return
    supervision.announce(f"{path} has no checkpoint yet: the run starts again")
    with _from_the_start(deck, path, True, supervision) as ongoing:
        yield ongoing


@contextmanager
def _from_the_checkpoint(deck, interrupted, supervision):
    """Yield the run of an InterruptedRun at its checkpoint, in a new file that replaces its file."""
    prepared = prepare(deck, partial(compile_time_integration, time=deck.values["time"]))
    integrator, sampler = integrator_of(prepared), Sampler(prepared.system)
    start, recorded = restore(interrupted.checkpoint["run"], integrator)
    layout = layout_of(sampler)
    interrupted.check_layout(layout)
    note, doubtful = interrupted.note(start.motion.t)
    warnings = [*interrupted.warnings, *[note] * doubtful]
    resumptions = [*interrupted.resumptions, *[note] * (not doubtful)]
    automatic, model = interrupted.automatic, interrupted.model
    source = source_of(deck, automatic=automatic, model=model, warnings=warnings, resumptions=resumptions)
    begin = partial(interrupted.copy_to, interruption=supervision.interruption)
    postponed = supervision.interruption.postponed()
    with postponed, Writer.create(interrupted.path, layout, source, force=True, begin=begin) as writer:
        supervision.announce(note)
        recorder = Recorder(prepared, writer, sampler, integrator)
        recorder.from_plain(recorded)
        yield Ongoing(prepared, start, integrator, recorder, supervision, interrupted.warnings)


def layout_of(sampler: Sampler) -> Layout:
    """Return the Layout of the rows that a Sampler fills."""
    return Layout([Series(c.path, c.unit, c.doc, c.shape) for c in sampler.columns])


class Ongoing:
    """A run whose results file is open; ``state`` is its current RunState.

    The message of a failure repeats the warnings about the elements that failed; ``notes`` are the warnings from
    before the time integration.
    """

    def __init__(
        self,
        prepared: "Prepared",
        start: "RunState",
        integrator: "TimeIntegrator",
        recorder: Recorder,
        supervision: Supervision,
        notes: Sequence[str],
    ):
        self.deck, self.state, self.integrator, self.recorder = prepared.deck, start, integrator, recorder
        self._prepared, self._start = prepared, start
        self._announce, self._notes, interval = supervision.announce, notes, supervision.interval
        writer = CheckpointWriter(integrator, recorder, supervision.interruption, interval)
        self._checkpoint_writer = integrator.pause = writer
        recorder.poll = self._checkpoint_writer.poll
        integrator.method.patience = min(integrator.method.patience, interval)
        integrator.recorder, integrator.observers = recorder, tuple(supervision.observers)
        self._judged = start
        self._short_steps: ShortSteps | None = None
        judges = [self._judge_steps] if integrator.control.adaptive and integrator.method.order == 2 else []
        self._outlook: Outlook | None = None
        self._begun = clock.monotonic()
        self._longest = 0.0 if integrator.control.adaptive else integrator.control.maximum  # step so far [s]
        integrator.reporters = recorder.report, *judges, self._watch_pace, *supervision.reporters

    def _judge_steps(self, run):
        """Let a monitor, once there is a reason for one, count the steps up to ``run`` if they are very short."""
        last, control = self._judged, self.integrator.control
        steps, time = run.steps - last.steps, run.motion.t - last.motion.t
        if steps < BLOCK:
            return
        self._judged = run
        if time < VERY_SHORT * control.duration * steps:
            if self._short_steps is None:
                from mecano.solve.time.short_steps import ShortSteps  # most runs have no such steps

                self._short_steps = ShortSteps(self.integrator.method, control)
            self._short_steps.add(last, run)

    def _watch_pace(self, run):
        """Let an Outlook, once the run has taken some time, watch over its pace."""
        if run.steps > self._start.steps:  # before, the step is a first guess
            self._longest = max(self._longest, run.h)
        if self._outlook is not None:
            self._outlook.look(run, self._longest)
        elif clock.monotonic() - self._begun > AT_ONCE:
            from mecano.analyses.outlook import Outlook  # most runs end before

            end = self.deck.values["time"]["end"]
            self._outlook = Outlook(self.integrator, end, self._announce, run)

    def advance(self, t: float, given: Mapping[str, float] | None = None) -> None:
        """Integrate to the time ``t`` [s], with new values of external signals from the current time on.

        ``given`` maps names of signals to these values. Raises ConvergenceError, NonFiniteError, Stopped, ResultsError.
        """
        deck, sampler, recorder = self.deck, self.recorder.sampler, self.recorder
        try:
            with recorder.kept_if_it_fails():
                self.state = self.integrator.to(t, self.state, self._memory_with(given) if given else None)
        except (ConvergenceError, NonFiniteError) as error:
            from mecano.analyses.control_stability import causes_of_failure  # most runs do not fail

            known = [*self._notes, *self.integrator.warnings, *limit_warnings(deck, sampler, recorder.writer.extremes)]
            latches = open_latch_warnings(deck, recorder.row, sampler, recorder.writer.extremes)
            turning = unstable_turning_warnings(deck.values["time"], sampler, recorder.writer.extremes)
            unstable = causes_of_failure(self._prepared, self._start, self._notes)
            after = [*latches, *(f"warning: {text}" for text in turning), *unstable]
            raise type(error)("\n".join([failure_text(error, deck, known), *after])) from error

    def _memory_with(self, given):
        from mecano.elements.signals.external import with_external_values  # not needed by runs without such signals

        titles = {title_of("external", name): value for name, value in given.items()}
        return with_external_values(self.integrator.system, self.state.motion, titles)

    def to_the_end(self) -> "RunState":
        """Integrate to the end of the run, close the file, and return the final RunState."""
        self.advance(self.deck.values["time"]["end"])
        self._complete()
        return self.state

    def _complete(self):
        """Announce the warnings about the whole run, and close the file as complete."""
        self.recorder.flush()
        warnings = self._final_warnings()
        for text in warnings:
            self._announce(text)
        t, writer = self.state.motion.t, self.recorder.writer
        if self.ended and t > writer.last_time:
            writer.append(t, self.recorder.row)  # between two saved times
        met = f"{UNTIL.format(self.deck.values['time']['until'])} at t = {t:.9g} s"
        writer.close("complete", with_warnings(met if self.ended else ENDED, warnings))

    @property
    def ended(self) -> bool:
        """Whether the condition at which the run ends is met."""
        return self.integrator.monitor.ended(self.state.motion)

    def _final_warnings(self):
        deck, integrator, recorder, values = self.deck, self.integrator, self.recorder, self.deck.values["time"]
        sampler, extremes = recorder.sampler, recorder.writer.extremes
        warnings = [*integrator.warnings, *step_cut_warnings(values, integrator.cuts, self.state)]
        if self._short_steps:
            warnings += self._short_steps.warnings(self.state)
        warnings += capture_warnings(values, integrator.capture)
        warnings += until_warnings(values, self.state.motion.t, self.ended)
        warnings += limit_warnings(deck, sampler, extremes)
        warnings += open_latch_warnings(deck, recorder.row, sampler, extremes)
        warnings += waiting_warnings(integrator.system, self.state.motion.phases)
        warnings += _unmet_conditions(deck, integrator.system, self.state.motion.phases, sampler, extremes)
        warnings += untouched_ground_warnings(deck, sampler, extremes, self.state.motion.t)
        if any(ground["profile"] for ground in deck.values["grounds"].values()):
            from mecano.analyses.unmet_bumps import unmet_bump_warnings  # few decks have a profile

            warnings += unmet_bump_warnings(deck, sampler, extremes)
        warnings += wrap_warnings(deck, sampler, extremes)
        length, mass = integrator.method.length, mass_of(integrator.system)
        warnings += energy_warnings(values, sampler, extremes, length, mass)
        warnings += unstable_turning_warnings(values, sampler, extremes)
        warnings += circle_warnings(values, integrator.method, self.state, sampler, extremes)
        warnings += undeveloped_friction_warnings(deck, sampler, extremes, length)
        if integrator.method.order == 2:
            warnings += yielding_warnings(integrator.system, self.state.compliance, length, sampler, extremes)
        return [*warnings, *oscillation_warnings(values, sampler, recorder.ringing, extremes, length, mass)]

    def leave(self) -> None:
        """Close the file: as complete at the end of the run, otherwise with a checkpoint."""
        t = self.state.motion.t
        if t >= self.deck.values["time"]["end"] or self.ended:
            self._complete()
            return
        self.checkpoint()
        self.recorder.writer.close("stopped", f"left at t = {t:.9g} s")

    def checkpoint(self) -> None:
        """Write a checkpoint of the current state. Raises ResultsError."""
        self._checkpoint_writer.write(self.state)


def _unmet_conditions(deck, system, *states):
    if not any(event.command or event.condition for batch in system.batches for event in batch.kind.events):
        return ()
    from mecano.analyses.unmet_conditions import unmet_condition_warnings  # few runs have conditions

    return unmet_condition_warnings(deck, system, *states)
