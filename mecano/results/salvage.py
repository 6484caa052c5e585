"""Reading a file that was cut short, by an interrupted copy for example: HDF5 itself refuses it.

HDF5 is shown the file at its full length, with zeros where it ends. Only rows whose chunks lie within what is there
count.
"""

import os
import struct

import h5py

_SIZES = struct.Struct("<8s20xQ")  # signature and end of file of a superblock of version 2


def missing_bytes(path):
    """How many bytes are gone at the end of an HDF5 file; 0 also for what is no such file."""
    with open(path, "rb") as file:
        head = file.read(_SIZES.size)
    if len(head) < _SIZES.size or head[8] != 2:
        return 0
    signature, end = _SIZES.unpack(head)
    return max(end - os.path.getsize(path), 0) if signature == b"\x89HDF\r\n\x1a\n" else 0


class Lengthened:
    """A read-only file-like object for h5py: a file and zeros after its end."""

    def __init__(self, path, missing):
        self._path = path
        self._size = os.path.getsize(path) + missing
        self._position = 0

    def seek(self, offset, whence=os.SEEK_SET):
        """Move, and return the new position."""
        self._position = offset + (0, self._position, self._size)[whence]
        return self._position

    def tell(self):
        """Return the position."""
        return self._position

    def read(self, size):
        """Read bytes."""
        with open(self._path, "rb") as file:
            file.seek(self._position)
            data = file.read(size).ljust(size, b"\0")
        self._position += size
        return data

    def readinto(self, buffer):
        """Fill a buffer."""
        view = memoryview(buffer).cast("B")
        view[:] = self.read(len(view))
        return len(view)


def rows_within(dataset, rows, size):
    """Of the first ``rows`` rows of a chunked dataset, how many lie in the first ``size`` bytes of the file."""
    height = dataset.chunks[0]
    for start in range(0, rows, height):
        if not _chunks_within(dataset, start, size):
            return start
    return rows


def _chunks_within(dataset, row, size):
    starts = [(row,)] if dataset.ndim == 1 else [(row, c) for c in range(0, dataset.shape[1], dataset.chunks[1])]
    try:
        chunks = [dataset.id.get_chunk_info_by_coord(start) for start in starts]
    except (OSError, RuntimeError, ValueError):
        return False
    return all(c.byte_offset is not None and c.byte_offset + c.size <= size for c in chunks)


def open_cut(path, missing):
    """Open what is left of a file; OSError when not even its root is there."""
    return h5py.File(Lengthened(path, missing), "r")
