"""The strain-free line of a beam: straight or a circular arc, optionally twisted. NumPy, once per beam.

A station is (x (3,) [m], A (3, 3)): a point of the line and the section axes there, columns 1, 2, 3, inertial.
"""

from functools import cache

import numpy as np

from mecano.constraints.joint_nodes import PLACE, check_apart
from mecano.constraints.triads import cross, hat, norm, triad
from mecano.maths.so3 import log, tangent_inverse
from mecano.maths.vector import mat, vec

MOST_TURN = 3.0  # rad between the ends of one element
PARALLEL = 1e-6  # sine of the angle up to which directions are parallel
UPRIGHT = 1e-3  # sine of the angle to the vertical up to which a beam is upright
ROUNDING = 1e-14  # rad: smaller angles are round-off
FLAT = 1e-9  # of the length: an arc with a smaller rise is straight


def stations(d, nodes):
    """Return the stations at the ends of each of the ``mesh`` elements, mesh + 1 in all."""
    (x_1, _), (x_2, _) = nodes
    axis, about, angle, centre = _arc(x_1, d["via"], x_2)
    shares = _shares(d["mesh"])
    if centre is None and d["twist"] == 0.0:
        axes = _section_axes(axis, d["up"])
        return [(x, axes) for x in x_1 + shares * np.subtract(x_2, x_1)]
    turned = _rotations(about, angle * shares)
    axes = turned @ _section_axes(axis, d["up"]) @ _rotations(np.array([1.0, 0.0, 0.0]), d["twist"] * shares)
    x = x_1 + shares * np.subtract(x_2, x_1) if centre is None else centre + turned @ (x_1 - centre)
    return list(zip(x, axes, strict=True))


@cache
def _shares(n):
    """Return the distances (n + 1, 1) of the stations from the first end, over the length."""
    return np.linspace(0.0, 1.0, n + 1)[:, None]


def _rotations(about, angles):
    """Return the rotations (n, 3, 3) by ``angles`` (n, 1) [rad] about a unit vector (Rodrigues)."""
    sines, versines = np.sin(angles)[..., None], (1.0 - np.cos(angles))[..., None]
    return np.eye(3) + sines * hat(about) + versines * (hat(about) @ hat(about))


def screw(first, second):
    """Return the strain-free screw (u, phi) (6,) [m, rad] from one station to the next, in section axes of the second.

    For a straight element it is (length, 0, ...) without round-off, so that equal elements are recognized as equal.
    """
    (x_1, A_1), (x_2, A_2) = first, second
    line = np.subtract(x_2, x_1)
    phi = np.zeros(3) if A_1 is A_2 or np.array_equal(A_1, A_2) else np.array(log(mat(A_1.T @ A_2)))
    if np.abs(phi).max() <= ROUNDING:
        return np.array([norm(line), 0.0, 0.0, 0.0, 0.0, 0.0])
    return np.concatenate([np.array(tangent_inverse(vec(phi, 0))) @ A_2.T @ line, phi])


def _arc(x_1, via, x_2):
    """Return initial tangent, axis, angle [rad] and centre of the arc; the centre is None for a straight line."""
    chord = np.subtract(x_2, x_1)
    if via is not None:
        first, second = np.subtract(via, x_1), np.subtract(x_2, via)
        normal = np.cross(first, second)
        if norm(normal) > FLAT * chord @ chord:
            about = normal / norm(normal)
            half = np.arctan2(norm(normal), first @ second)  # inscribed angle: half of the central angle
            rise = np.cross(about, chord)
            centre = np.asarray(x_1) + 0.5 * (chord + rise / np.tan(half))
            return np.cross(about, x_1 - centre), about, 2.0 * half, centre
    return chord, np.zeros(3), 0.0, None


def _section_axes(axis, up):
    """Return section axes (3, 3), 1 along ``axis``, 3 towards ``up``; default: z, or x for an upright beam."""
    if up is None:
        upright = np.hypot(axis[0], axis[1]) <= UPRIGHT * norm(axis)
        up = (1.0, 0.0, 0.0) if upright else (0.0, 0.0, 1.0)
    third, _, first = triad(axis, np.asarray(up, float))
    return np.stack([first, cross(third, first), third], axis=1)


def check_line(d, nodes, is_round):
    """Return errors that prevent the values from being a beam."""
    if texts := check_apart(d, nodes):
        return texts
    (x_1, _), (x_2, _) = nodes
    if d["via"] is not None and min(norm(np.subtract(d["via"], x)) for x in (x_1, x_2)) <= PLACE:
        return ["'via' must lie between the nodes, not on one of them"]
    axis, _, angle, centre = _arc(x_1, d["via"], x_2)
    if d["via"] is not None and centre is None and np.dot(np.subtract(d["via"], x_1), np.subtract(x_2, d["via"])) < 0:
        return ["'via' lies on the line of the nodes, but not between them"]
    if d["up"] is None and not is_round:
        return ["missing 'up': the direction of axis 3 of a section that is not round"]
    axis = axis / norm(axis)
    if d["up"] is not None and norm(np.cross(axis, d["up"])) <= PARALLEL * np.linalg.norm(d["up"]):
        return ["'up' must not be parallel to the beam"]
    turn = np.hypot(angle, d["twist"]) / d["mesh"]
    if turn > MOST_TURN:
        return [f"'mesh' is too small: an element turns by {turn:.3g} rad, {MOST_TURN:g} at most"]
    return []
