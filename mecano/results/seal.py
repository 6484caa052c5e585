"""What shows that a byte of a closed file has changed: a CRC-32 of every 1024 bytes, behind the end of the HDF5 file.

HDF5 does not look there. At the very end: a mark, how many bytes are covered, and the CRC-32 of all the sums.
"""

import os
import struct
import zlib

import numpy as np

BLOCK = 1024
END = struct.Struct("<16sQI")
MARK = b"mecano seal 1\0\0\0"


class Seal:
    """The sums at the end of a closed file, for readers.

    Attributes
    ----------
    covered : int
        Bytes that are covered.
    sums : (n,) array of uint32
        Of each block.
    whole : bool
        The sums themselves have not changed.
    """

    def __init__(self, covered, sums, whole):
        self.covered, self.sums, self.whole = covered, sums, whole

    def changed(self, data, first):
        """Return which blocks (n,) of ``data``, whole blocks from number ``first`` on, are not what they were."""
        found = block_sums(data)
        return first + np.flatnonzero(found != self.sums[first : first + len(found)])


def block_sums(data):
    """Return the CRC-32 (n,) uint32 of each block of bytes; the last one may be shorter."""
    view = memoryview(data)
    return np.array([zlib.crc32(view[i : i + BLOCK]) for i in range(0, len(view), BLOCK)], "<u4")


def seal(sums, covered):
    """Return the bytes to be put behind a file of ``covered`` bytes whose blocks have the ``sums`` (n,) uint32."""
    data = sums.tobytes()
    return data + END.pack(MARK, covered, _sum_of(covered, data))


def seal_of(descriptor):
    """The Seal of an open file, or None: it has none, or its last bytes are gone. Raises OSError."""
    size = os.fstat(descriptor).st_size
    end = os.pread(descriptor, END.size, max(size - END.size, 0))
    if len(end) < END.size:
        return None
    mark, covered, total = END.unpack(end)
    length = 4 * -(-covered // BLOCK)
    if mark != MARK:
        return None
    if covered + length + END.size != size:
        return Seal(0, np.zeros(0, "<u4"), False)
    sums = os.pread(descriptor, length, covered)
    return Seal(covered, np.frombuffer(sums, "<u4"), total == _sum_of(covered, sums))


def _sum_of(size, sums):
    return zlib.crc32(sums, zlib.crc32(struct.pack("<Q", size)))
