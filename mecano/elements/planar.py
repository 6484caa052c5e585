r"""Planar joint: node b slides in a plane carried by node a and turns about its normal.

With :math:`\mu_3` the normal carried by a and :math:`\xi_3` the one carried by b:

.. math::  \mu_1 \cdot \xi_3 = 0, \qquad \mu_2 \cdot \xi_3 = 0, \qquad \mu_3 \cdot (x_b - x_a) - c = 0

The constant c is that of the start: the plane goes through node b. The multipliers are the moments on b about
:math:`+\mu_2` and :math:`-\mu_1`, then the force on b along the normal, of either sign: b cannot leave the plane. The
axes in the plane are chosen as for the hinge, and assembly refuses :math:`\xi_3 = -\mu_3`.

Option: ``turning_law`` gives a moment about the normal from the angle and its rate.
"""

import numpy as np
from numba import njit

from mecano.constraints.carried import follow, turned
from mecano.constraints.joint_frame import flipped, not_across, triad
from mecano.constraints.pair import AXIS_1, pair_parts, triads_together
from mecano.constraints.slide import slide
from mecano.constraints.twist_law import TURNING_FIELDS, TWIST_LAW, turning_parts
from mecano.contract import Kind, Output, record
from mecano.maths.vec import mat, put, vec
from mecano.schema import DIRECTION, NODE_PAIR, Field

HELD = ("about_2", "about_1", "along_axis")
RECORD = record(mu=(3, 3), xi=(3, 3), start=3)


@njit
def _angle(p, v, R):
    return turned(mat(R[0]), vec(v, 3), mat(p.mu), mat(R[1]), vec(v, 9), mat(p.xi))


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Sliding, rotation and reactions."""
    for i in range(3):
        along, y[3 + i] = slide(q, v, mat(R[0]), vec(p.mu[i], 0))
        y[i] = along - p.start[i]
    angle, y[7] = _angle(p, v, R)
    y[6] = follow(m[0], angle)
    y[8] = q[14]
    put(y, 9, (-q[13], q[12], 0.0))


@njit
def commit(p, m, mode, t, laws, q, v, a, R, m_out):
    """Follow the angle over whole turns."""
    m_out[0] = follow(m[0], _angle(p, v, R)[0])


def prepare(d, nodes, context):
    """Axes of both nodes and the start of b along those of a."""
    return triads_together(nodes, triad(d["axis"], d["axis_1"]))


def parts(d, nodes, context):
    """The normal of b stays parallel to that of a, and b in the plane; the law of the angle."""
    p = prepare(d, nodes, context)
    return pair_parts(p, HELD, None, context) + turning_parts(d, p, context)


def check(d, nodes):
    """An axis in the plane."""
    return not_across(d)


def admissible(p, q, R):
    """Refuse the flipped solution."""
    return flipped(R, p["mu"], p["xi"])


def sample(rng):
    """A random plane beside the first node, with and without the law."""
    nodes = [(rng.normal(size=3), np.eye(3)), (rng.normal(size=3), np.diag([-1.0, 1.0, -1.0]))]
    law = (("spring", {"stiffness": 3.0}), ("damper_polynomial", {"coefficients": [0.0, 2.0, 0.0, 1.0]}))
    d = {"axis": rng.normal(size=3)}
    return [(d, nodes, ""), ({**d, "axis_1": rng.normal(size=3), "turning_law": law, "natural_angle": 0.2}, nodes, "")]


PLANAR = Kind(
    name="planar",
    section="joints",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground"),
        Field("axis", DIRECTION, "-", "normal of the plane at the start, inertial; carried by a"),
        AXIS_1,
        *TURNING_FIELDS,
    ),
    outputs=(
        Output("displacement", "m", "sliding of b relative to a along mu_1, mu_2 and the normal since the start", (3,)),
        Output("velocity", "m/s", "rate of the displacement", (3,)),
        Output("angle", "rad", "rotation of b relative to a about the normal since the start, over any turns"),
        Output("rate", "rad/s", "rate of the angle"),
        Output("force", "N", "force of a on b along the normal"),
        Output("moment", "N m", "moment of a on b at node b, about mu_1, mu_2 and the normal", (3,)),
    ),
    optional=(("turning_law", TWIST_LAW, ""),),
    memory=("angle",),
    prepare=prepare,
    parts=parts,
    check=check,
    observe=observe,
    commit=commit,
    admissible=admissible,
    sample=sample,
)
