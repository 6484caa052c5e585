"""Checksums of a closed file: a CRC-32 of every 4096 bytes, appended after the end of the HDF5 data.

HDF5 ignores them. They end with a mark, the number of bytes covered, and the CRC-32 of all the sums.
"""

import os
import struct
import zlib

import numpy as np

BLOCK = 4096  # the page of operating systems
END = struct.Struct("<16sQI")
MARK = b"mecano seal 2\0\0\0"


class Seal:
    """The sums at the end of a closed file, for readers.

    Attributes
    ----------
    covered : int
        Number of bytes covered.
    sums : (n,) array of uint32
        CRC-32 of each block.
    whole : bool
        Whether the sums themselves are unchanged.
    """

    def __init__(self, covered: int, sums: np.ndarray, whole: bool):
        self.covered, self.sums, self.whole = covered, sums, whole

    def changed(self, data: bytes | memoryview, first: int) -> np.ndarray:
        """Return the numbers (n,) of changed blocks in ``data``, which begin with block ``first``."""
        found = block_sums(data)
        return first + np.flatnonzero(found != self.sums[first : first + len(found)])


def block_sums(data: bytes | memoryview) -> np.ndarray:
    """Return the CRC-32 (n,) uint32 of each block of bytes; the last one may be shorter."""
    return np.array(crcs(data), "<u4")


def crcs(data: bytes | memoryview) -> list[int]:
    """Return the CRC-32 of each block of bytes as a list."""
    view = memoryview(data)
    return [zlib.crc32(view[i : i + BLOCK]) for i in range(0, len(view), BLOCK)]


def seal(sums: np.ndarray, covered: int) -> bytes:
    """Return the bytes to append to a file of ``covered`` bytes whose blocks have the ``sums`` (n,) uint32."""
    data = sums.tobytes()
    return data + END.pack(MARK, covered, _sum_of(covered, data))


def seal_of(descriptor: int) -> Seal | None:
    """Return the Seal of an open file, or None if it has none or its last bytes are missing. Raises OSError."""
    size = os.fstat(descriptor).st_size
    end = os.pread(descriptor, END.size, max(size - END.size, 0))
    if len(end) < END.size:
        return None
    mark, covered, total = END.unpack(end)
    if mark != MARK:
        return None
    length = 4 * -(-covered // BLOCK)
    if covered + length + END.size != size:
        return Seal(0, np.zeros(0, "<u4"), False)
    sums = os.pread(descriptor, length, covered)
    return Seal(covered, np.frombuffer(sums, "<u4"), total == _sum_of(covered, sums))


def _sum_of(size, sums):
    return zlib.crc32(sums, zlib.crc32(struct.pack("<Q", size)))
