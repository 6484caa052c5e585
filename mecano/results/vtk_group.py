"""The group /VTKHDF: a motion as points and cells over time, for ParaView and other programs based on VTK.

Format VTKHDF 2.2, UnstructuredGrid with Steps: each dataset holds the values of all saved times in succession. The
connectivity never changes and is stored once. Reference: docs.vtk.org, VTKHDF file format.
"""

import os
from collections.abc import Iterable
from dataclasses import dataclass

import h5py
import numpy as np

from mecano.errors import ResultsError
from mecano.results.disk import atomic_hdf5_file
from mecano.results.opening import open_source
from mecano.results.table import describe, name_axes

GROUP = "VTKHDF"
VERSION = (2, 2)  # the first version that allows other groups in the file
VERTEX, LINE, POLY_LINE = 1, 3, 4
TEXT = h5py.string_dtype("ascii")  # the type of UTF-8 crashes VTK 9.7; UTF-8 bytes in this one do not
COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
CHUNK_NUMBERS = 2**15  # 256 KB
LENGTHS = "length_"  # prefix of the names of the scales of all axes


@dataclass(frozen=True)
class Field:
    """Data at points or cells: ``values`` (times, n) or (times, n, 3), nan where unknown; unit, description."""

    unit: str
    doc: str
    values: np.ndarray


@dataclass(frozen=True)
class Grid:
    """Moving points and the cells between them at some saved times.

    Attributes
    ----------
    times : (n,) array
        Saved times [s]; for statics the load factor or the length of the path.
    points : Field
        Positions (n, p, 3) [m], inertial.
    cells : tuple of (int, tuple of int)
        Type and point numbers of each of the c cells.
    point_data, cell_data : dict
        Name -> Field of (n, p, ...) or (n, c, ...).
    cell_owner : (c,) array of int
        Index of the owner of each cell in the ``owner`` names.
    names : dict
        Lists of names: of the first points, and of the owners.
    """

    times: np.ndarray
    points: Field
    cells: tuple[tuple[int, tuple[int, ...]], ...]
    point_data: dict[str, Field]
    cell_data: dict[str, Field]
    cell_owner: np.ndarray
    names: dict[str, list[str]]


def write_grids(file: h5py.File, grids: Iterable[Grid], times: np.ndarray) -> None:
    """Write Grids of successive saved times as the group VTKHDF of an open h5py file, which must not have one.

    ``grids`` is an iterator of Grids, so that only one is held at a time; ``times`` (n,) [s] are the times of all.
    """
    group, done = file.create_group(GROUP), 0
    for grid in grids:
        if not done:
            _begin(group, grid, times)
        for name, field in _fields(grid):
            instants, number, *inner = field.values.shape
            rows = slice(done * number, (done + instants) * number)
            group[name][rows] = field.values.reshape(-1, *inner)
        done += len(grid.times)


def _begin(group, grid, times):
    """Write the constant data, and allocate the datasets that change with time."""
    group.attrs["Version"] = np.array(VERSION, dtype="i8")
    kind = b"UnstructuredGrid"
    group.attrs.create("Type", kind, dtype=h5py.string_dtype("ascii", len(kind)))
    _write_cells(group, grid)
    for name, field in _fields(grid):
        _make_room(group, name, field, len(times))
    _put(group, "CellData/owner", grid.cell_owner.astype("i8"))
    for name, texts in grid.names.items():
        _put(group, f"FieldData/{name}", np.array([text.encode() for text in texts], dtype=TEXT))
    _write_steps(group.create_group("Steps"), group, grid, times)


def _fields(grid):
    """Yield (name in the group, Field) of all data that change with time."""
    yield "Points", grid.points
    for part, fields in (("PointData", grid.point_data), ("CellData", grid.cell_data)):
        for name, field in fields.items():
            yield f"{part}/{name}", field


def add_grids(path: str | os.PathLike[str], grids: Iterable[Grid], times: np.ndarray, *, force: bool) -> None:
    """Add Grids to the results file ``path``, whose other data are kept; on failure the file is unchanged.

    ``grids`` and ``times`` as for ``write_grids``. Raises ResultsError if the group exists and ``force`` is False, if
    bytes have changed since the file was closed, or if it cannot be written.
    """
    _refuse_damaged(path)
    with atomic_hdf5_file(path, begun=path) as file:
        if GROUP in file and not force:
            raise ResultsError(f"{path} already has a group /{GROUP}; --force to replace it")
        if GROUP in file:
            del file[GROUP]
        write_grids(file, grids, times)


def _refuse_damaged(path):
    """Raise ResultsError for a file with changed bytes, which would be given valid checksums when rewritten."""
    source = open_source(path)
    try:
        if source.sums is not None and len(source.changed()):
            raise ResultsError(f"{path} is damaged: nothing is added to it; mecano verify names the data affected")
    finally:
        source.close()


def _write_cells(group, grid):
    ends = np.cumsum([0, *(len(points) for _, points in grid.cells)])
    whole = {
        "NumberOfPoints": [grid.points.values.shape[1]], "NumberOfCells": [len(grid.cells)],
        "NumberOfConnectivityIds": [ends[-1]], "Offsets": ends,
        "Connectivity": [i for _, points in grid.cells for i in points],
    }  # fmt: skip
    for name, values in whole.items():
        _put(group, name, np.array(values, dtype="i8"))
    _put(group, "Types", np.array([kind for kind, _ in grid.cells], dtype="u1"))


def _write_steps(steps, group, grid, times):
    """Write the offsets of each saved time in the datasets."""
    count, n_points, n_cells = len(times), grid.points.values.shape[1], len(grid.cells)
    row = np.arange(count, dtype="i8")
    none, one = np.zeros(count, dtype="i8"), np.ones(count, dtype="i8")
    steps.attrs["NSteps"] = np.int64(count)
    starts = {
        "Values": np.asarray(times, dtype="f8"), "PartOffsets": none, "NumberOfParts": one,
        "PointOffsets": row * n_points, "CellOffsets": none[:, None], "ConnectivityIdOffsets": none[:, None],
        "CellDataOffsets/owner": none,
        **{f"PointDataOffsets/{name}": row * n_points for name in grid.point_data},
        **{f"CellDataOffsets/{name}": row * n_cells for name in grid.cell_data},
    }  # fmt: skip
    for name, texts in grid.names.items():
        starts[f"FieldDataOffsets/{name}"] = none
        starts[f"FieldDataSizes/{name}"] = np.stack([one, len(texts) * one], axis=1)
    for name, values in starts.items():
        _put(steps, name, values, group)


def _make_room(group, name, field, count):
    """Create a dataset for the values of a Field at ``count`` saved times in succession."""
    _, number, *inner = field.values.shape
    shape = (count * number, *inner)
    rows = max(1, min(shape[0], CHUNK_NUMBERS // int(np.prod(inner, dtype=int))))
    options = {"chunks": (rows, *inner), **COMPRESSION} if shape[0] else {}
    dataset = _put(group, name, None, shape=shape, dtype=field.values.dtype, **options)
    describe(dataset, units=field.unit, long_name=field.doc)


def _put(group, name, values, top=None, **options):
    """Create a dataset whose axes have scales in ``top``, for readers that require them (netCDF, xarray)."""
    dataset = group.create_dataset(name, data=values, **options)
    name_axes(dataset, *(_scale(top or group, length, axis) for axis, length in enumerate(dataset.shape)))
    return dataset


def _scale(group, length, axis):
    """Return a scale without data, which takes no space; the axes of a dataset have different ones."""
    name = f"{LENGTHS}{axis}_{length}"
    if name not in group:
        group.create_dataset(name, shape=(length,), dtype="u1").make_scale(name)
    return group[name]
