r"""Fixed joint: two nodes share position and rotation (Boolean identification: no equation).

With ``compliance`` laws hold b along and about the axes that a carries; what has no law is held by a multiplier each.
:math:`\mu_3` is ``axis``, :math:`\mu_1` is ``axis_1`` or the inertial axis most perpendicular to it. For stiffness that
couples the axes see ``bushing``. With ``release`` it holds b by multipliers until then.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.along_coordinate.hold import RELEASE_MODES
from mecano.constraints.joint_frame import NODES, not_across, not_at_one_place, not_flipped, not_parallel
from mecano.constraints.joint_samples import ORIENTATIONS, SPRUNG
from mecano.constraints.pair import (
    AXES,
    AXIS_1,
    PAIR_RECORD,
    axis_place,
    compliance_field,
    law_outputs,
    pair_force,
    pair_moment,
    pair_parts,
    pair_record,
)  # fmt: skip
from mecano.constraints.release import FIRST_ROW, RELEASE, SAMPLE, check_release, releasable
from mecano.element_interface import Display, Kind, Output, nothing
from mecano.jit.kernel import kernel
from mecano.maths.vector import mat, put, vec
from mecano.schema import DIRECTION, Field


@kernel
def observe(p, at, F, y, e):
    """Write the reactions."""
    put(y, 0, -vec(F, 6))
    put(y, 3, -(mat(at.R[1]) @ vec(F, 9)))


@kernel
def observe_held(p, at, F, y, e):
    """Write the reactions if every axis is held by a part of its own."""
    put(y, 0, mat(at.R[0]) @ (mat(p.mu).T @ pair_force(p, at.laws, at.q, at.v, at.R)))
    put(y, 3, mat(at.R[0]) @ (mat(p.mu).T @ pair_moment(p, at.laws, at.q, at.v, at.R)))


def _place(d, nodes, context):
    return {**axis_place(d, nodes, context), "start": np.zeros(3)}


def prepare_held(d, nodes, context):
    """Return the axes of both nodes, and the constraint or law of each axis."""
    return pair_record(_place(d, nodes, context), AXES, d["compliance"], context)


def parts_held(d, nodes, context):
    """Return the Parts that hold the six axes."""
    return pair_parts(_place(d, nodes, context), AXES, d["compliance"], context)


def variant(d):
    """The joint that shares all, or the one whose axes are held by parts."""
    return FIXED_RELEASE if d["release"] else FIXED_HELD if d["compliance"] else FIXED


def shares(d, nodes):
    """Return shares of position and rotation."""
    return [("x", 0, 1), ("R", 0, 1)]


def check(d, nodes):
    """The nodes start at one place with one rotation."""
    return not_at_one_place(nodes) + not_parallel(nodes) + not_across(d, nodes) + check_release(d, ("compliance",))


def sample(rng):
    """Return two equal nodes, joined rigidly, and by laws along all axes or some."""
    node = (rng.normal(size=3), ORIENTATIONS[1])
    play = (("dead_band", {"stiffness": 9.0, "lower": -0.01, "upper": 0.02}), ("damper", {"coefficient": 0.3}))
    d = {"axis": rng.normal(size=3), "axis_1": rng.normal(size=3)}
    return [
        ({}, [node, node], ""),
        ({**d, "compliance": dict.fromkeys(AXES, SPRUNG)}, [node, node], ""),
        ({**d, "compliance": {"along_2": play, "about_1": SPRUNG}}, [node, node], ""),
        *((SAMPLE, [node, node], phase) for phase in RELEASE_MODES),
    ]


FIXED = Kind(
    name="fixed",
    section="joints",
    doc=__doc__,
    display=Display(force="force"),
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        NODES,
        Field("axis", DIRECTION, "-", "axis of the compliance at the start, inertial", (0.0, 0.0, 1.0)),
        AXIS_1,
        compliance_field(AXES),
        RELEASE,
    ),
    outputs=(
        Output("force", "N", "force of a on b, inertial axes", (3,)),
        Output("moment", "N m", "moment of a on b, inertial axes", (3,)),
    ),
    optional=law_outputs("compliance", AXES),
    shares=shares,
    variant=variant,
    check=check,
    observe=observe,
    sample=sample,
)

FIXED_HELD = replace(
    FIXED,
    name="fixed_held",
    dtype=PAIR_RECORD,
    prepare=prepare_held,
    shares=nothing,
    parts=parts_held,
    observe=observe_held,
    admissible=not_flipped,
)


def _prepare_release(d, nodes, context):
    return pair_record(_place(d, nodes, context), AXES, None, context, FIRST_ROW)


FIXED_RELEASE = replace(releasable(FIXED_HELD, parts_held), prepare=_prepare_release, admissible=None)
