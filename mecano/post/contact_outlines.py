"""Outlines of a contact as lines in space: the ball, and the surface on which it may lie."""

import numpy as np

from mecano.constraints.touching import given

POINTS = 49  # of a circle
BEYOND = 2.0  # radii of the ball, or this
LEAST = 0.05  # share of the way of the ball, by which a plane is drawn beyond


def outlines(motion, d):
    """Return lines [(instants, n, 3)] of the contact with the deck values ``d`` in a Motion (shapes.py)."""
    (a, b), (name, surface) = d["nodes"], given(d)
    if b not in motion.nodes:
        return []
    x, middle = motion.position(b), surface.get("point", surface.get("center"))
    at = motion.run.deck["nodes"][a]["position"] if a in motion.nodes else np.zeros(3)
    middle = np.array(at if middle is None else middle, float)
    main = np.array(surface.get("normal", surface.get("axis", x[0] - middle)), float)
    main /= np.linalg.norm(main)
    across = main if name == "cylinder" else _across(main, np.ptp(x, axis=0))
    along = np.cross(across, _across(main, np.zeros(3)) if name == "cylinder" else main)
    if name == "plane":
        way = np.abs((x - middle) @ along).max()
        line = np.array([-1.0, 1.0])[:, None] * (max(BEYOND * d["radius"], LEAST * way) + way) * along
    else:
        line = _stadium(surface["radius"], surface.get("length", 0.0), np.cross(along, across), along)
    ball = _stadium(d["radius"], 0.0, np.cross(along, across), along)
    return [_carried(motion, a, middle + line), x[:, None] + ball]


def _across(main, spread):
    """Return the unit vector, normal to ``main``, along which the ``spread`` (3,) of the motion is least."""
    free = np.abs(main) < 0.9
    axis = np.eye(3)[np.flatnonzero(free)[np.argmin(spread[free])]]
    normal = axis - (axis @ main) * main
    return normal / np.linalg.norm(normal)


def _stadium(radius, length, axis, side):
    """Return the outline (n, 3) of two half circles that are ``length`` apart along an axis; a circle if it is zero."""
    angle = np.linspace(0.0, 2.0 * np.pi, POINTS)[:, None]
    shift = np.where(np.cos(angle) > 0.0, length, 0.0)
    return (shift + radius * np.cos(angle)) * axis + radius * np.sin(angle) * side


def _carried(motion, node, points):
    """Return points (n, 3) of the start, fixed in a node or the ground, at all instants."""
    if node not in motion.nodes:
        return np.broadcast_to(points, (len(motion.position(motion.nodes[0])), *points.shape))
    start = np.array(motion.run.deck["nodes"][node]["position"], float)
    return motion.position(node)[:, None] + np.stack([motion.turned(node, p - start) for p in points], axis=1)
