"""Solve and check decks from Python, with progress on the standard error; Ctrl-C leaves a checkpoint."""

import os
import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from mecano.errors import UsageError
from mecano.interface.deck import AnyDeck, AnyPath, Values, checked_deck, name_of
from mecano.interface.results import Results, preformatted
from mecano.interface.run_with_progress import run_with_progress
from mecano.process.cores import bounded_blas
from mecano.process.interrupt import Interruption


@bounded_blas()
def run(
    deck: AnyDeck, path: AnyPath | None = None, *, set: Values | None = None, force: bool = False, resume: bool = False,
    checkpoint: float | None = None, quiet: bool = False,
) -> Results:  # fmt: skip
    """Solve a deck, with progress on the standard error, and return its open results file.

    Ctrl-C ends the run with a checkpoint and raises KeyboardInterrupt; ``resume`` continues it, bit for bit.

    Parameters
    ----------
    deck : str, Path, Deck or dict
    path : str or Path
        Results file; by default the name of the deck with .h5, in the working folder.
    set : dict
        Overrides of values of the deck, {"time.end": 2}.
    force : bool
        Replace an existing results file.
    resume : bool
        Continue the results file from its last checkpoint, if there is one.
    checkpoint : float
        Wall-clock time between checkpoints [s]; by default 30.
    quiet : bool
        Print nothing.

    Returns
    -------
    Results

    Raises
    ------
    DeckError
        The deck is invalid; the message gives locations and corrections.
    UsageError
        The options exclude each other or do not apply to the deck, or the results file belongs to another deck.
    MecanoError
        The run failed: AssemblyError, ConvergenceError, NonFiniteError, ResultsError. The file keeps every saved time.

    Examples
    --------
    >>> results = mecano.run("pendulum.yaml", set={"time.end": 0.5}, quiet=True)
    >>> float(results.time[-1])
    0.5
    """
    refuse_both(resume, force)
    require(checkpoint is None or checkpoint >= 0.0, "checkpoint", checkpoint, "a time [s] of zero or more")
    checked = checked_deck(deck, set)
    path = os.fspath(path or f"{name_of(deck)}.h5")
    interruption = Interruption(again=resuming(deck, path, set))
    with interruptible(interruption):
        run_with_progress(
            checked, path, force=force, resume=resume, checkpoint=checkpoint, quiet=quiet, interruption=interruption
        )
    return Results(path)


@bounded_blas()
def check(deck: AnyDeck, *, set: Values | None = None) -> "Check":
    """Check a deck without running it.

    Returns
    -------
    Check
        Its text is the output of `mecano check`.

    Raises
    ------
    DeckError, AssemblyError, NonFiniteError

    Examples
    --------
    >>> model = mecano.check("pendulum.yaml")
    >>> model.mass, model.mobility, model.redundant_constraints
    (1.0, 1, 0)
    """
    from mecano.analyses.prepare import model_facts, prepare
    from mecano.analyses.summary import summary_of

    prepared = prepare(checked_deck(deck, set))
    text, warnings = summary_of(prepared)
    return Check(**model_facts(prepared), warnings=tuple(warnings), text=text)


@dataclass(frozen=True, kw_only=True)
class Check:
    """Summary of a model before a run."""

    mass: float  # [kg]
    unknowns: int
    degrees_of_freedom: int
    multipliers: int
    redundant_constraints: int
    mobility: int
    warnings: tuple[str, ...] = ()
    text: str = field(repr=False)

    def __str__(self):
        return self.text

    def _repr_html_(self) -> str:
        return preformatted(self.text)


def refuse_both(resume: bool, force: bool) -> None:
    """Raise UsageError if a results file is to be both continued and replaced."""
    if resume and force:
        raise UsageError("resume=True continues a results file, force=True replaces it")


def require(valid: Any, option: str, value: object, wanted: str) -> None:
    """Raise UsageError for an invalid value of an option."""
    if not valid:
        raise UsageError(f"{option}={value!r}: write {wanted}")


@contextmanager
def interruptible(interruption: Interruption) -> Iterator[None]:
    """Handle Ctrl-C by an Interruption within the block, and restore the handlers at its end.

    Does nothing outside the main thread, which alone receives signals.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handler, hook = signal.getsignal(signal.SIGINT), sys.unraisablehook
    interruption.listen((signal.SIGINT,))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        sys.unraisablehook = hook


def resuming(deck: AnyDeck, path: str, overrides: Values | None) -> str:
    """Return the Python call that resumes a run, for messages."""
    words = ["deck" if isinstance(deck, Mapping) else repr(os.fspath(deck)), repr(path)]
    words += [f"set={dict(overrides)!r}"] if overrides else []
    return f"mecano.run({', '.join(words)}, resume=True)"
