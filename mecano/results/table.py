"""Growing tables in a results file: numbers in one dataset with a named view of each series, and lists of texts.

Hundreds of datasets that grow together cost milliseconds at every flush. So all numbers of a saved time are one row of
one dataset of chunks, and each series is a virtual dataset, a view of its columns: HDF5 shows it under its own path,
with its own shape and attributes, and it costs nothing while the run goes on.
"""

import zlib
from math import prod

import h5py
import numpy as np
from h5py import h5a, h5d, h5p, h5s, h5t

from mecano.results.layout import AXES, EVENT_NUMBERS, EVENT_TEXTS

CHUNK_NUMBERS = 8192  # 64 KB
BLOCK_NUMBERS = 2**17  # 1 MB
MOST_VIEWS = 3000
"""Up to so many series have a named view (0.3 ms each to make); beyond, only the storage holds them."""
_TEXT_DTYPE = h5py.string_dtype()
_TEXT = h5t.py_create(_TEXT_DTYPE, logical=True)
_REFERENCES = h5t.py_create(h5py.vlen_dtype(h5py.ref_dtype), logical=True)


def chunk_shape(width):
    """Rows and columns of a chunk: a row of chunks near 1 MB, a chunk near 64 KB so that one series reads little."""
    rows = min(max(1 << (BLOCK_NUMBERS // width).bit_length() - 1, 16), 1024)
    return rows, min(max(CHUNK_NUMBERS // rows, 1), width)


def describe(item, **texts):
    """Write text attributes, as item.attrs[key] = text does, in half its time."""
    for key, text in texts.items():
        attribute = h5a.create(item.id, key.encode(), _TEXT, h5s.create(h5s.SCALAR))
        attribute.write(np.array(text, dtype=_TEXT_DTYPE))


def name_axes(dataset, *scales):
    """Say which dimension scales belong to the axes, as the HDF5 dimension scale specification stores it.

    The scales do not list their datasets in return (H5DSattach_scale rewrites that whole list for every dataset).
    """
    references = np.empty(len(scales), dtype=object)
    for i, scale in enumerate(scales):
        references[i] = np.array([scale.ref], dtype=h5py.ref_dtype)
    h5a.create(dataset.id, b"DIMENSION_LIST", _REFERENCES, h5s.create_simple(references.shape)).write(references)


class Axes:
    """Scales for the components of values: /xyz, /wxyz, /index_9, /index2_9, ...

    They are at the top of the file, as netCDF looks for them only upwards.
    """

    def __init__(self, file):
        self._file = file
        self._scales = {}

    def scale(self, length, axis=1):
        """Return the scale of that length; xarray wants those of the axes of a matrix to differ."""
        return self._scale(f"index_{length}" if axis == 1 else f"index{axis}_{length}", np.arange(length))

    def of(self, shape):
        """Scales of all axes of a value: letters for vectors and quaternions."""
        if len(shape) == 1 and shape[0] in AXES:
            letters = AXES[shape[0]]
            return [self._scale("".join(letters), np.array(letters, dtype="S1"))]
        return [self.scale(length, axis) for axis, length in enumerate(shape, start=1)]

    def _scale(self, name, values):
        if name not in self._scales:
            self._scales[name] = self._file.create_dataset(name, data=values)
            self._scales[name].make_scale(name)
        return self._scales[name]


class NumberTable:
    """Rows of float64, the time first, buffered and written in blocks to one dataset.

    Parameters
    ----------
    file : h5py.File
    path : str
        Of the dataset.
    width : int
        Numbers in a row, the time included.
    """

    def __init__(self, file, path, width):
        chunks = chunk_shape(width)
        self.dataset = file.create_dataset(
            path, shape=(0, width), maxshape=(None, width), chunks=chunks, dtype="<f8", fillvalue=np.nan
        )
        self.buffer = np.empty((chunks[0], width))
        self.filled = 0
        self.written = 0
        self.sum = 0  # CRC-32 of all rows written

    def add(self, time, values):
        """Keep a row; true when the buffer is full and has to be written."""
        row = self.buffer[self.filled]
        row[0] = time
        row[1:] = values
        self.filled += 1
        return self.filled == len(self.buffer)

    def write(self):
        """Hand the kept rows to HDF5."""
        if self.filled:
            self._put(self.buffer[: self.filled])
            self.filled = 0

    def extend(self, rows):
        """Hand rows (n, width), the time first, to HDF5 behind the kept ones: what many ``add`` do, in less time."""
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

    def view(self, group, name, column, shape):
        """Make a virtual dataset that shows some columns as values of the given shape, and return it."""
        total, part = self.buffer.shape[1], prod(shape)
        many = h5s.UNLIMITED
        source = h5s.create_simple((0, total), (many, total))
        source.select_hyperslab((0, column), (many, 1), stride=(1, part), block=(1, part))
        target = h5s.create_simple((0, *shape), (many, *shape))
        ones = (1,) * len(shape)
        target.select_hyperslab((0,) * (1 + len(shape)), (many, *ones), stride=(1, *shape), block=(1, *shape))
        properties = h5p.create(h5p.DATASET_CREATE)
        properties.set_fill_value(np.array([np.nan]))
        properties.set_virtual(target, b".", self.dataset.name.encode(), source)
        return h5py.Dataset(h5d.create(group.id, name.encode(), h5t.IEEE_F64LE, target, properties))

    def time_view(self, group, name, unit, doc):
        """Make the view of the times, a dimension scale for all other views."""
        times = self.view(group, name, 0, ())
        describe(times, units=unit, long_name=doc)
        times.make_scale(name)
        return times


def make_views(file, axes, layout, outputs, steps):
    """Name the series of a Layout in an h5py file: a view of each in the NumberTables ``outputs`` and ``steps``."""
    times = outputs.time_view(file, "time", layout.axis.unit, layout.axis.doc)
    name_axes(outputs.dataset, times, axes.scale(1 + layout.size))
    groups = {}
    for series in layout.series if len(layout.series) <= MOST_VIEWS else ():
        parent, _, name = series.path.rpartition("/")
        if parent not in groups:
            groups[parent] = file.require_group(parent or "/")
        view = outputs.view(groups[parent], name, 1 + layout.slices[series.path].start, series.shape)
        describe(view, units=series.unit, long_name=series.doc)
        name_axes(view, times, *axes.of(series.shape))
    solver = file.create_group("solver")
    ends = steps.time_view(file, "step_time", layout.axis.unit, "end of the accepted step")
    name_axes(steps.dataset, ends, axes.scale(1 + len(layout.steps)))
    for column, series in enumerate(layout.steps, start=1):
        view = steps.view(solver, series.path, column, ())
        describe(view, units=series.unit, long_name=series.doc)
        name_axes(view, ends)


class EventTable:
    """The list of events: a dataset per field in the group ``events``, with the time as their dimension scale.

    Texts have a fixed length in bytes; longer ones are cut.
    """

    def __init__(self, file, text_length):
        group = file.create_group("events")
        self._length = text_length
        self._pending = []
        self.written = 0
        self.sum = 0  # CRC-32 of all events written
        kind = h5py.string_dtype("utf-8", text_length)
        times = group.create_dataset("event_time", shape=(0,), maxshape=(None,), chunks=(512,), dtype="<f8")
        describe(times, units="s", long_name="time of the event")
        times.make_scale("event_time")
        self._datasets = [times]
        for name, doc in EVENT_TEXTS.items():
            texts = group.create_dataset(name, shape=(0,), maxshape=(None,), chunks=(64,), dtype=kind)
            describe(texts, long_name=doc)
            name_axes(texts, times)
            self._datasets.append(texts)
        for name, (unit, doc) in EVENT_NUMBERS.items():
            numbers = group.create_dataset(name, shape=(0,), maxshape=(None,), chunks=(512,), dtype="<f8")
            describe(numbers, units=unit, long_name=doc)
            name_axes(numbers, times)
            self._datasets.append(numbers)

    def add(self, time, texts, numbers):
        """Keep an event: its time, and what ``EVENT_TEXTS`` and ``EVENT_NUMBERS`` name."""
        cut = [text.encode()[: self._length].decode(errors="ignore").encode() for text in texts]
        self._pending.append((float(time), *cut, *map(float, numbers)))

    def write(self):
        """Hand the kept events to HDF5."""
        if not self._pending:
            return
        end = self.written + len(self._pending)
        for dataset, column in zip(self._datasets, zip(*self._pending, strict=True), strict=True):
            dataset.resize((end,))
            dataset[self.written :] = np.array(column, dtype=dataset.dtype)
        self.written = end
        self.sum = event_sum(self._pending, self.sum)
        self._pending.clear()


def event_sum(rows, before=0):
    """CRC-32 of events: tuples of a time, texts as bytes and numbers; ``before``: that of the events before them."""
    return zlib.crc32("".join(map(repr, rows)).encode(), before)
