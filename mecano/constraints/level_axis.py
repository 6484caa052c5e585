r"""Level axis: :math:`a \cdot n = 0` for an axis a carried by the node and an inertial direction n.

Equation (19) of Cardona, Geradin & Doan 1991; the multiplier is the moment on the node about the driving
direction a x n.
"""

import numpy as np

from mecano.compiled.kernel import kernel
from mecano.constraints.augmented import add_constraint, put_levels
from mecano.constraints.carried import carried
from mecano.contract import Kind, Row, record
from mecano.maths.vector import add_mat, cross, dot, mat, skew, vec

RECORD = record(axis=3, normal=3)
MULTIPLIER = 3


@kernel
def force(p, at, f, K, C, M):
    """Moment on the node."""
    axis, n = vec(p.axis, 0), mat(at.R[0]).T @ vec(p.normal, 0)
    g = add_constraint(f, K, MULTIPLIER, at.k, at.penalty, dot(axis, n), at.q[MULTIPLIER], ((0, cross(axis, n)),))
    add_mat(K, 0, 0, g, skew(axis) @ skew(n))


@kernel
def levels(p, at, g):
    """Value and rates."""
    axis, axis1, axis2 = carried(mat(at.R[0]), vec(at.v, 0), vec(at.a, 0), vec(p.axis, 0))
    n = vec(p.normal, 0)
    put_levels(g, 0, dot(axis, n), dot(axis1, n), dot(axis2, n))


def sample(rng):
    """A random axis and normal."""
    return [({"axis": rng.normal(size=3), "normal": rng.normal(size=3)}, [(np.zeros(3), np.eye(3))], "")]


LEVEL_AXIS = Kind(
    name="level_axis",
    section="",
    doc=__doc__,
    dtype=RECORD,
    layout=("R0",),
    multipliers=(Row("moment that keeps the axis level", "N m", "rad"),),
    force=force,
    levels=levels,
    sample=sample,
)
