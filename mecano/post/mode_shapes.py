"""Pictures of modes: the mechanism at some phase angles of each motion, from the file of modes only."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from types import SimpleNamespace
from typing import TYPE_CHECKING, NoReturn

import matplotlib
import numpy as np

from mecano.errors import ResultsError
from mecano.post.draw_sketch import draw_sketch
from mecano.post.figure import plain_figure
from mecano.post.runs import SECTIONS
from mecano.post.shapes import apart, shapes, vertical
from mecano.post.sketch import Sketch
from mecano.post.style import SETTINGS
from mecano.post.view_direction import eye, projection
from mecano.results.modes_file import ModesFile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mecano.schema import Values

HARDLY = 0.05  # of the largest motion: displacements that hardly count beside rotations
AMPLITUDE = 0.12  # of the size of the mechanism
MOST_TURN = 1.2  # rad: largest rotation of what is drawn as turning, as a wheel
TURNING = ("wheel", "wheel_on_body", "gears", "contact", "curve")
LONGEST_TITLE = 44  # characters in a line
PHASES = np.radians((180.0, 135.0, 90.0, 45.0, 0.0))  # the last one, drawn darkest, is the real part
MOTION_COUNTS = 0.5  # weight of motion over extent in the choice of the plane, each relative to its largest
COLUMNS, PANEL = 3, (4.2, 3.2)  # inches
NO_SHAPES = "nothing moves, so there are no shapes to draw"


@dataclass(frozen=True)
class ModeMotion:
    """The motion of one mode, with the interface of ``shapes.Motion``: positions of nodes at PHASES."""

    run: SimpleNamespace  # deck, things, paths
    file: ModesFile  # ModesFile
    mode: int
    amplitude: float

    @cached_property
    def nodes(self) -> list[str]:
        """Names of the nodes, including those of divided members."""
        return list(self.file.nodes)

    @cached_property
    def _turns(self):
        return self.amplitude * np.exp(1j * PHASES)

    def position(self, node: str) -> np.ndarray:
        """Return the positions (phases, 3) [m] of a node."""
        values = self.file.nodes[node]
        return values["position"] + np.real(self._turns[:, None] * values["translation"][self.mode])

    def path(self, node: str) -> np.ndarray:
        """Return the positions (phases, 3) [m] of a node."""
        return self.position(node)

    def path_from(self, node: str, other: str) -> np.ndarray:
        """Return the positions (phases, 3) [m] of the ``other`` node relative to a node, whose rotation is small."""
        return self.position(other) - self.position(node)

    def apart(self, nodes: Sequence[str], points: np.ndarray) -> bool:
        """Return whether nodes with ``points`` (phases, nodes, 3) [m] are apart at any phase."""
        return apart(points)

    def released(self, label: str) -> np.ndarray:
        """Return (phases,) whether the joint or element "hinge 'pin'" has been released in the state of the modes."""
        return np.full(len(PHASES), label in self.file.released)

    def inside(self, name: str, d: "Values") -> np.ndarray | None:
        """Return the positions (phases, n, 3) [m] of the nodes inside the superelement ``name``, or None."""
        values = self.file.inner.get(name)
        if values is None:
            return None
        return values["position"] + np.real(self._turns[:, None, None] * values["translation"][self.mode])

    def turned(self, node: str, direction: Sequence[float] | np.ndarray) -> np.ndarray:
        """Return an inertial direction (3,) of the state, rotated with the node by finite angles: (phases, 3)."""
        rotation = np.real(self._turns[:, None] * self.file.nodes[node]["rotation"][self.mode])
        angle = np.linalg.norm(rotation, axis=1, keepdims=True)
        axis = rotation / np.where(angle > 0.0, angle, 1.0)
        across = np.cross(axis, direction)
        return direction + np.sin(angle) * across + (1.0 - np.cos(angle)) * np.cross(axis, across)

    def vector(self, path: str) -> NoReturn:
        """Raise ResultsError, as a file of modes has no outputs."""
        raise ResultsError(f"'{path}' is not in a file of modes")


def mode_sketches(file: ModesFile) -> list[Sketch]:
    """Return a Sketch for each mode of a ModesFile at PHASES, with ``amplitude_of``."""
    things = {f"{s}/{name}": d for s in SECTIONS for name, d in file.resolved.get(s, {}).items()}
    paths = frozenset(f"nodes/{name}/position" for name in file.nodes)
    run = SimpleNamespace(deck=file.resolved, things=things, paths=paths, display=lambda d: file.displays[d["type"]])
    return [_sketch(run, file, mode) for mode in range(len(file.values))]


def amplitude_of(file: ModesFile, mode: int) -> float:
    """Return the factor of a shape by which its largest displacement is AMPLITUDE of the size of the mechanism.

    It is less where a wheel would turn by more than MOST_TURN.
    """
    positions, moves = _places_and_moves(file, mode)
    size = float(np.linalg.norm(np.ptp(positions, axis=0))) or 1.0
    largest = float(np.abs(moves).max(initial=0.0))
    amplitude = AMPLITUDE * size / largest if largest > 1e-6 else 2.0 * AMPLITUDE
    return min(amplitude, MOST_TURN / max(_largest_turn(file, mode), 1e-9))


def _places_and_moves(file, mode):
    """Return the positions (n, 3) of all nodes, those inside superelements included, and their shape (n, 3)."""
    inner = file.inner.values()
    positions = np.concatenate([[node["position"] for node in file.nodes.values()], *(n["position"] for n in inner)])
    moves = np.concatenate(
        [[node["translation"][mode] for node in file.nodes.values()], *(n["translation"][mode] for n in inner)]
    )
    return positions, moves


def _sketch(run, file, mode):
    """Return the Sketch of a mode in the plane of largest motion and extent, or in space if it moves across that."""
    positions, moves = _places_and_moves(file, mode)
    amplitude = amplitude_of(file, mode)
    drawn = tuple(shapes(ModeMotion(run, file, mode, amplitude)))
    motion = [amplitude * np.abs(moves).max(axis=0), *(0.5 * np.ptp(s.points, axis=0).max(axis=0) for s in drawn)]
    moved = np.max(motion, axis=0)
    seen = _relative(np.ptp(positions, axis=0)) + MOTION_COUNTS * _relative(moved)
    first, second, across = map(int, np.argsort(-seen, kind="stable"))
    axes, view = tuple(sorted((first, second))), None
    if moved[across] > moved[[first, second]].max():
        up, points = vertical(file.resolved.get("gravity")), np.concatenate([s.points for s in drawn], axis=1)
        axes, view = (), projection(eye(points, up=up), up)
    return Sketch("", axes, np.degrees(PHASES), drawn, np.zeros((len(PHASES), 2)), (), (), view=view)


def _relative(extents):
    """Return extents (3,) relative to the largest one."""
    return extents / (extents.max() or 1.0)


def _largest_turn(file, mode):
    """Return the largest rotation of a node with something drawn as TURNING, in the scale of the mode."""
    things = [d for section in SECTIONS for d in file.resolved.get(section, {}).values()]
    turning = [d for d in things if file.displays[d["type"]].shape in TURNING]
    nodes = {node for d in turning for node in (d.get("node"), *d.get("nodes", ())) if node in file.nodes}
    return max((float(np.linalg.norm(file.nodes[node]["rotation"][mode])) for node in nodes), default=0.0)


def _title(file, mode):
    """Return the title of a mode, with the node that turns in a second line if one is too short for it."""
    text, turns = named_mode(file, mode) + ("" if file.converged[mode] else ", not converged"), _turning(file, mode)
    return text + (turns if len(text + turns) <= LONGEST_TITLE else turns.replace(", ", ",\n", 1))


def _turning(file, mode):
    """Return the node that turns most if nothing moves as far: the twist of a line of beams cannot be seen."""
    moves, turns = (
        {name: float(np.linalg.norm(node[what][mode])) for name, node in file.nodes.items()}
        for what in ("translation", "rotation")
    )
    if not turns or file.kinds[mode] == "free" or max(moves.values()) > HARDLY or not any(turns.values()):
        return ""
    return f", {max(turns, key=lambda name: turns[name])} turns"


def named_mode(file: ModesFile, mode: int) -> str:
    """Return the number of a mode with its frequency and damping, or its kind, as text."""
    numbers = file.numbers
    if file.kinds[mode] == "free":
        return f"mode {mode + 1}: free"
    if file.kinds[mode] in ("decay", "divergence"):
        return f"mode {mode + 1}: {file.kinds[mode]}, {numbers['real_part'][mode]:.4g} /s"
    text = f"mode {mode + 1}: {numbers['frequency'][mode]:.5g} Hz"
    ratio = numbers["damping_ratio"][mode]
    text += f", damping {ratio:.3g}" if abs(ratio) > 1e-9 else ""
    return text + (", flutter" if file.kinds[mode] == "flutter" else "")


def modes_figure(file: ModesFile) -> "Figure":
    """Return the figure of all modes of a ModesFile. Raises ResultsError if it has none."""
    if not len(file.values):
        raise ResultsError(f"{file.path}: {NO_SHAPES}")
    sketches = mode_sketches(file)
    columns = min(COLUMNS, len(sketches))
    rows = math.ceil(len(sketches) / columns)
    with matplotlib.rc_context(SETTINGS):
        title, heading = file.title or file.path.stem, f"modes about: {file.about}"
        figure = plain_figure(columns * PANEL[0], rows * PANEL[1], title, heading)
        grid = figure.add_gridspec(rows, columns)
        for i, sketch in enumerate(sketches):
            ax = figure.add_subplot(grid[i // columns, i % columns])
            draw_sketch(ax, sketch, _title(file, i), named=False)
    return figure
