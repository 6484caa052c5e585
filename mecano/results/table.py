"""Growing tables in a results file: numbers in one dataset, with each series as a view, and events.

Hundreds of growing datasets would cost milliseconds at every flush. So all numbers of a saved time form one row of a
single chunked dataset (views.py).
"""

import zlib
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any

import h5py
import numpy as np
from h5py import h5a, h5s, h5t

from mecano.results.layout import AXES, EVENT_NUMBERS, EVENT_TEXTS

CHUNK_NUMBERS = 8192  # 64 KB
BLOCK_NUMBERS = 2**17  # 1 MB
_TEXT_DTYPE = h5py.string_dtype()
_TEXT = h5t.py_create(_TEXT_DTYPE, logical=True)
_ONE = h5s.create(h5s.SCALAR)
_REFERENCES = h5t.py_create(h5py.vlen_dtype(h5py.ref_dtype), logical=True)


def chunk_shape(width: int) -> tuple[int, int]:
    """Return rows and columns of a chunk: about 1 MB per row of chunks, some 64 KB per chunk, to read one series fast.

    The columns are divided evenly: the file also holds those that chunks have beyond ``width``.
    """
    rows = min(max(1 << max(BLOCK_NUMBERS // width, 1).bit_length() - 1, 16), 1024)
    chunks = max(width * rows // CHUNK_NUMBERS, 1)
    return rows, -(-width // chunks)


def describe(item: h5py.Dataset | h5py.Group, **texts: str) -> None:
    """Write text attributes, as ``item.attrs[key] = text``, in half the time."""
    for key, text in texts.items():
        put_text(item.id, key.encode(), text)


def put_numbers(group: h5py.Group, name: str, values: Any, unit: str, doc: str) -> h5py.Dataset:
    """Create a dataset of floats with unit and description, and return it."""
    dataset = group.create_dataset(name, data=np.asarray(values, float))
    describe(dataset, units=unit, long_name=doc)
    return dataset


def put_text(identifier: h5py.h5d.DatasetID | h5py.h5g.GroupID, key: bytes, text: str) -> None:
    """Write a text attribute of the group or dataset with an HDF5 ``identifier``."""
    h5a.create(identifier, key, _TEXT, _ONE).write(_stored(text))


@lru_cache
def _stored(text):
    return np.array(text, dtype=_TEXT_DTYPE)


def name_axes(dataset: h5py.Dataset, *scales: h5py.Dataset) -> None:
    """Assign dimension scales to the axes of a dataset, as the HDF5 dimension scale specification stores them.

    The back references of the scales are omitted (H5DSattach_scale rewrites their whole list for every dataset).
    """
    put_axes(dataset.id, references(scales))


def references(scales: Sequence[h5py.Dataset]) -> np.ndarray:
    """Return the references to dimension scales that ``put_axes`` writes."""
    found = np.empty(len(scales), dtype=object)
    for i, scale in enumerate(scales):
        found[i] = np.array([scale.ref], dtype=h5py.ref_dtype)
    return found


def put_axes(identifier: h5py.h5d.DatasetID, scales: np.ndarray) -> None:
    """Do as ``name_axes`` for an HDF5 identifier, with ``scales`` from ``references``."""
    h5a.create(identifier, b"DIMENSION_LIST", _REFERENCES, h5s.create_simple(scales.shape)).write(scales)


class Axes:
    """Dimension scales for the components of values: /xyz, /wxyz, /index_9, /index2_9, ...

    They are in the root group, as netCDF searches only a group and those above it.
    """

    def __init__(self, file: h5py.File):
        self._file = file
        self._scales: dict[str, h5py.Dataset] = {}

    def scale(self, length: int, axis: int = 1) -> h5py.Dataset:
        """Return the scale of that length; xarray requires different ones for the axes of a matrix."""
        return self._scale(f"index_{length}" if axis == 1 else f"index{axis}_{length}", np.arange(length))

    def of(self, shape: tuple[int, ...]) -> list[h5py.Dataset]:
        """Return the scales of all axes of a value: letters for vectors and quaternions."""
        if len(shape) == 1 and shape[0] in AXES:
            letters = AXES[shape[0]]
            return [self._scale("".join(letters), np.array(letters, dtype="S1"))]
        return [self.scale(length, axis) for axis, length in enumerate(shape, start=1)]

    def _scale(self, name, values):
        if name not in self._scales:
            self._scales[name] = self._file.create_dataset(name, data=values)
            self._scales[name].make_scale(name)
        return self._scales[name]


def create_numbers(file: h5py.File, path: str, width: int) -> h5py.Dataset:
    """Create a dataset for a NumberTable with ``width`` numbers per row, time included."""
    return file.create_dataset(
        path, shape=(0, width), maxshape=(None, width), chunks=chunk_shape(width), dtype="<f8", fillvalue=np.nan
    )


class NumberTable:
    """Rows of float64 with the time first, buffered and written in blocks to a dataset of ``create_numbers``."""

    def __init__(self, dataset: h5py.Dataset):
        self.dataset = dataset
        self.buffer = np.empty((dataset.chunks[0], dataset.shape[1]))
        self.filled = 0
        self.written = 0
        self.sum = 0  # CRC-32 of all rows written

    def add(self, time: float, values: np.ndarray) -> bool:
        """Buffer a row; return whether the buffer is full and must be written."""
        row = self.buffer[self.filled]
        row[0] = time
        row[1:] = values
        self.filled += 1
        return self.filled == len(self.buffer)

    def write(self) -> None:
        """Write the buffered rows to HDF5."""
        if self.filled:
            self._put(self.buffer[: self.filled])
            self.filled = 0

    def extend(self, rows: np.ndarray) -> None:
        """Write rows (n, width), with the time first, to HDF5 after the buffered ones; faster than many ``add``."""
        self.write()
        self._put(rows)

    def _put(self, rows):
        count, width = rows.shape
        self.dataset.id.set_extent((self.written + count, width))
        space = self.dataset.id.get_space()
        space.select_hyperslab((self.written, 0), rows.shape)
        self.dataset.id.write(h5s.create_simple(rows.shape), space, rows)
        self.sum = zlib.crc32(rows, self.sum)
        self.written += count


def create_events(file: h5py.File, text_length: int) -> None:
    """Create the group ``events``: a dataset per field, scaled by the time, with texts of ``text_length`` bytes."""
    group = file.create_group("events")
    kind = h5py.string_dtype("utf-8", text_length)
    times = group.create_dataset("event_time", shape=(0,), maxshape=(None,), chunks=(512,), dtype="<f8")
    describe(times, units="s", long_name="time of the event")
    times.make_scale("event_time")
    for name, doc in EVENT_TEXTS.items():
        texts = group.create_dataset(name, shape=(0,), maxshape=(None,), chunks=(64,), dtype=kind)
        describe(texts, long_name=doc)
        name_axes(texts, times)
    for name, (unit, doc) in EVENT_NUMBERS.items():
        numbers = group.create_dataset(name, shape=(0,), maxshape=(None,), chunks=(512,), dtype="<f8")
        describe(numbers, units=unit, long_name=doc)
        name_axes(numbers, times)


class EventTable:
    """The events in a group made by ``create_events``; longer texts are truncated."""

    def __init__(self, group: h5py.Group):
        self._datasets = [group[name] for name in ("event_time", *EVENT_TEXTS, *EVENT_NUMBERS)]
        self._length = self._datasets[1].dtype.itemsize
        self._pending: list[tuple[Any, ...]] = []
        self.written = 0
        self.sum = 0  # CRC-32 of all events written

    def add(self, time: float, texts: Iterable[str], numbers: Iterable[float]) -> None:
        """Buffer an event: its time [s], ``texts`` as in ``EVENT_TEXTS``, ``numbers`` as in ``EVENT_NUMBERS``."""
        cut = [text.encode()[: self._length].decode(errors="ignore").encode() for text in texts]
        self._pending.append((float(time), *cut, *map(float, numbers)))

    def write(self) -> None:
        """Write the buffered events to HDF5."""
        if not self._pending:
            return
        end = self.written + len(self._pending)
        for dataset, column in zip(self._datasets, zip(*self._pending, strict=True), strict=True):
            dataset.resize((end,))
            dataset[self.written :] = np.array(column, dtype=dataset.dtype)
        self.written = end
        self.sum = event_sum(self._pending, self.sum)
        self._pending.clear()


def event_sum(rows: Iterable[tuple[Any, ...]], before: int = 0) -> int:
    """Return the CRC-32 of events, tuples of time, texts as bytes, and numbers; ``before``: that of earlier events."""
    return zlib.crc32("".join(map(repr, rows)).encode(), before)
