"""Kinds of wheels with one variant for each slip law, in which the functions of that law are compiled."""

from dataclasses import replace
from functools import cache

from mecano.elements.wheels.tire_law import slip_law_of


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
