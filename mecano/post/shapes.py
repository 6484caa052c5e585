"""The mechanism as lines in space at given instants: bodies, rods, springs, wheels, joints, supports.

Positions come from the file, the connectivity from the resolved deck.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mecano.constraints.triads import triad
from mecano.element_interface import RELEASES
from mecano.elements.joints.guiding_curve import drawn
from mecano.model.mesh import divided_nodes, inner_names
from mecano.post.belt_lines import belt_lines
from mecano.post.contact_outlines import outlines, surface_outlines
from mecano.post.curve_values import terms_of
from mecano.post.ground import plane_of
from mecano.post.lone_bodies import LoneBodies
from mecano.post.recovered import lines, nodes_inside, recovered

if TYPE_CHECKING:
    from mecano.post.mode_shapes import ModeMotion
    from mecano.post.runs import Run
    from mecano.schema import Values

BODY, MASS, ROD, SPRING, WHEEL, JOINT, SUPPORT = "body", "mass", "rod", "spring", "wheel", "joint", "support"
CABLE = "cable"  # a thin rod
GUIDE = "guide"  # a curve whose points do not count as places of the mechanism
GEAR = "gear"  # a pitch circle
RIM_POINTS = 49
AnyMotion: TypeAlias = "Motion | ModeMotion"


@dataclass(frozen=True)
class Shape:
    """A shape at some instants: ``points`` (instants, n, 3) [m]; the last point of a wheel or gear is its centre.

    ``nodes`` are the names of the nodes at the points, "" for other points; empty if no point is a node. ``shown``
    (instants,) bool is False after the release of the joint or element; None if it has no release.
    """

    style: str
    name: str
    points: np.ndarray
    nodes: tuple[str, ...] = ()
    shown: np.ndarray | None = None

    def at(self, instants: np.ndarray) -> "Shape":
        """Return the shape at some of its instants, given by their indices."""
        return replace(self, points=self.points[instants], shown=None if self.shown is None else self.shown[instants])

    def is_shown(self, i: int) -> bool:
        """Return whether the shape is shown at the instant of index ``i``."""
        return self.shown is None or bool(self.shown[i])


class Motion:
    """Positions of the nodes of a run at the saved times of the indices ``rows``."""

    def __init__(self, run: "Run", rows: slice | np.ndarray):
        self.run, self.rows = run, rows
        names = [name for path, d in run.things.items() for name in inner_names(path.partition("/")[2], d)]
        self.nodes = [name for name in [*run.deck.get("nodes", {}), *names] if f"nodes/{name}/position" in run.paths]

    def position(self, node: str) -> np.ndarray:
        """Return the positions (instants, 3) [m] of a node."""
        return self.vector(f"nodes/{node}/position")

    def path(self, node: str) -> np.ndarray:
        """Return the positions (saved times, 3) [m] of a node at all saved times."""
        return self.run.results.find(f"nodes/{node}/position").values

    def path_from(self, node: str, other: str) -> np.ndarray:
        """Return the positions (saved times, 3) [m] of the ``other`` node as seen from a node, relative to it.

        They are in inertial axes of the start, when the node has not turned yet.
        """
        turned = self.run.results.find(f"nodes/{node}/rotation").values
        material = _rotated(turned * (1, -1, -1, -1), self.path(other) - self.path(node))
        return _rotated(np.broadcast_to(turned[0], turned.shape), material)

    def vector(self, path: str) -> np.ndarray:
        """Return an output (instants, ...) of the file."""
        if isinstance(self.rows, slice):
            return self.run.results.find(path, self.rows).values
        return self.run.results.find(path).values[self.rows]

    def apart(self, nodes: Sequence[str], points: np.ndarray) -> bool:
        """Return whether nodes with ``points`` (instants, nodes, 3) [m] are apart at any instant."""
        return apart(points)

    def released(self, label: str) -> np.ndarray:
        """Return at which instants (instants,) the joint or element "hinge 'pin'" has been released."""
        times = [event.time for event in self.run.results.events if (event.element, event.name) == (label, RELEASES)]
        return self.run.results.time[self.rows] > min(times, default=np.inf)

    def inside(self, name: str, d: "Values") -> np.ndarray | None:
        """Return the positions (instants, n, 3) [m] of the nodes inside the superelement ``name``, or None."""
        if not nodes_inside(d) or f"elements/{name}/frame_origin" not in self.run.paths:
            return None
        return recovered(d, lambda output: self.vector(f"elements/{name}/{output}")).positions

    def turned(self, node: str, direction: Sequence[float] | np.ndarray) -> np.ndarray:
        """Return an inertial direction (3,) of the start, rotated with the node: (instants, 3)."""
        path = f"nodes/{node}/rotation"
        start = self.run.results.find(path, slice(1)).values
        carried = _rotated(start * (1, -1, -1, -1), np.array(direction, float)[None])
        return _rotated(self.vector(path), carried)

    def turn(self, node: str) -> np.ndarray:
        """Return the rotation of a node since the start, unit quaternions (instants, 4)."""
        path = f"nodes/{node}/rotation"
        w, u = np.split(self.vector(path), (1,), axis=1)
        w0, u0 = np.split(self.run.results.find(path, slice(1)).values * (1, -1, -1, -1), (1,), axis=1)
        return np.concatenate(
            [w * w0 - np.sum(u * u0, axis=1, keepdims=True), w * u0 + w0 * u + np.cross(u, u0)], axis=1
        )


def vertical(gravity: Sequence[float] | None) -> np.ndarray:
    """Return the inertial axis (3,) that points up, against most of the gravity; z without any."""
    if gravity is None or not any(gravity):
        return np.array([0.0, 0.0, 1.0])
    axis = int(np.argmax(np.abs(gravity)))
    return -np.sign(gravity[axis]) * np.eye(3)[axis]


def wheel_of(shape: Shape) -> tuple[np.ndarray, np.ndarray, float]:
    """Return centre (3,), axis (3,) and radius [m] of the Shape of a wheel at its first instant."""
    points = shape.points[0]
    return points[-1], np.cross(*(points[[0, RIM_POINTS // 4]] - points[-1])), radius_of(points)


def radius_of(points: np.ndarray) -> float:
    """Return the radius [m] of a wheel whose points (n, 3) end with its centre."""
    return float(np.linalg.norm(points[:-1] - points[-1], axis=1).max())


def apart(points: np.ndarray) -> bool:
    """Return whether ``points`` (instants, n, 3) [m] are apart at any instant."""
    return np.ptp(points, axis=1).max(initial=0.0) > 1e-9


def _rotated(quaternions, vectors):
    """Return R v for unit quaternions (n, 4) and vectors (1 or n, 3): v + 2 w (u x v) + 2 u x (u x v)."""
    w, u = quaternions[:, :1], quaternions[:, 1:]
    across = np.cross(u, vectors)
    return vectors + 2.0 * w * across + 2.0 * np.cross(u, across)


def shapes(motion: AnyMotion) -> list[Shape]:
    """Return all Shapes of the mechanism; supports and joints last, as they are drawn on top."""
    found, lone = [], LoneBodies(motion)
    for path, d in motion.run.things.items():
        section, _, name = path.partition("/")
        if shape := motion.run.display(d).shape or BY_DEFAULT.get(section):
            own = SHAPES[shape](motion, name, d)
            if shape == "body" and own and (own[0].style == MASS or d["node"] == lone.spacecraft):
                own = [_with_corners(own[0], lone.corners(d))]
            if own and d.get("release"):
                shown = ~motion.released(f"{d['type']} '{name}'")
                own = [replace(one, shown=shown) for one in own]
            found += own
    for name in motion.nodes:
        if motion.run.deck["nodes"].get(name, {}).get("fixed"):
            found.append(Shape(SUPPORT, name, motion.position(name)[:, None], (name,)))
    order = (WHEEL, GUIDE, GEAR, BODY, CABLE, ROD, SPRING, MASS, SUPPORT, JOINT)
    return sorted(found, key=lambda shape: order.index(shape.style))


def _body(motion, name, d):
    nodes = [node for node in dict.fromkeys([d["node"], *d.get("attached", ())]) if node in motion.nodes]
    points = [motion.position(node) for node in nodes]
    path = f"elements/{name}/center_of_mass"
    if path in motion.run.paths:
        centre = motion.vector(path)
        away = not points or np.abs(centre - points[0]).max(initial=0.0) > 1e-9
        if (len(points) < 2 and away) or _far(centre, points):
            points.append(centre)
            nodes.append("")
    if not points:
        return []
    return [Shape(BODY if len(points) > 1 else MASS, name, np.stack(points, axis=1), tuple(nodes))]


def _far(centre, points):
    """Return whether the centre of mass of a body is farther from all of its nodes than these from one another."""
    at = np.array([point[:1] for point in points]).reshape(-1, 3)
    if len(at) < 2 or not len(centre):
        return False
    spread = np.linalg.norm(at[:, None] - at, axis=2).max()
    return bool(np.linalg.norm(at - centre[0], axis=1).min() > max(spread, 1e-9))


def _with_corners(shape, corners):
    """Return the shape of a body with ``corners`` (instants, n, 3) around it, if it has some."""
    if corners is None:
        return shape
    points = np.concatenate([shape.points, corners], axis=1)
    return replace(shape, style=BODY, points=points, nodes=(*shape.nodes, *[""] * corners.shape[1]))


def _mass(motion, name, d):
    node = d["node"]
    return [Shape(MASS, name, motion.position(node)[:, None], (node,))] if node in motion.nodes else []


def _member(style, motion, name, d):
    """Return the line through all nodes of a member."""
    return _line(style, motion, name, {"nodes": divided_nodes(name, d)})


def _superelement(motion, name, d):
    """Return lines through the boundary nodes and, if the file has its coordinates, the inner nodes."""
    nodes = [node for node in d["nodes"] if f"nodes/{node}/position" in motion.run.paths]
    if len(nodes) < len(d["nodes"]):
        return []
    points = [motion.position(node) for node in nodes]
    inside = motion.inside(name, d)
    if inside is not None:
        points += list(np.moveaxis(inside, 1, 0))
        nodes += [""] * inside.shape[1]
    chains = [[i for i in chain if i < len(points)] for chain in lines(d)]
    return [
        Shape(ROD, name, np.stack([points[i] for i in chain], axis=1), tuple(nodes[i] for i in chain))
        for chain in chains
        if len(chain) > 1
    ]


def _belt(motion, name, d):
    return [Shape(CABLE, name, points) for points in belt_lines(motion, d)]


def _line(style, motion, name, d):
    """Return the line of any element between two nodes."""
    nodes = [node for node in d.get("nodes", ()) if node in motion.nodes]
    if len(nodes) < 2:
        return []
    points = np.stack([motion.position(node) for node in nodes], axis=1)
    return [Shape(style, name, points, tuple(nodes))] if motion.apart(nodes, points) else []


def _spring(motion, name, d):
    """Return the line of a spring, or nothing for one without a force, which only measures a length."""
    return [] if _is_gauge(motion.run.deck, d) else _line(SPRING, motion, name, d)


def _actuator(motion, name, d):
    """Return the line of a cylinder or jack, or nothing for the attraction of bodies that no joint holds."""
    return _line(ROD, motion, name, d) if motion.run.deck.get("joints") else []


def _is_gauge(deck, d):
    """Return whether all numbers of the law of a spring are zero."""
    terms = terms_of(deck, d.get("law"))
    return bool(terms) and not any(any(values.values()) for _, values in terms)


def _joint(motion, name, d):
    """Return a dot at the position of a joint, with a support if it joins the ground."""
    nodes = d.get("nodes", ())
    moving = [node for node in nodes if node in motion.nodes]
    if not moving:
        return []
    points = motion.position(moving[-1])[:, None]
    held = len(moving) < len(nodes) and motion.run.display(d).support and not _slides(d)
    support = [Shape(SUPPORT, name, points[:1].repeat(len(points), axis=0))] if held else []
    return [*support, Shape(JOINT, name, points, (moving[-1],))]


def _slides(d):
    """Return whether a generic joint leaves or drives a displacement."""
    moved = [*d.get("free", ()), *(axis for key in ("driven", "driven_rates") for axis in d.get(key) or ())]
    return any(axis.startswith("along") for axis in moved)


def _curve(motion, name, d):
    """Return the curve, moved with its node, and a dot at the point on it."""
    (a, b), points = d["nodes"], drawn(d)
    if b not in motion.nodes:
        return []
    dot = motion.position(b)[:, None]
    if a in motion.run.deck["nodes"]:
        start = np.array(motion.run.deck["nodes"][a]["position"], float)
        carried = np.stack([motion.turned(a, point - start) for point in points], axis=1)
        points = motion.position(a)[:, None] + carried
    return [Shape(GUIDE, name, np.broadcast_to(points, (len(dot), *points.shape[-2:]))), Shape(JOINT, name, dot)]


def _contact(motion, name, d):
    return [Shape(GUIDE, name, points) for points in outlines(motion, d)]


def _wheel(motion, name, d):
    if d["node"] not in motion.nodes:
        return []
    rim = _flattened(_tread(motion, d, d["node"]), motion.run.deck["grounds"][d["ground"]])
    return [_round(motion, WHEEL, name, rim, d["node"])]


def _wheel_on_body(motion, name, d):
    hub = d["nodes"][1]
    radius = motion.run.deck["tire_laws"][d["tire_law"]]["radius"]
    surface = [Shape(GUIDE, name, line) for line in surface_outlines(motion, d, radius)]
    return [*surface, _round(motion, WHEEL, name, _tread(motion, d, hub), hub)] if hub in motion.nodes else []


def _gears(motion, name, d):
    """Return the pitch circles, given by their radii, of a gear pair or of the pinion of a rack."""
    axis, nodes = d.get("axis", d.get("axis_a")), d["nodes"]
    circles = (
        (nodes[1], axis, d.get("radius", d.get("radius_a"))),
        (nodes[-1], d.get("axis_b") or axis, d.get("radius_b")),
    )
    return [
        _round(motion, GEAR, name, _rim(motion, node, own, radius), node)
        for node, own, radius in circles
        if radius is not None and node in motion.nodes
    ]


def _tread(motion, d, node):
    """Return points (instants, RIM_POINTS, 3) of the undeformed tread of a wheel."""
    radius = d["radius"] if "radius" in d else motion.run.deck["tire_laws"][d["tire_law"]]["radius"]
    return _rim(motion, node, d["axis"], radius)


def _rim(motion, node, axis, radius):
    """Return points (instants, RIM_POINTS, 3) of a circle about an axis fixed in a node, inertial at the start."""
    mu_1, mu_2, _ = triad(axis)
    e1, e2 = motion.turned(node, mu_2), motion.turned(node, -mu_1)
    angle = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS)[:, None]
    return motion.position(node)[:, None] + radius * (np.cos(angle) * e1[:, None] + np.sin(angle) * e2[:, None])


def _round(motion, style, name, rim, node):
    """Return the Shape of a rim and its centre."""
    points = np.concatenate([rim, motion.position(node)[:, None]], axis=1)
    return Shape(style, name, points, ("",) * RIM_POINTS + (node,))


def _flattened(points, ground):
    """Return the points, with those below a flat ground raised onto it."""
    if ground.get("profile"):
        return points
    point, normal = plane_of(ground)
    depth = np.maximum(0.0, (point - points) @ normal)
    return points + depth[..., None] * normal


BY_DEFAULT = {"elements": "line", "joints": "joint"}  # shapes of the kinds of a section; loads have none
BEAM, SUPERELEMENT = "beam", "superelement"
BENDING = (BEAM, SUPERELEMENT)
SHAPES: dict[str, Callable[[AnyMotion, str, "Values"], list[Shape]]] = {
    "line": partial(_line, ROD), "cable": partial(_member, CABLE), "spring": _spring,
    "actuator": _actuator,
    "belt": _belt, BEAM: partial(_member, ROD), SUPERELEMENT: _superelement,
    "body": _body, "mass": _mass, "wheel": _wheel, "wheel_on_body": _wheel_on_body, "curve": _curve,
    "contact": _contact, "gears": _gears, "joint": _joint,
    "nothing": lambda motion, name, d: [],
}  # fmt: skip
"""Functions that draw each ``Display.shape``."""
