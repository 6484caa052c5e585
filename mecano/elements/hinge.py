r"""Hinge: node b turns about an axis that it shares with node a.

Both nodes share one position (Boolean identification: no multiplier). With :math:`\mu_i` carried by a,
:math:`\xi_3` the axis carried by b and :math:`\mu_3` the axis carried by a (equations
(11)-(17) of Cardona, Geradin & Doan 1991):

.. math::  \mu_1 \cdot \xi_3 = 0, \qquad \mu_2 \cdot \xi_3 = 0

The multiplier of the first is the moment on b about :math:`+\mu_2`, that of the second about :math:`-\mu_1`. Both
equations also hold for :math:`\xi_3 = -\mu_3`: assembly refuses that solution. :math:`\mu_1` is the inertial axis most
perpendicular to the axis at the start, made perpendicular; :math:`\mu_2 = \mu_3 \times \mu_1`.
"""

import numpy as np
from numba import njit

from mecano.constraints.carried import follow, turned
from mecano.constraints.joint_frame import not_at_one_place, triad, turned_onto
from mecano.constraints.orthogonal import ORTHOGONAL
from mecano.contract import Kind, Output, Part, record
from mecano.maths.vec import mat, mul, put, scale, tmul, vec
from mecano.schema import DIRECTION, NODE_PAIR, Field

RECORD = record(mu=(3, 3), xi=(3, 3))


@njit
def _angle(p, v, R):
    return turned(mat(R[0]), vec(v, 3), mat(p.mu), mat(R[1]), vec(v, 9), mat(p.xi))


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Angle and reactions."""
    angle, y[1] = _angle(p, v, R)
    y[0] = follow(m[0], angle)
    put(y, 2, scale(-1.0, mul(mat(p.mu), tmul(mat(R[0]), vec(F, 6)))))
    put(y, 5, (-q[13], q[12], 0.0))


@njit
def commit(p, m, mode, t, laws, q, v, a, R, m_out):
    """Follow the angle over whole turns."""
    m_out[0] = follow(m[0], _angle(p, v, R)[0])


def prepare(d, nodes, context):
    """Axes of both nodes; those of b are mu_1, mu_2, mu_3 turned with the axis of a onto that of b."""
    mu = triad(d["axis"])
    axis_b = d["axis"] if d["axis_b"] is None else d["axis_b"]
    return {"mu": mu @ nodes[0][1], "xi": mu @ turned_onto(d["axis"], axis_b).T @ nodes[1][1]}


def parts(d, nodes, context):
    """mu_1 and mu_2 perpendicular to xi_3."""
    p = prepare(d, nodes, context)
    return [Part(ORTHOGONAL, (0, 1), {"mu": p["mu"][i], "xi": p["xi"][2]}) for i in (0, 1)]


def shares(d, n_nodes):
    """One position."""
    return [("x", 0, 1)]


def check(d, nodes):
    """The nodes start at one place."""
    return not_at_one_place(nodes)


def admissible(p, q, R):
    """Refuse the flipped solution."""
    if (R[0] @ p["mu"][2]) @ (R[1] @ p["xi"][2]) < 0.0:
        return "the axis carried by its second node points against that of the first (flipped by half a turn)"
    return ""


def sample(rng):
    """Random axes."""
    x = rng.normal(size=3)
    nodes = [(x, rotation) for rotation in np.linalg.qr(rng.normal(size=(2, 3, 3)))[0]]
    nodes = [(x, R * np.linalg.det(R)) for x, R in nodes]
    return [({"axis": rng.normal(size=3)}, nodes, ""), ({"axis": (1, 0, 0), "axis_b": (1, 0.1, 0)}, nodes, "")]


HINGE = Kind(
    name="hinge",
    section="joints",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground"),
        Field("axis", DIRECTION, "-", "axis at the start, inertial"),
        Field("axis_b", DIRECTION, "-", "axis carried by b at the start, inertial, where it differs", None),
    ),
    outputs=(
        Output("angle", "rad", "rotation of b relative to a about the axis since the start, over any turns"),
        Output("rate", "rad/s", "rate of the angle"),
        Output("force", "N", "force of a on b along mu_1, mu_2 and the axis", (3,)),
        Output("moment", "N m", "moment of a on b about mu_1, mu_2 and the axis", (3,)),
    ),
    memory=("angle",),
    prepare=prepare,
    shares=shares,
    parts=parts,
    check=check,
    observe=observe,
    commit=commit,
    admissible=admissible,
    sample=sample,
)
