"""Lower pairs: joints of two nodes that hold some of the six axes of pair.py and leave the others free.

A joint is a row of a table: the axes that it holds, the motions that it measures, its options. Where both nodes can
share one position or one rotation, they do, without a multiplier. Friction and compliance need the reactions along all
held axes: then each axis is held by a part of its own.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import chain

import numpy as np

from mecano.constraints.along_coordinate.law import bounds
from mecano.constraints.along_coordinate.measure import REACTIONS, Outputs
from mecano.constraints.joint_nodes import NODES, check_axis_1
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
    rigid_axes,
)  # fmt: skip
from mecano.constraints.release import FIRST_ROW, RELEASE, SAMPLE, check_release, releasable
from mecano.constraints.triads import not_flipped
from mecano.element_interface import FREELY, Display, Kind, nothing
from mecano.immutable import immutable
from mecano.jit.kernel import kernel
from mecano.schema import Field

ALL_HELD = Outputs(REACTIONS, put_reactions)
"""Reactions of a joint each of whose axes is held by a part of its own."""


@immutable
class Shared:
    """Unknowns shared by the nodes of a joint if no option needs all reactions."""

    unknowns: Callable  # (deck values, nodes) -> shares
    held: tuple  # axes that are left to be held by constraints
    put_reactions: Callable  # (p, at, F, y, i): write the reactions, starting at y[i]
    hidden: tuple  # outputs of these that depend on the forces F
    check: Callable = nothing  # (deck values, nodes) -> texts: errors of nodes that cannot share them
    apart: Callable | None = None  # (deck values, nodes) -> whether the nodes cannot share them but be held as they are


@immutable
class LowerPair:
    """A row of the table of lower pairs."""

    axis: Field
    held: tuple  # of AXES
    display: Display = Display()
    motions: tuple = ()  # Outputs of the motions that are free
    options: tuple = ()  # of Option
    reactions: Outputs = ALL_HELD
    released: "LowerPair | None" = None  # the row of the joint with a release, if it is a ``rigid_pair``
    fields: tuple = ()  # of its own, after the axis
    record: np.dtype = AXES_RECORD
    place: Callable = axis_place  # (d, nodes, context) -> values of the record, mu, xi and start among them

    @property
    def declared(self):
        """The fields of the deck."""
        return (NODES, self.axis, *self.fields, AXIS_1, *chain.from_iterable(o.fields for o in self.options))

    @property
    def optional(self):
        """The outputs of its options, see Kind.optional."""
        return tuple(chain.from_iterable(option.optional for option in self.options))

    def parts(self, d, nodes, context, held=None):
        """Return the [Part] that hold all axes, or those in ``held``, and those of the options."""
        p = self.place(d, nodes, context)
        holding = pair_parts(p, self.held if held is None else held, d.get("compliance"), context)
        return holding + [part for option in self.options for part in option.parts(d, p, context)]

    def needs_reactions(self, d):
        """Return True if an option that is given needs the reactions along all axes."""
        given = (field.name for option in self.options if option.needs_reactions for field in option.fields)
        return any(d[name] for name in given)

    def holds(self, d):
        """Return the axes that it holds rigidly, see Kind.holds; none with ``axis_b``, as the assembly turns b."""
        varies = d.get("release") or d.get("axis_b") is not None
        return () if varies else rigid_axes(self.held, d.get("compliance"))

    def observe(self, put):
        """Return the ``observe`` of a joint: its free motions, then the reactions, which ``put`` writes."""
        for motion in reversed(self.motions):
            put = _one_after_another(motion.put, motion.size, put)

        @kernel
        def observe(p, at, F, y, e):
            put(p, at, F, y, 0)

        return observe


def _one_after_another(first, size, second):
    @kernel
    def put(p, at, F, y, i):
        first(p, at, F, y, i)
        second(p, at, F, y, i + size)

    return put


def rigid_pair(name, doc, pair, cases=({},)):
    """Return the Kind of a lower pair whose axes are held by one constraint each."""

    def check(d, nodes):
        return check_axis_1(d, nodes) + [text for option in pair.options for text in option.check(d)]

    def measured(of):
        return lambda d, nodes, context: of(pair.place(d, nodes, context))

    outputs = (*pair.motions, pair.reactions)
    kind = Kind(
        name=name, section="joints", doc=doc, display=pair.display, dtype=pair.record, layout=("x0", "R0", "x1", "R1"),
        fields=pair.declared, outputs=tuple(chain.from_iterable(o.declared for o in outputs)), optional=pair.optional,
        memory=tuple(chain.from_iterable(o.memory for o in outputs)),
        commit=next((o.commit for o in outputs if o.commit), None),
        measures={output: measured(of) for o in outputs for output, of in o.measures.items()},
        prepare=pair.place, parts=pair.parts, check=check, observe=pair.observe(pair.reactions.put),
        admissible=not_flipped, turns="" if "about_axis" in pair.held else FREELY, holds=pair.holds,
        cases=cases, bounds=bounds,
    )  # fmt: skip
    return _with_release(kind, pair) if pair.released else kind


def _with_release(kind, pair):
    """Return the ``kind`` of a rigid pair with the field ``release``."""
    given = replace(
        kind, fields=(*kind.fields, RELEASE), cases=(*kind.cases, {**kind.cases[0], **SAMPLE}),
        check=lambda d, nodes: kind.check(d, nodes) + check_release(d, _options(pair)),
    )  # fmt: skip
    free = rigid_pair(kind.name, kind.doc, pair.released)
    released = releasable(free, fields=given.fields, check=given.check, admissible=None)
    return replace(given, variant=lambda d: released if d["release"] else given)


def _options(pair):
    """Return the fields of the options that exclude a release."""
    return tuple(dict.fromkeys(field for field, _, _ in pair.optional))


def lower_pair(name, doc, pair, cases):
    """Return the Kind of a lower pair any of whose axes a law may hold, or whose axes may be released."""

    def prepare(d, nodes, context):
        return pair_record(pair.place(d, nodes, context), pair.held, d["compliance"], context)

    rigid = rigid_pair(name, doc, pair)
    excluded = (*_options(pair), "compliance")
    kind = replace(
        rigid, dtype=PAIR_RECORD, fields=(*pair.declared, compliance_field(pair.held), RELEASE),
        optional=(*pair.optional, *law_outputs("compliance", pair.held)), prepare=prepare,
        check=lambda d, nodes: rigid.check(d, nodes) + check_release(d, excluded),
        cases=(*cases, {**cases[0], **SAMPLE}),
    )  # fmt: skip
    released = _released(kind, pair)
    return replace(kind, variant=lambda d: released if d["release"] else kind)


def sharing_pair(name, doc, pair, shared, cases):
    """Return the Kind of a lower pair whose nodes share unknowns, unless an option needs the reactions of all axes."""
    given = lower_pair(f"{name}_held", doc, pair, cases)
    apart = replace(given, check=lambda d, nodes: shared.check(d, nodes) + given.check(d, nodes))
    released = _released(apart, pair)

    def variant(d):
        return released if d["release"] else apart if d["compliance"] or pair.needs_reactions(d) else together

    together = replace(
        apart, name=name, dtype=pair.record, prepare=pair.place, shares=shared.unknowns,
        parts=partial(pair.parts, held=shared.held), variant=variant,
        observe=pair.observe(shared.put_reactions), admissible=not_flipped if "about_2" in shared.held else None,
        hidden=dict.fromkeys(shared.hidden, ""), revealed=apart, apart=shared.apart,
    )  # fmt: skip
    return together


def _released(kind, pair):
    """Return the variant of a lower pair with a release."""

    def prepare(d, nodes, context):
        return pair_record(pair.place(d, nodes, context), pair.held, None, context, FIRST_ROW)

    return releasable(kind, prepare=prepare, admissible=None)
