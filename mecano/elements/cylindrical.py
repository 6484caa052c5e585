r"""Cylindrical joint: node b slides along an axis carried by node a and turns about it.

With :math:`\mu_i` carried by a and :math:`\xi_3` the axis carried by b:

.. math::  \mu_i \cdot \xi_3 = 0, \qquad \mu_i \cdot (x_b - x_a) - c_i = 0, \qquad i = 1, 2

The constants c_i are those of the start: the axis goes through node b. The multipliers are the moments on b about
:math:`+\mu_2` and :math:`-\mu_1`, then the forces on b along :math:`\mu_1` and :math:`\mu_2`; these are chosen as for
the hinge, and assembly refuses :math:`\xi_3 = -\mu_3`.
"""

import numpy as np
from numba import njit

from mecano.constraints.carried import carried, follow, product_rates, turned
from mecano.constraints.in_plane import IN_PLANE
from mecano.constraints.joint_frame import triad
from mecano.constraints.orthogonal import ORTHOGONAL
from mecano.contract import Kind, Output, Part, record
from mecano.maths.vec import ZERO, mat, put, sub, vec
from mecano.schema import DIRECTION, NODE_PAIR, Field

RECORD = record(mu=(3, 3), xi=(3, 3), start=3)


@njit
def _angle(p, v, R):
    return turned(mat(R[0]), vec(v, 3), mat(p.mu), mat(R[1]), vec(v, 9), mat(p.xi))


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Rotation, sliding and reactions."""
    angle, y[1] = _angle(p, v, R)
    y[0] = follow(m[0], angle)
    axis = carried(mat(R[0]), vec(v, 3), ZERO, vec(p.mu[2], 0))
    along, y[3], _ = product_rates(axis, (sub(vec(q, 6), vec(q, 0)), sub(vec(v, 6), vec(v, 0)), ZERO))
    y[2] = along - p.start[2]
    put(y, 4, (q[14], q[15], 0.0))
    put(y, 7, (-q[13], q[12], 0.0))


@njit
def commit(p, m, mode, t, laws, q, v, a, R, m_out):
    """Follow the angle over whole turns."""
    m_out[0] = follow(m[0], _angle(p, v, R)[0])


def prepare(d, nodes, context):
    """Axes of both nodes and the start of b along those of a."""
    mu = triad(d["axis"])
    start = mu @ np.subtract(nodes[1][0], nodes[0][0])
    return {"mu": mu @ nodes[0][1], "xi": mu @ nodes[1][1], "start": start}


def parts(d, nodes, context):
    """The axis of b stays parallel to that of a, and b in two planes of a."""
    p = prepare(d, nodes, context)
    turns = [Part(ORTHOGONAL, (0, 1), {"mu": p["mu"][i], "xi": p["xi"][2]}) for i in (0, 1)]
    return turns + [Part(IN_PLANE, (0, 1), {"mu": p["mu"][i], "offset": p["start"][i], "law": 0}) for i in (0, 1)]


def admissible(p, q, R):
    """Refuse the flipped solution."""
    if (R[0] @ p["mu"][2]) @ (R[1] @ p["xi"][2]) < 0.0:
        return "the axis carried by its second node points against that of the first (flipped by half a turn)"
    return ""


def sample(rng):
    """A random axis beside the first node."""
    nodes = [(rng.normal(size=3), np.eye(3)), (rng.normal(size=3), np.diag([-1.0, 1.0, -1.0]))]
    return [({"axis": rng.normal(size=3)}, nodes, "")]


CYLINDRICAL = Kind(
    name="cylindrical",
    section="joints",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground"),
        Field("axis", DIRECTION, "-", "axis at the start, inertial; it goes through node b"),
    ),
    outputs=(
        Output("angle", "rad", "rotation of b relative to a about the axis since the start, over any turns"),
        Output("rate", "rad/s", "rate of the angle"),
        Output("displacement", "m", "sliding of b relative to a along the axis since the start"),
        Output("velocity", "m/s", "rate of the displacement"),
        Output("force", "N", "force of a on b along mu_1, mu_2 and the axis", (3,)),
        Output("moment", "N m", "moment of a on b at node b, about mu_1, mu_2 and the axis", (3,)),
    ),
    memory=("angle",),
    prepare=prepare,
    parts=parts,
    observe=observe,
    commit=commit,
    admissible=admissible,
    sample=sample,
)
