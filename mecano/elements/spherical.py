"""Spherical joint: two nodes share one position and turn freely (Boolean identification: no equation)."""

import numpy as np
from numba import njit

from mecano.constraints.joint_frame import not_at_one_place
from mecano.contract import Kind, Output
from mecano.maths.vec import put, scale, vec
from mecano.schema import NODE_PAIR, Field


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Reaction."""
    put(y, 0, scale(-1.0, vec(F, 3)))


def shares(d, n_nodes):
    """One position."""
    return [("x", 0, 1)]


def check(d, nodes):
    """The nodes start at one place."""
    return not_at_one_place(nodes)


def sample(rng):
    """Two nodes at one place."""
    x = rng.normal(size=3)
    return [({}, [(x, np.eye(3)), (x, np.diag([-1.0, 1.0, -1.0]))], "")]


SPHERICAL = Kind(
    name="spherical",
    section="joints",
    doc=__doc__,
    layout=("x0", "x1"),
    fields=(Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground"),),
    outputs=(Output("force", "N", "force of a on b, inertial axes", (3,)),),
    shares=shares,
    check=check,
    observe=observe,
    sample=sample,
)
