"""A read-only HDF5 file that checks its bytes as they are read, as changed bytes might crash HDF5."""

import os
import struct
import time
from collections.abc import Collection

import numpy as np

from mecano.results.checksums import BLOCK, seal_of
from mecano.results.global_heap import endless_heaps
from mecano.results.live_checksums import last_table
from mecano.results.seekable import Buffer, Seekable

AT_ONCE = 256  # blocks
PAGE = 4096
SIGNATURE = b"\x89HDF\r\n\x1a\n"
_ATTEMPTS = 8
_HEAD = struct.Struct("<8sB19xQ")  # signature, version and end of the file of a superblock of version 2


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

    def _checked(self, start, stop):
        """Return the bytes from ``start`` to ``stop``, or fewer at the end. Raises OSError if a block has changed."""
        for attempt in range(_ATTEMPTS):
            first = start // BLOCK
            data, changed = self._compared(first, -(-stop // BLOCK))
            if not len(changed):
                return data[start - BLOCK * first :][: stop - start]
            time.sleep(0.003 * attempt)  # the writer may be changing them now
            self.refresh()
        self.damaged.update(map(int, changed))
        raise OSError(f"{self.path} is damaged: bytes have changed {self.place(self.damaged)}")

    def _compared(self, first, last):
        """Return the bytes of blocks ``first`` to ``last``, fewer at the end, and the numbers of changed ones."""
        data = os.pread(self._descriptor, BLOCK * (last - first), BLOCK * first)
        if self.sums is None:
            return data, ()
        count = max(min(self.sums.covered - BLOCK * first, len(data)), 0)
        return data, self.sums.changed(memoryview(data)[:count], first)

    def changed(self) -> np.ndarray:
        """Return the numbers (n,) of all changed blocks in the file."""
        assert self.sums is not None, "a file without checksums is read unchecked"
        last = -(-min(self.sums.covered, self.size) // BLOCK)
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
        first, count = BLOCK * min(blocks), len(blocks)
        more = f", and {count - 1} more blocks" if count > 1 else ""
        return f"between byte {first} and {first + BLOCK - 1}{more}"


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
