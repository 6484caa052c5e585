"""Configurations of the mechanism at several times, side by side: lines seen along one direction."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib
import numpy as np

from mecano.errors import UsageError
from mecano.post.draw_sketch import draw_compass, draw_patch, draw_shapes
from mecano.post.figure import plain_figure
from mecano.post.ground import ground_patch, grounds_near
from mecano.post.shapes import CABLE, GUIDE, JOINT, MASS, SUPPORT, Motion, shapes, vertical
from mecano.post.sketch import FLAT, plane_axes
from mecano.post.style import INK, PALE, SETTINGS
from mecano.post.view_direction import direction, projection

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mecano.post.runs import Run

AZIMUTH, ELEVATION = math.radians(-72.0), math.radians(24.0)  # of the eye
COLUMNS, WIDTH = 3, 3.6  # of the picture; inches of each view
TALLEST = 1.4  # height over width of a view
MARGIN = 0.06  # of the size of the picture's content
SUPPORT_SIZE = 7
FAR = 2.0  # sizes: a mechanism that travels farther is drawn about its centre at each time


def times_of(text: str) -> list[float]:
    """Return the times [s] of a text "0,1.5,3.2". Raises UsageError."""
    try:
        times = [float(part) for part in text.split(",")]
    except ValueError:
        raise UsageError(f"--at '{text}' cannot be understood; write times with commas between, as 0,1.5,3.2") from None
    if not all(math.isfinite(t) for t in times):
        raise UsageError(f"--at '{text}': times must be finite")
    return times


def configurations_figure(run: "Run", times: Sequence[float], title: str) -> "Figure":
    """Return the figure of the saved configurations nearest to ``times`` [s], on one scale. Raises UsageError."""
    saved = run.results.time
    rows = np.array([int(np.abs(saved - t).argmin()) for t in times])
    drawn = shapes(Motion(run, rows))
    shown = [shape for shape in drawn if shape.style not in (MASS, JOINT, SUPPORT)]
    if not shown:
        raise UsageError("--at: nothing in these results is drawn as a line")
    matrix = _matrix(run, shown)
    lines = [(shape, shape.points @ matrix.T) for shape in shown]
    fixed = [name for name, node in run.deck.get("nodes", {}).items() if node.get("fixed")]
    supports = [run.results.find(f"nodes/{name}/position").values[rows] @ matrix.T for name in fixed]
    supports += [shape.points[:, 0] @ matrix.T for shape in drawn if shape.style == SUPPORT]
    colours = {shape.name: PALE if shape.style in (CABLE, GUIDE) else INK for shape in shown}
    patches = [_patches(run, shown, matrix, i) for i in range(len(rows))]
    shift, low, high = _frame(np.concatenate([*(points for _, points in lines), *zip(*patches, strict=True)], axis=1))
    room = MARGIN * (high - low).max()
    with matplotlib.rc_context(SETTINGS):
        columns = min(COLUMNS, len(rows))
        high_rows = math.ceil(len(rows) / columns)
        aspect = min((high[1] - low[1] + 2 * room) / (high[0] - low[0] + 2 * room), TALLEST)
        heading = _heading(run, travels=bool(shift.any()), supported=bool(supports))
        figure = plain_figure(columns * WIDTH, high_rows * (WIDTH * aspect + 0.3), title, heading)
        grid = figure.add_gridspec(high_rows, columns)
        for i, row in enumerate(rows):
            ax = figure.add_subplot(grid[i // columns, i % columns])
            draw_shapes(ax, [(shape, p[i] - shift[i]) for shape, p in lines if shape.is_shown(i)], colours)
            for outline in patches[i]:
                draw_patch(ax, outline - shift[i])
            for place in supports:
                ax.plot(*(place[i] - shift[i]), "o", color=INK, markersize=SUPPORT_SIZE, markerfacecolor=PALE)
            ax.set_xlim(low[0] - room, high[0] + room)
            ax.set_ylim(low[1] - room, high[1] + room)
            ax.set_aspect("equal")
            draw_compass(ax, matrix)
            ax.set_title(_named(saved[row], times[i]), color=INK, fontsize=10)
    return figure


def _matrix(run, shown):
    """Return the matrix (2, 3) that projects positions: from the side if all lie in a plane and none on a ground."""
    points, gravity = np.concatenate([shape.points for shape in shown], axis=1), run.deck.get("gravity")
    extents = np.ptp(points, axis=(0, 1))
    if extents.min() <= FLAT * extents.max() and not grounds_near(run.deck, points):
        return np.eye(3)[list(plane_axes(points.reshape(-1, 3), gravity))]
    up = vertical(gravity)
    return projection(direction(AZIMUTH, ELEVATION, up), up)


def _patches(run, shown, matrix, i):
    """Return the outlines (k, 2) of all grounds around the configuration ``i``."""
    points = np.concatenate([shape.points for shape in shown], axis=1)
    return [ground_patch(run.deck, ground, points[i]) @ matrix.T for ground in grounds_near(run.deck, points)]


def _frame(points):
    """Return the origins (n, 2) of configurations (n, k, 2), and the lower and upper corner (2,) of their frame."""
    low, high = points.min(axis=1), points.max(axis=1)
    middle = 0.5 * (low + high)
    far = np.ptp(middle, axis=0).max() > FAR * (high - low).max()
    shift = middle if far else np.zeros_like(middle)
    return shift, (low - shift).min(axis=0), (high - shift).max(axis=0)


def _heading(run, travels, supported):
    """Return the heading of the figure."""
    of = f"configurations of {run.label}" if run.label else "configurations"
    return of + ", all on one scale" + ", each about its middle" * travels + "; dots: supports" * supported


def _named(saved, requested):
    """Return a text with the time drawn, and the time requested if they differ."""
    shown, wanted = f"t = {saved:.4g} s", f"{requested:.4g} s"
    return shown if shown.endswith(f" {wanted}") else f"{shown}, saved nearest to {wanted}"
