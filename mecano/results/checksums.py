"""What shows that a byte of a closed file has changed: a CRC-32 of every 4096 bytes, behind the end of the HDF5 file.

HDF5 does not look there. At the very end: a mark, how many bytes are covered, and the CRC-32 of all the sums.
"""

import os
import struct
import zlib

import numpy as np

BLOCK = 4096  # the page of operating systems
END = struct.Struct("<16sQI")
MARK = b"mecano seal 2\0\0\0"
BLOCKS = {MARK: BLOCK, b"mecano seal 1\0\0\0": 1024}
"""Bytes in a block of files with each mark."""


class Seal:
    """The sums at the end of a closed file, for readers.

    Attributes
    ----------
    block : int
        Bytes of a block.
    covered : int
        Bytes that are covered.
    sums : (n,) array of uint32
        Of each block.
    whole : bool
        The sums themselves have not changed.
    """

    def __init__(self, block, covered, sums, whole):
        self.block, self.covered, self.sums, self.whole = block, covered, sums, whole

    def changed(self, data, first):
        """Return which blocks (n,) of ``data``, whole blocks from number ``first`` on, are not what they were."""
        found = block_sums(data, self.block)
        return first + np.flatnonzero(found != self.sums[first : first + len(found)])


def block_sums(data, block=BLOCK):
    """Return the CRC-32 (n,) uint32 of each block of bytes; the last one may be shorter."""
    return np.array(crcs(data, block), "<u4")


def crcs(data, block=BLOCK):
    """Return the CRC-32 of each block of bytes as a list."""
    view = memoryview(data)
    return [zlib.crc32(view[i : i + block]) for i in range(0, len(view), block)]


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
    if mark not in BLOCKS:
        return None
    block = BLOCKS[mark]
    length = 4 * -(-covered // block)
    if covered + length + END.size != size:
        return Seal(block, 0, np.zeros(0, "<u4"), False)
    sums = os.pread(descriptor, length, covered)
    return Seal(block, covered, np.frombuffer(sums, "<u4"), total == _sum_of(covered, sums))


def _sum_of(size, sums):
    return zlib.crc32(sums, zlib.crc32(struct.pack("<Q", size)))
