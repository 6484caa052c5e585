r"""Hinge: node b turns about an axis that it shares with node a.

Both nodes share one position (Boolean identification: no multiplier). With :math:`\mu_i` carried by a,
:math:`\xi_3` the axis carried by b and :math:`\mu_3` the axis carried by a (equations
(11)-(17) of Cardona, Geradin & Doan 1991):

.. math::  \mu_1 \cdot \xi_3 = 0, \qquad \mu_2 \cdot \xi_3 = 0

The multiplier of the first is the moment on b about :math:`+\mu_2`, that of the second about :math:`-\mu_1`. Both
equations also hold for :math:`\xi_3 = -\mu_3`: assembly refuses that solution. :math:`\mu_1` is ``axis_1``, or the
inertial axis most perpendicular to the axis at the start, made perpendicular; :math:`\mu_2 = \mu_3 \times \mu_1`.

Options. ``turning_law`` gives a moment from the angle and its rate: stiffness, damping, free play, a motor.
``latch`` locks the hinge for good at an angle, ``stops`` are rigid and may rebound; both exchange momentum at the
instant when they are met (docs/shocks.md).
``friction`` and ``compliance`` need the reactions along all five axes: the joint then shares nothing but has one
multiplier, or the law in its place, for each. Force and moment are those of what holds b; law and friction have
outputs of their own.
"""

from dataclasses import replace

import numpy as np
from numba import njit

from mecano.constraints.angle_stops import ANGLE_END_FIELDS, ANGLE_LATCH, ANGLE_STOP, angle_end_parts
from mecano.constraints.carried import follow, turned
from mecano.constraints.friction import LENGTH, check_friction, friction_fields, radius
from mecano.constraints.hinge_friction import HINGE_FRICTION, hinge_friction_record
from mecano.constraints.joint_frame import flipped, not_across, not_at_one_place, triad, turned_onto
from mecano.constraints.pair import (
    AXIS_1,
    PAIR_RECORD,
    compliance_field,
    law_outputs,
    pair_force,
    pair_moment,
    pair_parts,
    pair_record,
    triads_together,
)  # fmt: skip
from mecano.constraints.twist_law import TURNING_FIELDS, TWIST_LAW, turning_parts
from mecano.contract import Kind, Output, Part, nothing, record
from mecano.maths.vec import mat, mul, put, scale, tmul, vec
from mecano.schema import DIRECTION, NODE_PAIR, Field

RECORD = record(mu=(3, 3), xi=(3, 3))
HELD = ("about_2", "about_1", "along_1", "along_2", "along_axis")


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


@njit
def observe_held(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Angle and reactions, where every axis is held by a part of its own."""
    angle, y[1] = _angle(p, v, R)
    y[0] = follow(m[0], angle)
    put(y, 2, pair_force(p, laws, q, v, R))
    put(y, 5, pair_moment(p, laws, q, v, R))


def _place(d, nodes):
    """Axes of both nodes; those of b are mu_1, mu_2, mu_3 turned with the axis of a onto that of b."""
    mu = triad(d["axis"], d["axis_1"])
    axis_b = d["axis"] if d["axis_b"] is None else d["axis_b"]
    return {**triads_together(nodes, mu, mu @ turned_onto(d["axis"], axis_b).T), "start": np.zeros(3)}


def prepare(d, nodes, context):
    """Axes of both nodes."""
    place = _place(d, nodes)
    return {"mu": place["mu"], "xi": place["xi"]}


def prepare_held(d, nodes, context):
    """Axes of both nodes, and what holds each axis."""
    return pair_record(_place(d, nodes), HELD, d["compliance"], context)


def parts(d, nodes, context):
    """mu_1 and mu_2 perpendicular to xi_3; the law of the angle."""
    p = _place(d, nodes)
    return pair_parts(p, HELD[:2], None, context) + turning_parts(d, p, context) + angle_end_parts(d, p)


def parts_held(d, nodes, context):
    """Five axes held, the law of the angle, friction."""
    p, friction = _place(d, nodes), d["friction"]
    parts = pair_parts(p, HELD, d["compliance"], context) + turning_parts(d, p, context)
    if friction:
        values = hinge_friction_record(p["mu"][2], p["xi"][2], friction, context)
        parts.append(Part(HINGE_FRICTION, (0, 1), values, borrows=(0, 1, 2, 3, 4)))
    return parts + angle_end_parts(d, p)


def variant(d):
    """The hinge that shares its position, or the one whose axes are all held by parts."""
    return HINGE_HELD if d["friction"] or d["compliance"] else HINGE


def shares(d, n_nodes):
    """One position."""
    return [("x", 0, 1)]


def check(d, nodes):
    """The nodes start at one place; friction has its reactions."""
    return not_at_one_place(nodes) + not_across(d) + check_friction(d)


def admissible(p, q, R):
    """Refuse the flipped solution."""
    return flipped(R, p["mu"], p["xi"])


def sample(rng):
    """Random axes."""
    x = rng.normal(size=3)
    nodes = [(x, rotation) for rotation in np.linalg.qr(rng.normal(size=(2, 3, 3)))[0]]
    nodes = [(x, R * np.linalg.det(R)) for x, R in nodes]
    law = (("spring", {"stiffness": 3.0}), ("damper_polynomial", {"coefficients": [0.0, 2.0, 0.0, 1.0]}))
    falling = (("exponential", {"start": 0.5, "limit": 0.3, "rate": 0.1, "origin": 0.0}),)
    friction = {
        "coefficient": falling, "regularization": 0.2, "radius": 0.3, "collar_radius": 0.4, "length": 0.7,
    }  # fmt: skip
    d, stops = {"axis": rng.normal(size=3)}, {"lower": -1.0, "upper": 2.0, "restitution": 0.4}
    return [
        (d, nodes, ""),
        ({"axis": (1, 0, 0), "axis_b": (1, 0.1, 0), "latch": {"angle": 1.5}}, nodes, ""),
        ({**d, "turning_law": law, "natural_angle": 0.3, "friction": friction}, nodes, ""),
        ({**d, "friction": {**friction, "regularization": 50.0, "length": None}, "stops": stops}, nodes, ""),
        ({**d, "axis_1": rng.normal(size=3), "turning_law": law, "compliance": dict.fromkeys(HELD, law)}, nodes, ""),
    ]


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
        AXIS_1,
        *TURNING_FIELDS,
        *ANGLE_END_FIELDS,
        friction_fields(
            radius("radius", "radius of the bearing"),
            radius("collar_radius", "mean radius at which the axial force acts", 0.0),
            LENGTH,
        ),
        compliance_field(HELD),
    ),
    outputs=(
        Output("angle", "rad", "rotation of b relative to a about the axis since the start, over any turns"),
        Output("rate", "rad/s", "rate of the angle"),
        Output("force", "N", "force of a on b along mu_1, mu_2 and the axis", (3,)),
        Output("moment", "N m", "moment of a on b about mu_1, mu_2 and the axis", (3,)),
    ),
    optional=(
        ("turning_law", TWIST_LAW, ""),
        ("latch", ANGLE_LATCH, ""),
        ("stops", ANGLE_STOP, ""),
        ("friction", HINGE_FRICTION, ""),
        *law_outputs("compliance", HELD),
    ),
    memory=("angle",),
    prepare=prepare,
    shares=shares,
    parts=parts,
    variant=variant,
    check=check,
    observe=observe,
    commit=commit,
    admissible=admissible,
    sample=sample,
)

HINGE_HELD = replace(
    HINGE,
    name="hinge_held",
    dtype=PAIR_RECORD,
    prepare=prepare_held,
    shares=nothing,
    parts=parts_held,
    observe=observe_held,
)
