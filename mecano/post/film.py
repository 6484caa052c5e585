"""Films of a motion, GIF, WebP or MP4: the mechanism as in pictures, seen from a fixed direction."""

import os
import subprocess
from pathlib import Path
from textwrap import wrap

import matplotlib
import numpy as np
from matplotlib import animation, cm
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from mecano.errors import ResultsError, UsageError
from mecano.post.draw_sketch import colours_of, draw_shapes, draw_way
from mecano.post.ground import bars_across
from mecano.post.runs import opened_runs
from mecano.post.scene import Scene, scene_of
from mecano.post.sketch import sketch
from mecano.post.style import GREY, INK, PALE, SETTINGS, shown_unit, with_unit
from mecano.post.view_direction import projection
from mecano.results.whole_file import atomic_file, make_folder

WRITERS = {".gif": "pillow", ".webp": "pillow", ".mp4": "ffmpeg"}
FRAMES, PER_SECOND = 150, 15
SIZE, DOTS = (5.4, 3.9), 120  # inches of the largest view, per inch
NARROWEST, LOWEST = 2.6, 1.3  # inches of a view
BESIDE, BAR, BELOW = 0.15, (0.12, 0.65), 0.3  # inches beside the view; of the colours and their numbers; of the time
LETTER, LINE = 0.085, 0.2  # inches of the title
MARGIN = 1.08
PITCH = 0.4  # of the larger half width of the view: distance of the lines behind it, at most
COLOURS = "viridis"
SHORTEST = np.array([0.6, 0.2])  # width over height of the view, and height over width: a strut is a line, too


def film(path: str | os.PathLike[str], target: str | os.PathLike[str], title: str | None = None) -> Path:
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
    with (
        opened_runs([path]) as [run],
        matplotlib.rc_context(SETTINGS | {"grid.color": PALE}),
        atomic_file(target) as hidden,
    ):
        scene, side = scene_of(run, FRAMES), sketch(run)
        matrix = side.projection if side else projection(scene.eye, scene.up)
        _write(scene, matrix, hidden, writer, title or run.title)
    return target


def _write(scene, matrix, target, writer, title):
    figure = Figure()
    figure.set_layout_engine("none")  # computing the layout for each frame would take half of the time
    picture = _Picture(scene, matrix, figure)
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
    """A figure of the film: what stays from frame to frame, and the shapes drawn at each."""

    def __init__(self, scene: Scene, matrix: np.ndarray, figure: Figure):
        self._scene, self._matrix = scene, matrix
        self._figure, self._ax = figure, (ax := figure.add_subplot())
        self._limits()
        ax.set_aspect("equal")
        ax.tick_params(length=0, labelbottom=False, labelleft=False)
        ax.spines[:].set_visible(False)
        pitch = _round_length(PITCH * self._half.max())
        for axis in (ax.xaxis, ax.yaxis):
            axis.set_major_locator(MultipleLocator(pitch))
        ax.grid(not scene.grounds)
        for sides in scene.grounds:
            draw_way(ax, self._flat(sides), self._flat(bars_across(sides, pitch)))
        self._time = figure.text(0.0, 0.0, "", color=INK)
        self._scale = figure.text(0.0, 0.0, f"lines every {pitch:g} m", color=GREY, ha="right")
        self._plain = colours_of(scene.shapes)
        self._colours = self._coloured()
        self._still = set(ax.get_children())

    def _flat(self, points):
        return points @ self._matrix.T

    def _limits(self):
        """Set centre and half widths of the view: of the motion, apart from that along axes that the view follows."""
        self._shift = self._scene.middle * self._scene.followed
        points = np.concatenate([s.points - self._shift[:, None] for s in self._scene.shapes], axis=1)
        flat = self._flat(points).reshape(-1, 2)
        low, high = flat.min(axis=0), flat.max(axis=0)
        self._middle, self._half = 0.5 * (low + high), half_widths(high - low)

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
        self._scale.set_position(((BESIDE + width) / whole[0], 0.3 * BELOW / whole[1]))
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
        centre = self._middle + self._flat(self._shift[frame])
        self._ax.set_xlim(centre[0] - self._half[0], centre[0] + self._half[0])
        self._ax.set_ylim(centre[1] - self._half[1], centre[1] + self._half[1])
        self._time.set_text(f"{scene.axis[0]} {scene.times[frame]:.4g} {scene.axis[1]}")
        for artist in set(self._ax.get_children()) - self._still:
            artist.remove()
        shapes = [shape for shape in scene.shapes if shape.is_shown(frame)]
        draw_shapes(self._ax, [(s, self._flat(s.points[frame])) for s in shapes], self._colours_at(frame))

    def _colours_at(self, frame):
        """Return name -> colour, or colours (m, 4) of pieces, of all shapes; grey of those without values."""
        if not self._colours:
            return self._plain
        name, factor, mapping = self._colours
        values = zip(self._scene.shapes, self._scene.colours, strict=True)
        known = {shape.name: mapping.to_rgba(own[name][frame] / factor) for shape, own in values if name in own}
        return dict.fromkeys(self._plain, GREY) | known


def _round_length(most):
    """Return the largest of 1, 2, 5 times a power of ten that is no longer than ``most`` [m]."""
    power = 10.0 ** np.floor(np.log10(most))
    return max(power * factor for factor in (1, 2, 5) if power * factor <= most)
