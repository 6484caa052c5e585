"""Fixed joint: two nodes share position and rotation (Boolean identification: no equation)."""

import numpy as np
from numba import njit

from mecano.constraints.joint_frame import not_at_one_place, not_parallel
from mecano.contract import Kind, Output
from mecano.maths.vec import mat, mul, put, scale, vec
from mecano.schema import NODE_PAIR, Field


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Reactions."""
    put(y, 0, scale(-1.0, vec(F, 6)))
    put(y, 3, scale(-1.0, mul(mat(R[1]), vec(F, 9))))


def shares(d, n_nodes):
    """One position and one rotation."""
    return [("x", 0, 1), ("R", 0, 1)]


def check(d, nodes):
    """The nodes start at one place with one rotation."""
    return not_at_one_place(nodes) + not_parallel(nodes)


def sample(rng):
    """Two equal nodes."""
    node = (rng.normal(size=3), np.diag([-1.0, 1.0, -1.0]))
    return [({}, [node, node], "")]


FIXED = Kind(
    name="fixed",
    section="joints",
    doc=__doc__,
    layout=("x0", "R0", "x1", "R1"),
    fields=(Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground"),),
    outputs=(
        Output("force", "N", "force of a on b, inertial axes", (3,)),
        Output("moment", "N m", "moment of a on b, inertial axes", (3,)),
    ),
    shares=shares,
    check=check,
    observe=observe,
    sample=sample,
)
