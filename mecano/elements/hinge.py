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

from mecano.compiled.kernel import kernel
from mecano.constraints.angle_stops import ANGLE_END_FIELDS, ANGLE_LATCH, ANGLE_STOP, angle_end_parts
from mecano.constraints.axis_motion import REACTIONS, TURNING, follow_turning, put_turning
from mecano.constraints.friction import LENGTH, check_friction, friction_fields, radius
from mecano.constraints.hinge_friction import HINGE_FRICTION, hinge_friction_record
from mecano.constraints.joint_frame import (
    NODES,
    not_across,
    not_at_one_place,
    not_flipped,
    one_position,
    triad,
    turned_onto,
)  # fmt: skip
from mecano.constraints.joint_samples import RUBBING, SPRUNG, STICKING
from mecano.constraints.pair import (
    AXES_RECORD,
    AXIS_1,
    PAIR_RECORD,
    compliance_field,
    law_outputs,
    pair_parts,
    pair_record,
    put_reactions,
    triads_together,
)  # fmt: skip
from mecano.constraints.twist_law import TURNING_FIELDS, TWIST_LAW, turning_parts
from mecano.contract import Kind, Part, nothing
from mecano.maths.vector import mat, put, vec
from mecano.schema import DIRECTION, Field

HELD = ("about_2", "about_1", "along_1", "along_2", "along_axis")


@kernel
def observe(p, at, F, y, e):
    """Angle and reactions."""
    put_turning(p, at.m, at.v, at.R, y, 0)
    put(y, 2, -(mat(p.mu) @ (mat(at.R[0]).T @ vec(F, 6))))
    put(y, 5, (-at.q[13], at.q[12], 0.0))


@kernel
def observe_held(p, at, F, y, e):
    """Angle and reactions, where every axis is held by a part of its own."""
    put_turning(p, at.m, at.v, at.R, y, 0)
    put_reactions(p, at.laws, at.q, at.v, at.R, y, 2)


def prepare(d, nodes, context):
    """Axes of both nodes; those of b are mu_1, mu_2, mu_3 turned with the axis of a onto that of b."""
    mu = triad(d["axis"], d["axis_1"])
    axis_b = d["axis"] if d["axis_b"] is None else d["axis_b"]
    return {**triads_together(nodes, mu, mu @ turned_onto(d["axis"], axis_b).T), "start": np.zeros(3)}


def prepare_held(d, nodes, context):
    """Axes of both nodes, and what holds each axis."""
    return pair_record(prepare(d, nodes, context), HELD, d["compliance"], context)


def parts(d, nodes, context):
    """mu_1 and mu_2 perpendicular to xi_3; the law of the angle."""
    p = prepare(d, nodes, context)
    return pair_parts(p, HELD[:2], None, context) + turning_parts(d, p, context) + angle_end_parts(d, p)


def parts_held(d, nodes, context):
    """Five axes held, the law of the angle, friction."""
    p, friction = prepare(d, nodes, context), d["friction"]
    parts = pair_parts(p, HELD, d["compliance"], context) + turning_parts(d, p, context)
    if friction:
        values = hinge_friction_record(p["mu"][2], p["xi"][2], friction, context)
        parts.append(Part(HINGE_FRICTION, (0, 1), values, borrows=(0, 1, 2, 3, 4)))
    return parts + angle_end_parts(d, p)


def variant(d):
    """The hinge that shares its position, or the one whose axes are all held by parts."""
    return HINGE_HELD if d["friction"] or d["compliance"] else HINGE


def check(d, nodes):
    """The nodes start at one place; friction has its reactions."""
    return not_at_one_place(nodes) + not_across(d, nodes) + check_friction(d)


def sample(rng):
    """Random axes."""
    x = rng.normal(size=3)
    nodes = [(x, rotation) for rotation in np.linalg.qr(rng.normal(size=(2, 3, 3)))[0]]
    nodes = [(x, R * np.linalg.det(R)) for x, R in nodes]
    radii, stops = {"radius": 0.3, "collar_radius": 0.4}, {"lower": -1.0, "upper": 2.0, "restitution": 0.4}
    d, law = {"axis": rng.normal(size=3)}, {"turning_law": SPRUNG}
    return [
        (d, nodes, ""),
        ({"axis": (1, 0, 0), "axis_b": (1, 0.1, 0), "latch": {"angle": 1.5}}, nodes, ""),
        ({**d, **law, "natural_angle": 0.3, "friction": {**RUBBING, **radii}}, nodes, ""),
        ({**d, "friction": {**STICKING, **radii}, "stops": stops}, nodes, ""),
        ({**d, "axis_1": rng.normal(size=3), **law, "compliance": dict.fromkeys(HELD, SPRUNG)}, nodes, ""),
    ]


HINGE = Kind(
    name="hinge",
    section="joints",
    doc=__doc__,
    dtype=AXES_RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        NODES,
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
    outputs=(*TURNING, *REACTIONS),
    optional=(
        ("turning_law", TWIST_LAW, ""),
        ("latch", ANGLE_LATCH, ""),
        ("stops", ANGLE_STOP, ""),
        ("friction", HINGE_FRICTION, ""),
        *law_outputs("compliance", HELD),
    ),
    memory=("angle",),
    prepare=prepare,
    shares=one_position,
    parts=parts,
    variant=variant,
    check=check,
    observe=observe,
    commit=follow_turning,
    admissible=not_flipped,
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
