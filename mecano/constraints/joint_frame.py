"""Triads of joint axes, shared unknowns, checks of nodes and axes: Python that runs once for each joint."""

import math

import numpy as np

from mecano.schema import NODE_PAIR, Field

PLACE = 1e-6  # tolerance for nodes that share a position in the deck [m]
ANGLE = 1e-6  # tolerance for nodes that share a rotation in the deck [rad]
NODES = Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground")
ENDS = Field("nodes", NODE_PAIR, "-", "nodes a and b, not at the same place")


def one_position(d, nodes):
    """Return the ``shares`` of a joint whose two nodes have the same position."""
    return [("x", 0, 1)]


def one_rotation(d, nodes):
    """Return the ``shares`` of a joint whose two nodes have the same rotation."""
    return [("R", 0, 1)]


def unit(a):
    """Return the unit vector (3,) along a vector."""
    a = np.array(a, float)
    return a / np.linalg.norm(a)


def triad(axis, first=None):
    """Return right-handed unit axes (3, 3), rows: mu_3 along ``axis``, mu_1 the component of ``first`` normal to it.

    Without ``first`` (None), mu_1 is derived from the inertial axis most perpendicular to ``axis`` (x before y before
    z).
    """
    mu_3 = np.asarray(axis, float)
    mu_3 = mu_3 / norm(mu_3)
    if first is None:
        # round-off must not decide between axes that are equally perpendicular
        first = np.eye(3)[np.argmin(np.round(np.abs(mu_3), 6))]
    mu_1 = np.asarray(first, float) - (first @ mu_3) * mu_3
    mu_1 /= norm(mu_1)
    return np.array([mu_1, cross(mu_3, mu_1), mu_3])


def norm(a):
    """Return the length of an array (n,) of floats, as numpy.linalg.norm does in ten times as long."""
    return math.sqrt(a.dot(a))


def cross(a, b):
    """Return the cross product of two arrays (3,); numpy.cross, for any shape, takes ten times as long."""
    (a_1, a_2, a_3), (b_1, b_2, b_3) = a.tolist(), b.tolist()
    return np.array([a_2 * b_3 - a_3 * b_2, a_3 * b_1 - a_1 * b_3, a_1 * b_2 - a_2 * b_1])


def not_flipped(p, q, R):
    """Return an error if the axis xi_3 of the second node opposes mu_3 of the first: the ``admissible`` of a joint."""
    if (R[0] @ p["mu"][2]) @ (R[1] @ p["xi"][2]) < 0.0:
        return "the axis fixed in its second node is opposite to that of the first (flipped by half a turn)"
    return ""


def not_across(d, nodes):
    """Return errors if ``axis_1`` of a joint, if given, is parallel to its axis."""
    if d["axis_1"] is None or np.linalg.norm(np.cross(triad(d["axis_1"])[2], triad(d["axis"])[2])) > PLACE:
        return []
    return ["'axis_1' must not be parallel to the axis"]


def turned_onto(a, b):
    """Return the smallest rotation (3, 3) from the direction of ``a`` to that of ``b``."""
    a, b = triad(a)[2], triad(b)[2]
    if a @ b < -1.0 + 1e-12:
        mu = triad(a)
        return 2.0 * np.outer(mu[0], mu[0]) - np.eye(3)
    w = np.cross(a, b)
    hat = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    return np.eye(3) + hat + hat @ hat / (1.0 + a @ b)


def not_at_one_place(d, nodes):
    """Return errors if two nodes that share a position do not coincide initially: the ``check`` of a joint."""
    gap = np.linalg.norm(np.subtract(nodes[1][0], nodes[0][0]))
    if gap <= PLACE:
        return []
    how = "for a joint elsewhere on a body, add a node there: 'attached' of a rigid_body, or a rigid_link"
    return [f"its nodes must be at the same place; they are {gap:.6g} m apart ({how})"]


def turn_between(a, b):
    """Return 2 sin(angle/2) of the angle between the initial rotations of two nodes."""
    return np.linalg.norm(np.subtract(b[1], a[1])) / np.sqrt(2.0)


def not_parallel(d, nodes):
    """Return errors if two nodes that share a rotation have different initial rotations: the ``check`` of a joint."""
    turn = turn_between(*nodes)
    if turn <= ANGLE:
        return []
    degrees = np.degrees(2.0 * np.arcsin(min(1.0, turn / 2.0)))
    how = "a node 'attached' to a rigid_body, or of a rigid_link, may have an orientation of its own"
    return [f"its nodes must have the same rotation; they differ by {degrees:.6g} degrees ({how})"]


def at_one_place(d, nodes):
    """Return errors if two nodes whose distance must not vanish coincide initially: the ``check`` of an element."""
    gap = np.linalg.norm(np.subtract(nodes[1][0], nodes[0][0]))
    if gap > PLACE:
        return []
    how = "'ground' is at the place of the other node; elsewhere use a node with 'fixed: true'"
    return [f"its nodes must not be at the same place ({how})"]
