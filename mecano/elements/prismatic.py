r"""Prismatic joint: node b slides along an axis carried by node a and does not turn relative to it.

Both nodes share one rotation (Boolean identification). With :math:`\mu_1, \mu_2` carried by a and perpendicular to
the axis:

.. math::  \mu_i \cdot (x_b - x_a) - c_i = 0, \qquad i = 1, 2

The constants c_i are those of the start: the line of sliding goes through node b. The multipliers are the forces on
b along :math:`\mu_1` and :math:`\mu_2`, which are chosen as for the hinge; the moments are what balances b.
"""

import numpy as np
from numba import njit

from mecano.constraints.carried import carried, product_rates
from mecano.constraints.in_plane import IN_PLANE
from mecano.constraints.joint_frame import not_parallel, triad
from mecano.contract import Kind, Output, Part, record
from mecano.maths.vec import ZERO, mat, mul, put, scale, sub, vec
from mecano.schema import DIRECTION, NODE_PAIR, Field

RECORD = record(mu=(3, 3), start=3)


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Sliding and reactions."""
    mu = mat(p.mu)
    axis = carried(mat(R[0]), vec(v, 3), ZERO, mu[2])
    along, y[1], _ = product_rates(axis, (sub(vec(q, 6), vec(q, 0)), sub(vec(v, 6), vec(v, 0)), ZERO))
    y[0] = along - p.start[2]
    put(y, 2, (q[12], q[13], 0.0))
    put(y, 5, scale(-1.0, mul(mu, vec(F, 9))))


def prepare(d, nodes, context):
    """Axes carried by a and the start of b along them."""
    mu = triad(d["axis"])
    return {"mu": mu @ nodes[0][1], "start": mu @ np.subtract(nodes[1][0], nodes[0][0])}


def parts(d, nodes, context):
    """b stays in two planes of a."""
    p = prepare(d, nodes, context)
    return [Part(IN_PLANE, (0, 1), {"mu": p["mu"][i], "offset": p["start"][i], "law": 0}) for i in (0, 1)]


def shares(d, n_nodes):
    """One rotation."""
    return [("R", 0, 1)]


def check(d, nodes):
    """The nodes start with one rotation."""
    return not_parallel(nodes)


def sample(rng):
    """A random axis beside both nodes."""
    R = np.diag([-1.0, 1.0, -1.0])
    return [({"axis": rng.normal(size=3)}, [(rng.normal(size=3), R), (rng.normal(size=3), R)], "")]


PRISMATIC = Kind(
    name="prismatic",
    section="joints",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground"),
        Field("axis", DIRECTION, "-", "direction of sliding at the start, inertial; carried by a"),
    ),
    outputs=(
        Output("displacement", "m", "sliding of b relative to a along the axis since the start"),
        Output("velocity", "m/s", "rate of the displacement"),
        Output("force", "N", "force of a on b along mu_1, mu_2 and the axis", (3,)),
        Output("moment", "N m", "moment of a on b at node b, about mu_1, mu_2 and the axis", (3,)),
    ),
    prepare=prepare,
    shares=shares,
    parts=parts,
    check=check,
    observe=observe,
    sample=sample,
)
