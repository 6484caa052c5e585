"""Decks in other units of length, mass and time: every number that is declared with a unit is scaled."""

from dataclasses import replace

import numpy as np
from instances import KINDS

from mecano.deck.laws import _in_use
from mecano.deck.sections import GROUND_FIELDS, SECTIONS
from mecano.deck.units import dimension_of, unit_of
from mecano.deck.values import _of_power
from mecano.elements.members.cross_section import SHAPES
from mecano.elements.wheels.tire_law import TIRE_LAW_FIELDS
from mecano.laws import TERMS

NUMBERS = ("number", "numbers", "vector", "inertia", "points")
LAWS = ("law", "curve", "drive")
INNER = ("either", "shorthand")  # a value of another type
TABLES = {"ground": GROUND_FIELDS, "tire_law": tuple(TIRE_LAW_FIELDS)}
KIND_TABLES = {"kind": KINDS, "wheel": KINDS, "joint": KINDS, "section": SHAPES}
BLOCKS = ("matrix_6", "matrix")
RESOLVED = {"laws", "grounds", "tire_laws", "sections", "parameters"}  # in the values that refer to them


class Units:
    """Sizes of the new units of length [m], mass [kg] and time [s]; a model of one metre has ``length`` metres."""

    def __init__(self, length, mass, time):
        self.sizes = length, mass, time

    def of(self, unit):
        """Return the factor on a quantity of this unit."""
        powers = dimension_of(unit)
        assert powers is not None, unit
        return float(np.prod([size**power for size, power in zip(self.sizes, powers, strict=True)]))

    def scaled(self, deck):
        """Return the checked ``deck`` in these units; it has no signals, whose formulas have units of their own."""
        assert not deck.values["signals"]
        kept = {name: deck.values[name] for name in RESOLVED if name in deck.values}
        fields = [field for field in SECTIONS if field.name not in RESOLVED]
        return replace(deck, values={**self._mapping(fields, deck.values), **kept})

    def _mapping(self, fields, values):
        given = {field.name: self._value(field, values[field.name]) for field in fields if field.name in values}
        return {**values, **given}

    def _value(self, field, value):
        name, options = field.type.name, field.type.options
        if value is None or isinstance(value, (str, bool, int)):
            return value
        if name in LAWS and isinstance(value, tuple):
            return tuple(
                (term, self._mapping(_in_use(TERMS[term], field, found.get("exponent")), found))
                for term, found in value
            )
        if name == "coefficients":
            return [self._numbers(x, _of_power(field.unit, power)) for power, x in enumerate(value)]
        if name in INNER:
            return self._value(replace(field, type=options[0]), value)
        if name in BLOCKS:
            return self._blocks(value, field.unit.split(", "))
        if name == "list":
            return [self._value(replace(field, type=options[0]), item) for item in value]
        if name == "named":
            return {key: self._value(replace(field, type=options[0]), item) for key, item in value.items()}
        if name == "mapping":
            return self._mapping(options, value)
        if name in TABLES:
            return self._mapping(TABLES[name], value)
        if name in KIND_TABLES:
            return self._mapping(KIND_TABLES[name][value["type"]].fields, value)
        return self._numbers(value, field.unit) if name in NUMBERS else value

    def _blocks(self, value, units):
        """Return six numbers, or six rows of six, scaled: units of the blocks by lengths, by both, and by angles."""
        sizes = np.array([self.of(unit) for unit in units])
        either = np.repeat([0, 1], 3)
        return (np.asarray(value) * sizes[2 * either if np.ndim(value) == 1 else either[:, None] + either]).tolist()

    def _numbers(self, value, unit):
        """Return a number, or nested lists of numbers, each of which may have a unit of its own, scaled."""
        if isinstance(value, (list, tuple, np.ndarray)):
            return [self._numbers(item, unit_of(unit, i, len(value))) for i, item in enumerate(value)]
        return value * self.of(unit)
