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

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_motion import REACTIONS, SLIDING, put_sliding
from mecano.constraints.friction import LENGTH, check_friction, friction_fields
from mecano.constraints.guide_friction import KEYED_FRICTION, keyed_record
from mecano.constraints.joint_frame import NODES, not_across, not_flipped, not_parallel, one_rotation
from mecano.constraints.joint_samples import RUBBING, SLIDE_ENDS, SPRUNG, STICKING, two_parallel
from mecano.constraints.pair import (
    AXES_RECORD,
    AXIS_1,
    PAIR_RECORD,
    axis_place,
    compliance_field,
    law_outputs,
    pair_parts,
    pair_record,
    put_reactions,
)  # fmt: skip
from mecano.constraints.slide_law import SLIDE_LAW, SLIDING_FIELDS, sliding_parts
from mecano.constraints.slide_stops import SLIDE_END_FIELDS, SLIDE_LATCH, SLIDE_STOP, slide_end_parts
from mecano.contract import Kind, Part, nothing
from mecano.maths.vector import mat, put, vec
from mecano.schema import DIRECTION, NUMBER, Field, positive

HELD = ("about_2", "about_1", "about_axis", "along_1", "along_2")


@kernel
def observe(p, at, F, y, e):
    """Sliding and reactions."""
    put_sliding(p, at.q, at.v, at.R, y, 0)
    put(y, 2, (at.q[12], at.q[13], 0.0))
    put(y, 5, -(mat(p.mu) @ vec(F, 9)))


@kernel
def observe_held(p, at, F, y, e):
    """Sliding and reactions, where every axis is held by a part of its own."""
    put_sliding(p, at.q, at.v, at.R, y, 0)
    put_reactions(p, at.laws, at.q, at.v, at.R, y, 2)


def prepare_held(d, nodes, context):
    """Axes of both nodes, and what holds each axis."""
    return pair_record(axis_place(d, nodes, context), HELD, d["compliance"], context)


def parts(d, nodes, context):
    """b stays in two planes of a; the law along the axis."""
    p = axis_place(d, nodes, context)
    return pair_parts(p, HELD[3:], None, context) + sliding_parts(d, p, context) + slide_end_parts(d, p)


def parts_held(d, nodes, context):
    """Five axes held, the law along the sixth, friction."""
    p, friction = axis_place(d, nodes, context), d["friction"]
    parts = pair_parts(p, HELD, d["compliance"], context) + sliding_parts(d, p, context)
    if friction:
        values = keyed_record(p["mu"][2], friction, context)
        parts.append(Part(KEYED_FRICTION, (0, 1), values, borrows=(0, 1, 2, 3, 4)))
    return parts + slide_end_parts(d, p)


def variant(d):
    """The joint that shares its rotation, or the one whose axes are all held by parts."""
    return PRISMATIC_HELD if d["friction"] or d["compliance"] else PRISMATIC


def check(d, nodes):
    """The nodes start with one rotation; friction has its reactions."""
    return not_parallel(nodes) + not_across(d, nodes) + check_friction(d)


def sample(rng):
    """A random axis beside both nodes; every option."""
    nodes, d = two_parallel(rng), {"axis": rng.normal(size=3)}
    law = {"sliding_law": SPRUNG, "natural_displacement": 0.2}
    return [
        (d, nodes, ""),
        ({**d, **law, "friction": {**RUBBING, "key_radius": 0.3}}, nodes, ""),
        ({**d, "friction": {**STICKING, "key_radius": None}}, nodes, ""),
        ({**d, **SLIDE_ENDS}, nodes, ""),
        ({**d, "axis_1": rng.normal(size=3), "compliance": dict.fromkeys(HELD, SPRUNG)}, nodes, ""),
    ]


PRISMATIC = Kind(
    name="prismatic",
    section="joints",
    doc=__doc__,
    dtype=AXES_RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        NODES,
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
    outputs=(*SLIDING, *REACTIONS),
    optional=(
        ("sliding_law", SLIDE_LAW, ""),
        ("latch", SLIDE_LATCH, ""),
        ("stops", SLIDE_STOP, ""),
        ("friction", KEYED_FRICTION, ""),
        *law_outputs("compliance", HELD),
    ),
    prepare=axis_place,
    shares=one_rotation,
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
    admissible=not_flipped,
)
