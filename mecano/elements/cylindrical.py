r"""Cylindrical joint: node b slides along an axis carried by node a and turns about it.

With :math:`\mu_i` carried by a and :math:`\xi_3` the axis carried by b:

.. math::  \mu_i \cdot \xi_3 = 0, \qquad \mu_i \cdot (x_b - x_a) - c_i = 0, \qquad i = 1, 2

The constants c_i are those of the start: the axis goes through node b. The multipliers are the moments on b about
:math:`+\mu_2` and :math:`-\mu_1`, then the forces on b along :math:`\mu_1` and :math:`\mu_2`; these are chosen as for
the hinge, and assembly refuses :math:`\xi_3 = -\mu_3`.

Options. ``turning_law`` and ``sliding_law`` give a moment from the angle and a force from the displacement, with their
rates. ``latch`` locks the sliding for good at a displacement, ``stops`` of it are rigid and may rebound
(docs/shocks.md). ``friction`` is driven by the four multipliers. ``compliance`` puts laws in the place of rigid
constraints. Force and moment are those of what holds b; laws and friction have outputs of their own.
"""

from dataclasses import replace

import numpy as np
from numba import njit

from mecano.constraints.carried import follow, turned
from mecano.constraints.friction import LENGTH, check_friction, friction_fields, radius
from mecano.constraints.guide_friction import ROUND_FRICTION, round_record
from mecano.constraints.joint_frame import flipped, not_across, triad
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
)
from mecano.constraints.slide import slide
from mecano.constraints.slide_law import SLIDE_LAW, SLIDING_FIELDS, sliding_parts
from mecano.constraints.slide_stops import SLIDE_END_FIELDS, SLIDE_LATCH, SLIDE_STOP, slide_end_parts
from mecano.constraints.twist_law import TURNING_FIELDS, TWIST_LAW, turning_parts
from mecano.contract import Kind, Output, Part, record
from mecano.maths.vec import mat, put, vec
from mecano.schema import DIRECTION, NODE_PAIR, Field

HELD = ("about_2", "about_1", "along_1", "along_2")
RECORD = record(mu=(3, 3), xi=(3, 3), start=3)


@njit
def _angle(p, v, R):
    return turned(mat(R[0]), vec(v, 3), mat(p.mu), mat(R[1]), vec(v, 9), mat(p.xi))


@njit
def _put_motion(p, m, q, v, R, y):
    angle, y[1] = _angle(p, v, R)
    y[0] = follow(m[0], angle)
    along, y[3] = slide(q, v, mat(R[0]), vec(p.mu[2], 0))
    y[2] = along - p.start[2]


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Rotation, sliding and reactions."""
    _put_motion(p, m, q, v, R, y)
    put(y, 4, (q[14], q[15], 0.0))
    put(y, 7, (-q[13], q[12], 0.0))


@njit
def observe_held(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Rotation, sliding and reactions, where laws take the place of some constraints."""
    _put_motion(p, m, q, v, R, y)
    put(y, 4, pair_force(p, laws, q, v, R))
    put(y, 7, pair_moment(p, laws, q, v, R))


@njit
def commit(p, m, mode, t, laws, q, v, a, R, m_out):
    """Follow the angle over whole turns."""
    m_out[0] = follow(m[0], _angle(p, v, R)[0])


def prepare(d, nodes, context):
    """Axes of both nodes and the start of b along those of a."""
    return triads_together(nodes, triad(d["axis"], d["axis_1"]))


def prepare_held(d, nodes, context):
    """The same, and what holds each axis."""
    return pair_record(prepare(d, nodes, context), HELD, d["compliance"], context)


def parts(d, nodes, context):
    """The axis of b stays parallel to that of a, and b in two planes of a; laws along the axis, friction."""
    p, friction = prepare(d, nodes, context), d["friction"]
    parts = pair_parts(p, HELD, d["compliance"], context) + turning_parts(d, p, context) + sliding_parts(d, p, context)
    if friction:
        values = round_record(p["mu"][2], p["xi"][2], friction, context)
        parts.append(Part(ROUND_FRICTION, (0, 1), values, borrows=(0, 1, 2, 3)))
    return parts + slide_end_parts(d, p)


def variant(d):
    """The rigid joint, or the one that a law holds along some axis."""
    return CYLINDRICAL_HELD if d["compliance"] else CYLINDRICAL


def check(d, nodes):
    """An axis across; friction has its reactions."""
    return not_across(d) + check_friction(d)


def admissible(p, q, R):
    """Refuse the flipped solution."""
    return flipped(R, p["mu"], p["xi"])


def sample(rng):
    """A random axis beside the first node; every option."""
    nodes = [(rng.normal(size=3), np.eye(3)), (rng.normal(size=3), np.diag([-1.0, 1.0, -1.0]))]
    law = (("spring", {"stiffness": 3.0}), ("damper_polynomial", {"coefficients": [0.0, 2.0, 0.0, 1.0]}))
    friction = {"coefficient": 0.3, "regularization": 0.2, "radius": 0.3, "length": 0.7}
    d = {"axis": rng.normal(size=3)}
    return [
        (d, nodes, ""),
        ({**d, "latch": {"displacement": -0.5}, "stops": {"lower": -1.0, "upper": 2.0, "restitution": 0.4}}, nodes, ""),
        ({**d, "turning_law": law, "natural_angle": 0.2, "sliding_law": law, "friction": friction}, nodes, ""),
        ({**d, "friction": {**friction, "regularization": 50.0, "radius": 0.0, "length": None}}, nodes, ""),
        ({**d, "axis_1": rng.normal(size=3), "compliance": {"along_1": law, "about_1": law}}, nodes, ""),
    ]


CYLINDRICAL = Kind(
    name="cylindrical",
    section="joints",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground"),
        Field("axis", DIRECTION, "-", "axis at the start, inertial; it goes through node b"),
        AXIS_1,
        *TURNING_FIELDS,
        *SLIDING_FIELDS,
        *SLIDE_END_FIELDS,
        friction_fields(radius("radius", "radius at which turning slides", 0.0), LENGTH),
        compliance_field(HELD),
    ),
    outputs=(
        Output("angle", "rad", "rotation of b relative to a about the axis since the start, over any turns"),
        Output("rate", "rad/s", "rate of the angle"),
        Output("displacement", "m", "sliding of b relative to a along the axis since the start"),
        Output("velocity", "m/s", "rate of the displacement"),
        Output("force", "N", "force of a on b along mu_1, mu_2 and the axis", (3,)),
        Output("moment", "N m", "moment of a on b at node b, about mu_1, mu_2 and the axis", (3,)),
    ),
    optional=(
        ("turning_law", TWIST_LAW, ""),
        ("sliding_law", SLIDE_LAW, ""),
        ("latch", SLIDE_LATCH, ""),
        ("stops", SLIDE_STOP, ""),
        ("friction", ROUND_FRICTION, ""),
        *law_outputs("compliance", HELD),
    ),
    memory=("angle",),
    prepare=prepare,
    parts=parts,
    variant=variant,
    check=check,
    observe=observe,
    commit=commit,
    admissible=admissible,
    sample=sample,
)

CYLINDRICAL_HELD = replace(
    CYLINDRICAL, name="cylindrical_held", dtype=PAIR_RECORD, prepare=prepare_held, observe=observe_held
)
