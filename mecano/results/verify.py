"""Whether the bytes of a results file are those that were written, and if not, of which datasets they are."""

import zlib
from bisect import bisect_left, bisect_right
from itertools import pairwise

import h5py
import numpy as np

from mecano.errors import ResultsError
from mecano.results.reader import open_results
from mecano.results.salvage import missing_bytes
from mecano.results.seal import BLOCK, block_sums, seal_of
from mecano.results.table import event_sum
from mecano.results.writer import STATUSES

ROWS = 1024  # read at once
MOST = 12  # datasets named
STRUCTURE = "what describes the datasets (names, shapes, attributes, texts of the deck)"


def verify(path):
    """What can be said for a results file in which nothing is wrong, as text.

    A closed file is checked to the last byte. One that is still being written, was killed or could not be written to
    its end is checked up to its last checkpoint. Raises ResultsError where bytes have changed or are missing.
    """
    try:
        with open(path, "rb") as file:
            problem, sealed = _against_seal(path, file.fileno())
    except OSError as error:
        raise ResultsError(f"cannot read {path}: {error.strerror}") from error
    if problem:
        raise ResultsError(problem)
    with open_results(path) as results:
        count, status = len(results.time), results.status
        told = f"{path}: {status}, {count} saved times" + (f" up to {results.time[-1]:.9g}" if count else "")
        if sealed:
            return f"{told}; every byte is as it was written"
        if status == "truncated":
            raise ResultsError(f"{told}; it is cut short by {missing_bytes(path)} bytes")
        if status in ("complete", "stopped"):
            raise ResultsError(f"{told}; its last bytes, which hold the sums to check by, are missing or have changed")
        return f"{told}; it was not closed, so that only rows before a checkpoint can be checked: {_checked(results)}"


def _against_seal(path, descriptor):
    """(what is wrong, or ""; True when the file has a seal) of an open file."""
    seal, changed = compared(path, descriptor)
    if seal is None:
        return "", False
    if not seal.whole:
        return f"{path} is damaged: the sums at its end, by which it is checked, have changed", True
    if not len(changed):
        return "", True
    of = owners(path, changed)
    named = "; ".join(of[:MOST]) + (f"; and {len(of) - MOST} more" if len(of) > MOST else "")
    where = f"{len(changed)} of {len(seal.sums)} blocks of {BLOCK} bytes, the first at byte {BLOCK * changed[0]}"
    return f"{path} is damaged: bytes have changed in {where}. They belong to: {named}", True


def compared(path, descriptor):
    """(Seal, numbers of the blocks that are not as it says) of an open file; None instead of the Seal if it has none.

    It has none either while the status is all that differs: this is written last, so the writer was killed before.
    """
    seal = seal_of(descriptor)
    if seal is None or not seal.whole:
        return seal, ()
    changed = np.flatnonzero(block_sums(descriptor, seal.covered) != seal.sums)
    place, length = _status_to_come(path) if 0 < len(changed) <= 2 else (0, 0)
    for status in STATUSES[1:] if length else ():
        sums = block_sums(descriptor, seal.covered, place, status.encode().ljust(length, b"\0"))
        if np.array_equal(sums, seal.sums):
            return None, ()
    return seal, changed


def _status_to_come(path):
    """(place, number of bytes) of the status of an HDF5 file that still says it is running; (0, 0) of any other."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            status = file["run/status"]
            return (status.id.get_offset(), status.id.get_storage_size()) if status[()] == b"running" else (0, 0)
    except (OSError, RuntimeError, KeyError, ValueError):
        return 0, 0


def owners(path, blocks):
    """Names of what has bytes in the ``blocks`` (n,), ascending, of an HDF5 file, in the order of the file."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            extents = sorted(_extents(file))
    except (OSError, RuntimeError, KeyError, ValueError):
        return [STRUCTURE]
    begins, ends = [a for a, _, _ in extents], [b for _, b, _ in extents]  # both ascend, for extents do not overlap
    found, between = [], False
    for block in blocks:
        first, last = BLOCK * int(block), BLOCK * (int(block) + 1)
        inside = extents[bisect_right(ends, first) : bisect_left(begins, last)]
        found += [name for _, _, name in inside]
        edges = [first, *(edge for a, b, _ in inside for edge in (a, b)), last]
        between |= any(a < b for a, b in list(pairwise(edges))[::2])
    return [*dict.fromkeys(found), *([STRUCTURE] if between else [])]


def _extents(file):
    """(first byte, byte after the last, name) of all numbers of all datasets."""
    datasets = []
    file.visititems(lambda name, item: datasets.append((name, item)) if isinstance(item, h5py.Dataset) else None)
    for name, dataset in datasets:
        if dataset.chunks:
            for i in range(dataset.id.get_num_chunks()):
                chunk = dataset.id.get_chunk_info(i)
                row = chunk.chunk_offset[0]
                yield (
                    chunk.byte_offset, chunk.byte_offset + chunk.size,
                    f"{name}, rows {row} to {row + dataset.chunks[0] - 1}",
                )  # fmt: skip
        elif dataset.id.get_offset() is not None:
            first = dataset.id.get_offset()
            yield first, first + dataset.id.get_storage_size(), name


def _checked(results):
    """What the sums of the last checkpoint say of the rows before it; raises ResultsError."""
    if results.checkpoint is None:
        return "there is none"
    saved, steps, events = map(int, results.checkpoint["file"]["rows"])
    found = {
        "storage/output": _sum(results, "output", saved),
        "storage/solver": _sum(results, "solver", steps),
        "events": event_sum(map(_row, results.events[:events])),
    }
    wanted = results.checkpoint["file"]["sums"]
    wrong = [name for (name, total), expected in zip(found.items(), wanted, strict=True) if total != expected]
    if wrong:
        raise ResultsError(f"{results.path} is damaged: bytes have changed in {', '.join(wrong)}")
    return f"its {saved} saved times, {steps} steps and {events} events are as they were written"


def _sum(results, table, count):
    total = 0
    for first in range(0, count, ROWS):
        total = zlib.crc32(results.rows(table, first, min(first + ROWS, count)), total)
    return total


def _row(event):
    texts = (event.element, event.name, event.before, event.after, event.impulse_unit)
    return (event.time, *(text.encode() for text in texts), event.impulse, event.energy_lost)
