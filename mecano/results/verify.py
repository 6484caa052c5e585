"""Verification of a results file: whether bytes have changed, and to which datasets they belong."""

import os
import zlib
from bisect import bisect_left, bisect_right
from itertools import pairwise

import h5py
import numpy as np

from mecano.errors import ResultsError, name_list
from mecano.results.checksums import BLOCK, Seal
from mecano.results.layout import FORMAT
from mecano.results.opening import errors_as_damage, format_of, open_checked, open_source
from mecano.results.reader import open_results
from mecano.results.table import event_sum

ROWS = 1024  # read at once
MOST = 24  # datasets named: a block may hold many short ones
LOST = "its last bytes, with the checksums, are missing or have changed"
STRUCTURE = "metadata (names, shapes, attributes, texts of the deck)"


def verify(path: str | os.PathLike[str]) -> str:
    """Check every byte of a results file, and return a summary if it is intact.

    The file may be closed, still being written, killed or incomplete, and also hold modes, a sweep or a study. If the
    checksums are lost, those in the last checkpoint of a run show whether the rows before it have changed. Raises
    ResultsError if bytes or checksums have changed or are missing.
    """
    source = open_source(path)
    try:
        with errors_as_damage(path):
            problem = _damage(source)
            if problem:
                raise ResultsError(problem)
            return _undamaged(path, source)
    finally:
        source.close()


def _damage(source):
    """Return a description of the damage shown by the checksums of a Checked; "" if there is none, or no checksums."""
    sums, path = source.sums, source.path
    if sums is None:
        return ""
    if isinstance(sums, Seal) and not sums.whole:
        return f"{path} is damaged: the checksums at its end have changed"
    changed = source.changed()
    if not len(changed):
        return ""
    of = owners(path, changed)
    named = name_list(of, MOST, "; ")
    total = -(-min(sums.covered, source.size) // BLOCK)
    where = f"{len(changed)} of {total} blocks of {BLOCK} bytes, the first at byte {BLOCK * changed[0]}"
    return f"{path} is damaged: bytes have changed in {where}. Data affected: {named}"


def _undamaged(path, source):
    """Return the summary of a file without changed bytes. Raises ResultsError if checksums or bytes are missing."""
    whole = "all bytes are unchanged"
    if format_of(path) not in ("", FORMAT):
        if source.sums is None:
            raise ResultsError(f"{path}: {format_of(path)}; {LOST}")
        return f"{path}: {format_of(path)}; {whole}"
    with open_results(path) as results:
        count, status = len(results.time), results.status
        reported = f"{path}: {status}, {count} saved times" + (f" up to {results.time[-1]:.9g}" if count else "")
        if isinstance(source.sums, Seal):
            return f"{reported}; {whole}"
        if source.sums is not None:
            return f"{reported}; {'it was not closed; ' if status in ('running', 'killed') else ''}{whole}"
        if status == "truncated":
            raise ResultsError(f"{reported}; it is cut short by {source.missing} bytes")
        raise ResultsError(f"{reported}; {LOST}; {_checked(results)}")


def owners(path: str | os.PathLike[str], blocks: np.ndarray) -> list[str]:
    """Return the names of datasets with bytes in the ``blocks`` (n,), in the order of the file."""
    try:
        with open_checked(path) as file:
            extents = sorted(_extents(file))
    except ResultsError:
        return [STRUCTURE]
    begins, ends = [a for a, _, _ in extents], [b for _, b, _ in extents]  # both ascend, as extents do not overlap
    found, between = [], False
    for block in blocks:
        first, last = BLOCK * int(block), BLOCK * (int(block) + 1)
        inside = extents[bisect_right(ends, first) : bisect_left(begins, last)]
        found += [name for _, _, name in inside]
        edges = [first, *(edge for a, b, _ in inside for edge in (a, b)), last]
        between |= any(a < b for a, b in list(pairwise(edges))[::2])
    return [*dict.fromkeys(found), *([STRUCTURE] if between else [])]


def _extents(file):
    """Yield (first byte, byte after the last, name) of the storage of all datasets."""
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
    """Return a text on the rows before the last checkpoint, checked by its sums. Raises ResultsError."""
    if results.checkpoint is None:
        return "without a checkpoint its data cannot be verified"
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
    return f"by its last checkpoint, its {saved} saved times, {steps} steps and {events} events are unchanged"


def _sum(results, table, count):
    total = 0
    for first in range(0, count, ROWS):
        total = zlib.crc32(results.rows(table, first, min(first + ROWS, count)), total)
    return total


def _row(event):
    texts = (event.element, event.name, event.before, event.after, event.impulse_unit)
    return (event.time, *(text.encode() for text in texts), event.impulse, event.energy_lost)
