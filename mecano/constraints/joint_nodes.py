"""Nodes of joints and elements: shared unknowns, distance, and checks of positions and rotations."""

import numpy as np

from mecano.constraints.triads import triad
from mecano.schema import NODE_PAIR, Field

PLACE = 1e-6  # tolerance for nodes that share a position in the deck [m]
ANGLE = 1e-6  # tolerance for nodes that share a rotation in the deck [rad]
PERPENDICULAR = 1e-6  # cosine up to which two directions are perpendicular
NODES = Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground")
ENDS = Field("nodes", NODE_PAIR, "-", "nodes a and b, not at the same place")


def one_position(d, nodes):
    """Return the ``shares`` of a joint whose two nodes have the same position."""
    return [("x", 0, 1)]


def one_rotation(d, nodes):
    """Return the ``shares`` of a joint whose two nodes have the same rotation."""
    return [("R", 0, 1)]


def check_one_place(d, nodes):
    """Return errors if two nodes that share a position do not coincide initially: the ``check`` of a joint."""
    gap = distance(nodes)
    if gap <= PLACE:
        return []
    how = "for a joint elsewhere on a body, add a node there: 'attached' of a rigid_body, or a rigid_link"
    return [f"its nodes must be at the same place; they are {gap:.6g} m apart ({how})"]


def turn_between(a, b):
    """Return 2 sin(angle/2) of the angle between the initial rotations of two nodes."""
    return np.linalg.norm(np.subtract(b[1], a[1])) / np.sqrt(2.0)


def turned_apart(d, nodes):
    """Return whether two nodes have different initial rotations: ``Shared.apart`` of a joint."""
    return bool(turn_between(*nodes) > ANGLE)


def check_one_rotation(d, nodes):
    """Return errors if two nodes that share a rotation have different initial rotations: the ``check`` of a joint."""
    if not turned_apart(d, nodes):
        return []
    degrees = np.degrees(2.0 * np.arcsin(min(1.0, turn_between(*nodes) / 2.0)))
    how = "a node 'attached' to a rigid_body, or of a rigid_link, may have an orientation of its own"
    return [f"its nodes must have the same rotation; they differ by {degrees:.6g} degrees ({how})"]


def distance(nodes):
    """Return the initial distance [m] of two nodes (x, R)."""
    return float(np.linalg.norm(np.subtract(nodes[1][0], nodes[0][0])))


def check_apart(d, nodes):
    """Return errors if two nodes whose distance must not vanish coincide initially: the ``check`` of an element."""
    if distance(nodes) > PLACE:
        return []
    how = "'ground' is at the place of the other node; elsewhere use a node with 'fixed: true'"
    return [f"its nodes must not be at the same place ({how})"]


def check_perpendicular(d, first, second):
    """Return errors if the directions in the fields ``first`` and ``second`` of a joint are not perpendicular."""
    cosine = triad(d[first])[2] @ triad(d[second])[2]
    if abs(cosine) <= PERPENDICULAR:
        return []
    degrees = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return [f"{first!r} and {second!r} must be perpendicular; they are {degrees:.6g} degrees apart"]


def check_axis_1(d, nodes):
    """Return errors if ``axis_1`` of a joint, if given, is parallel to its axis."""
    if d["axis_1"] is None or np.linalg.norm(np.cross(triad(d["axis_1"])[2], triad(d["axis"])[2])) > PLACE:
        return []
    return ["'axis_1' must not be parallel to the axis"]
