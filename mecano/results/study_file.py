"""The table of a study by `mecano sweep`, as HDF5 (layout in docs/studies.md) and as CSV."""

import csv
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import h5py
import numpy as np

from mecano.results.disk import atomic_hdf5_file
from mecano.results.opening import open_format
from mecano.results.provenance import provenance
from mecano.results.table import describe
from mecano.results.whole_file import atomic_file

FORMAT, FORMAT_VERSION = "mecano study", 1
TEXT = h5py.string_dtype()
BETWEEN = " | "  # two warnings of a case
FAIL = "fail"  # verdict on a case with an output beyond its limits
LIMITS = "at_least", "at_most"
Bounds: TypeAlias = tuple[float | None, float | None]  # smallest and largest value of a case that passes, if limited
ENDLESS = -np.inf, np.inf


@dataclass(frozen=True)
class Column:
    """One column of the table: ``group`` is "case", "parameters" or "outputs"; values (n,) numbers or texts."""

    group: str
    name: str
    unit: str
    doc: str
    values: np.ndarray
    limits: Bounds = (None, None)

    @property
    def numeric(self) -> bool:
        """True if the values are numbers."""
        return self.values.dtype.kind in "fi"

    @property
    def beyond(self) -> np.ndarray:
        """Flags (n,): the value is beyond the limits, or missing; all False without limits."""
        return ~np.array([within(self.limits, value) for value in self.values], bool)

    @property
    def path(self) -> str:
        """Path in the file."""
        return f"{self.group}/{self.name.replace('/', '|')}"


@dataclass(frozen=True)
class StudyTable:
    """The table of a study, a row for each case: all its columns, the text of the study file, title and deck."""

    title: str
    text: str
    deck: str
    columns: tuple[Column, ...]

    def group(self, name: str) -> tuple[Column, ...]:
        """Return the columns of a group."""
        return tuple(column for column in self.columns if column.group == name)

    def __getitem__(self, path):
        """Return the values of a column, by its path such as "case/status"."""
        return next(column.values for column in self.columns if column.path == path)

    @property
    def named(self) -> bool:
        """True if cases have names."""
        return any(column.path == "case/name" for column in self.columns)

    @property
    def case_names(self) -> list[str]:
        """Names of the cases; of those without one, the numbers."""
        numbers = [f"{n:.0f}" for n in self["case/case"]]
        return [name or n for name, n in zip(self["case/name"], numbers, strict=True)] if self.named else numbers

    @property
    def verdict(self) -> str:
        """Numbers of cases by status, as text."""
        counts = Counter(self["case/status"])
        words = ", ".join(f"{count} {word}" for word, count in counts.items())
        failed = list(self.verdicts).count(FAIL)
        return f"{counts.total()} cases: {words}{counts_text(sum(map(bool, self.warnings)), failed)}"

    @property
    def verdicts(self) -> Sequence[str] | np.ndarray:
        """Verdicts on the cases, "pass", "fail", or "" of incomplete ones; empty if no output has limits."""
        return next((column.values for column in self.columns if column.path == "case/verdict"), ())

    @property
    def warnings(self) -> list[list[str]]:
        """Lists of warnings of all cases."""
        texts = next((column.values for column in self.columns if column.path == "case/warnings"), ())
        return [text.split(BETWEEN) if text else [] for text in texts]


def within(limits: Bounds, value: float) -> bool:
    """Return whether a number is within (smallest, largest), each None if it is absent.

    A missing number (nan) is within absent limits only.
    """
    if limits == (None, None):
        return True
    low, high = (bound if limit is None else limit for limit, bound in zip(limits, ENDLESS, strict=True))
    return bool(low <= value <= high)


def counts_text(warned: int, failed: int) -> str:
    """Return the end of a verdict on a study: numbers of complete cases with warnings, and beyond their limits."""
    counts = (warned, "with warnings"), (failed, "beyond limits")
    return "".join(f"; {count} {what}" for count, what in counts if count)


def column(group: str, name: str, unit: str, doc: str, values: Sequence[Any], limits: Bounds = (None, None)) -> Column:
    """Return a Column of Python values: floats if all are numbers or None (nan), otherwise texts."""
    numbers = all(value is None or type(value) in (int, float) for value in values)
    array = np.array([np.nan if value is None else value for value in values], float) if numbers else np.array(
        ["" if value is None else str(value) for value in values], object
    )  # fmt: skip
    return Column(group, name, unit, doc, array, limits)


def write_study(path: str | os.PathLike[str], table: StudyTable) -> None:
    """Write a StudyTable to a file that appears only when complete. Raises ResultsError."""
    with atomic_hdf5_file(path) as file:
        for one in table.columns:
            kind = None if one.numeric else TEXT
            dataset = file.create_dataset(one.path, data=one.values, dtype=kind)
            describe(dataset, units=one.unit, long_name=one.doc)
            limits = zip(LIMITS, one.limits, strict=True)
            dataset.attrs.update({name: limit for name, limit in limits if limit is not None})
        file["study/text"] = table.text
        file["study/columns"] = np.array([one.path for one in table.columns], TEXT)
        run = file.create_group("run")
        run.attrs.update({"title": table.title, "deck_path": table.deck, **provenance()})
        file.attrs.update({"format": FORMAT, "format_version": FORMAT_VERSION})


def read_study(path: str | os.PathLike[str]) -> StudyTable:
    """Read the StudyTable of a file. Raises ResultsError."""
    with open_format(path, FORMAT, "a table of a study") as file:
        columns = tuple(_read(file, name.decode()) for name in file["study/columns"][:])
        run = file["run"].attrs
        return StudyTable(run["title"], file["study/text"][()].decode(), run["deck_path"], columns)


def _read(file, path):
    dataset, (group, _, name) = file[path], path.partition("/")
    values = dataset[:] if dataset.dtype.kind in "fi" else dataset.asstr()[:]
    limits = tuple(dataset.attrs.get(limit) for limit in LIMITS)
    return Column(group, name.replace("|", "/"), dataset.attrs["units"], dataset.attrs["long_name"], values, limits)


def write_columns(path: str | os.PathLike[str], table: StudyTable) -> None:
    """Write a StudyTable as comma-separated values: a row for each case. Raises ResultsError."""
    with atomic_file(Path(path)) as hidden, open(hidden, "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow([one.name + (f" [{one.unit}]" if one.unit else "") for one in table.columns])
        rows.writerows(zip(*([_cell(value) for value in one.values] for one in table.columns), strict=True))


def _cell(value):
    if not isinstance(value, float):
        return value
    if np.isnan(value):
        return ""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))
