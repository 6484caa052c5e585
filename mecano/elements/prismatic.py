r"""Prismatic joint: node b slides along an axis carried by node a and does not turn relative to it.

Both nodes share one rotation (Boolean identification). With :math:`\mu_1, \mu_2` carried by a and perpendicular to
the axis:

.. math::  \mu_i \cdot (x_b - x_a) - c_i = 0, \qquad i = 1, 2

The constants c_i are those of the start: the line of sliding goes through node b. The multipliers are the forces on
b along :math:`\mu_1` and :math:`\mu_2`, which are chosen as for the hinge; the moments are what balances b.

Options. ``sliding_law`` gives a force from the displacement and its rate. ``latch`` locks it for good at a
displacement, ``stops`` are rigid and may rebound (docs/shocks.md). ``friction`` and ``compliance`` need the
reactions along all five axes: the joint then shares nothing but has one multiplier, or the law in its place, for each.
Force and moment are those of what holds b; law and friction have outputs of their own.
"""

from dataclasses import replace

import numpy as np
from numba import njit

from mecano.constraints.friction import LENGTH, check_friction, friction_fields
from mecano.constraints.guide_friction import KEYED_FRICTION, keyed_record
from mecano.constraints.joint_frame import flipped, not_across, not_parallel, triad
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
from mecano.contract import Kind, Output, Part, nothing, record
from mecano.maths.vec import mat, mul, put, scale, vec
from mecano.schema import DIRECTION, NODE_PAIR, NUMBER, Field, positive

HELD = ("about_2", "about_1", "about_axis", "along_1", "along_2")
RECORD = record(mu=(3, 3), start=3)


@njit
def _put_motion(p, q, v, R, y):
    along, y[1] = slide(q, v, mat(R[0]), vec(p.mu[2], 0))
    y[0] = along - p.start[2]


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Sliding and reactions."""
    _put_motion(p, q, v, R, y)
    put(y, 2, (q[12], q[13], 0.0))
    put(y, 5, scale(-1.0, mul(mat(p.mu), vec(F, 9))))


@njit
def observe_held(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Sliding and reactions, where every axis is held by a part of its own."""
    _put_motion(p, q, v, R, y)
    put(y, 2, pair_force(p, laws, q, v, R))
    put(y, 5, pair_moment(p, laws, q, v, R))


def _place(d, nodes):
    return triads_together(nodes, triad(d["axis"], d["axis_1"]))


def prepare(d, nodes, context):
    """Axes carried by a and the start of b along them."""
    place = _place(d, nodes)
    return {"mu": place["mu"], "start": place["start"]}


def prepare_held(d, nodes, context):
    """Axes of both nodes, and what holds each axis."""
    return pair_record(_place(d, nodes), HELD, d["compliance"], context)


def parts(d, nodes, context):
    """b stays in two planes of a; the law along the axis."""
    p = _place(d, nodes)
    return pair_parts(p, HELD[3:], None, context) + sliding_parts(d, p, context) + slide_end_parts(d, p)


def parts_held(d, nodes, context):
    """Five axes held, the law along the sixth, friction."""
    p, friction = _place(d, nodes), d["friction"]
    parts = pair_parts(p, HELD, d["compliance"], context) + sliding_parts(d, p, context)
    if friction:
        values = keyed_record(p["mu"][2], friction, context)
        parts.append(Part(KEYED_FRICTION, (0, 1), values, borrows=(0, 1, 2, 3, 4)))
    return parts + slide_end_parts(d, p)


def variant(d):
    """The joint that shares its rotation, or the one whose axes are all held by parts."""
    return PRISMATIC_HELD if d["friction"] or d["compliance"] else PRISMATIC


def shares(d, n_nodes):
    """One rotation."""
    return [("R", 0, 1)]


def check(d, nodes):
    """The nodes start with one rotation; friction has its reactions."""
    return not_parallel(nodes) + not_across(d) + check_friction(d)


def admissible(p, q, R):
    """Refuse the flipped solution."""
    return flipped(R, p["mu"], p["xi"])


def sample(rng):
    """A random axis beside both nodes; every option."""
    R = np.diag([-1.0, 1.0, -1.0])
    nodes = [(rng.normal(size=3), R), (rng.normal(size=3), R)]
    law = (("spring", {"stiffness": 3.0}), ("damper_polynomial", {"coefficients": [0.0, 2.0, 0.0, 1.0]}))
    friction = {"coefficient": 0.3, "regularization": 0.2, "key_radius": 0.3, "length": 0.7}
    d = {"axis": rng.normal(size=3)}
    return [
        (d, nodes, ""),
        ({**d, "sliding_law": law, "natural_displacement": 0.2, "friction": friction}, nodes, ""),
        ({**d, "friction": {**friction, "regularization": 50.0, "key_radius": None, "length": None}}, nodes, ""),
        ({**d, "latch": {"displacement": -0.5}, "stops": {"lower": -1.0, "upper": 2.0, "restitution": 0.4}}, nodes, ""),
        ({**d, "axis_1": rng.normal(size=3), "compliance": dict.fromkeys(HELD, law)}, nodes, ""),
    ]


PRISMATIC = Kind(
    name="prismatic",
    section="joints",
    doc=__doc__,
    dtype=RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground"),
        Field("axis", DIRECTION, "-", "direction of sliding at the start, inertial; carried by a"),
        AXIS_1,
        *SLIDING_FIELDS,
        *SLIDE_END_FIELDS,
        friction_fields(
            LENGTH,
            Field(
                "key_radius",
                NUMBER,
                "m",
                "radius at which a key holds the moment about the axis; when absent that moment causes no friction",
                None,
                positive,
            ),
        ),
        compliance_field(HELD),
    ),
    outputs=(
        Output("displacement", "m", "sliding of b relative to a along the axis since the start"),
        Output("velocity", "m/s", "rate of the displacement"),
        Output("force", "N", "force of a on b along mu_1, mu_2 and the axis", (3,)),
        Output("moment", "N m", "moment of a on b at node b, about mu_1, mu_2 and the axis", (3,)),
    ),
    optional=(
        ("sliding_law", SLIDE_LAW, ""),
        ("latch", SLIDE_LATCH, ""),
        ("stops", SLIDE_STOP, ""),
        ("friction", KEYED_FRICTION, ""),
        *law_outputs("compliance", HELD),
    ),
    prepare=prepare,
    shares=shares,
    parts=parts,
    variant=variant,
    check=check,
    observe=observe,
    sample=sample,
)

PRISMATIC_HELD = replace(
    PRISMATIC,
    name="prismatic_held",
    dtype=PAIR_RECORD,
    prepare=prepare_held,
    shares=nothing,
    parts=parts_held,
    observe=observe_held,
    admissible=admissible,
)
