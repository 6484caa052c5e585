"""Lower pairs with an axis: joints of two nodes that hold some of the six axes of pair.py and leave the others free.

A joint is a row of a table: the axes that it holds, the coordinate of its latch and stops, its friction. Nodes that can
share an unknown (one position, or one rotation) share it, without a multiplier; friction and compliance need the
reactions along all held axes, and then each axis is held by a part of its own.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from mecano.constraints.along_coordinate.friction import check_friction, friction_fields
from mecano.constraints.along_coordinate.law import SLIDING_FIELDS, TURNING_FIELDS
from mecano.constraints.along_coordinate.measure import (
    REACTIONS,
    SLIDING,
    TURNING,
    follow_turning,
    put_sliding,
    put_turning,
)
from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.twist import TWIST
from mecano.constraints.joint_frame import NODES, not_across, not_flipped
from mecano.constraints.of_coordinates import (
    ANGLE_END_FIELDS,
    ANGLE_LATCH,
    ANGLE_STOP,
    SLIDE_END_FIELDS,
    SLIDE_LATCH,
    SLIDE_LAW,
    SLIDE_STOP,
    TWIST_LAW,
    angle_end_parts,
    slide_end_parts,
    sliding_parts,
    turning_parts,
)  # fmt: skip
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
from mecano.constraints.release import FIRST_ROW, RELEASE, check_release, releasable
from mecano.element_interface import Display, Kind, Measured, Part
from mecano.jit.kernel import kernel
from mecano.schema import DIRECTION, Field


@dataclass(frozen=True)
class Friction:
    """Friction of a joint, driven by the reactions of all axes that it holds."""

    kind: Kind
    values: Callable  # (place, deck values, Context) -> record
    fields: tuple  # deck fields besides those common to all friction


@dataclass(frozen=True)
class Shared:
    """Unknowns shared by the nodes of a joint if no option needs all reactions."""

    unknowns: Callable  # (deck values, nodes) -> shares
    held: tuple  # axes that remain to be held by constraints
    reactions: Callable  # (p, at, F, y, i): write force and moment of a on b starting at y[i]
    check: Callable  # nodes -> [text]: errors that prevent the sharing


@dataclass(frozen=True)
class LowerPair:
    """A row of the table of lower pairs."""

    axis: str  # description of the deck's ``axis``
    held: tuple  # of AXES
    ends: object  # the Coordinate of latch and stops, TWIST or SLIDE
    friction: Friction
    shared: Shared | None = None
    fields: tuple = ()  # additional deck fields, after the axis
    place: Callable = axis_place  # (d, nodes, context) -> {mu, xi, start}
    pictures: tuple = ()

    @property
    def turns(self):
        """True if the rotation about the axis is free."""
        return "about_axis" not in self.held

    @property
    def slides(self):
        """True if the sliding along the axis is free."""
        return "along_axis" not in self.held

    def options(self, d, p, context):
        """Return the Parts of laws, friction, latch and stops."""
        parts = turning_parts(d, p, context) if self.turns else []
        parts += sliding_parts(d, p, context) if self.slides else []
        if d["friction"]:
            values = self.friction.values(p, d["friction"], context)
            parts.append(Part(self.friction.kind, (0, 1), values, coupled_to=tuple(range(len(self.held)))))
        return parts + (angle_end_parts(d, p) if self.ends is TWIST else slide_end_parts(d, p))


def sharing_pair(name, doc, pair, sample):
    """Return the Kind whose nodes share unknowns, and the one whose axes are all held by parts."""
    apart = lower_pair(f"{name}_held", doc, pair, sample)

    def parts(d, nodes, context):
        p = pair.place(d, nodes, context)
        return pair_parts(p, pair.shared.held, None, context) + pair.options(d, p, context)

    released = _released(apart, pair)

    def variant(d):
        return released if d["release"] else apart if d["friction"] or d["compliance"] else together

    together = replace(
        apart, name=name, dtype=AXES_RECORD, prepare=pair.place, shares=pair.shared.unknowns, parts=parts,
        variant=variant, observe=_observed(pair, pair.shared.reactions),
        admissible=not_flipped if pair.turns else None,
    )  # fmt: skip
    return together, apart


def lower_pair(name, doc, pair, sample):
    """Return the Kind of a lower pair whose axes are all held by parts."""

    def prepare(d, nodes, context):
        return pair_record(pair.place(d, nodes, context), pair.held, d["compliance"], context)

    def parts(d, nodes, context):
        p = pair.place(d, nodes, context)
        return pair_parts(p, pair.held, d["compliance"], context) + pair.options(d, p, context)

    def check(d, nodes):
        together = pair.shared.check(nodes) if pair.shared else []
        return together + not_across(d, nodes) + check_friction(d) + check_release(d, _others(pair))

    kind = Kind(
        name=name, section="joints", doc=doc, dtype=PAIR_RECORD, layout=("x0", "R0", "x1", "R1"),
        display=Display(support=not pair.slides, pictures=pair.pictures, force="force", along_axes=True),
        fields=_fields(pair), outputs=(*TURNING * pair.turns, *SLIDING * pair.slides, *REACTIONS),
        optional=_optional(pair), memory=("angle",) if pair.turns else (),
        prepare=prepare, parts=parts, check=check, observe=_observed(pair, _all_held),
        commit=follow_turning if pair.turns else None, admissible=not_flipped, sample=sample, measures=_measures(pair),
    )  # fmt: skip
    released = _released(kind, pair)
    return replace(kind, variant=lambda d: released if d["release"] else kind)


def _measures(pair):
    """Return the ``measures``: the turning about the axis and the sliding along it, where they are free."""

    def angle(d, nodes, context):
        p = pair.place(d, nodes, context)
        return Measured(TWIST, (0, 1), {"mu": p["mu"], "xi": p["xi"]})

    def displacement(d, nodes, context):
        p = pair.place(d, nodes, context)
        return Measured(SLIDE, (0, 1), {"mu": p["mu"][2]}, p["start"][2])

    return {**({"angle": angle} if pair.turns else {}), **({"displacement": displacement} if pair.slides else {})}


def _released(kind, pair):
    """Return the variant of a lower pair with a release."""

    def prepare(d, nodes, context):
        return pair_record(pair.place(d, nodes, context), pair.held, None, context, FIRST_ROW)

    def parts(d, nodes, context):
        return pair_parts(pair.place(d, nodes, context), pair.held, None, context)

    return replace(releasable(kind, parts), prepare=prepare, admissible=None)


def _others(pair):
    """Names of the options that a joint with a release cannot have."""
    laws = ("turning_law",) * pair.turns + ("sliding_law",) * pair.slides
    return (*laws, "latch", "stops", "friction", "compliance")


def _fields(pair):
    ends = ANGLE_END_FIELDS if pair.ends is TWIST else SLIDE_END_FIELDS
    axis = Field("axis", DIRECTION, "-", pair.axis)
    laws = (*TURNING_FIELDS * pair.turns, *SLIDING_FIELDS * pair.slides)
    return (
        NODES, axis, *pair.fields, AXIS_1, *laws, *ends, friction_fields(*pair.friction.fields),
        compliance_field(pair.held), RELEASE,
    )  # fmt: skip


def _optional(pair):
    latch, stop = (ANGLE_LATCH, ANGLE_STOP) if pair.ends is TWIST else (SLIDE_LATCH, SLIDE_STOP)
    return (
        *((("turning_law", TWIST_LAW, ""),) * pair.turns), *((("sliding_law", SLIDE_LAW, ""),) * pair.slides),
        ("latch", latch, ""), ("stops", stop, ""), ("friction", pair.friction.kind, ""),
        *law_outputs("compliance", pair.held),
    )  # fmt: skip


@kernel
def _all_held(p, at, F, y, i):
    """Write the reactions if every axis is held by a part of its own."""
    put_reactions(p, at.laws, at.q, at.v, at.R, y, i)


def _observed(pair, reactions):
    """Return the ``observe`` of a pair: free motion, then force and moment."""
    turns, slides = pair.turns, pair.slides
    sliding, after = 2 * turns, 2 * (turns + slides)

    @kernel
    def observe(p, at, F, y, e):
        if turns:
            put_turning(p, at.m, at.v, at.R, y, 0)
        if slides:
            put_sliding(p, at.q, at.v, at.R, y, sliding)
        reactions(p, at, F, y, after)

    return observe
