"""The group /VTKHDF: a motion as points and cells over time, for ParaView and whatever else reads with VTK.

Format VTKHDF 2.2, UnstructuredGrid with Steps: the values of one saved time after the other in each dataset. What
joins the points never changes, so it is there once. Reference: docs.vtk.org, VTKHDF file format.
"""

from dataclasses import dataclass

import h5py
import numpy as np

from mecano.errors import ResultsError
from mecano.results.checked import checked
from mecano.results.disk import hdf5_appearing
from mecano.results.table import describe, name_axes

GROUP = "VTKHDF"
VERSION = (2, 2)  # the first that allows other groups beside it
VERTEX, LINE, POLY_LINE = 1, 3, 4
TEXT = h5py.string_dtype("ascii")  # that of UTF-8, which the bytes may well be, crashes VTK 9.7
COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
CHUNK_NUMBERS = 2**15  # 256 KB
LENGTHS = "length_"  # of the scales of all axes


@dataclass(frozen=True)
class Field:
    """Data at the points or cells: ``values`` (times, n) or (times, n, 3), nan where it is not known; unit, meaning."""

    unit: str
    doc: str
    values: np.ndarray


@dataclass(frozen=True)
class Grid:
    """Points that move, and cells between them, at some saved times.

    Attributes
    ----------
    times : (n,) array
        Saved times [s], of statics what stands for them.
    points : Field
        Positions (n, p, 3) [m], inertial.
    cells : tuple of (int, tuple of int)
        Type of each of the c cells and numbers of its points.
    point_data, cell_data : dict
        Name -> Field of (n, p, ...) or (n, c, ...).
    cell_owner : (c,) array of int
        Number of the owner of each cell among the ``owner`` names.
    names : dict
        Lists of names: of the first points, of the owners.
    """

    times: np.ndarray
    points: Field
    cells: tuple
    point_data: dict
    cell_data: dict
    cell_owner: np.ndarray
    names: dict


def write_grids(file, grids, times):
    """Write Grids, of successive saved times, as the group VTKHDF of an open h5py file, which must not have one.

    ``grids`` yields them, ``times`` (n,) [s] are those of all. No more than one Grid is held at a time.
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
    """All that is there once, with room for the rest."""
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
    """(name in the group, Field) of all that changes."""
    yield "Points", grid.points
    for part, fields in (("PointData", grid.point_data), ("CellData", grid.cell_data)):
        for name, field in fields.items():
            yield f"{part}/{name}", field


def add_grids(path, grids, times, *, force=False):
    """Add Grids to the results file ``path``, which keeps all else; nothing happens to it if that fails.

    ``grids``, ``times``: as of ``write_grids``. Raises ResultsError: it has such a group and ``force`` is not given,
    bytes of it have changed since it was closed, or the disk does not take it.
    """
    _refuse_damaged(path)
    with hdf5_appearing(path, begun=path) as file:
        if GROUP in file and not force:
            raise ResultsError(f"{path} has a group /{GROUP} already; --force to replace it")
        if GROUP in file:
            del file[GROUP]
        write_grids(file, grids, times)


def _refuse_damaged(path):
    """Raise ResultsError for a file of which bytes have changed: those that it gets would get good sums."""
    source = checked(path)
    try:
        if source.sums is not None and len(source.changed()):
            raise ResultsError(f"{path} is damaged: nothing is added to it; mecano verify tells what has changed")
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
    """Where in each dataset a saved time begins."""
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
    """A dataset for a Field at so many saved times, those of one after the other."""
    _, number, *inner = field.values.shape
    shape = (count * number, *inner)
    rows = max(1, min(shape[0], CHUNK_NUMBERS // int(np.prod(inner, dtype=int))))
    options = {"chunks": (rows, *inner), **COMPRESSION} if shape[0] else {}
    describe(_put(group, name, None, shape=shape, dtype="f8", **options), units=field.unit, long_name=field.doc)


def _put(group, name, values, top=None, **options):
    """A dataset whose axes have scales in ``top``, for readers that ask for such (netCDF, xarray)."""
    dataset = group.create_dataset(name, data=values, **options)
    name_axes(dataset, *(_scale(top or group, length, axis) for axis, length in enumerate(dataset.shape)))
    return dataset


def _scale(group, length, axis):
    """A scale without numbers, which takes no room; the axes of one dataset have different ones."""
    name = f"{LENGTHS}{axis}_{length}"
    if name not in group:
        group.create_dataset(name, shape=(length,), dtype="u1").make_scale(name)
    return group[name]
