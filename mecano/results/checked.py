"""Reading of HDF5 files with checksums: a byte changed since it was written never reaches HDF5, which might crash."""

import os
import signal
import struct
import time
from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager, suppress

import h5py
import numpy as np

from mecano.errors import MecanoError, ResultsError
from mecano.results.checksums import BLOCK, seal_of
from mecano.results.global_heap import endless_heaps
from mecano.results.live_checksums import last_table
from mecano.results.seekable import Buffer, Seekable
from mecano.results.whole_file import other_than_file

AT_ONCE = 256  # blocks
PAGE = 4096
UNREADABLE = (
    OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, IndexError, OverflowError, struct.error,
)  # fmt: skip
"""Exceptions raised for damaged files by h5py and by the interpretation of its data."""
PATIENCE = 5.0  # s of processor time in which HDF5 must read the metadata of a file without checksums
SHORT = 2**20  # bytes
_ATTEMPTS = 8
_ends: dict[tuple[int, ...], int] = {}
"""Version of a file without checksums -> exit code of trial reading, or minus the signal"""
_HEAD = struct.Struct("<8sB19xQ")  # signature, version and end of the file of a superblock of version 2
SIGNATURE = b"\x89HDF\r\n\x1a\n"


class Checked(Seekable):
    """A read-only file-like object for h5py that checks every byte by the checksums in the file.

    Reading a changed block raises OSError, and so does reading beyond the end of a truncated file.

    Attributes
    ----------
    path : str or Path
    sums : Seal, LastTable or None
        Checksums; None if the file has none and is read unchecked.
    size, missing : int
        Numbers of bytes present, and missing at the end of the HDF5 file. In files without checksums, pages of zeros
        at the end count as missing, as crashes of machines leave them.
    damaged : set of int
        Numbers of the changed blocks found so far.
    """

    def __init__(self, path: str | os.PathLike[str]):
        self.path = path
        self.damaged: set[int] = set()
        flags = getattr(os, "O_BINARY", 0) | getattr(os, "O_NONBLOCK", 0)  # the latter: do not wait for a pipe
        self._descriptor = os.open(path, os.O_RDONLY | flags)
        try:
            self.refresh()
            self.size = os.fstat(self._descriptor).st_size
            if self.sums is None:
                self.size = _content(self._descriptor, self.size)
            self.missing = _missing(self._descriptor, self.size) if self.sums is None else 0
            self._endless = endless_heaps(self._descriptor, self.size) if self.sums is None else ()
        except BaseException:
            self.close()
            raise

    def refresh(self) -> None:
        """Locate the checksums, which move as a file grows."""
        self.sums = seal_of(self._descriptor) or last_table(self._descriptor)

    def close(self) -> None:
        """Close the file."""
        os.close(self._descriptor)

    @property
    def end(self) -> int:
        """Size of the whole file in bytes, missing ones included."""
        return self.size + self.missing

    def readinto(self, buffer: Buffer) -> int:
        """Fill a buffer. Raises OSError for changed or missing bytes."""
        view = memoryview(buffer).cast("B")
        start, stop = self._position, self._position + len(view)
        data = self._checked(start, stop)
        if len(data) < len(view) or (self.missing and stop > self.size):
            raise OSError(f"{self.path} is cut short by {self.missing} bytes")
        for place in self._endless:
            if start <= place < stop:
                raise OSError(f"{self.path} is damaged: the texts from byte {place} on cannot be read")
        view[:] = data
        self._position = stop
        return len(view)

    @property
    def block(self) -> int:
        """Size of a block in bytes."""
        return self.sums.block if self.sums is not None else BLOCK

    def _checked(self, start, stop):
        """Return the bytes from ``start`` to ``stop``, or fewer at the end. Raises OSError if a block has changed."""
        for attempt in range(_ATTEMPTS):
            first = start // self.block
            data, changed = self._compared(first, -(-stop // self.block))
            if not len(changed):
                return data[start - self.block * first :][: stop - start]
            time.sleep(0.003 * attempt)  # the writer may be changing them now
            self.refresh()
        self.damaged.update(map(int, changed))
        raise OSError(f"{self.path} is damaged: bytes have changed {self.place(self.damaged)}")

    def _compared(self, first, last):
        """Return the bytes of blocks ``first`` to ``last``, fewer at the end, and the numbers of changed ones."""
        data = os.pread(self._descriptor, self.block * (last - first), self.block * first)
        if self.sums is None:
            return data, ()
        count = max(min(self.sums.covered - self.block * first, len(data)), 0)
        return data, self.sums.changed(memoryview(data)[:count], first)

    def changed(self) -> np.ndarray:
        """Return the numbers (n,) of all changed blocks in the file."""
        assert self.sums is not None, "a file without checksums is read unchecked"
        last = -(-min(self.sums.covered, self.size) // self.block)
        found = []
        for first in range(0, last, AT_ONCE):
            for attempt in range(_ATTEMPTS):
                _, changed = self._compared(first, min(first + AT_ONCE, last))
                if not len(changed):
                    break
                time.sleep(0.003 * attempt)
                self.refresh()
            found += list(changed)
        return np.array(found, int)

    def place(self, blocks: Collection[int]) -> str:
        """Return a description of the place of ``blocks`` in the file."""
        first, count = self.block * min(blocks), len(blocks)
        more = f", and {count - 1} more blocks" if count > 1 else ""
        return f"between byte {first} and {first + self.block - 1}{more}"


def _content(descriptor, size):
    """Return the size of an open file in bytes, without the pages of zeros at its end."""
    for first in range((size - 1) // PAGE * PAGE, -1, -PAGE):
        if os.pread(descriptor, PAGE, first).strip(b"\0"):
            return min(first + PAGE, size)
    return 0


def _missing(descriptor, size):
    """Return the number of bytes missing at the end of an HDF5 file; 0 for other files."""
    head = os.pread(descriptor, _HEAD.size, 0)
    if len(head) < _HEAD.size:
        return 0
    signature, version, end = _HEAD.unpack(head)
    return max(end - size, 0) if signature == SIGNATURE and version == 2 else 0


def cut_short(paths: Iterable[str | os.PathLike[str]]) -> Iterator[str]:
    """Yield a warning for each truncated file, of which only the remaining data are shown."""
    for path in paths:
        with suppress(OSError, ValueError):
            source = Checked(path)
            source.close()
            if source.missing:
                yield f"{path} is cut short by {source.missing} bytes: only the remaining data are shown"


@contextmanager
def blaming(*paths: str | os.PathLike[str]) -> Iterator[None]:
    """Attribute unexpected exceptions in this block to damage of files without checksums.

    If one of the files has no checksums, raises ResultsError instead of any exception other than a MecanoError.
    """
    try:
        yield
    except MecanoError:
        raise
    except Exception as error:
        for path in paths:
            with suppress(OSError):
                source = Checked(path)
                source.close()
                if source.sums is None:
                    raise ResultsError(unreadable(source, error)) from error
        raise


@contextmanager
def open_checked(path: str | os.PathLike[str]) -> Iterator[h5py.File]:
    """Open the HDF5 file ``path`` for reading within a block.

    Raises ResultsError, which names the damage, if the file or anything read in the block is unreadable.
    """
    source = checked(path)
    try:
        with h5py.File(source, "r") as file:
            yield file
    except UNREADABLE as error:
        raise ResultsError(unreadable(source, error)) from error
    finally:
        source.close()


def format_of(path: str | os.PathLike[str]) -> str:
    """Return the attribute ``format`` of a file of mecano, or "" if it cannot be read."""
    try:
        with open_checked(path) as file:
            found = file.attrs.get("format", "")
            return found if isinstance(found, str) else ""
    except ResultsError:
        return ""


def checked(path: str | os.PathLike[str]) -> Checked:
    """Return a Checked of an HDF5 file. Raises ResultsError if it is unreadable or not an HDF5 file."""
    try:
        if os.path.exists(path) and (other := other_than_file(path)):
            table = os.path.join(path, "table.h5")
            hint = f"; the table of its study is {table}" if os.path.exists(table) else ""
            raise ResultsError(f"cannot read {path}: it is {other}{hint}")
        source = Checked(path)
    except (OSError, ValueError) as error:
        raise ResultsError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from error
    try:
        if source.size < len(SIGNATURE) or source.read(len(SIGNATURE)) != SIGNATURE:
            hint = f"; if it is a deck: mecano run {path}" if str(path).endswith((".yaml", ".yml")) else ""
            raise ResultsError(f"{path} is not a results file of mecano: not an HDF5 file{hint}")
        if source.sums is None:
            _refuse_crashing(path)
    except (OSError, ResultsError) as error:
        source.close()
        raise error if isinstance(error, ResultsError) else ResultsError(unreadable(source, error)) from error
    return source


def _refuse_crashing(path):
    """Raise ResultsError for a file without checksums that crashes HDF5, as found by a child process that reads it."""
    at = os.stat(path)
    version = at.st_dev, at.st_ino, at.st_size, at.st_mtime_ns
    if not hasattr(os, "fork"):
        return
    if version not in _ends:
        child = os.fork()
        if not child:
            _read_all(path)
        _ends[version] = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if _ends[version] < 0:
        how = signal.Signals(-_ends[version])
        raise ResultsError(
            f"{path} is damaged: the checksums at its end are missing, and reading it "
            + ("does not end" if how == signal.SIGPROF else f"ends by {how.name}")
        )


def _read_all(path):
    """Read the metadata and the short datasets of a file, and end this process."""
    try:
        _read_quietly(path)
    finally:
        os._exit(0)


def _read_quietly(path):
    for number in (signal.SIGPROF, signal.SIGINT, signal.SIGTERM, signal.SIGSEGV, signal.SIGABRT):
        signal.signal(number, signal.SIG_DFL)
    quiet = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(quiet, stream)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    with suppress(Exception), h5py.File(Checked(path), "r") as file:
        file.visititems(_read_item)
        _read_item("", file)


def _read_item(_, item):
    with suppress(Exception):
        dict(item.attrs)
    with suppress(Exception):
        if isinstance(item, h5py.Dataset) and item.size * item.dtype.itemsize < SHORT:
            item[()]


def unreadable(source: Checked, error: BaseException, what: str = "") -> str:
    """Return the message for an ``error`` in reading ``what``, or anything, from the file of a Checked."""
    name = f"'{what}' in {source.path}" if what else source.path
    if source.damaged:
        return (
            f"{name} cannot be read: bytes have changed {source.place(source.damaged)}; "
            f"`mecano verify {source.path}` names the data affected"
        )
    if source.missing:
        return f"{name} cannot be read: the file is cut short by {source.missing} bytes ({error})"
    text = str(error.args[0]) if isinstance(error, KeyError) and error.args else str(error)
    text = f"there is no '{text}'" if isinstance(error, KeyError) and text.isidentifier() else text
    lost = "; the checksums at its end are missing or have changed" if source.sums is None else ""
    return f"{name} cannot be read: {text}{lost}"
