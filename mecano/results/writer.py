"""Writing of the results file during the run.

A saved time, step or event is acknowledged when ``flush`` returns: it then remains in the file whatever happens to the
process. The data are flushed before the counters in ``run/acknowledged`` are written, and readers read no more rows
than these state. ``flush`` is called automatically when a buffer is full or ``flush_interval`` has passed.
"""

import atexit
import errno
import os
import time as clocks
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from mecano.errors import ResultsError
from mecano.jit.machine_code import compile_time
from mecano.model.extremes import Extremes
from mecano.results.checkpoints import Slots
from mecano.results.disk import Disk, deferring_signals, open_file
from mecano.results.empty_file import CHANGING, RUNNING, TEXT_LENGTHS, empty_file
from mecano.results.file_names import give_name, refuse_existing, remove_abandoned
from mecano.results.layout import EXTREMES, Layout
from mecano.results.provenance import Source, provenance
from mecano.results.table import EventTable, NumberTable, chunk_shape, describe
from mecano.results.whole_file import hidden_name

if TYPE_CHECKING:
    from mecano.results.recorded import Event
    from mecano.results.state import SavedState

STATUSES = (RUNNING, "complete", "stopped", "failed")
WRITING = "writing failed"
"""Beginning of the reason of a run that ended because of a full disk."""
LOST = (errno.ENOENT, errno.ENODATA)  # the file was removed, replaced or cut short
UNSAFE = 2**14
"""Limit of numbers passed to the disk and not yet acknowledged, which a failure of the disk may lose."""
_CLOSING = 2e-9
"""Time to close a file per byte [s]: writing cached data to the disk, and the checksums."""


class Writer:
    """A results file being written; made by ``Writer.create``, usable as a context manager.

    Attributes
    ----------
    path : Path
    extremes : Extremes
        To be updated with the values of every accepted step.
    acknowledged : int
        Number of acknowledged saved times.
    """

    @classmethod
    def create(
        cls,
        path: str | os.PathLike[str],
        layout: Layout,
        source: Source,
        *,
        force: bool = False,
        flush_interval: float = 1.0,
        begin: Callable[[Self], object] = lambda writer: None,
    ) -> Self:
        """Create a results file; it appears under its name only when it is ready for the first row.

        Parameters
        ----------
        path : str or Path
        layout : Layout
        source : Source
        force : bool
            Replace an existing file.
        flush_interval : float
            Longest time between flushes while rows arrive [s].
        begin : callable
            Called with the writer before the file appears, for instance to append rows.

        Raises
        ------
        ResultsError
            The file exists, or cannot be written.
        """
        path = Path(path)
        refuse_existing(path, force)
        hidden = path.with_name(f"{hidden_name(path)}.{os.getpid()}.part")
        try:
            remove_abandoned(path)
            disk = Disk(hidden)
            try:
                writer = cls(path, disk, layout, source, flush_interval)
                writer._publish(hidden, force, begin)
            except BaseException:
                disk.close()
                hidden.unlink(missing_ok=True)
                raise
        except OSError as error:
            if error.errno is None:  # from h5py, which never sees a failing Disk
                raise
            raise ResultsError(f"cannot write {path}: {error.strerror}") from error
        atexit.register(writer._at_exit)
        return writer

    def __init__(self, path: Path, disk: Disk, layout: Layout, source: Source, flush_interval: float):
        self.path = path
        self.extremes = Extremes(layout.size)
        self.acknowledged = 0
        self._disk = disk
        self._interval = flush_interval
        self._started, self._used, self._compiled = clocks.monotonic() - compile_time(), 0.0, 0.0
        self._due, self._unsafe = clocks.monotonic() + flush_interval, 0
        self._size = layout.size
        self._slot = 0
        self._last_time: float | None = None
        self._safe_time: float | None = None
        with deferring_signals():
            disk.write(empty_file(layout))
            file = self._file = _opened(disk, layout)
            self._outputs, self._steps = NumberTable(file["storage/output"]), NumberTable(file["storage/solver"])
            self._events, self._slots = EventTable(file["events"]), Slots(file, disk)
            self._write_source(source)
            file.flush()
            changing = (*CHANGING, *(f"extremes/{name}" for name in EXTREMES if layout.size))
            self._offsets = {name: file[name].id.get_offset() for name in changing}

    def _publish(self, hidden, force, begin):
        """Give the file its name; an existing file is replaced only if ``force``."""
        try:
            begin(self)
            if self._disk.error is not None:
                raise self._disk.error
            give_name(hidden, self.path, force)
        except BaseException:
            with deferring_signals():
                if self._file is not None:
                    self._file.close()
            raise

    def _write_source(self, source):
        """Write deck and provenance."""
        for name, text in source.texts().items():
            self._file[f"deck/{name}"] = text
        run, about = self._file["run"], {"title": source.title, "deck_path": source.deck_path, **provenance()}
        describe(run, **{key: text for key, text in about.items() if isinstance(text, str)})
        run.attrs.update({key: number for key, number in about.items() if not isinstance(number, str)})

    @property
    def last_time(self) -> float:
        """Time [s] of the last row of outputs, of which there is at least one."""
        assert self._last_time is not None
        return self._last_time

    def append(self, time: float, values: np.ndarray) -> None:
        """Append the values (layout.size,) at a saved time [s]."""
        self._last_time = time
        if self._outputs.add(time, values) or clocks.monotonic() >= self._due:
            self.flush()

    def append_step(self, time: float, values: np.ndarray) -> None:
        """Append an accepted step that ends at a time [s]: ``values`` (n,) of the columns of the solver history."""
        if self._steps.add(time, values) or clocks.monotonic() >= self._due:
            self.flush()

    def extend(self, table: str, rows: np.ndarray) -> None:
        """Append rows (n, width), the time first, as ``Results.rows`` gives them, to "output" or "solver"."""
        if not len(rows):
            return
        {"output": self._outputs, "solver": self._steps}[table].extend(rows)
        if table == "output":
            self._last_time = float(rows[-1, 0])
        self._unsafe += rows.size
        if self._unsafe >= UNSAFE or clocks.monotonic() >= self._due:
            self.flush()

    def append_event(self, event: "Event") -> None:
        """Append an Event."""
        texts = event.element, event.name, event.before, event.after, event.impulse_unit
        self._events.add(event.time, texts, (event.impulse, event.energy_lost))

    def flush(self) -> int:
        """Write all appended data to the file, and return the number of acknowledged saved times.

        Raises
        ------
        ResultsError
            Writing failed; data acknowledged before remain readable, and the file is closed.
        """
        if self._file is None:
            raise ResultsError(f"{self.path} is closed")
        with deferring_signals():
            for table in (self._outputs, self._steps, self._events):
                table.write()
            self._file.flush()
            self._disk.keep_loss(self.path)
            if self._disk.error is None:
                self._acknowledge()
        if self._disk.error is not None:
            self._give_up(self._disk.error)
        self._due, self._unsafe = clocks.monotonic() + self._interval, 0
        return self.acknowledged

    @property
    def closing_time(self) -> float:
        """Upper estimate of the time to close the file and write it to the disk [s]."""
        return _CLOSING * self._disk.size

    def checkpoint(self, state: "SavedState") -> None:
        """Acknowledge all appended data, and write a checkpoint with the ``state`` (results/state.py).

        Raises
        ------
        ResultsError
            Writing failed; the previous checkpoint remains valid, and the file is closed.
        """
        self.flush()
        with deferring_signals():
            self._slots.write({"run": state, "file": self._position()})
        if self._disk.error is not None:
            self._give_up(self._disk.error)

    def _position(self):
        """Return numbers of rows, checksums, clocks and extremes, for ``resume_at``."""
        tables, extremes = (self._outputs, self._steps, self._events), vars(self.extremes)
        return {
            "rows": np.array([table.written for table in tables]),
            "sums": np.array([table.sum for table in tables]),
            "clock": np.array(self._clock()),
            "compile_time": np.array(self._compiled + compile_time()),
            "extremes": {name: values.copy() for name, values in extremes.items()},
        }

    def resume_at(self, checkpoint: "SavedState") -> None:
        """Continue from a checkpoint, all rows before which have been appended.

        Raises
        ------
        ResultsError
            The rows differ from those at the checkpoint, or writing failed.
        """
        position = checkpoint["file"]
        self.flush()
        now = self._position()
        if not all(np.array_equal(now[key], position[key]) for key in ("rows", "sums")):
            raise ResultsError(f"the data of {self.path} before its checkpoint have changed since they were written")
        for name, values in position["extremes"].items():
            getattr(self.extremes, name)[:] = values
        self._started -= position["clock"][0]
        self._used += position["clock"][1]
        self._compiled += position.get("compile_time", 0.0)
        self.checkpoint(checkpoint["run"])

    def _acknowledge(self):
        self._slot = 1 - self._slot
        if self._size:
            self._patch_extremes()
        self._patch_clock()
        counters = [self._outputs.written, self._steps.written, self._events.written, self._slot]
        self._disk.patch(self._offsets["run/acknowledged"], np.array(counters, dtype="<i8"))
        self.acknowledged, self._safe_time = self._outputs.written, self._last_time

    def _clock(self):
        return clocks.monotonic() - self._started - compile_time(), self._used + clocks.process_time()

    def _patch_clock(self):
        self._disk.patch(self._offsets["run/clock"], np.array(self._clock()))
        self._disk.patch(self._offsets["run/compile_time"], np.array(self._compiled + compile_time()))

    def _patch_extremes(self):
        """Write the extremes to the row not in use, so that after a kill those of the counters are intact."""
        now = self.extremes
        high, low = (np.where(np.isnan(t), np.nan, x) for x, t in ((now.high, now.high_time), (now.low, now.low_time)))
        for name, row in zip(EXTREMES, (high, now.high_time, low, now.low_time), strict=True):
            self._disk.patch(self._offsets[f"extremes/{name}"] + row.nbytes * self._slot, row)

    def _text(self, name, text):
        """Return the offset in the file of a text, and its padded bytes."""
        length = TEXT_LENGTHS[name]
        cut = text.encode()[:length].decode(errors="ignore").encode()
        return self._offsets[f"run/{name}"], cut.ljust(length, b"\0")

    def _give_up(self, cause):
        """Close the file after a failure of the disk, the ``cause``, and raise ResultsError."""
        safe = f"{self.acknowledged} saved times"
        safe += f" up to t = {self._safe_time:.6g} s" if self.acknowledged else ""
        kept = "" if cause.errno in LOST else f"; {safe} are kept"
        self._end("failed")
        raise ResultsError(f"cannot write {self.path}: {cause.strerror}{kept}") from cause

    def close(self, status: str = "complete", reason: str = "") -> None:
        """Flush and close; later calls do nothing.

        Parameters
        ----------
        status : "complete", "stopped" or "failed"
        reason : str
            Reason of the end, truncated to 8000 bytes.

        Raises
        ------
        ResultsError
            The last data could not be written.
        """
        if status not in STATUSES[1:]:
            raise ValueError(f"'{status}' is not a status a run can end with")
        if self._file is None:
            return
        self.flush()
        self._acknowledge()  # again, so that both rows of the extremes are valid
        self._end(status, reason)
        if self._disk.error is not None:
            raise ResultsError(f"cannot write {self.path}: {self._disk.error.strerror}") from self._disk.error

    def _end(self, status, reason=""):
        """Close the HDF5 file, write status and reason, and append the checksums of a closed file."""
        with deferring_signals():
            self._file.close()
            self._file = None
            self._patch_clock()
            self._disk.patch(*self._text("reason", reason))
            if self._disk.error is not None:
                status, failure = "failed", f"{WRITING}: {self._disk.error.strerror}"
                self._disk.patch(*self._text("reason", f"{reason}; {failure}" if reason else failure))
            self._disk.patch(*self._text("status", status))
            if self._disk.error is None:
                self._disk.seal()
            self._disk.close()
        atexit.unregister(self._at_exit)

    def _at_exit(self):
        self.close("failed", "the process ended before the run did")

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        with deferring_signals():  # signals may repeat: that of the limit of processor time comes every second
            if error is None:
                self.close()
            elif self._file is not None:
                stopped = isinstance(error, KeyboardInterrupt)
                reason = str(error) or ("interrupted" if stopped else kind.__name__)
                self.close("stopped" if stopped else "failed", reason)


def _opened(disk, layout):
    """Open the file with a chunk cache for several rows of chunks, so that an incomplete chunk is never read back."""
    rows, width = chunk_shape(1 + layout.size)
    chunks = -(-(1 + layout.size) // width)
    return open_file(disk, max(3 * 8 * rows * width * chunks, 2**20), max(4 * chunks + 1, 521))
