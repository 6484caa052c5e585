"""Reading of results files: complete, still being written, killed, or truncated."""

import os
import platform
from collections.abc import Mapping
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from mecano.element_interface import SECTIONS, Display
from mecano.errors import ResultsError
from mecano.model.mesh import piece_names
from mecano.model.model import title_of
from mecano.results.checkpoints import latest
from mecano.results.layout import EVENT_NUMBERS, EVENT_TEXTS, EXTREMES, FORMAT, FORMAT_VERSION, Layout, Series
from mecano.results.lookup import ByName, Extremes, Lookup, require_names
from mecano.results.opened_file import OpenedFile
from mecano.results.provenance import is_running, read_displays, start_time
from mecano.results.reason import split_reason
from mecano.results.recorded import MAGNITUDE, Event, Extreme, Trace
from mecano.results.run_attributes import ENDS, read_attributes
from mecano.results.state import SavedState

_CLOCKS = 60.0  # s by which clocks may have been set
MOST_NUMBERS = 2**24  # of a table that is kept in memory: 128 MB
_KEPT = tuple(
    "_table series time events _subjects steps extremes resolved displays metadata _run_attributes automatic model "
    "resumptions warnings checkpoint".split()
)
_EVENT_COLUMNS = tuple(f"events/{name}" for name in ("event_time", *EVENT_TEXTS, *EVENT_NUMBERS))


def open_results(path: str | os.PathLike[str]) -> "Results":
    """Open a results file for reading.

    Raises
    ------
    ResultsError
        The file does not exist, is not a results file of mecano, or is too badly truncated.
    """
    return Results(path)


class Results(ByName):
    """Content of a results file, as acknowledged when the file was opened; a context manager."""

    def __init__(self, path: str | os.PathLike[str]):
        self.path = Path(path)
        self._where = self.path.absolute()  # also after os.chdir
        self._open(self.path)

    def __reduce__(self):
        """Return what opens the same file in another process."""
        return type(self), (self._where,)

    def _open(self, path):
        self._opened = None
        for name in _KEPT:
            self.__dict__.pop(name, None)
        try:
            self._opened = OpenedFile(path)
            with self._file.reading("format"):
                self._check_format()
            self._status = self._file.text("run/status")  # before the counters: those of a complete run are the last
            with self._file.reading("run/acknowledged"):
                counters = self._file.h5["run/acknowledged"][:4]
                self._rows, self._step_rows, self._event_rows, self._slot = map(int, counters)
            with self._file.reading("storage/layout"):
                self._layout = Layout.from_json(self._file.h5["storage/layout"][()])
            self._clip()
        except BaseException:
            self.close()
            raise

    def _check_format(self):
        found = _as_text(self._file.h5.attrs.get("format"))
        if found != FORMAT:
            what = f"of a run, but of the format '{found}'" if found else "of mecano, but another HDF5 file"
            raise ResultsError(f"{self.path} is not a results file {what}")
        if self.format_version > FORMAT_VERSION:
            raise ResultsError(
                f"{self.path} has format {self.format_version} of a newer mecano; this one reads {FORMAT_VERSION}"
            )

    @property
    def format_version(self) -> int:
        """Version of the format of the file."""
        with self._file.reading("format_version"):
            return int(self._file.h5.attrs["format_version"])

    def _clip(self):
        """Limit the numbers of rows to those present."""
        self._rows = self._file.rows_present("storage/output", self._rows)
        self._step_rows = self._file.rows_present("storage/solver", self._step_rows)
        self._event_rows = min(self._file.rows_present(name, self._event_rows) for name in _EVENT_COLUMNS)

    def refresh(self) -> None:
        """Open the file again, to read data added by a running writer."""
        self.close()
        self._open(self._where)

    def close(self) -> None:
        """Close the file."""
        if self._opened is not None:
            self._opened.close()
            self._opened = None

    @property
    def _file(self):
        """The opened file. Raises ResultsError after ``close``."""
        if self._opened is None:
            raise ResultsError(f"the results of {self.path} have been closed: read them before, or open the file again")
        return self._opened

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    @cached_property
    def time(self) -> np.ndarray:
        """Saved times (n,) [s]."""
        return self._file.read("storage/output", (slice(self._rows), 0))

    @property
    def axis(self) -> Series:
        """Name, unit and description of ``time``; for statics the load factor or the length of the path."""
        return self._layout.axis

    @cached_property
    def _lookup(self):
        return Lookup(self._layout.series)

    @cached_property
    def series(self) -> dict[str, Series]:
        """Declarations of all series: path -> Series with unit, description and shape."""
        return {one.path: one for one in self._layout.series}

    def find(self, name: str, rows: slice = slice(None)) -> Trace:
        """Return the Trace of a series, named by any ending of its path: ``wheel.radial_force``, ``axle.position.z``.

        ``axle.position.magnitude`` is the length of a vector. ``rows`` is a slice of the saved times.
        ``solver.step_size`` is a column of the solver history, over the ends of all accepted steps.

        Raises
        ------
        ResultsError
            No series, or more than one, has that name; the message lists similar names.
        """
        require_names([name])
        dotted = name.replace("/", ".")
        if dotted.endswith(MAGNITUDE):
            return self.find(dotted.removesuffix(MAGNITUDE), rows).magnitude
        head, _, column = dotted.partition(".")
        if head == "solver" and column in self.step_columns:
            unit, doc = self.step_columns[column]
            return Trace(f"solver/{column}", unit, doc, (), self.steps["time"], self.steps[column])
        series, component = self._lookup.find(name)
        start = 1 + self._layout.slices[series.path].start
        times, rows = self.time[rows], slice(*rows.indices(self._rows))
        if component is not None:
            values = self._columns(rows, start + component)
            return Trace(series.scalars[component], series.unit, series.doc, (), times, values)
        values = self._columns(rows, slice(start, start + series.width))
        shaped = values.reshape(-1, *series.shape)
        return Trace(series.path, series.unit, series.doc, series.components, times, shaped)

    def _columns(self, rows, columns):
        """Return some columns of the saved rows, a new array."""
        table = self._table
        return self._file.read("storage/output", (rows, columns)) if table is None else table[rows, columns].copy()

    @cached_property
    def _table(self):
        """All saved rows, read at once: a column alone takes as many chunks. None where they are many or damaged."""
        if self._rows * (1 + self._layout.size) > MOST_NUMBERS:
            return None
        try:
            return self._file.read("storage/output", (slice(self._rows), slice(None)))
        except ResultsError:
            return None

    def __getitem__(self, name):
        """Return the output with this name, as ``find`` does."""
        return self.find(name)

    @cached_property
    def events(self) -> list[Event]:
        """List of all Events in order of time."""
        columns = [self._file.read(name, slice(self._event_rows)) for name in _EVENT_COLUMNS]
        return [Event(*map(_plain, values)) for values in zip(*columns, strict=True)]

    def subject(self, event: Event) -> tuple[str, str]:
        """Return (kind, name) of the element, joint, load or signal of an Event."""
        return self._subjects.get(event.element, ("", event.element))

    @cached_property
    def _subjects(self):
        """The subjects of events by their titles in the file."""
        entries = [entry for section in SECTIONS for entry in self.resolved.get(section, {}).items()]
        return {title_of(d["type"], one): (d["type"], one) for name, d in entries for one in piece_names(name, d)}

    @cached_property
    def steps(self) -> np.ndarray:
        """Solver history: structured array of ``time`` [s] and the ``step_columns``, a row per accepted step."""
        rows = self._file.read("storage/solver", (slice(self._step_rows), slice(None)))
        kind = np.dtype([(name, "f8") for name in ("time", *(one.path for one in self._layout.steps))])
        return np.ascontiguousarray(rows).view(kind).reshape(-1)

    @property
    def step_columns(self) -> dict[str, tuple[str, str]]:
        """Unit and description of each column of the solver history: name -> (unit, doc)."""
        return {one.path: (one.unit, one.doc) for one in self._layout.steps}

    @cached_property
    def extremes(self) -> Mapping[str, Extreme]:
        """Extremes of every number over all accepted steps: name of an output, with its component -> Extreme."""
        if not self._layout.size:
            return {}
        rows = [self._file.read(f"extremes/{name}", self._slot) for name in EXTREMES]
        units = [one.unit for one in self._layout.series for _ in one.scalars]
        columns = (row.tolist() for row in rows)
        table = zip(self._layout.scalars, *columns, units, strict=True)
        return Extremes({name: Extreme(*values) for name, *values in table}, self._lookup)

    @cached_property
    def metadata(self) -> dict[str, Any]:
        """Provenance: versions, machine, command line, overrides, hashes of included files, ..."""
        metadata = dict(self._run_attributes)
        metadata["overrides"] = self._file.json("deck/overrides", list)
        metadata["includes"] = self._file.json("deck/includes", dict)
        metadata["format_version"] = self.format_version
        with self._file.reading("run/clock"):
            metadata["wall_time"], metadata["processor_time"] = map(float, self._file.read("run/clock", slice(None)))
        with self._file.reading("run/compile_time"):
            metadata["compile_time"] = float(self._file.read("run/compile_time", ()))
        return metadata

    @cached_property
    def _run_attributes(self):
        return read_attributes(self._file.h5["run"], self._file.reading)

    @property
    def deck_text(self) -> str:
        """The deck as written by its author."""
        return self._file.text("deck/text")

    @cached_property
    def resolved(self) -> dict[str, Any]:
        """The resolved deck: plain data after overrides, includes and defaults."""
        return self._file.json("deck/resolved", dict)

    @cached_property
    def displays(self) -> dict[str, Display]:
        """Displays of the kinds of the deck: {kind: Display}."""
        with self._file.reading("deck/displays"):
            return read_displays(self._file.h5)

    @cached_property
    def automatic(self) -> dict[str, float]:
        """Values chosen where the deck says "automatic": name -> number."""
        return self._file.json("deck/automatic", dict)

    @cached_property
    def model(self) -> dict[str, Any]:
        """Properties of the model: name -> number, or text."""
        return self._file.json("deck/model", dict)

    @cached_property
    def warnings(self) -> list[str]:
        """Warnings about the model issued before the run and, if it is complete, about its results: list of str."""
        return [*self._file.json("deck/warnings", list), *self._ended[1]]

    @cached_property
    def resumptions(self) -> list[str]:
        """Notes on the run that leave its results as they are, namely where it was resumed: list of str."""
        return self._file.json("deck/resumptions", list)

    @cached_property
    def checkpoint(self) -> SavedState | None:
        """State of the last valid checkpoint whose rows are present, or None."""
        with self._file.reading("checkpoints"):
            state = latest(self._file.h5["checkpoints"])
            there = self._rows, self._step_rows, self._event_rows
            return state if state is not None and np.all(state["file"]["rows"] <= there) else None

    @property
    def resumable(self) -> bool:
        """True if the run ended early with a checkpoint, from which ``mecano run --resume`` continues."""
        return self.status in ("stopped", "killed", "failed", "truncated") and self.checkpoint is not None

    def rows(self, table: str, first: int, last: int) -> np.ndarray:
        """Return rows ``first`` to ``last`` of the table "output" or "solver" as stored, with the time first."""
        return self._file.read(f"storage/{table}", (slice(first, last), slice(None)))

    @property
    def layout(self) -> Layout:
        """The declared series, and the columns of the solver history."""
        return self._layout

    @property
    def status(self) -> str:
        """End of the run: "complete", "stopped" or "failed"; otherwise "running", "killed" or "truncated".

        A killed run is recognized on the machine where it ran; elsewhere it seems to be running.
        """
        if self._file.source.missing:
            return "truncated"
        with self._file.reading("run/status"):
            if self._status not in ENDS:
                raise ValueError(f"'{self._status}' is not one of {', '.join(ENDS)}")
        if self._status == "running" and self.written_here and not self._writer_lives:
            return "killed" if self._file.text("run/status") == "running" else "running"  # it may have ended since
        return self._status

    @property
    def written_here(self) -> bool:
        """True if the file was written on this machine."""
        return self._run_attributes["host"] == platform.node() and os.name == "posix"

    @property
    def reason(self) -> str:
        """Reason of the end of the run, with warnings about its results; empty while it runs."""
        reason, warnings = self._ended
        return "; ".join([reason, *warnings])

    @property
    def end(self) -> str:
        """Reason of the end of the run, without warnings."""
        return self._ended[0]

    @property
    def _ended(self):
        stored = self._file.text("run/reason")
        return split_reason(stored) if self._status == "complete" else (stored, [])

    @property
    def _writer_lives(self):
        process = self._run_attributes["process"]
        with self._file.reading("run/started"):
            started = datetime.fromisoformat(self._run_attributes["started"]).timestamp()
        return is_running(process) and start_time(process) < started + _CLOCKS  # otherwise the number was reused


def _plain(value):
    """Return a text or number of an event as str or float."""
    return value.decode() if isinstance(value, bytes) else float(value)


def _as_text(value):
    return value.decode(errors="replace") if isinstance(value, bytes) else value
