r"""Rigid link: a massless rigid arm between two nodes.

The follower shares the rotation of the master (Boolean identification); with d, material, from the start:

.. math::  x_f - x_m - R_m d = 0
"""

import numpy as np

from mecano.compiled.kernel import kernel
from mecano.constraints.joint_frame import not_parallel, one_rotation
from mecano.constraints.joint_samples import two_parallel
from mecano.constraints.rigid_offset import RIGID_OFFSET
from mecano.contract import Kind, Output, Part
from mecano.maths.vec import mat, mul, put, scale, vec
from mecano.schema import NODE_PAIR, Field


@kernel
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Reactions on the follower."""
    put(y, 0, vec(q, 12))
    put(y, 3, scale(-1.0, mul(mat(R[1]), vec(F, 9))))


def parts(d, nodes, context):
    """One rigid offset."""
    (x_m, R_m), (x_f, _) = nodes
    return [Part(RIGID_OFFSET, (0, 1), {"d": R_m.T @ np.subtract(x_f, x_m)})]


def check(d, nodes):
    """The nodes start with one rotation."""
    return not_parallel(nodes)


def sample(rng):
    """Two nodes of one rotation."""
    return [({}, two_parallel(rng), "")]


RIGID_LINK = Kind(
    name="rigid_link",
    section="elements",
    doc=__doc__,
    layout=("x0", "R0", "x1", "R1"),
    fields=(Field("nodes", NODE_PAIR, "-", "master and follower"),),
    outputs=(
        Output("force", "N", "force of the link on the follower, inertial axes", (3,)),
        Output("moment", "N m", "moment of the link on the follower, inertial axes", (3,)),
    ),
    shares=one_rotation,
    parts=parts,
    check=check,
    observe=observe,
    sample=sample,
)
