"""Unit vectors and right-handed triads of joint axes: Python that runs once for each joint."""

import math

import numpy as np


def unit(a):
    """Return the unit vector (3,) along a vector."""
    a = np.array(a, float)
    return a / np.linalg.norm(a)


def carried_axis(d, nodes):
    """Return the unit vector (3,) along the ``axis`` of the deck, in the axes of the first node."""
    return unit(np.asarray(nodes[0][1], float).T @ np.asarray(d["axis"], float))


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
    """Return the length of an array (n,) of floats, as numpy.linalg.norm, which takes ten times as long."""
    return math.sqrt(a.dot(a))


def cross(a, b):
    """Return the cross product of two arrays (3,); numpy.cross, for any shape, takes ten times as long."""
    (a_1, a_2, a_3), (b_1, b_2, b_3) = a.tolist(), b.tolist()
    return np.array([a_2 * b_3 - a_3 * b_2, a_3 * b_1 - a_1 * b_3, a_1 * b_2 - a_2 * b_1])


def hat(a):
    """Return the matrix (3, 3) of b -> a x b."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def turned_onto(a, b):
    """Return the smallest rotation (3, 3) from the direction of ``a`` to that of ``b``."""
    a, b = triad(a)[2], triad(b)[2]
    if a @ b < -1.0 + 1e-12:
        mu = triad(a)
        return 2.0 * np.outer(mu[0], mu[0]) - np.eye(3)
    w = np.cross(a, b)
    return np.eye(3) + hat(w) + hat(w) @ hat(w) / (1.0 + a @ b)


def not_flipped(p, q, R):
    """Return an error if the axis xi_3 of the second node opposes mu_3 of the first: the ``admissible`` of a joint."""
    if (R[0] @ p["mu"][2]) @ (R[1] @ p["xi"][2]) < 0.0:
        return "the axis fixed in its second node is opposite to that of the first (flipped by half a turn)"
    return ""
