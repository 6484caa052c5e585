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

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_motion import REACTIONS, SLIDING, TURNING, follow_turning, put_sliding, put_turning
from mecano.constraints.friction import LENGTH, check_friction, friction_fields, radius
from mecano.constraints.guide_friction import ROUND_FRICTION, round_record
from mecano.constraints.joint_frame import NODES, not_across, not_flipped
from mecano.constraints.joint_samples import RUBBING, SLIDE_ENDS, SPRUNG, STICKING, two_places
from mecano.constraints.pair import (
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
from mecano.constraints.twist_law import TURNING_FIELDS, TWIST_LAW, turning_parts
from mecano.contract import Kind, Part
from mecano.schema import DIRECTION, Field

HELD = ("about_2", "about_1", "along_1", "along_2")


@kernel
def observe(p, at, F, y, e):
    """Rotation, sliding and reactions."""
    put_turning(p, at.m, at.v, at.R, y, 0)
    put_sliding(p, at.q, at.v, at.R, y, 2)
    put_reactions(p, at.laws, at.q, at.v, at.R, y, 4)


def prepare(d, nodes, context):
    """Axes of both nodes, the start of b along those of a, what holds each axis."""
    return pair_record(axis_place(d, nodes, context), HELD, d["compliance"], context)


def parts(d, nodes, context):
    """The axis of b stays parallel to that of a, and b in two planes of a; laws along the axis, friction."""
    p, friction = axis_place(d, nodes, context), d["friction"]
    parts = pair_parts(p, HELD, d["compliance"], context) + turning_parts(d, p, context) + sliding_parts(d, p, context)
    if friction:
        values = round_record(p["mu"][2], p["xi"][2], friction, context)
        parts.append(Part(ROUND_FRICTION, (0, 1), values, borrows=(0, 1, 2, 3)))
    return parts + slide_end_parts(d, p)


def check(d, nodes):
    """An axis across; friction has its reactions."""
    return not_across(d, nodes) + check_friction(d)


def sample(rng):
    """A random axis beside the first node; every option."""
    nodes, d = two_places(rng), {"axis": rng.normal(size=3)}
    laws = {"turning_law": SPRUNG, "natural_angle": 0.2, "sliding_law": SPRUNG}
    return [
        (d, nodes, ""),
        ({**d, **SLIDE_ENDS}, nodes, ""),
        ({**d, **laws, "friction": {**RUBBING, "radius": 0.3}}, nodes, ""),
        ({**d, "friction": {**STICKING, "radius": 0.0}}, nodes, ""),
        ({**d, "axis_1": rng.normal(size=3), "compliance": {"along_1": SPRUNG, "about_1": SPRUNG}}, nodes, ""),
    ]


CYLINDRICAL = Kind(
    name="cylindrical",
    section="joints",
    doc=__doc__,
    dtype=PAIR_RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        NODES,
        Field("axis", DIRECTION, "-", "axis at the start, inertial; it goes through node b"),
        AXIS_1,
        *TURNING_FIELDS,
        *SLIDING_FIELDS,
        *SLIDE_END_FIELDS,
        friction_fields(radius("radius", "radius at which turning slides", 0.0), LENGTH),
        compliance_field(HELD),
    ),
    outputs=(*TURNING, *SLIDING, *REACTIONS),
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
    check=check,
    observe=observe,
    commit=follow_turning,
    admissible=not_flipped,
    sample=sample,
)
