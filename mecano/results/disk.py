"""The file on disk as HDF5 sees it, arranged so that a kill at any instant leaves a readable file.

HDF5 writes through this object instead of by itself, for four reasons:

* HDF5 notes the new end of the file in the superblock before it makes the file that long; a kill in between
  leaves a file that nothing opens. Here the file grows first.
* After a failed write (disk full) HDF5 can neither go on nor close, and crashes at the exit of the process.
  Here the first failure is kept in ``error``, nothing more reaches the disk, and HDF5 sees a disk that works.
* Some numbers (counters, status) must change after all else is written, in one go, and without new space:
  ``patch`` writes them straight to their place.
* A signal handler that raises must not do so inside HDF5: ``undisturbed`` defers it.

So the file is at every instant a beginning of the sequence of writes. With the extensible-array index of chunks, which
only ever grows at its end, and with metadata kept within pages of the operating system, each such beginning is a valid
file (tests/test_results_crash.py tries them all).
"""

import os
import signal
import struct
import threading
from contextlib import contextmanager

import h5py

from mecano.interrupt import SIGNALS
from mecano.results.seal import seal

PAGE = 4096
SIGNATURE = b"\x89HDF\r\n\x1a\n"
_END_OF_FILE = slice(28, 36)  # in a superblock of version 2


class Disk:
    """A file-like object for h5py over a new file.

    Attributes
    ----------
    error : OSError or None
        The first failure to write; after it nothing but patches is tried.
    size : int
        Bytes that it holds, or would after a failure.
    """

    def __init__(self, path):
        self.error = None
        self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_TRUNC, 0o666)
        self._position = 0
        self.size = 0
        self._withheld = []  # (offset, bytes) of the writes after the failure, which HDF5 may read again

    def seek(self, offset, whence=os.SEEK_SET):
        """Move, and return the new position."""
        self._position = offset + (0, self._position, self.size)[whence]
        return self._position

    def tell(self):
        """Return the position."""
        return self._position

    def read(self, size):
        """Read bytes."""
        buffer = bytearray(size)
        return bytes(buffer[: self.readinto(buffer)])

    def readinto(self, buffer):
        """Read into a buffer as much as there is."""
        view = memoryview(buffer).cast("B")
        start, count = self._position, min(len(view), max(self.size - self._position, 0))
        os.preadv(self._descriptor, [view[:count]], start)
        for offset, data in self._withheld:
            first, last = max(offset, start), min(offset + len(data), start + count)
            if first < last:
                view[first - start : last - start] = data[first - offset : last - offset]
        self._position += count
        return count

    def write(self, data):
        """Write bytes, making room first when they announce a longer file."""
        data = memoryview(data).cast("B")
        if self._position == 0 and data[:8] == SIGNATURE:
            end = struct.unpack("<Q", data[_END_OF_FILE])[0]
            if end > self.size:
                self.truncate(end)
        if self.error is None:
            self.error = self._put(self._position, data)
        if self.error is not None:
            self._withheld.append((self._position, bytes(data)))
        self._position += len(data)
        self.size = max(self.size, self._position)
        return len(data)

    def truncate(self, size=None):
        """Make the file as long as told."""
        self.size = self._position if size is None else size
        if self.error is None:
            try:
                os.ftruncate(self._descriptor, self.size)
            except OSError as error:
                self.error = error
        return self.size

    def flush(self):
        """Nothing is buffered here."""

    def patch(self, offset, data):
        """Overwrite bytes that are in the file already; after a failure too, as this needs no new space."""
        error = self._put(offset, memoryview(data).cast("B"))
        self.error = self.error or error

    def _put(self, offset, data):
        try:
            while len(data):
                written = os.pwrite(self._descriptor, data, offset)
                offset, data = offset + written, data[written:]
        except OSError as error:
            return error
        return None

    def seal(self, offset, data):
        """Put the sums that show changed bytes behind the file, those it will have when ``data`` are patched there.

        Of a failure, kept in ``error``, nothing is left.
        """
        size = os.fstat(self._descriptor).st_size
        try:
            self.patch(size, seal(self._descriptor, size, offset, data))
            if self.error is not None:
                os.ftruncate(self._descriptor, size)
        except OSError as error:
            self.error = self.error or error

    def close(self):
        """Wait until the bytes are on the disk, and close; a late failure is kept in ``error``."""
        for action in (os.fsync, os.close):
            try:
                action(self._descriptor)
            except OSError as error:
                self.error = self.error or error
        self._descriptor = -1  # the system may give the old number to another file


def new_file(stream):
    """Create an empty HDF5 file: a superblock that readers accept while it is open, newer formats for the rest."""
    h5py.File(stream, "w", libver=("earliest", "v110"), fs_strategy="page", fs_page_size=PAGE).close()
    return open_file(stream)


def open_file(stream, cache_bytes=2**20, cache_slots=521):
    """Open such a file to write on; the chunk cache of each dataset has so many bytes and places."""
    return h5py.File(stream, "r+", libver=("v110", "v110"), rdcc_nbytes=cache_bytes, rdcc_nslots=cache_slots)


@contextmanager
def undisturbed():
    """Put off the Python handlers of signals to the end of the block."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    pending = []
    usual = {number: signal.getsignal(number) for number in SIGNALS}
    usual = {number: handler for number, handler in usual.items() if callable(handler)}
    for number in usual:
        signal.signal(number, lambda *arguments: pending.append(arguments))
    try:
        yield
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
        for number, frame in pending:
            usual[number](number, frame)
