"""Named views of the numbers in a results file: a virtual dataset for each series, with unit, description and axes.

A view has its own path and shape, and costs nothing during the run. As there may be thousands, objects common to
several are created once, and the low-level interface of h5py is used.
"""

from math import prod

import h5py
import numpy as np
from h5py import h5d, h5p, h5s, h5t

from mecano.results.layout import Layout, Series
from mecano.results.table import Axes, name_axes, put_axes, put_text, references

MOST_VIEWS = 3000
"""Largest number of series for which views are made (0.15 ms each); with more, only the storage holds the series."""
STEP_TIME = Series("step_time", "s", "end of the accepted step")


class Views:
    """The views of the dataset ``table`` of a NumberTable; the view of its times is the dimension scale of all others.

    Parameters
    ----------
    file : h5py.File
    axes : Axes
    table : h5py.Dataset
    time : Series
        Declaration of the first column.
    """

    def __init__(self, file: h5py.File, axes: Axes, table: h5py.Dataset, time: Series):
        self._file, self._axes, self._table = file.id, axes, table.name.encode()
        width = table.shape[1]
        self._columns = h5s.create_simple((0, width), (h5s.UNLIMITED, width))
        self._properties = h5p.create(h5p.DATASET_CREATE)
        self._properties.set_fill_value(np.array([np.nan]))
        self._links = h5p.create(h5p.LINK_CREATE)
        self._links.set_create_intermediate_group(True)
        self._links.set_char_encoding(h5t.CSET_UTF8)
        self._spaces: dict[tuple[int, ...], h5s.SpaceID] = {}  # by the shape of a value
        self._scales: dict[tuple[int, ...], np.ndarray] = {}
        self.times = h5py.Dataset(self._make(time, 0))
        self.times.make_scale(time.path)

    def add(self, series: Series, column: int) -> None:
        """Create the view of a Series whose numbers begin in a ``column`` of the table."""
        if series.shape not in self._scales:
            self._scales[series.shape] = references([self.times, *self._axes.of(series.shape)])
        put_axes(self._make(series, column), self._scales[series.shape])

    def _make(self, series, column):
        """Create a view without names of its axes, and return its identifier."""
        if series.shape not in self._spaces:
            self._spaces[series.shape] = _space(series.shape)
        space, width = self._spaces[series.shape], prod(series.shape)
        self._columns.select_hyperslab((0, column), (h5s.UNLIMITED, 1), stride=(1, width), block=(1, width))
        properties = self._properties.copy()
        properties.set_virtual(space, b".", self._table, self._columns)
        made = h5d.create(self._file, series.path.encode(), h5t.IEEE_F64LE, space, properties, self._links)
        put_text(made, b"units", series.unit)
        put_text(made, b"long_name", series.doc)
        return made


def _space(shape):
    """Return the dataspace of an unlimited number of values of a shape."""
    many, ones = h5s.UNLIMITED, (1,) * len(shape)
    space = h5s.create_simple((0, *shape), (many, *shape))
    space.select_hyperslab((0,) * (1 + len(shape)), (many, *ones), stride=(1, *shape), block=(1, *shape))
    return space


def make_views(file: h5py.File, axes: Axes, layout: Layout, outputs: h5py.Dataset, steps: h5py.Dataset) -> None:
    """Create a view of each series of a Layout in an h5py file, in the datasets ``outputs`` and ``steps``."""
    views = Views(file, axes, outputs, layout.axis._replace(path="time"))
    name_axes(outputs, views.times, axes.scale(1 + layout.size))
    for series in layout.series if len(layout.series) <= MOST_VIEWS else ():
        views.add(series, 1 + layout.slices[series.path].start)
    views = Views(file, axes, steps, STEP_TIME)
    name_axes(steps, views.times, axes.scale(1 + len(layout.steps)))
    for column, series in enumerate(layout.steps, start=1):
        views.add(series._replace(path=f"solver/{series.path}"), column)
