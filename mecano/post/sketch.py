"""Side view of the mechanism at several instants: choice of plane and instants, shapes in the plane."""

from dataclasses import dataclass, replace

import numpy as np

from mecano.post.ground import ground_line
from mecano.post.shapes import GUIDE, WHEEL, Motion, shapes

MOST_ROWS = 300  # saved times considered
INSTANTS = 7
FAR = 6.0  # widths: a mechanism that travels farther is shown side by side, not in place
PITCH = 1.25  # spacing side by side, in widths
PATHS = 12  # most paths of points shown
STILL = 1e-3  # of the size of the picture: points that move less have no path
ALIKE = 0.99  # ratio above which two extents count as equal


@dataclass(frozen=True)
class Sketch:
    """Shapes in the plane of two inertial axes.

    Attributes
    ----------
    label : str
        Label of the run.
    axes : (int, int)
        Inertial axes (0, 1, 2) to the right and up.
    times : (n,) array
        Instants [s].
    shapes : tuple of Shape
        Shapes with points (n, k, 3) [m].
    shift : (n,) array
        Shift of the horizontal coordinates at each instant [m]; zeros if shown in place.
    paths : tuple of (m, 2) arrays
        Paths of points [m].
    grounds : tuple of (k, 2) arrays
        Lines of the ground, with the shift included [m].
    axis : (str, str)
        Name and unit of the times.
    """

    label: str
    axes: tuple
    times: np.ndarray
    shapes: tuple
    shift: np.ndarray
    paths: tuple
    grounds: tuple
    axis: tuple = ("time", "s")

    @property
    def in_place(self):
        """Whether all instants are shown in place, without shift."""
        return not self.shift.any()

    @property
    def aspect(self):
        """Height over width of all shapes."""
        points = [s.points[..., self.axes] + np.stack([self.shift, 0.0 * self.shift], -1)[:, None] for s in self.shapes]
        width, height = np.ptp(np.concatenate([some.reshape(-1, 2) for some in points]), axis=0)
        return height / width if width > 0.0 else 1.0


def sketch(run):
    """Return the Sketch of a run, or None if there is nothing to draw."""
    count = len(run.results.time)
    if not count:
        return None
    rows = np.unique(np.linspace(0, count - 1, MOST_ROWS).round().astype(int))
    moving = shapes(Motion(run, rows))
    points = np.concatenate([np.zeros((0, 3)), *(s.points.reshape(-1, 3) for s in moving)])
    if not points.size or not np.ptp(points, axis=0).any():
        return None
    axes = _axes(points, run.deck.get("gravity"))
    cloud = _cloud(moving)
    instants = _instants(run.results.time[rows], cloud)
    drawn = tuple(replace(s, points=s.points[instants]) for s in moving)
    shift = _shift(drawn, axes[0])
    paths = () if shift.any() else _paths(cloud[..., axes])
    times = run.results.time[rows[instants]]
    grounds, axis = tuple(_grounds(run, drawn, axes, shift)), run.results.axis
    return Sketch(run.label or run.title, axes, times, drawn, shift, paths, grounds, (axis.path, axis.unit))


def _axes(points, gravity):
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


def _shift(drawn, right):
    """Return the horizontal shift (n,) [m]: zeros, or side by side if the mechanism travels far."""
    x = np.concatenate([s.points[..., right] for s in drawn], axis=1)
    low, high = x.min(axis=1), x.max(axis=1)
    width, middle = np.max(high - low), 0.5 * (low + high)
    if np.ptp(middle) <= FAR * width or not width:
        return np.zeros(len(x))
    return PITCH * width * np.arange(len(x)) - middle


def _paths(cloud):
    """Return the longest distinct paths (m, 2) of a cloud of points (m, n, 2)."""
    extents = np.hypot(*np.ptp(cloud, axis=0).T)
    size = np.hypot(*np.ptp(cloud.reshape(-1, 2), axis=0))
    paths = []
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
