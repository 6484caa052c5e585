"""Drawing of a side view of the mechanism into axes of matplotlib."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.text import OffsetFrom

from mecano.post.shapes import BODY, CABLE, GEAR, GUIDE, JOINT, MASS, ROD, SPRING, SUPPORT, WHEEL
from mecano.post.style import COLOURS, GREY, INK, PALE, legend_above, note_below

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from matplotlib.axes import Axes

    from mecano.post.shapes import Shape
    from mecano.post.sketch import Sketch

LETTERS = "xyz"
BESIDE = (-28.0, 20.0)  # points, of the compass, where the first instant is in the corner
FAINTEST = 0.12  # opacity of the first instant if instants are superimposed
COILS = 5
MOST_NAMES = 8
MOST_PARTS = 24  # coloured one by one
NARROW, WIDE = 3.7, 8.0  # inches, of axes
LABEL_WIDTH = 0.6  # inches, of the time of an instant
MOST_DOTS = 60  # joints drawn as dots; more would hide the mechanism
MASS_SIZE, JOINT_SIZE, SUPPORT_SIZE = 7.0, 4.0, 20.0  # points
GROUND = "#c8b89a"
FLAT, HATCH = 1e-3, 0.35  # width over length of a ground that is seen from the side; length of its hatch over its pitch
TRIANGLE = ((0.0, 0.0), (-0.6, -1.0), (0.6, -1.0))


def draw_sketch(ax: "Axes", sketch: "Sketch", title: str = "", named: bool = True) -> None:
    """Draw ground, paths, and the shapes at all instants, later ones darker if superimposed.

    ``named``: add a legend and the span of the instants.
    """
    colours = colours_of(sketch.shapes)
    for line in sketch.grounds:
        _draw_ground(ax, line) if sketch.axes else draw_patch(ax, line)
    for path in sketch.paths:
        ax.plot(*path.T, color=PALE, linewidth=0.8, zorder=1)
    count = len(sketch.times)
    for i in range(count):
        opacity = FAINTEST + (1.0 - FAINTEST) * (i / max(count - 1, 1)) ** 2 if sketch.in_place else 1.0
        placed = [(shape, sketch.flat(shape.points[i], i)) for shape in sketch.shapes if shape.is_shown(i)]
        draw_shapes(ax, placed, colours, opacity)
    ax.set_aspect("equal", adjustable="datalim" if sketch.in_place else "box")
    ax.margins(0.05, 0.08)
    if sketch.axes:
        ax.set_ylabel(f"{LETTERS[sketch.axes[1]]} [m]")
    else:
        draw_compass(ax, sketch.projection, *([] if sketch.in_place else [BESIDE]))
    taken = _draw_legend(ax, colours, sketch) if named else 0.0
    ax.set_title(title, loc="left", pad=4 + taken)
    if sketch.in_place:
        if sketch.axes:
            ax.set_xlabel(f"{LETTERS[sketch.axes[0]]} [m]")
        unit = sketch.axis[1]
        span = f"{sketch.times[0]:.3g} to {sketch.times[-1]:.3g}"
        text = f"{span}{' ' * bool(unit)}{unit}, earlier is fainter"
        note_below(ax, text if count > 1 and named else "")
    else:
        _label_instants(ax, sketch)


def colours_of(shapes: "Sequence[Shape]") -> dict[str, str]:
    """Return the colours of all named shapes except joints and supports: name -> colour."""
    keys = _coloured(shapes)
    order = list(dict.fromkeys(keys.values()))
    return {name: COLOURS[order.index(key) % len(COLOURS)] for name, key in keys.items()}


def _coloured(shapes):
    """Return {name: what its colour means}: the name itself; of more than MOST_PARTS names, the style."""
    styles = {s.name: s.style for s in shapes if s.style not in (JOINT, SUPPORT)}
    return styles if len(styles) > MOST_PARTS else {name: name for name in styles}


def draw_shapes(
    ax: "Axes",
    placed: "Sequence[tuple[Shape, np.ndarray]]",
    colours: "Mapping[str, str | np.ndarray]",
    opacity: float = 1.0,
) -> None:
    """Draw shapes at one instant, each with its points (n, 2) in the picture.

    ``colours``: name -> colour, or colours (m, 4) of the pieces of a line.
    """
    few = sum(shape.style == JOINT for shape, _ in placed) <= MOST_DOTS
    rods: list[tuple] = []
    for shape, points in placed:
        colour = colours.get(shape.name, INK)
        if shape.style in RODS:
            rods += _pieces(points, colour)
        elif few or shape.style != JOINT:
            DRAW[shape.style](ax, points, colour if isinstance(colour, str) else colour[0], opacity)
    _draw_rods(ax, rods, opacity)


def _pieces(points, colour):
    """Return (points, colour) of the parts of a line, which is one part if it has one colour."""
    if isinstance(colour, str):
        return [(points, colour)]
    count = len(points) - 1
    return [(points[k : k + 2], colour[k * len(colour) // count]) for k in range(count)]


def _draw_legend(ax, colours, sketch):
    """Draw the legend, and return its height in points."""
    meanings = {key: colours[name] for name, key in _coloured(sketch.shapes).items()}
    if not 1 < len(meanings) <= MOST_NAMES:
        return 0.0
    handles = [Line2D([], [], color=colour, linewidth=3, label=text) for text, colour in meanings.items()]
    return legend_above(ax, handles, WIDE if sketch.wide else NARROW)


def _label_instants(ax, sketch):
    """Label the side-by-side view with as many times as fit, instead of a horizontal coordinate."""
    middles = []
    for i in range(len(sketch.times)):
        x = np.concatenate([sketch.flat(shape.points[i], i)[:, 0] for shape in sketch.shapes])
        middles.append(0.5 * (x.min() + x.max()))
    width, height = ax.get_position().size * ax.get_figure().get_size_inches()  # before layout, which changes it little
    pitch = min(width, height / max(sketch.aspect, 1e-9)) / len(middles)
    every = max(1, int(np.ceil(LABEL_WIDTH / pitch)))
    for i, t in list(enumerate(sketch.times))[::every]:
        place = (middles[i], 0.0)
        ax.annotate(f"{t:.3g} {sketch.axis[1]}", place, xycoords=ax.get_xaxis_transform(), xytext=(0, -4),
                    textcoords="offset points", ha="center", va="top", fontsize=8)  # fmt: skip
    ax.set_xticks([])
    ax.spines["bottom"].set_visible(False)


def draw_patch(ax: "Axes", outline: np.ndarray) -> None:
    """Draw a piece of ground with an ``outline`` (k, 2) in a view in space."""
    ax.fill(*outline.T, color="#efe9dd", zorder=0.5, linewidth=0)
    ax.plot(*outline.T, color=GROUND, zorder=0.6, linewidth=0.7)


def draw_compass(ax: "Axes", projection: np.ndarray, centre: tuple[float, float] = (20.0, 20.0)) -> None:
    """Draw the inertial axes of a view that has no coordinates of its own, ``centre`` [points] from its lower left."""
    ax.set_axis_off()
    corner = OffsetFrom(ax.transAxes, (0.0, 0.0))
    for letter, end in zip(LETTERS, projection.T, strict=True):
        if not end.any():  # along the line of sight
            continue
        beyond = np.add(centre, (16 + 7 / np.hypot(*end)) * end)
        ax.annotate(letter, beyond, xycoords=corner, ha="center", va="center", fontsize=8, color=GREY)
        line = {"arrowstyle": "-", "color": GREY, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
        ax.annotate("", np.add(centre, 16 * end), xycoords=corner, xytext=centre, textcoords=corner, arrowprops=line)


def draw_way(ax: "Axes", sides: np.ndarray, bars: np.ndarray) -> None:
    """Draw the ground between two lines, ``sides`` (2, k, 2), with ``bars`` (n, 2, 2) across; from the side, a line."""
    colour = GROUND
    if np.abs(sides[1] - sides[0]).max() > FLAT * np.ptp(sides, axis=(0, 1)).max():
        draw_patch(ax, np.concatenate([sides[0], sides[1, ::-1], sides[0, :1]]))
    else:
        colour, depth = GREY, HATCH * np.ptp(bars[:2, 0], axis=0).max()
        ax.plot(*sides[0].T, color=GREY, linewidth=1.2, zorder=1)
        bars = bars[:, :1] - np.array([(0.0, 0.0), (depth, depth)])
    ax.add_collection(LineCollection(list(bars), colors=colour, linewidths=1.0, zorder=0.7))


def _draw_ground(ax, line):
    ax.plot(*line.T, color=GREY, linewidth=1.0, zorder=1)
    depth = 0.04 * np.ptp(line[:, 0])
    ax.fill_between(line[:, 0], line[:, 1], line[:, 1] - depth, color="#eeeeee", zorder=0.5, linewidth=0)


def _draw_body(ax, points, colour, opacity):
    """Draw a body as a line between two points, or as the convex outline of more."""
    if len(points) == 2:
        ax.plot(*points.T, color=colour, alpha=opacity, linewidth=2.6, solid_capstyle="round", zorder=3)
        return
    outline = hull(points)
    ax.fill(*outline.T, color=colour, alpha=0.2 * opacity, linewidth=0, zorder=2.5)
    ax.plot(*np.vstack([outline, outline[:1]]).T, color=colour, alpha=opacity, linewidth=2.0, zorder=3)


def _draw_rods(ax, rods, opacity):
    """Draw all rods as one collection, as separate lines take a millisecond each."""
    if rods:
        lines, drawn = map(list, zip(*rods, strict=True))  # two colours in a tuple are one colour and its opacity
        ax.add_collection(LineCollection(lines, colors=drawn, alpha=opacity, linewidths=1.4, capstyle="projecting",
                                         joinstyle="round", zorder=3))  # fmt: skip


def _draw_spring(ax, points, colour, opacity):
    ax.plot(*zigzag(points).T, color=colour, alpha=opacity, linewidth=1.2, zorder=3.2)


def _draw_mass(ax, points, colour, opacity):
    ax.plot(*points[0], "o", color=colour, alpha=opacity, markersize=MASS_SIZE, markeredgewidth=0, zorder=3.5)


def _draw_wheel(ax, points, colour, opacity):
    """Draw the rim of a wheel and a spoke, which shows its rotation."""
    rim, centre = points[:-1], points[-1]
    ax.fill(*rim.T, color=colour, alpha=0.15 * opacity, linewidth=0, zorder=2)
    ax.plot(*rim.T, color=colour, alpha=opacity, linewidth=1.8, zorder=2.2)
    ax.plot(*np.stack([centre, rim[0]]).T, color=colour, alpha=opacity, linewidth=0.9, zorder=2.2)


def _draw_joint(ax, points, colour, opacity):
    ax.plot(*points[0], "o", color=INK, alpha=opacity, markersize=JOINT_SIZE, markerfacecolor="white", zorder=4)


def _draw_support(ax, points, colour, opacity):
    if opacity == 1.0:
        ax.plot(*points[0], marker=TRIANGLE, color=GREY, markersize=SUPPORT_SIZE, markeredgewidth=0, zorder=2.8)


RODS = (ROD, CABLE, GUIDE, GEAR)
DRAW = {
    BODY: _draw_body,
    MASS: _draw_mass,
    SPRING: _draw_spring,
    WHEEL: _draw_wheel,
    JOINT: _draw_joint,
    SUPPORT: _draw_support,
}


def hull(points: np.ndarray) -> np.ndarray:
    """Return the convex outline (m, 2), counter-clockwise, of points (n, 2)."""
    ordered = sorted(map(tuple, points))

    def half(sequence):
        chain: list[tuple] = []
        for p in sequence:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= 0.0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return np.array(half(ordered) + half(ordered[::-1]) or ordered[:1])


def _turn(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def zigzag(points: np.ndarray) -> np.ndarray:
    """Return a zigzag line (n, 2) between two points (2, 2), with straight ends and coils 0.1 of its length high."""
    (a, b), count = points, 2 * COILS
    along = b - a
    across = 0.1 * np.array([-along[1], along[0]])
    u = np.concatenate([[0.0], np.linspace(0.2, 0.8, count + 1), [1.0]])
    height = np.concatenate([[0.0, 0.0], np.tile([1.0, -1.0], COILS)[:-1], [0.0, 0.0]])
    return a + u[:, None] * along + height[:, None] * across
