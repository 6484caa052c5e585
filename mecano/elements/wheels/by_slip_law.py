"""Kinds of wheels with one variant for each slip law, in which the functions of that law are compiled."""

from dataclasses import replace
from functools import cache

from mecano.constraints.ground import ends
from mecano.element_interface import Kind, record
from mecano.elements.wheels.rolling_contact import limits
from mecano.elements.wheels.tire_law import RADIAL_RECORD, slip_law_of
from mecano.elements.wheels.tire_wheel import EVENTS, PHASES


def wheel_with(law, compiled, own_record, prepare, **fields):
    """Return the Kind of a wheel with a SlipLaw.

    ``compiled(law)``: its ``residual`` and ``observe``; ``own_record``: fields of its record besides the axis, the
    radial force and those of the law, all but the last from ``prepare``; ``fields``: of the Kind.
    """
    residual, observe = compiled(law)

    def prepare_all(d, nodes, context):
        return {**prepare(d, nodes, context), **law.prepare(d["tire_law"], context)}

    return Kind(
        section="elements",
        dtype=record(axis=3, **own_record, **RADIAL_RECORD, **law.record),
        phases=PHASES,
        events=EVENTS,
        prepare=prepare_all,
        limits=limits,
        ends=ends,
        residual=residual,
        observe=observe,
        **fields,
    )


def by_slip_law(make, first):
    """Return the Kind ``make(first)`` of a wheel with the SlipLaw ``first``, and ``make(law)`` as its variants."""

    @cache
    def named(law):
        kind = make(law)
        return replace(kind, name=f"{kind.name}_{law.name}")

    def variant(d):
        law = slip_law_of(d["tire_law"])
        return wheel if law is first else named(law)

    wheel = replace(make(first), variant=variant)
    return wheel
