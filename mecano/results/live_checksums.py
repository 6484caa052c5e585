"""Checksums within a file that is being written, valid for all bytes after a kill at any instant.

A table holds the last two CRC-32 of every block of BLOCK bytes. Before a block is written, its new sum is put into the
table. The operating system interrupts a write only between pages, so that each block matches one of its two sums
whenever the process is killed.

The table lies beyond the end of the HDF5 data, where HDF5 does not read: the table of n blocks begins at byte BLOCK n,
and an END follows it. Before the data grow into the table, a larger one is written beyond it, its END last. The
numbers of blocks form a fixed sequence (``sizes``), by which a reader finds the END of the last table.
"""

import errno
import itertools
import os
import struct
import zlib
from array import array
from collections.abc import Iterator

import numpy as np

from mecano.results.checksums import BLOCK, END, block_sums, crcs

MARK = b"mecano live 1\0\0\0"
FIRST = 64  # blocks of the smallest table
PAIR = 8  # bytes of the two sums of a block
AT_ONCE = 256  # blocks read at once
_ZEROS = zlib.crc32(bytes(BLOCK))


def sizes() -> Iterator[int]:
    """Yield the possible numbers of blocks of a table, ascending, without end."""
    n = FIRST
    while True:
        yield n
        n += n // 4


def end_of(n: int) -> int:
    """Return the size in bytes of a file whose last table has ``n`` blocks."""
    return (BLOCK + PAIR) * n + END.size


class LiveChecksums:
    """The table of checksums of an open file that only this process writes; all methods may raise OSError."""

    def __init__(self, descriptor: int):
        self._descriptor = descriptor
        self._blocks = 0
        self._certain = True

    def cover(self, size: int) -> None:
        """Move the table beyond the first ``size`` bytes, unless it lies there already."""
        if size <= BLOCK * self._blocks:
            return
        before, blocks = self._blocks, next(n for n in sizes() if BLOCK * n >= size)
        table = np.full((blocks, 2), _ZEROS, "<u4")
        table[:before] = self._pairs(0, before)
        for first in range(before, blocks, AT_ONCE):  # the old table, or all of a file written without one
            content = os.pread(self._descriptor, BLOCK * min(AT_ONCE, blocks - first), BLOCK * first)
            if not content:
                break
            there = block_sums(content.ljust(-(-len(content) // BLOCK) * BLOCK, b"\0"))
            table[first : first + len(there)] = there[:, None]
        self._put(BLOCK * blocks, table.tobytes())
        self._put(BLOCK * blocks + table.nbytes, _end(blocks))
        self._blocks = blocks
        if before:  # the old table is no longer valid
            place = end_of(before) - END.size
            self.announce(place, bytes(END.size))
            self._put(place, bytes(END.size))

    def announce(self, offset: int, data: bytes | memoryview) -> None:
        """Put the new sums of the blocks into the table before ``data`` are written at an ``offset``."""
        first, end = offset // BLOCK, offset + len(data)
        last = -(-end // BLOCK)
        start, stop = BLOCK * first, BLOCK * last
        if last == first + 1:
            before = self._read(start, BLOCK)
            sums = [zlib.crc32(b"".join((before[: offset - start], data, before[end - start :])))]
        else:
            head = self._read(start, offset - start) if offset > start else b""
            tail = self._read(end, stop - end) if end < stop else b""
            sums = crcs(b"".join((head, data, tail)) if head or tail else data)
        place = BLOCK * self._blocks + PAIR * first
        if self._certain:
            pairs = array("I", self._read(place, PAIR * len(sums)))
            pairs[1::2] = pairs[::2]
        else:
            pairs = array("I", [0, 0] * len(sums))
            pairs[1::2] = array("I", crcs(self._read(start, stop - start)))
        pairs[::2] = array("I", sums)
        put(self._descriptor, place, pairs.tobytes())

    def recompute(self) -> None:
        """Recompute the sums of blocks from now on instead of reading them, as a write has failed."""
        self._certain = False

    def sums(self, blocks: int) -> np.ndarray:
        """Return the sums (blocks,) last written of the first ``blocks`` blocks."""
        return self._pairs(0, blocks)[:, 0]

    def _pairs(self, first, last):
        data = self._read(BLOCK * self._blocks + PAIR * first, PAIR * (last - first))
        return np.frombuffer(data, "<u4").reshape(-1, 2)

    def _read(self, offset, size):
        """Return bytes in front of the end of the last table."""
        data = os.pread(self._descriptor, size, offset)
        if len(data) < size:
            raise OSError(errno.ENODATA, "it was cut short while it was written")
        return data

    def _put(self, offset, data):
        put(self._descriptor, offset, data)


class LastTable:
    """The last table of checksums in a file that was not closed, for readers.

    Parameters
    ----------
    descriptor : int
        Descriptor of the open file.
    blocks : int
        Number of blocks covered.
    """

    def __init__(self, descriptor: int, blocks: int):
        self._descriptor, self._blocks = descriptor, blocks
        self.covered = BLOCK * blocks

    def changed(self, data: bytes | memoryview, first: int) -> np.ndarray:
        """Return the numbers (n,) of changed blocks in ``data``, which begin with block ``first``."""
        sums = block_sums(data)
        place = BLOCK * self._blocks + PAIR * first
        data = os.pread(self._descriptor, PAIR * len(sums), place)
        pairs = np.frombuffer(data.ljust(PAIR * len(sums), b"\0"), "<u4").reshape(-1, 2)  # the table may be moving
        return first + np.flatnonzero((sums != pairs[:, 0]) & (sums != pairs[:, 1]))


def last_table(descriptor: int) -> LastTable | None:
    """Return the LastTable of an open file, or None if it has none. Raises OSError."""
    size = os.fstat(descriptor).st_size
    possible = list(itertools.takewhile(lambda n: end_of(n) <= size, sizes()))
    for n in reversed(possible):
        if os.pread(descriptor, END.size, end_of(n) - END.size) == _end(n):
            return LastTable(descriptor, n)
    return None


def put(descriptor: int, offset: int, data: bytes | memoryview) -> None:
    """Write all bytes of ``data`` at an ``offset`` of an open file. Raises OSError."""
    data = memoryview(data)
    while len(data):
        written = os.pwrite(descriptor, data, offset)
        offset, data = offset + written, data[written:]


def _end(n):
    return END.pack(MARK, n, zlib.crc32(struct.pack("<Q", n), zlib.crc32(MARK)))
