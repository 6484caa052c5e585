"""Films of a motion, GIF, WebP or MP4: the mechanism as lines, seen from a fixed direction."""

import subprocess
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib import animation, cm
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from mecano.errors import ResultsError, UsageError
from mecano.post.draw_sketch import line_of
from mecano.post.runs import opened_runs
from mecano.post.scene import Scene, scene_of
from mecano.post.shapes import BODY, CABLE, GEAR, JOINT, MASS, ROD, SPRING, SUPPORT, WHEEL
from mecano.post.style import GREY, INK, PALE, SETTINGS, shown_unit, with_unit
from mecano.post.view_direction import projection
from mecano.results.whole_file import atomic_file, make_folder

if TYPE_CHECKING:
    import os

WRITERS = {".gif": "pillow", ".webp": "pillow", ".mp4": "ffmpeg"}
FRAMES, PER_SECOND = 150, 15
SIZE, DOTS = (7.2, 5.2), 90  # inches of the largest view, per inch
NARROWEST, LOWEST = 3.0, 1.6  # inches of a view
BESIDE, BAR, BELOW = 0.15, (0.12, 0.65), 0.3  # inches beside the view; of the colours and their numbers; of the time
LETTER, LINE = 0.085, 0.2  # inches of the title
MARGIN = 1.08
LINES = {
    ROD: ("#0072b2", 2.4),
    CABLE: ("#0072b2", 1.2),
    SPRING: ("#d55e00", 1.6),
    BODY: ("#444444", 3.0),
    WHEEL: ("#333333", 1.5),
    GEAR: ("#009e73", 1.2),
}
MARKS = {MASS: ("o", 7.0, "#444444"), JOINT: ("o", 3.5, INK), SUPPORT: ("^", 8.0, GREY)}
COLOURS = "viridis"
SHORTEST = np.array([0.6, 0.2])  # width over height of the view, and height over width: a strut is a line, too


def film(path: "str | os.PathLike[str]", target: "str | os.PathLike[str]", title: str | None = None) -> Path:
    """Write the film ``target`` (.gif, .webp or .mp4) of the results file ``path``, and return its Path.

    Lines are coloured by stress, or otherwise by axial force, if the file has them.

    Raises
    ------
    UsageError
        The program that writes such films is not installed.
    ResultsError
        The file cannot be read or has nothing to draw, or the film cannot be written.
    """
    target = Path(target)
    writer = WRITERS[target.suffix]
    if not animation.writers.is_available(writer):
        raise UsageError(f"--animate {target}: {target.suffix} films need {writer}, which is not installed; .html does")
    make_folder(target.parent)
    with opened_runs([path]) as [run], matplotlib.rc_context(SETTINGS), atomic_file(target) as hidden:
        _write(scene_of(run, FRAMES), hidden, writer, title or run.title)
    return target


def _write(scene, target, writer, title):
    figure = Figure()
    figure.set_layout_engine("none")  # computing the layout for each frame would take half of the time
    picture = _Picture(scene, figure)
    picture.arrange(title)
    moving = animation.FuncAnimation(figure, picture.show, frames=len(scene.times), blit=False)
    try:
        moving.save(target, writer=writer, fps=PER_SECOND, dpi=DOTS)
    except subprocess.CalledProcessError as error:
        lines = [line.strip() for line in (error.stderr or "").splitlines() if line.strip()]
        raise ResultsError(f"{writer} fails to write the film: {lines[-1] if lines else error}") from error


def half_widths(extent: np.ndarray) -> np.ndarray:
    """Return the half widths (2,) of the view of a mechanism of an extent (2,) [m], for which there are axes to see."""
    shown = MARGIN * np.maximum(extent, SHORTEST * extent.max(initial=0.0))
    return 0.5 * np.where(shown > 0.0, shown, 1.0)


class _Picture:
    """A figure of the film, and the artists updated from frame to frame."""

    def __init__(self, scene: Scene, figure: Figure):
        self._scene, self._projection = scene, projection(scene.eye, scene.up)
        self._figure, self._ax = figure, (ax := figure.add_subplot())
        self._limits()
        ax.set_axis_off()
        ax.set_aspect("equal")
        for line in (line for lines in scene.grounds for line in lines):
            ax.plot(*self._flat(line).T, color="#c8b89a", linewidth=1.0, zorder=1)
        self._time = figure.text(0.0, 0.0, "", color=INK)
        self._lines = {i: self._line(shape) for i, shape in enumerate(scene.shapes) if shape.style not in MARKS}
        self._marks = {i: self._mark(shape) for i, shape in enumerate(scene.shapes) if shape.style in MARKS}
        self._colours = self._coloured()

    def _flat(self, points):
        return points @ self._projection.T

    def _limits(self):
        """Set centre and half widths of the view: of the whole motion, or of the mechanism if the view follows it."""
        scene = self._scene
        shift = scene.middle[:, None] if scene.follow else 0.0
        flat = np.concatenate([self._flat(s.points - shift).reshape(-1, 2) for s in scene.shapes])
        low, high = flat.min(axis=0), flat.max(axis=0)
        self._middle, self._half = 0.5 * (low + high), half_widths(high - low)

    def _line(self, shape):
        colour, width = LINES.get(shape.style, (GREY, 1.0))
        return self._ax.add_collection(LineCollection([], colors=colour, linewidths=width, capstyle="round", zorder=3))

    def _mark(self, shape):
        marker, size, colour = MARKS[shape.style]
        face = "white" if shape.style == JOINT else PALE if shape.style == SUPPORT else colour
        [mark] = self._ax.plot([], [], marker, color=colour, markersize=size, markerfacecolor=face, zorder=4)
        return mark

    def _coloured(self):
        """Draw the colour bar; return (name, factor, colour mapping) of the quantity shown, or None without one."""
        known = [one for one in self._scene.ranges if one[3] > one[2]]
        if not known:
            return None
        name, unit, low, high = known[0]
        factor, shown = shown_unit(unit, np.array([low, high]))
        mapping = cm.ScalarMappable(Normalize(low / factor, high / factor), COLOURS)
        self._bar = self._figure.colorbar(mapping, cax=self._figure.add_axes((0.9, 0.2, 0.02, 0.6)))
        self._bar.set_label(with_unit(name, shown))
        return name, factor, mapping

    def arrange(self, title: str) -> None:
        """Give the figure the shape of the view, with the title above, the time below, and the colours beside it."""
        view = self._half / max(self._half / SIZE)
        width, height = np.maximum(view, (NARROWEST, LOWEST))
        beside = BESIDE + (sum(BAR) if self._colours else 0.0)
        lines = wrap(title, int(width / LETTER)) or [""]
        whole = np.array([BESIDE + width + beside, BELOW + height + LINE * (len(lines) + 1)])
        whole = 2.0 / DOTS * np.ceil(0.5 * DOTS * whole)  # an even number of pixels, as films in MP4 need
        figure = self._figure
        figure.set_size_inches(float(whole[0]), float(whole[1]))
        self._ax.set_position((BESIDE / whole[0], BELOW / whole[1], width / whole[0], height / whole[1]))
        self._time.set_position((BESIDE / whole[0], 0.3 * BELOW / whole[1]))
        figure.text(
            BESIDE / whole[0], 1.0 - 0.4 * LINE / whole[1], "\n".join(lines), va="top", fontweight="bold", color=INK
        )
        if self._colours:
            left, tall = 2.0 * BESIDE + width, min(height, 3.2)
            self._bar.ax.set_position(
                (left / whole[0], (BELOW + 0.5 * (height - tall)) / whole[1], BAR[0] / whole[0], tall / whole[1])
            )

    def show(self, frame: int) -> None:
        """Update all artists to the saved time of index ``frame`` of the scene."""
        scene = self._scene
        centre = self._middle + (self._flat(scene.middle[frame]) if scene.follow else 0.0)
        self._ax.set_xlim(centre[0] - self._half[0], centre[0] + self._half[0])
        self._ax.set_ylim(centre[1] - self._half[1], centre[1] + self._half[1])
        self._time.set_text(f"{scene.axis[0]} {scene.times[frame]:.4g} {scene.axis[1]}")
        for i, line in self._lines.items():
            line.set_visible(scene.shapes[i].is_shown(frame))
            points = line_of(scene.shapes[i], self._flat(scene.shapes[i].points[frame]))  # of a wheel: rim and spoke
            line.set_segments(np.stack([points[:-1], points[1:]], axis=1))
            if self._colours:
                line.set_color(self._colour(scene.colours[i], frame, len(points) - 1))
        for i, mark in self._marks.items():
            mark.set_visible(scene.shapes[i].is_shown(frame))
            mark.set_data(*self._flat(scene.shapes[i].points[frame]).T)

    def _colour(self, values, frame, count):
        """Return the colours of ``count`` pieces of a line; grey if it has no values."""
        name, factor, mapping = self._colours
        if name not in values:
            return GREY
        own = values[name][frame] / factor  # one for each element of the line, which is several pieces if it bends
        return mapping.to_rgba(own[np.arange(count) * len(own) // count])
