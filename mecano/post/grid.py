"""The mechanism as points and cells over time, for ParaView.

Points are the nodes, the rims of wheels and gears, centres of mass and the nodes inside superelements. An element
between two nodes, or each element of a divided member, is a line; a wheel or gear is its rim and a spoke; a body is a
line through its points; a joint or a point mass is a vertex. Cells are hidden after the release of their owner.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from mecano.errors import ResultsError
from mecano.model.mesh import piece_names
from mecano.post.runs import Run
from mecano.post.shapes import BODY, GEAR, JOINT, SUPPORT, WHEEL, Motion, Shape, apart, shapes
from mecano.results.vtk_group import LINE, POLY_LINE, VERTEX, Field, Grid

UNITS = ("N", "N m", "Pa")  # of the outputs that cells carry
HIDDEN = "vtkGhostType"  # name of the array of VTK that hides cells, and its value (vtkDataSetAttributes::HIDDENCELL)
HIDDEN_CELL = 32
PLAIN = {"force": "force_along_axis", "moment": "moment_about_axis"}  # names of these where they are single numbers


NUMBERS = 2**20  # read at once from the results file, 8 MB; the data made of them are up to four times as large


def grids_of(run: Run) -> Iterator[Grid]:
    """Yield the Grids of successive blocks of saved times of a run, with the same cells and names.

    Raises ResultsError if there is nothing to draw.
    """
    count, size = len(run.results.time), max(1, NUMBERS // run.results.layout.size)
    motion = _Blocks(run)
    points, cells = _points(motion)
    if not cells or not count:
        raise ResultsError(f"{run.results.path}: nothing to be seen, no saved time or no node with a position")
    start = points.positions()
    for first in range(0, count, size):
        motion.rows = slice(first, first + size)
        yield _grid(motion, start)


class _Blocks(Motion):
    """The motion at a block of ``rows``, first the start; nodes apart at any saved time are apart in all blocks."""

    def __init__(self, run: Run):
        super().__init__(run, slice(1))
        self._apart: dict[tuple[str, ...], bool] = {}

    def apart(self, nodes: Sequence[str], points: np.ndarray) -> bool:
        """Return whether nodes are apart at any saved time of the run."""
        key = tuple(nodes)
        if key not in self._apart:
            whole = Motion(self.run, slice(None))
            self._apart[key] = apart(np.stack([whole.position(node) for node in nodes], axis=1))
        return self._apart[key]


def _points(motion):
    """Return the _Points of a motion and, for each cell, (owner in the file, (type, indices of points), Shape)."""
    points = _Points(motion)
    drawn = [shape for shape in shapes(motion) if shape.style != SUPPORT]
    return points, [(*found, shape) for shape in drawn for found in _cells(motion.run, shape, points.numbers(shape))]


def _grid(motion, start):
    """Return the Grid of a motion, with displacements relative to ``start`` (1, points, 3) [m]."""
    points, found = _points(motion)
    owners, cells, drawn = zip(*found, strict=True)
    positions = points.positions()
    point_data = {
        "displacement": Field("m", "displacement since the start, inertial", positions - start),
        "velocity": Field("m/s", "velocity, inertial", points.velocities()),
    }
    names = list(dict.fromkeys(owners))
    return Grid(
        motion.run.results.time[motion.rows], Field("m", "position, inertial", positions),
        cells, point_data, _data(motion, owners) | _hidden(drawn),
        np.array([names.index(owner) for owner in owners]), {"node": motion.nodes, "owner": names},
    )  # fmt: skip


class _Points:
    """The points: first the nodes, then the further points of shapes."""

    def __init__(self, motion: Motion):
        self._motion = motion
        self._positions = [motion.position(node) for node in motion.nodes]
        self._velocities = [motion.vector(f"nodes/{node}/velocity") for node in motion.nodes]
        self._number = {node: i for i, node in enumerate(motion.nodes)}

    def numbers(self, shape: Shape) -> list[int]:
        """Return the indices of the points of a shape, and add those that are not nodes."""
        rigid = next(filter(None, shape.nodes), None) if shape.style in (WHEEL, GEAR, BODY) else None
        return [
            self._number[node] if node else self._add_point(shape.points[:, i], rigid)
            for i, node in enumerate(shape.nodes or ("",) * shape.points.shape[1])
        ]  # fmt: skip

    def _add_point(self, positions, rigid):
        """Add a point and return its index; if it moves with a node ``rigid``, its velocity is v + omega x r."""
        velocities = np.full(positions.shape, np.nan)
        if rigid is not None:
            i, omega = self._number[rigid], self._motion.vector(f"nodes/{rigid}/angular_velocity")
            velocities = self._velocities[i] + np.cross(omega, positions - self._positions[i])
        self._positions.append(positions)
        self._velocities.append(velocities)
        return len(self._positions) - 1

    def positions(self) -> np.ndarray:
        """Return all positions (times, points, 3) [m]."""
        return np.stack(self._positions, axis=1)

    def velocities(self) -> np.ndarray:
        """Return all velocities (times, points, 3) [m/s]; nan inside superelements."""
        return np.stack(self._velocities, axis=1)


def _cells(run, shape, points):
    """Yield (owner in the file, cell) of each cell of a shape."""
    sections = ("joints",) if shape.style == JOINT else ("elements", "joints", "loads")
    owner = next(name for name in (f"{section}/{shape.name}" for section in sections) if name in run.things)
    pieces = piece_names(shape.name, run.things[owner])
    if len(pieces) > 1:
        for piece, ends in zip(pieces, zip(points[:-1], points[1:], strict=True), strict=True):
            yield f"elements/{piece}", (LINE, ends)
    else:
        yield owner, ({1: VERTEX, 2: LINE}.get(len(points), POLY_LINE), tuple(points))


def _data(motion, owners):
    """Return forces, moments and stresses of the owners of the cells: name -> Field."""
    run = motion.run
    shape = len(run.results.time[motion.rows]), len(owners)
    found: dict[str, Field] = {}
    cells_of: dict[str, list[int]] = {}
    for i, owner in enumerate(owners):
        cells_of.setdefault(owner, []).append(i)
    for path, series in run.results.series.items():
        owner, _, output = path.rpartition("/")
        cells = cells_of.get(owner)
        if not cells or series.unit not in UNITS or series.shape not in ((), (3,)):
            continue
        values = motion.vector(path)[:, None]
        name = output if series.shape else PLAIN.get(output, output)
        _fill(found, name, series, cells, values, shape)
        if output == run.display(run.pieces[owner]).axial:
            _fill(found, "axial_force", series, cells, values if values.ndim == 2 else values[..., 0], shape)
    return found


def _hidden(drawn):
    """Return the Field that hides the cells of released Shapes, one for each cell; none if nothing is released."""
    if all(shape.shown is None for shape in drawn):
        return {}
    shown = [np.ones(len(shape.points), bool) if shape.shown is None else shape.shown for shape in drawn]
    values = np.where(np.stack(shown, axis=1), 0, HIDDEN_CELL).astype("u1")
    return {HIDDEN: Field("-", "32 from the release of the joint or element on", values)}


def _fill(found, name, series, cells, values, shape):
    if name not in found:
        doc = "axial force, > 0 in tension" if name == "axial_force" else series.doc
        found[name] = Field(series.unit, doc, np.full((*shape, *values.shape[2:]), np.nan))
    found[name].values[:, cells] = values
