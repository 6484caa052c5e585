"""A view of the mechanism at several instants: from the side, or from where it is seen best."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mecano.post.ground import ground_line, ground_patch, grounds_near
from mecano.post.runs import Run
from mecano.post.shapes import GUIDE, WHEEL, Motion, Shape, shapes, vertical, wheel_of
from mecano.post.view_direction import eye, projection

MOST_ROWS = 300  # saved times considered
INSTANTS = 7
FAR = 6.0  # widths: a mechanism that travels farther is shown side by side, not in place
PITCH = 1.25  # spacing side by side, in widths
UPRIGHT = 0.35  # width over height of a mechanism, below which it is shown side by side, and the spacing
WIDE = 0.38  # height over width of a picture that is as wide as several panels
STANDS = 0.5  # of the height of all instants: the height of such a mechanism at one of them
MOVES = 0.02  # of the height: a mechanism that moves less is shown in place
PATHS = 12  # most paths of points shown
STILL = 1e-3  # of the size of the picture: a point that moves less has no path
ALIKE = 0.99  # two extents that differ by less count as equal
FLAT = 1e-3  # of the size: a mechanism that extends less along an axis is plane


@dataclass(frozen=True)
class Sketch:
    """Shapes projected onto a plane.

    Attributes
    ----------
    label : str
        Label of the run.
    axes : (int, int)
        Inertial axes (0, 1, 2) that point to the right and up; empty for a view in space.
    times : (n,) array
        Instants [s].
    shapes : tuple of Shape
        With points (n, k, 3) [m].
    shift : (n, 2) array
        To be added to the coordinates in the picture at each instant [m]; zeros if all is shown in place.
    paths : tuple of (m, 2) arrays
        Paths of points [m].
    grounds : tuple of (k, 2) arrays
        Lines of the ground, with the shift included [m].
    axis : (str, str)
        Name and unit of the times.
    """

    label: str
    axes: tuple[int, ...]
    times: np.ndarray
    shapes: tuple[Shape, ...]
    shift: np.ndarray
    paths: tuple[np.ndarray, ...]
    grounds: tuple[np.ndarray, ...]
    axis: tuple[str, str] = ("time", "s")
    view: np.ndarray | None = None  # (2, 3) of a view in space: to the right and up of the picture

    @property
    def projection(self) -> np.ndarray:
        """Matrix (2, 3): inertial positions to the right and up of the picture."""
        return np.eye(3)[list(self.axes)] if self.view is None else self.view

    def flat(self, points: np.ndarray, instant: int) -> np.ndarray:
        """Return points (k, 3) [m] in the picture (k, 2), with the shift of an instant."""
        return points @ self.projection.T + self.shift[instant]

    @property
    def in_place(self) -> bool:
        """True if all instants are shown in place, without shift."""
        return not self.shift.any()

    @property
    def wide(self) -> bool:
        """True if it needs the width of several panels to be as high as one."""
        return not self.in_place and self.aspect < WIDE

    @property
    def aspect(self) -> float:
        """Height over width of all that is shown."""
        points = [s.points @ self.projection.T + self.shift[:, None] for s in self.shapes]
        width, height = np.ptp(np.concatenate([some.reshape(-1, 2) for some in points]), axis=0)
        return height / width if width > 0.0 else 1.0


def sketch(run: Run) -> Sketch | None:
    """Return the Sketch of a run, or None if there is nothing to draw."""
    count = len(run.results.time)
    if not count:
        return None
    rows = np.unique(np.linspace(0, count - 1, MOST_ROWS).round().astype(int))
    moving = shapes(Motion(run, rows))
    points = np.concatenate([np.zeros((0, 3)), *(s.points.reshape(-1, 3) for s in moving)])
    if not points.size or not np.ptp(points, axis=0).any():
        return None
    cloud = _cloud(moving)
    axes, view = _view(run, moving, cloud)
    instants = _instants(run.results.time[rows], cloud)
    drawn = tuple(s.at(instants) for s in moving)
    matrix = np.eye(3)[list(axes)] if view is None else view
    shift = _shift(drawn, matrix, None if view is None else vertical(run.deck.get("gravity")))
    paths = () if shift.any() else _paths(cloud @ matrix.T)
    times, axis = run.results.time[rows[instants]], run.results.axis
    if view is None:
        grounds = tuple(_grounds(run, drawn, axes, shift[:, 0]))
    else:
        grounds = tuple(_patches(run, drawn, matrix, shift))
    return Sketch(run.label or run.title, axes, times, drawn, shift, paths, grounds, (axis.path, axis.unit), view)


def _view(run, moving, cloud):
    """Return (axes of the plane of a motion, None), or (no axes, matrix (2, 3) of a view in space)."""
    relative = cloud - 0.5 * (cloud.min(axis=1, keepdims=True) + cloud.max(axis=1, keepdims=True))
    gravity, points = run.deck.get("gravity"), np.concatenate([s.points.reshape(-1, 3) for s in moving])
    wheels = [wheel_of(shape) for shape in moving if shape.style == WHEEL]
    extents = np.ptp(relative.reshape(-1, 3), axis=0)
    # a wheel by itself is seen from the side, whichever way it leans
    if len(wheels) < 2 and (extents.min() <= FLAT * extents.max() or not extents.any()):
        return plane_axes(points, gravity), None
    if not extents.any() or np.count_nonzero(extents > FLAT * extents.max()) < 2:
        return plane_axes(points, gravity), None
    up = vertical(gravity)
    return (), projection(eye(relative[:: max(1, len(relative) // INSTANTS)], wheels, up), up)


def plane_axes(points: np.ndarray, gravity: Sequence[float] | None) -> tuple[int, ...]:
    """Return the two inertial axes of largest extent of points (n, 3), the vertical one second if included."""
    up = 2 if gravity is None or not any(gravity) else int(np.argmax(np.abs(gravity)))
    extent = np.ptp(points, axis=0)
    extent = np.where(extent > ALIKE * extent.max(), extent.max(), extent)
    first, second = sorted(range(3), key=lambda axis: (extent[axis], axis == up, -axis), reverse=True)[:2]
    if up in (first, second):
        return (first if second == up else second, up)
    return tuple(sorted((first, second)))


def _cloud(moving):
    """Return the points (instants, n, 3) of all shapes, with wheels reduced to centres and without guides."""
    places = [s.points[:, -1:] if s.style == WHEEL else s.points for s in moving if s.style != GUIDE]
    return np.concatenate(places, axis=1)


def _instants(times, cloud):
    """Return indices of instants, denser where the mechanism deforms or turns."""
    if len(times) <= INSTANTS:
        return np.arange(len(times))
    relative = cloud - cloud.mean(axis=1, keepdims=True) if cloud.shape[1] > 1 else cloud
    changes = np.linalg.norm(np.diff(relative, axis=0), axis=(1, 2))
    course = (times - times[0]) / (times[-1] - times[0])
    if changes.sum() > 0.0:
        course = 0.5 * course + 0.5 * np.concatenate([[0.0], np.cumsum(changes) / changes.sum()])
    return np.unique(np.searchsorted(course, np.linspace(0.0, course[-1], INSTANTS)).clip(max=len(times) - 1))


def _shift(drawn, matrix, up):
    """Shift (n, 2) of each instant: zeros, or side by side when the mechanism travels far.

    In a view in space, which has a vertical ``up``, travel along the ground moves the shapes up or down: this is
    removed.
    """
    flat = np.concatenate([s.points @ matrix.T for s in drawn], axis=1)
    low, high = flat.min(axis=1), flat.max(axis=1)
    width, middle = np.max((high - low)[:, 0]), 0.5 * (low + high)
    shift = np.zeros((len(flat), 2))
    pitch = PITCH * width
    if _is_upright(flat) and any(s.points.shape[1] > 1 for s in drawn):
        pitch = max(pitch, UPRIGHT * np.ptp(flat[..., 1]))
    elif np.ptp(middle, axis=0).max() <= FAR * width or not width:
        return shift
    shift[:, 0] = pitch * np.arange(len(flat)) - middle[:, 0]
    if up is not None:
        points = np.concatenate([s.points for s in drawn], axis=1)
        travel = 0.5 * (points.min(axis=1) + points.max(axis=1))
        travel -= travel[0]
        shift[:, 1] = -(travel - np.outer(travel @ up, up)) @ matrix[1]
    return shift


def _is_upright(flat):
    """Return whether a mechanism that moves is so narrow and high that it would hide itself if shown in place."""
    width, height = np.ptp(flat.reshape(-1, 2), axis=0)
    stands = np.ptp(flat[..., 1], axis=1).max() > STANDS * height  # otherwise something small that rises or falls
    return stands and width < UPRIGHT * height and np.ptp(flat, axis=0).max() > MOVES * height


def _patches(run, drawn, matrix, shift):
    """Yield outlines (k, 2) of the ground around the mechanism: one, or one for each instant if they are shifted."""
    for ground in grounds_near(run.deck, np.concatenate([shape.points for shape in drawn], axis=1)):
        spans = [[i] for i in range(len(shift))] if shift.any() else [range(len(shift))]
        for span in spans:
            points = np.concatenate([s.points[i] for s in drawn for i in span])
            outline = ground_patch(run.deck, ground, points)
            yield outline @ matrix.T + shift[span[0]]


def _paths(cloud):
    """Return the longest distinct paths (m, 2) of a cloud of points (m, n, 2)."""
    extents = np.hypot(*np.ptp(cloud, axis=0).T)
    size = np.hypot(*np.ptp(cloud.reshape(-1, 2), axis=0))
    paths: list[np.ndarray] = []
    for i in np.argsort(-extents):
        path = cloud[:, i]
        if len(paths) == PATHS or extents[i] <= STILL * size:
            break
        if all(np.abs(path - other).max() > STILL * size for other in paths):
            paths.append(path)
    return tuple(paths)


def _grounds(run, drawn, axes, shift):
    """Yield lines of the ground below each wheel at each instant, or one long line if shown in place."""
    right = axes[0]
    x = np.concatenate([s.points[..., right] for s in drawn], axis=1)
    half_width = 0.5 * (np.ptp(x, axis=1).max() if shift.any() else np.ptp(x)) * PITCH
    done = set()
    for name, d in run.deck.get("elements", {}).items():
        if "ground" not in d or d["ground"] in done:
            continue
        centres = next((s.points[:, -1] for s in drawn if s.name == name), None)
        if centres is None:
            continue
        done.add(d["ground"])
        for i in range(len(shift)):
            line = _ground_at(run, d["ground"], axes, centres[i], x[i] if shift.any() else x, half_width)
            if line is not None:
                yield line + (shift[i], 0.0)
            if not shift.any():
                break


def _ground_at(run, name, axes, centre, x, half_width):
    middle = centre.copy()
    middle[axes[0]] = 0.5 * (x.min() + x.max())
    return ground_line(run.deck, run.deck["grounds"][name], axes, middle, half_width)
