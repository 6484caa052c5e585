"""Scene of an animation: shapes at some saved times, values for their colours, forces, the ground."""

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from mecano.errors import ResultsError
from mecano.model.mesh import piece_names
from mecano.post.deformation import Part, flexible_parts
from mecano.post.forces import Arrow, arrows
from mecano.post.ground import ground_path
from mecano.post.runs import Run
from mecano.post.shapes import (
    BEAM,
    BENDING,
    BODY,
    GEAR,
    GUIDE,
    JOINT,
    SUPPORT,
    WHEEL,
    Motion,
    Shape,
    radius_of,
    shapes,
    vertical,
    wheel_of,
)
from mecano.post.view_direction import eye

FAR = 3.0  # sizes: the view follows a mechanism that travels farther
GROUND = 3.0  # sizes of the mechanism by which the ground extends beyond the path of its wheels
Range: TypeAlias = tuple[str, str, float, float]  # name and unit of a colouring, lowest and highest value
STRESS, AXIAL = ("stress", "Pa"), ("axial force", "N")
"""Values by which elements can be coloured: name, unit."""
MOST_POINTS, FEWEST = 300_000, 60  # nodes times saved times that a page can hold in some megabytes; saved times
BENT, MOST_BENT = 4, 400  # lines per beam element; number of elements above which it is a single line
LOOKED_AT = 20  # number of instants from which the view direction is chosen


@dataclass(frozen=True)
class Orientation:
    """Rotation of a shape: unit quaternions (n, 4) since the start, and its axis (n, 3), or None."""

    turn: np.ndarray | None = None
    axis: np.ndarray | None = None
    radius: float = 0.0  # of a wheel [m]


@dataclass(frozen=True)
class Scene:
    """Data of the animation of a run.

    Attributes
    ----------
    rows : (n,) array of int
        Indices of the saved times.
    times : (n,) array
    axis : (str, str)
        Name and unit of the times: they may be load factors.
    shapes : list of Shape
    kinds : list of str
        Kind of the element or joint of each shape; "" for a node.
    colours : list of dict
        For each shape: name -> values (n, pieces).
    ranges : list of (name, unit, lowest, highest)
        Of all colourings.
    parts : list of Part
        Flexible parts, whose deformation can be magnified.
    orientations : list of Orientation
        Of each shape.
    arrows : list of Arrow
    middle : (n, 3) array
        Of the mechanism at each time [m].
    size : float
        Largest distance from the middle along an axis [m].
    up : (3,) array
        The vertical, against gravity: an inertial axis.
    eye : (3,) array
        Unit vector to the eye that sees the mechanism best.
    grounds : list of (2, k, 3) arrays
        The sides of a strip of each ground, along the path of its wheels [m].
    """

    rows: np.ndarray
    times: np.ndarray
    axis: tuple[str, str]
    shapes: list[Shape]
    kinds: list[str]
    colours: list[dict[str, np.ndarray]]
    ranges: list[Range]
    parts: list[Part]
    orientations: list[Orientation]
    arrows: list[Arrow]
    middle: np.ndarray
    size: float
    up: np.ndarray
    eye: np.ndarray
    grounds: list[np.ndarray]

    @property
    def followed(self) -> np.ndarray:
        """Inertial axes (3,) bool along which the mechanism travels so far that the view must follow it."""
        return np.ptp(self.middle, axis=0) > FAR * self.size


def scene_of(run: Run, most: int) -> Scene:
    """Return the Scene of a run with at most ``most`` saved times, fewer of a model of many nodes.

    Raises ResultsError if there is nothing to show.
    """
    count = len(run.results.time)
    if not count:
        raise ResultsError(f"{run.results.path}: no saved times yet")
    nodes = sum(path.startswith("nodes/") and path.endswith("/position") for path in run.paths)
    shown = min(count, most, max(FEWEST, MOST_POINTS // max(nodes, 1)))
    rows = np.unique(np.linspace(0, count - 1, shown).round().astype(int))
    motion = Motion(run, rows)
    drawn = [_smooth_line(motion, shape) for shape in shapes(motion)]
    if not drawn:
        raise ResultsError(f"{run.results.path}: nothing to be drawn, no node has a position")
    cloud = np.concatenate([s.points[:, -1:] if s.style == WHEEL else s.points for s in drawn], axis=1)
    middle = 0.5 * (cloud.min(axis=1) + cloud.max(axis=1))
    size = max(float(np.abs(s.points - middle[:, None]).max()) for s in drawn) or 1.0
    coloured = [_colours(run, shape, rows) for shape in drawn]
    ranges = list(_ranges(coloured))
    named = {what for what, *_ in ranges}
    coloured = [{what: values for what, values in colours.items() if what in named} for colours in coloured]
    flexible = {path.partition("/")[2] for path, d in run.things.items() if run.display(d).shape in BENDING}
    up = vertical(run.deck.get("gravity"))
    return Scene(
        rows, run.results.time[rows], (run.results.axis.path, run.results.axis.unit), drawn,
        [_kind(run, shape) for shape in drawn], coloured, ranges,
        flexible_parts(drawn, flexible, _attached(run, flexible)), [_orientation(motion, shape) for shape in drawn],
        arrows(motion), middle, size, up,
        _eye(drawn, cloud - middle[:, None], up), list(_grounds(run, drawn, GROUND * size)),
    )  # fmt: skip


def _deck_of(run, shape):
    """Return (path, deck values) of the element or joint of a shape; ("", {}) for a node."""
    sections = ("joints", "elements") if shape.style in (JOINT, SUPPORT, GUIDE, GEAR) else ("elements", "joints")
    paths = [f"{section}/{shape.name}" for section in sections]
    path = next((path for path in paths if path in run.things), "")
    return path, run.things.get(path, {})


def _kind(run, shape):
    return _deck_of(run, shape)[1].get("type", "node" if shape.style == SUPPORT else "")


def _smooth_line(motion, shape):
    """Return a beam as a smooth line, a cubic between two nodes with their directions; other shapes unchanged."""
    _, d = _deck_of(motion.run, shape)
    if not d or motion.run.display(d).shape != BEAM or len(motion.run.pieces) > MOST_BENT:
        return shape
    nodes, points = shape.nodes, shape.points
    u = np.linspace(0.0, 1.0, BENT, endpoint=False)[:, None]
    pieces = []
    for i, (a, b) in enumerate(zip(nodes[:-1], nodes[1:], strict=True)):
        chord = points[0, i + 1] - points[0, i]
        tangents = [motion.turned(node, chord)[:, None] for node in (a, b)]
        p, q = points[:, None, i], points[:, None, i + 1]
        pieces.append(
            (2 * u**3 - 3 * u**2 + 1) * p + (u**3 - 2 * u**2 + u) * tangents[0]
            + (3 * u**2 - 2 * u**3) * q + (u**3 - u**2) * tangents[1]
        )  # fmt: skip
    inner = ("",) * (BENT - 1)
    names = tuple(name for node in nodes[:-1] for name in (node, *inner)) + (nodes[-1],)
    return replace(shape, points=np.concatenate([*pieces, points[:, -1:]], axis=1), nodes=names)


def _attached(run, flexible):
    """Return the names of nodes of flexible parts that are fixed or attached to other parts."""
    held = {name for name, node in run.deck.get("nodes", {}).items() if node.get("fixed")}
    for path, d in run.things.items():
        section, _, name = path.partition("/")
        if section == "joints" or (section == "elements" and name not in flexible):
            held |= {*d.get("nodes", ()), d.get("node"), *d.get("attached", ())}
    return held


def _orientation(motion, shape):
    """Return the Orientation of a wheel, body or joint with an axis."""
    path, d = _deck_of(motion.run, shape)
    if shape.style == WHEEL:
        hub = shape.nodes[-1]
        return Orientation(motion.turn(hub), motion.turned(hub, d["axis"]), wheel_of(shape)[2])
    if shape.style == BODY:
        return Orientation(motion.turn(shape.nodes[0]))
    axis = d.get("axis") if path.startswith("joints/") and shape.style == JOINT else None
    if axis is None:
        return Orientation()
    node = next((node for node in d["nodes"] if f"nodes/{node}/rotation" in motion.run.paths), None)
    return Orientation() if node is None else Orientation(axis=motion.turned(node, axis))


def _eye(drawn, cloud, up):
    """Return the direction to the eye, chosen from some instants."""
    wheels = [wheel_of(shape) for shape in drawn if shape.style == WHEEL]
    some = np.unique(np.linspace(0, len(cloud) - 1, LOOKED_AT).round().astype(int))
    return eye(cloud[some], wheels, up)


def _colours(run, shape, rows):
    """Return the values by which an element can be coloured: name -> values (instants, pieces)."""
    d, found = run.deck.get("elements", {}).get(shape.name), {}
    for (what, _), output in ((STRESS, "stress"), (AXIAL, run.display(d).axial)) if d else ():
        paths = [f"elements/{piece}/{output}" for piece in piece_names(shape.name, d)]
        if output and all(path in run.paths for path in paths):
            values = np.stack([run.results.find(path).values[rows] for path in paths], axis=1)
            found[what] = values.reshape(*values.shape[:2], -1)[..., 0]
    return found


def _ranges(coloured):
    """Yield name, unit, lowest and highest value of each colouring that is not zero throughout."""
    for what, unit in (STRESS, AXIAL):
        arrays = [colours[what] for colours in coloured if what in colours]
        if any(array.any() for array in arrays):
            yield what, unit, min(float(a.min()) for a in arrays), max(float(a.max()) for a in arrays)


def _grounds(run, drawn, beyond):
    """Yield the sides (2, k, 3) of each ground along the path of its wheels and ``beyond`` [m] its ends."""
    wheels: dict[str, list[np.ndarray]] = {}  # ground -> points of its wheels
    for shape in drawn:
        d = run.deck.get("elements", {}).get(shape.name, {})
        if shape.style == WHEEL and "ground" in d:
            wheels.setdefault(d["ground"], []).append(shape.points)
    for ground, points in wheels.items():
        centres = np.stack([one[:, -1] for one in points])
        radius = max(radius_of(one[0]) for one in points)
        yield ground_path(run.deck, run.deck["grounds"][ground], centres, radius, beyond)
