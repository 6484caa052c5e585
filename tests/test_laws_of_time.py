"""Every law of time in a deck may be a signal; the only exceptions are listed here."""

import numpy as np
import pytest

from mecano.analyses.kind_samples import samples
from mecano.deck.catalogue import _fields as declared_fields
from mecano.deck.laws import units_in
from mecano.element_interface import Context
from mecano.elements import KINDS
from mecano.laws.law_table import LawTable
from mecano.schema import MOTION

OF_TIME = [
    (place, field)
    for place, field in declared_fields()
    if field.type.name in ("law", "curve", "drive") and units_in(field)[1] == "s"
]
EXCEPTIONS = {
    "grounds.motion speed": "belongs to no element: a wheel_on_body runs on a body, which any force or motion drives",
    "grounds.motion rate": "the same",
}
DRIVES = [(place, field) for place, field in OF_TIME if f"{place} {field.name}" not in EXCEPTIONS]


def test_the_exceptions_are_known():
    assert {f"{place} {field.name}" for place, field in OF_TIME if field.type.name != "drive"} == set(EXCEPTIONS)


@pytest.mark.parametrize(("place", "field"), DRIVES, ids=[f"{place}.{field.name}" for place, field in DRIVES])
def test_it_takes_a_formula(place, field):
    """The element or one of its parts reads a signal; what is prescribed is moved by a formula of the time."""
    name, *inside = place.split(".")
    formula = "time**2/2" if field.type == MOTION else "command"
    given = {field.name: formula}
    if inside:
        (mapping,) = (of for of in KINDS[name].fields if of.name == inside[0])
        given = {mapping.name: {of.name: of.default for of in mapping.type.options} | given}
    found = [_read(KINDS[name], sample.values | given, sample.nodes) for sample in samples(KINDS[name])]
    assert any((MOVED if field.type == MOTION else formula) in read for read in found)


MOVED = "moved by a formula"


def _read(kind, values, nodes):
    """Return the formulas that an element with these values reads, and MOVED if one of its parts is."""
    chosen = kind.chosen(values)
    parts = chosen.parts(values, nodes, Context(LawTable(), np.zeros(3), KINDS))
    formulas = [*(chosen.read(values) if chosen.inputs else ()), *(text for part in parts for text in part.reads)]
    return formulas + [MOVED for part in parts if "second_rate" in part.parameters]
