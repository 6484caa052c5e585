"""What shows that a byte of a closed file has changed: a CRC-32 of every 1024 bytes, behind the end of the HDF5 file.

HDF5 does not look there. At the very end: a mark, how many bytes are covered, and the CRC-32 of all the sums.
"""

import os
import struct
import zlib
from typing import NamedTuple

import numpy as np

BLOCK = 1024
AT_ONCE = 2**20  # bytes read at once, a multiple of BLOCK
END = struct.Struct("<16sQI")
MARK = b"mecano seal 1\0\0\0"


class Seal(NamedTuple):
    """The sums at the end of a file, if there are any."""

    covered: int  # bytes
    sums: np.ndarray  # (n,) uint32, of each block
    whole: bool  # the sums themselves have not changed


def seal(descriptor, size, place=0, to_come=b""):
    """The bytes to be put behind a file of ``size`` bytes, read through an open descriptor. Raises OSError.

    They are those of the file as it will be with the bytes ``to_come`` at a ``place``.
    """
    sums = block_sums(descriptor, size, place, to_come).tobytes()
    return sums + END.pack(MARK, size, _sum_of(size, sums))


def seal_file(path):
    """Put the sums behind a file that has just been written otherwise. Raises OSError."""
    with open(path, "r+b") as file:
        size = file.seek(0, os.SEEK_END)
        file.write(seal(file.fileno(), size))


def block_sums(descriptor, size, place=0, instead=b""):
    """CRC-32 (n,) uint32 of each block of the first ``size`` bytes of an open file. Raises OSError.

    As if the bytes ``instead`` stood at a ``place``.
    """
    sums = []
    for start in range(0, size, AT_ONCE):
        data = bytearray(os.pread(descriptor, min(AT_ONCE, size - start), start))
        first, last = max(place, start), min(place + len(instead), start + len(data))
        if first < last:
            data[first - start : last - start] = instead[first - place : last - place]
        sums += [zlib.crc32(memoryview(data)[i : i + BLOCK]) for i in range(0, len(data), BLOCK)]
    return np.array(sums, "<u4")


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
