"""Writing the results file while the run goes on.

A saved time, step or event counts as acknowledged once ``flush`` has returned: it is then in the file whatever happens
to the process. First the data are flushed, then the counters in ``run/acknowledged`` are written; readers take no more
than these say. ``flush`` happens by itself whenever a buffer is full or ``flush_interval`` has passed.
"""

import atexit
import glob
import os
import time as clocks
from pathlib import Path

import numpy as np

from mecano.errors import ResultsError
from mecano.jit.store import compile_time
from mecano.model.extremes import Extremes
from mecano.results.checkpoints import Slots
from mecano.results.disk import SIGNATURE, Disk, open_file, undisturbed
from mecano.results.empty_file import CHANGING, RUNNING, TEXT_LENGTHS, empty_file
from mecano.results.layout import EXTREMES
from mecano.results.provenance import lives, provenance
from mecano.results.table import EventTable, NumberTable, chunk_shape
from mecano.results.whole_file import exists, hidden_name, refuse_folder

STATUSES = (RUNNING, "complete", "stopped", "failed")
_EXISTS = "{} exists already; give another name, or --force to replace it"
WRITING = "writing failed"
"""How the reason begins when the disk took no more."""
UNSAFE = 2**14
"""Numbers that were handed to the disk and are not acknowledged: a failure of the disk loses no more."""
_CLOSING = 2e-9
"""s for a byte of a file that is closed: for what the disk has not got yet, and a little for its sums."""


class Writer:
    """A results file being written; made by ``Writer.create``, usable as a context manager.

    Attributes
    ----------
    path : Path
    extremes : Extremes
        To be updated with the values of every accepted step.
    acknowledged : int
        Saved times that are safe in the file.
    """

    @classmethod
    def create(cls, path, layout, source, *, force=False, flush_interval=1.0, begin=lambda writer: None):
        """Start a results file; it appears under its name only when it is complete up to the first row.

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
            Called with the writer before the file appears: what it appends is in the file from the first.

        Raises
        ------
        ResultsError
            The file exists, or cannot be written.
        """
        path = Path(path)
        refuse_existing(path, force)
        hidden = path.with_name(f"{hidden_name(path)}.{os.getpid()}.part")
        try:
            _clear(path)
            disk = Disk(hidden)
            try:
                writer = cls(path, disk, layout, source, flush_interval)
                writer._publish(hidden, force, begin)
            except BaseException:
                disk.close()
                hidden.unlink(missing_ok=True)
                raise
        except OSError as error:
            if error.errno is None:  # from h5py: the disk never fails towards it
                raise
            raise ResultsError(f"cannot write {path}: {error.strerror}") from error
        atexit.register(writer._at_exit)
        return writer

    def __init__(self, path, disk, layout, source, flush_interval):
        self.path = path
        self.extremes = Extremes(layout.size)
        self.acknowledged = 0
        self._disk = disk
        self._interval = flush_interval
        self._started, self._used, self._compiled = clocks.monotonic() - compile_time(), 0.0, 0.0
        self._due, self._unsafe = clocks.monotonic() + flush_interval, 0
        self._size = layout.size
        self._slot = 0
        self._last_time = self._safe_time = None
        with undisturbed():
            disk.write(empty_file(layout))
            file = self._file = _opened(disk, layout)
            self._outputs, self._steps = NumberTable(file["storage/output"]), NumberTable(file["storage/solver"])
            self._events, self._slots = EventTable(file["events"]), Slots(file, disk)
            self._write_source(source)
            file.flush()
            changing = (*CHANGING, *(f"extremes/{name}" for name in EXTREMES if layout.size))
            self._offsets = {name: file[name].id.get_offset() for name in changing}

    def _publish(self, hidden, force, begin):
        """Give the finished file its name, never over another one unless told."""
        try:
            begin(self)
            if self._disk.error is not None:
                raise self._disk.error
            _move(hidden, self.path, force)
        except BaseException:
            with undisturbed():
                if self._file is not None:
                    self._file.close()
            raise

    def _write_source(self, source):
        """Write where the results come from."""
        for name, text in source.texts().items():
            self._file[f"deck/{name}"] = text
        self._file["run"].attrs.update({"title": source.title, "deck_path": source.deck_path, **provenance()})

    def append(self, time, values):
        """Save the values (layout.size,) at a time [s]."""
        self._last_time = time
        if self._outputs.add(time, values) or clocks.monotonic() >= self._due:
            self.flush()

    def append_step(self, time, values):
        """Record an accepted step that ends at a time [s]: one number for each column of the solver history."""
        if self._steps.add(time, values) or clocks.monotonic() >= self._due:
            self.flush()

    def extend(self, table, rows):
        """Append rows (n, width), the time first, as ``Results.rows`` gives them, to "output" or "solver"."""
        if not len(rows):
            return
        {"output": self._outputs, "solver": self._steps}[table].extend(rows)
        if table == "output":
            self._last_time = float(rows[-1, 0])
        self._unsafe += rows.size
        if self._unsafe >= UNSAFE or clocks.monotonic() >= self._due:
            self.flush()

    def append_event(self, time, element, name, before="", after="", impulse=0.0, unit="", lost=0.0):
        """Record an event: when [s], to which element, joint or load, which, and the modes before and after.

        Of a shock also its impulse, with the unit of that, and the energy lost [J].
        """
        self._events.add(time, (element, name, before, after, unit), (impulse, lost))

    def flush(self):
        """Bring all that was appended into the file, and return the number of acknowledged saved times.

        Raises
        ------
        ResultsError
            The disk does not take it; what was acknowledged before stays readable, and the file is closed.
        """
        if self._file is None:
            raise ResultsError(f"{self.path} is closed")
        with undisturbed():
            for table in (self._outputs, self._steps, self._events):
                table.write()
            self._file.flush()
            self._disk.keep_loss(self.path)
            if self._disk.error is None:
                self._acknowledge()
        if self._disk.error is not None:
            self._give_up()
        self._due, self._unsafe = clocks.monotonic() + self._interval, 0
        return self.acknowledged

    @property
    def closing_time(self):
        """How long it may take to close the file [s]: all of it is brought to the disk."""
        return _CLOSING * self._disk.size

    def checkpoint(self, state):
        """Acknowledge what was appended, and keep with it the ``state`` (results/state.py) to resume from.

        Raises
        ------
        ResultsError
            The disk does not take it; the checkpoint before stays, and the file is closed.
        """
        self.flush()
        with undisturbed():
            self._slots.write({"run": state, "file": self._position()})
        if self._disk.error is not None:
            self._give_up()

    def _position(self):
        """How far the file is, with the sums of what is in it: ``resume_at`` takes it."""
        tables, extremes = (self._outputs, self._steps, self._events), vars(self.extremes)
        return {
            "rows": np.array([table.written for table in tables]),
            "sums": np.array([table.sum for table in tables]),
            "clock": np.array(self._clock()),
            "compile_time": np.array(self._compiled + compile_time()),
            "extremes": {name: values.copy() for name, values in extremes.items()},
        }

    def resume_at(self, checkpoint):
        """Let the file, to which all rows up to a checkpoint have been appended, be where the checkpoint is.

        Raises
        ------
        ResultsError
            The rows are not those that were there then, or the disk is full.
        """
        position = checkpoint["file"]
        self.flush()
        now = self._position()
        if not all(np.array_equal(now[key], position[key]) for key in ("rows", "sums")):
            raise ResultsError(f"what {self.path} holds before its checkpoint has changed since it was written")
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
        """Write to the row that the counters do not name, so that a kill leaves those that belong to the counters."""
        now = self.extremes
        high, low = (np.where(np.isnan(t), np.nan, x) for x, t in ((now.high, now.high_time), (now.low, now.low_time)))
        for name, row in zip(EXTREMES, (high, now.high_time, low, now.low_time), strict=True):
            self._disk.patch(self._offsets[f"extremes/{name}"] + row.nbytes * self._slot, row)

    def _text(self, name, text):
        """The place in the file of a text, and its bytes there."""
        length = TEXT_LENGTHS[name]
        cut = text.encode()[:length].decode(errors="ignore").encode()
        return self._offsets[f"run/{name}"], cut.ljust(length, b"\0")

    def _give_up(self):
        cause = self._disk.error
        safe = f"{self.acknowledged} saved times"
        safe += f" up to t = {self._safe_time:.6g} s" if self.acknowledged else ""
        kept = "" if isinstance(cause, FileNotFoundError) else f"; {safe} are in it"
        self._end("failed")
        raise ResultsError(f"cannot write {self.path}: {cause.strerror}{kept}") from cause

    def close(self, status="complete", reason=""):
        """Flush and close; later calls do nothing.

        Parameters
        ----------
        status : "complete", "stopped" or "failed"
        reason : str
            Why the run ended; of a long text, the first 8000 bytes are kept.

        Raises
        ------
        ResultsError
            The last data did not get to the disk.
        """
        if status not in STATUSES[1:]:
            raise ValueError(f"'{status}' is not a status a run can end with")
        if self._file is None:
            return
        self.flush()
        self._acknowledge()  # again, so that both rows of the extremes hold
        self._end(status, reason)
        if self._disk.error is not None:
            raise ResultsError(f"cannot write {self.path}: {self._disk.error.strerror}") from self._disk.error

    def _end(self, status, reason=""):
        """Close, say how it ended, and put the sums of a closed file behind."""
        with undisturbed():
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
        with undisturbed():  # by a signal that comes again, as that of a limit of processor time does every second
            if error is None:
                self.close()
            elif self._file is not None:
                stopped = isinstance(error, KeyboardInterrupt)
                reason = str(error) or ("interrupted" if stopped else kind.__name__)
                self.close("stopped" if stopped else "failed", reason)


def refuse_existing(path, force):
    """Raise ResultsError when ``path`` exists and may not be replaced: never anything but an HDF5 file."""
    refuse_folder(path)
    if not exists(path):
        return
    if not force:
        raise ResultsError(_EXISTS.format(path))
    try:
        with open(path, "rb") as file:
            begins = file.read(len(SIGNATURE))
    except OSError as error:
        raise ResultsError(f"cannot read {path}, which would be replaced: {error.strerror}") from error
    if begins != SIGNATURE:
        raise ResultsError(f"{path} exists already and is no results file; give another name")


def _opened(disk, layout):
    """The file with room in memory for the chunks of a block, so that an incomplete one is never read back."""
    rows, width = chunk_shape(1 + layout.size)
    chunks = -(-(1 + layout.size) // width)
    return open_file(disk, max(3 * 8 * rows * width * chunks, 2**20), max(4 * chunks + 1, 521))


def _clear(path):
    """Remove what killed runs have left of the file before it had its name."""
    for hidden in path.parent.glob(f"{glob.escape(hidden_name(path))}.*.part"):
        process = hidden.name.split(".")[-2]
        if process.isdigit() and not lives(int(process)):
            hidden.unlink(missing_ok=True)


def _move(hidden, path, force):
    if force:
        os.replace(hidden, path)
        return
    try:
        os.link(hidden, path)
    except FileExistsError:
        raise ResultsError(_EXISTS.format(path)) from None
    except OSError:  # a file system without hard links
        os.rename(hidden, path)
        return
    os.unlink(hidden)
