"""Run the cases of studies from Python, and read their tables."""

import os
from collections.abc import Iterator
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import UnknownNameError, UsageError
from mecano.interface.deck import AnyPath, explained, name_of
from mecano.interface.results import Results
from mecano.interface.solving import interruptible, refuse_both, require
from mecano.process.cores import cores
from mecano.process.interrupt import Interruption

if TYPE_CHECKING:
    import pandas

    from mecano.results.study_file import StudyTable


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

    if not isinstance(study, str | os.PathLike):
        raise TypeError(f"a study is the path of a file, not a {type(study).__name__}; json.dump writes a dict to one")
    require(jobs is None or jobs >= 1, "jobs", jobs, "1 or more")
    require(again in (None, "failed"), "again", again, "'failed'")
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
        """Return a DataFrame with a row for each case; its number and exit code are whole numbers, or missing.

        Raises ImportError without pandas.
        """
        from mecano.interface.results import imported

        frame = imported("pandas", "Study.to_pandas").DataFrame({name: self[name] for name in self.columns})
        frame = frame.astype(dict.fromkeys(frame.columns.intersection(["case", "exit_code"]), "Int64"))
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
