"""The file on disk as HDF5 sees it, arranged so that a kill at any instant leaves a readable file.

HDF5 writes through this object instead of by itself, for five reasons:

* Every byte has a check sum, whenever the process is killed (live_checksums.py).
* HDF5 notes the new end of the file in the superblock before it makes the file that long; a kill in between
  leaves a file that nothing opens. Here the file, with the table of sums at its end, grows first.
* After a failed write (disk full) HDF5 can neither go on nor close, and crashes at the exit of the process.
  Here the first failure is kept in ``error``, nothing more reaches the disk, and HDF5 sees a disk that works.
* Some numbers (counters, status) must change after all else is written, in one go, and without new space:
  ``patch`` writes them straight to their place.
* A signal handler that raises must not do so inside HDF5: ``undisturbed`` defers it.

So the file is at every instant a beginning of the sequence of writes. With the extensible-array index of chunks, which
only ever grows at its end, and with metadata kept within pages of the operating system, each such beginning is a valid
file (tests/test_results_crash.py tries them all).
"""

import errno
import os
import shutil
import signal
import struct
import threading
from contextlib import contextmanager, suppress
from pathlib import Path

import h5py

from mecano.process.interrupt import SIGNALS
from mecano.results.checksums import BLOCK, seal, seal_of
from mecano.results.live_checksums import LiveChecksums, put
from mecano.results.seekable import Seekable
from mecano.results.whole_file import appearing

PAGE = 4096
SIGNATURE = b"\x89HDF\r\n\x1a\n"
_END_OF_FILE = slice(28, 36)  # in a superblock of version 2


class Disk(Seekable):
    """A file-like object for h5py over a file that is being written; its bytes have check sums at every instant.

    Parameters
    ----------
    path : str or Path
        Of a new file; or, with ``begun``, of one that is there and that nobody else reads or writes.
    begun : bool
        Go on with the bytes that are there.

    Attributes
    ----------
    error : OSError or None
        The first failure to write; after it nothing but patches is tried.
    size : int
        Bytes that it holds, or would after a failure, without the sums.
    """

    def __init__(self, path, begun=False):
        self.error = None
        self._descriptor = os.open(path, os.O_RDWR | (0 if begun else os.O_CREAT | os.O_TRUNC), 0o666)
        self._sums = LiveChecksums(self._descriptor)
        self.size = _unsealed_size(self._descriptor) if begun else 0
        self._withheld = []  # (offset, bytes) of the writes after the failure, which HDF5 may read again

    @property
    def end(self):
        """Bytes of the file, without the sums."""
        return self.size

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
            self._fail(self._put, self._position, data)
        if self.error is not None:
            self._withheld.append((self._position, bytes(data)))
        self._position += len(data)
        self.size = max(self.size, self._position)
        return len(data)

    def truncate(self, size=None):
        """Set the length of the file; the bytes behind it are those of the sums."""
        self.size = self._position if size is None else size
        if self.error is None:
            self._fail(self._sums.cover, self.size)
        return self.size

    def flush(self):
        """Nothing is buffered here."""

    def patch(self, offset, data):
        """Overwrite bytes that are in the file already; after a failure too, as this needs no new space."""
        self._fail(self._put, offset, memoryview(data).cast("B"))

    def keep_loss(self, path):
        """Keep it as the first failure when the file was removed from its ``path`` and no other one stands there."""
        if self.error is None and os.fstat(self._descriptor).st_nlink == 0 and not os.path.lexists(path):
            self.error = FileNotFoundError(errno.ENOENT, "it was removed while it was written")

    def _put(self, offset, data):
        if not len(data):
            return
        self._sums.cover(offset + len(data))
        self._sums.announce(offset, data)
        put(self._descriptor, offset, data)

    def _fail(self, action, *arguments):
        """Do something; the first failure is kept."""
        try:
            action(*arguments)
        except OSError as error:
            self.error = self.error or error
            self._sums.doubt()

    def seal(self):
        """Put the sums of a file that will not change any more right behind it, in place of those of a changing one.

        Where there is no room for that, the latter stay, which show changed bytes as well.
        """
        covered = -(-self.size // BLOCK) * BLOCK
        with suppress(OSError):
            self._sums.cover(covered)
            data = seal(self._sums.sums(covered // BLOCK), covered)
            self._put(covered, data)
            os.ftruncate(self._descriptor, covered + len(data))

    def close(self):
        """Wait until the bytes are on the disk, and close; a late failure is kept in ``error``."""
        for action in (os.fsync, os.close):
            try:
                action(self._descriptor)
            except OSError as error:
                self.error = self.error or error
        self._descriptor = -1  # the system may give the old number to another file


def _unsealed_size(descriptor):
    """Bytes of an open file without the sums behind it, which are removed. Raises OSError."""
    found = seal_of(descriptor)
    size = found.covered if found else os.fstat(descriptor).st_size
    os.ftruncate(descriptor, size)
    return size


@contextmanager
def hdf5_appearing(path, begun=None):
    """Give a new HDF5 file, open for writing, that gets its name and its sums when the block ends.

    It begins as a copy of the file ``begun`` if that is given. Raises ResultsError; nothing is left then.
    """
    with appearing(Path(path)) as hidden:
        if begun is not None:
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
