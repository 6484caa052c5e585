"""Solution of decks and studies from Python, with progress on the standard error; Ctrl-C leaves a checkpoint."""

import os
import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import UnknownNameError, UsageError
from mecano.interface.deck import AnyDeck, AnyPath, Values, checked_deck, explained, name_of
from mecano.interface.results import Results, preformatted
from mecano.interface.run_with_progress import run_with_progress
from mecano.interface.saved_state import SavedState, saved_state
from mecano.process.cores import cores
from mecano.process.interrupt import Interruption
from mecano.solve.modal import SOLVERS

if TYPE_CHECKING:
    import pandas

    from mecano.results.study_file import StudyTable


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
    _require(checkpoint is None or checkpoint >= 0.0, "checkpoint", checkpoint, "a time [s] of zero or more")
    checked = checked_deck(deck, set)
    path = os.fspath(path or f"{name_of(deck)}.h5")
    interruption = Interruption(again=resuming(deck, path, set))
    with interruptible(interruption):
        run_with_progress(
            checked, path, force=force, resume=resume, checkpoint=checkpoint, quiet=quiet, interruption=interruption
        )
    return Results(path)


def check(deck: AnyDeck, *, set: Values | None = None) -> "Check":
    """Check a deck without running it.

    Returns
    -------
    Check
        Its text is the output of `mecano check`.

    Raises
    ------
    DeckError, AssemblyError

    Examples
    --------
    >>> model = mecano.check("pendulum.yaml")
    >>> model.mass, model.mobility, model.redundant_constraints
    (1.0, 1, 0)
    """
    from mecano.analyses.prepare import model_facts, prepare, warnings_of
    from mecano.analyses.summary import summary_of

    prepared = prepare(checked_deck(deck, set))
    return Check(**model_facts(prepared), warnings=tuple(warnings_of(prepared)), text=summary_of(prepared))


@dataclass(frozen=True, kw_only=True)
class Check:
    """Summary of a model before a run; ``mobility`` is None if it was not computed."""

    mass: float  # [kg]
    unknowns: int
    degrees_of_freedom: int
    multipliers: int
    redundant_constraints: int
    mobility: int | None = None
    warnings: tuple[str, ...] = ()
    text: str = field(repr=False)

    def __str__(self):
        return self.text

    def _repr_html_(self) -> str:
        return preformatted(self.text)


def modes(
    deck: AnyDeck, path: AnyPath | None = None, *, set: Values | None = None,
    at: SavedState | None = None, at_rest: bool = False, number: int = 10,
    frame: str = "inertial", solver: str = "automatic", force: bool = False,
) -> "Modes":  # fmt: skip
    """Compute modes about the initial state of a deck, its equilibrium, or a saved state.

    Parameters
    ----------
    deck : str, Path, Deck or dict
    path : str or Path
        File for the shapes; by default none is written.
    set : dict
        Overrides of values of the deck.
    at : str, Path or tuple
        "results.h5:1.25", or ("results.h5", 1.25): about the saved state nearest to that time; without a time the last.
    at_rest : bool
        About the equilibrium near the state of ``at``.
    number : int
        Number of modes, those of lowest frequency.
    frame : str
        Axes of the motions: "inertial", those of a node, or turning at "wx,wy,wz" [rad/s].
    solver : {"automatic", "dense", "sparse"}
    force : bool
        Replace an existing file.

    Returns
    -------
    Modes

    Raises
    ------
    DeckError, UsageError, AssemblyError, ConvergenceError, NonFiniteError, ResultsError

    Examples
    --------
    >>> found = mecano.modes("pendulum.yaml", set={"initial": "static"})
    >>> float(round(found.frequency[0], 4))  # of a point mass on 1 m: sqrt(9.81)/(2 pi)
    0.4985
    """
    from mecano.analyses.modal import modes as find

    _require(isinstance(number, int | np.integer) and number >= 1, "number", number, "a whole number of 1 or more")
    _require(solver in SOLVERS, "solver", solver, " or ".join(map(repr, SOLVERS)))
    place, checked = saved_state(at, at_rest), checked_deck(deck, set)
    where = None if path is None else os.fspath(path)
    text, found, about = find(
        checked, where, at=place, at_rest=at_rest, number=number, frame=frame, method=solver, force=force
    )
    return Modes(found.values, found.frequency, found.natural_frequency, found.damping_ratio, tuple(found.kinds),
                 found.shapes, about.words, text)  # fmt: skip


@dataclass(frozen=True)
class Modes:
    """Modes by ascending natural frequency; of a conjugate pair, the one with the positive imaginary part."""

    eigenvalues: np.ndarray  # (m,) complex [1/s]
    frequency: np.ndarray  # damped (m,) [Hz]
    natural_frequency: np.ndarray  # (m,) [Hz]
    damping_ratio: np.ndarray  # (m,)
    kinds: tuple[str, ...]  # free, oscillation, flutter, decay or divergence
    shapes: np.ndarray = field(repr=False)  # (m, n) complex, over the degrees of freedom
    about: str
    text: str = field(repr=False)  # the table that `mecano modes` prints

    def __str__(self):
        return self.text

    def _repr_html_(self) -> str:
        return preformatted(self.text)


def sweep(
    study: AnyPath, folder: AnyPath | None = None, *, jobs: int | None = None, resume: bool = False,
    again: str | None = None, force: bool = False, quiet: bool = False,
) -> "Study":  # fmt: skip
    """Run the cases of a study in parallel, each in a separate process, and return their table.

    Call it from the main thread. Ctrl-C ends all cases with checkpoints.

    Parameters
    ----------
    study : str or Path
        Study file.
    folder : str or Path
        Folder of the cases; by default the name of the study with _runs, in the working folder.
    jobs : int
        Number of parallel cases; by default one per core.
    resume : bool
        Run only the cases that are neither complete nor failed.
    again : {"failed"}
        As ``resume``, and also rerun failed cases from their start.
    force : bool
        Delete existing cases and run all.
    quiet : bool
        Print nothing.

    Returns
    -------
    Study
        Returned even if cases have failed; see its column ``status``.

    Raises
    ------
    DeckError, UsageError, ResultsError
    """
    from mecano.deck.source import is_utf8
    from mecano.results.study_file import read_study as read_table
    from mecano.study import execution
    from mecano.study.folder import Folder
    from mecano.study.pool import Limits, run_here
    from mecano.study.read import read_study, try_deck
    from mecano.study.units import units_of

    _require(jobs is None or jobs >= 1, "jobs", jobs, "1 or more")
    _require(again in (None, "failed"), "again", again, "'failed'")
    refuse_both(resume or again is not None, force)
    with explained():
        checked = read_study(os.fspath(study))
        deck = try_deck(checked)
    place = Folder(folder or f"{name_of(study)}_runs", checked)
    if not is_utf8(place.path):
        raise UsageError(f"the name of the folder {ascii(str(place.path))} is not UTF-8 text")
    interruption = Interruption(again=f"mecano.sweep({os.fspath(study)!r}, {str(place.path)!r}, resume=True)")
    with interruptible(interruption):
        due = execution.due(place, resume=resume, failed=again == "failed", force=force)
        run_cases = partial(run_here, limits=Limits(), jobs=jobs or cores())
        execution.execute(deck, place, units_of(checked, deck), due, run_cases, interruption, quiet=quiet)
    return Study(read_table(place.table), Path(place.path))


class Study:
    """Table of a study; ``study[name]`` is the array of a column, ``folder`` has the results of the cases.

    A varied value is named by any ending of its path.
    """

    def __init__(self, table: "StudyTable", folder: Path):
        self._columns = {one.name: one for one in table.columns}
        self.folder = folder

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns: case, varied values, status, outputs."""
        return tuple(self._columns)

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column: name -> unit, empty if it has none."""
        return {name: one.unit for name, one in self._columns.items()}

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __getitem__(self, name: str) -> np.ndarray:
        found = [name] if name in self._columns else [one for one in self._columns if one.endswith(f".{name}")]
        if len(found) > 1:
            raise UnknownNameError(f"'{name}' is ambiguous, it may be {', '.join(found)}: write more of the path")
        if not found:
            raise UnknownNameError(f"no column '{name}' in this study: there are {', '.join(self._columns)}")
        return self._columns[found[0]].values

    def __len__(self):
        """Return the number of cases."""
        return len(self["case"])

    def results(self, case: int) -> Results:
        """Open the results of a case, by its number from 1. Raises ResultsError, also if the case has not begun."""
        return Results(self.folder / f"{case:0{max(4, len(str(len(self))))}d}.h5")

    def to_pandas(self) -> "pandas.DataFrame":
        """Return a DataFrame with a row for each case. Raises ImportError without pandas."""
        from mecano.interface.results import imported

        frame = imported("pandas", "Study.to_pandas").DataFrame({name: self[name] for name in self.columns})
        frame.attrs["units"] = self.units
        return frame

    def __repr__(self):
        statuses, counts = np.unique(self["status"].astype(str), return_counts=True)
        ended = ", ".join(f"{count} {status}" for count, status in zip(counts, statuses, strict=True))
        return f"Study of {len(self)} cases: {ended}"

    def _repr_html_(self) -> str:
        """Return the table that notebooks display: the columns with their units."""
        head = [f"{name} [{unit}]" if unit else name for name, unit in self.units.items()]
        rows = [head, *(map(_shown, row) for row in zip(*(self[name] for name in self.columns), strict=True))]
        cells = ("".join(f"<td>{escape(text)}</td>" for text in row) for row in rows)
        return f"<table><caption>{escape(repr(self))}</caption><tr>{'</tr><tr>'.join(cells)}</tr></table>"


def _shown(value):
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def refuse_both(resume: bool, force: bool) -> None:
    """Raise UsageError if a results file is to be both continued and replaced."""
    if resume and force:
        raise UsageError("resume=True continues a results file, force=True replaces it")


def _require(valid, option, value, wanted):
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
