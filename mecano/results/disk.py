"""File object through which HDF5 writes, so that a kill at any instant leaves a readable file.

HDF5 writes through a Disk instead of directly, for five reasons:

* Every byte has a checksum whenever the process is killed (live_checksums.py).
* HDF5 writes the new end of the file to the superblock before it extends the file; a kill in between leaves a file
  that cannot be opened. Here the file, with the table of checksums at its end, is extended first.
* After a failed write (disk full) HDF5 can neither continue nor close, and crashes at the exit of the process. Here
  the first failure is kept in ``error``, later data are not written, and HDF5 sees no failure.
* Some numbers (counters, status) must be written after all other data, at once, and without allocation: ``patch``
  overwrites them in place.
* A signal handler must not raise inside HDF5: ``deferring_signals`` defers it.

So the file at any instant results from the first n of the sequence of writes. With the extensible-array index of
chunks, which only grows at its end, and with metadata aligned to pages of the operating system, it is valid for every n
(tests/test_results_crash.py tests all n).
"""

import errno
import os
import signal
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path

import h5py

from mecano.process.interrupt import SIGNALS
from mecano.results.checksums import BLOCK, seal, seal_of
from mecano.results.live_checksums import LiveChecksums, put
from mecano.results.seekable import Buffer, Seekable
from mecano.results.whole_file import atomic_file

PAGE = 4096
SIGNATURE = b"\x89HDF\r\n\x1a\n"
_END_OF_FILE = slice(28, 36)  # in a superblock of version 2


class Disk(Seekable):
    """A file-like object for h5py to write a file whose bytes have checksums at every instant.

    Parameters
    ----------
    path : str or Path
        New file or, with ``begun``, an existing one that no other process reads or writes.
    begun : bool
        Keep the existing bytes.

    Attributes
    ----------
    error : OSError or None
        The first failure to write; after it only patches are attempted.
    size : int
        Size in bytes as HDF5 sees it, also after a failure, without the checksums.
    """

    def __init__(self, path: str | os.PathLike[str], begun: bool = False):
        self.error: OSError | None = None
        self._descriptor = os.open(path, os.O_RDWR | (0 if begun else os.O_CREAT | os.O_TRUNC), 0o666)
        self._sums = LiveChecksums(self._descriptor)
        self.size = _unsealed_size(self._descriptor) if begun else 0
        self._withheld: list[tuple[int, bytes]] = []
        """Offset and bytes of the writes after a failure, which HDF5 may read again"""

    @property
    def end(self) -> int:
        """Size of the file in bytes, without the checksums."""
        return self.size

    def readinto(self, buffer: Buffer) -> int:
        """Fill a buffer as far as there are data, and return the number of bytes."""
        view = memoryview(buffer).cast("B")
        start, count = self._position, min(len(view), max(self.size - self._position, 0))
        os.preadv(self._descriptor, [view[:count]], start)
        for offset, data in self._withheld:
            first, last = max(offset, start), min(offset + len(data), start + count)
            if first < last:
                view[first - start : last - start] = data[first - offset : last - offset]
        self._position += count
        return count

    def write(self, data: Buffer) -> int:
        """Write bytes; a superblock that states a longer file extends the file first."""
        data = memoryview(data).cast("B")
        if self._position == 0 and data[:8] == SIGNATURE:
            end = struct.unpack("<Q", data[_END_OF_FILE])[0]
            if end > self.size:
                self.truncate(end)
        if self.error is None:
            self._fail(self._put, self._position, data)
        if self.error is not None:
            self._withheld.append((self._position, bytes(data)))
        self._position += len(data)
        self.size = max(self.size, self._position)
        return len(data)

    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file, beyond which the checksums lie."""
        self.size = self._position if size is None else size
        if self.error is None:
            self._fail(self._sums.cover, self.size)
        return self.size

    def flush(self) -> None:
        """Do nothing, as no data are buffered."""

    def patch(self, offset: int, data: Buffer) -> None:
        """Overwrite existing bytes in place, also after a failure, as no space is needed."""
        self._fail(self._put, offset, memoryview(data).cast("B"))

    def keep_loss(self, path: str | os.PathLike[str]) -> None:
        """Set ``error`` if the file was removed from its ``path``, or replaced by another one."""
        if self.error is None and os.fstat(self._descriptor).st_nlink == 0:
            what = "replaced" if os.path.lexists(path) else "removed"
            self.error = FileNotFoundError(errno.ENOENT, f"it was {what} while it was written")

    def _put(self, offset, data):
        if not len(data):
            return
        self._sums.cover(offset + len(data))
        self._sums.announce(offset, data)
        put(self._descriptor, offset, data)

    def _fail(self, action, *arguments):
        """Call ``action``, and keep its OSError if it is the first failure."""
        try:
            action(*arguments)
        except OSError as error:
            self.error = self.error or error
            self._sums.recompute()

    def seal(self) -> None:
        """Replace the checksums of a growing file by the shorter ones of a closed file, right after its data.

        If there is no space for them, the former remain, which also detect changed bytes.
        """
        covered = -(-self.size // BLOCK) * BLOCK
        with suppress(OSError):
            self._sums.cover(covered)
            data = seal(self._sums.sums(covered // BLOCK), covered)
            self._put(covered, data)
            os.ftruncate(self._descriptor, covered + len(data))

    def close(self) -> None:
        """Synchronize with the disk, and close; a late failure is kept in ``error``."""
        for action in (os.fsync, os.close):
            try:
                action(self._descriptor)
            except OSError as error:
                self.error = self.error or error
        self._descriptor = -1  # the system may reuse the number for another file


def _unsealed_size(descriptor):
    """Remove the checksums of a closed file, and return its size in bytes without them. Raises OSError."""
    found = seal_of(descriptor)
    size = found.covered if found else os.fstat(descriptor).st_size
    os.ftruncate(descriptor, size)
    return size


@contextmanager
def atomic_hdf5_file(path: str | os.PathLike[str], begun: str | os.PathLike[str] | None = None) -> Iterator[h5py.File]:
    """Open a new HDF5 file for writing, which gets its name and its checksums at the end of the block.

    It starts as a copy of the file ``begun`` if that is given. Raises ResultsError; no file is left then.
    """
    with atomic_file(Path(path)) as hidden:
        if begun is not None:
            import shutil

            shutil.copyfile(begun, hidden)
        disk = Disk(hidden, begun is not None)
        try:
            with open_file(disk) if begun is not None else new_file(disk) as file:
                yield file
            disk.seal()
        finally:
            disk.close()
        if disk.error is not None:
            raise disk.error


def new_file(stream: Seekable | BytesIO) -> h5py.File:
    """Create an empty HDF5 file with a superblock that readers accept during writing, and newer formats otherwise."""
    h5py.File(stream, "w", libver=("earliest", "v110"), fs_strategy="page", fs_page_size=PAGE).close()
    return open_file(stream)


def open_file(stream: Seekable | BytesIO, cache_bytes: int = 2**20, cache_slots: int = 521) -> h5py.File:
    """Open a file of ``new_file`` for writing, with a chunk cache of the given size for each dataset."""
    return h5py.File(stream, "r+", libver=("v110", "v110"), rdcc_nbytes=cache_bytes, rdcc_nslots=cache_slots)


@contextmanager
def deferring_signals() -> Iterator[None]:
    """Defer the Python handlers of signals to the end of the block."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    pending = []
    usual = {number: handler for number in SIGNALS if callable(handler := signal.getsignal(number))}
    for number in usual:
        signal.signal(number, lambda *arguments: pending.append(arguments))
    try:
        yield
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
        for number, frame in pending:
            usual[number](number, frame)
