"""A parameter of a sweep and its values, as written on the command line: a range or a list, with or without units."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from mecano.deck.units import ANY, UnitError, converted, is_quantity, same_dimension, si_unit
from mecano.deck.wording import suggestion
from mecano.errors import UsageError

MOST = 100_000  # states in one sweep
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


@dataclass(frozen=True)
class Axis:
    """A number of the deck and its values in a sweep: ``path`` as in ``--set``, ``name`` for display.

    ``unit`` is their SI unit as far as sweep or deck give one, else "".
    """

    path: str
    name: str
    values: np.ndarray
    unit: str = ""

    @property
    def displayed(self) -> "Axis":
        """The same Axis for people: angles that are written with a unit in degrees."""
        return self if self.unit != "rad" else replace(self, values=np.degrees(self.values), unit="deg")

    @property
    def size(self) -> float:
        """Value, in the units of ``values``, of the unit of ``displayed``."""
        return 1.0 if self.unit != "rad" else math.radians(1.0)

    @classmethod
    def parse(cls, text: str, parameters: Iterable[str]) -> Self:
        """Parse "speed=10:80:1" or "tire_laws.rubber.radius=0.3 m,32 cm"; a name without a dot is a parameter.

        Raises UsageError.
        """
        path, equals, written = text.partition("=")
        wanted = f"'{text}' cannot be understood; write --sweep speed=10:80:1 (from, to, step) or speed=10,20,40"
        if not equals or not path:
            raise UsageError(wanted)
        if "." not in path and path not in parameters:
            hint = suggestion(path, parameters)
            raise UsageError(f"the deck has no parameter '{path}' to sweep over" + (f"; {hint}" if hint else ""))
        full, name = path if "." in path else f"parameters.{path}", path.removeprefix("parameters.")
        is_range = ":" in written
        parts = [part.strip() for part in re.split("[:,]", written)]
        if (is_range and ("," in written or len(parts) != 3)) or not all(map(_is_value, parts)):
            raise UsageError(wanted)
        numbers, unit = _in_si_units(parts, text)
        return cls(full, name, _range(numbers, text) if is_range else np.array(sorted(set(numbers))), unit)


def _is_value(text):
    return bool(re.fullmatch(NUMBER, text)) or is_quantity(text)


def _in_si_units(parts, text):
    """Return ([number in SI units], SI unit or "") of values of a sweep, some of which have units."""
    quantities = [part for part in parts if is_quantity(part)]
    try:
        numbers = [converted(part, ANY) if is_quantity(part) else float(part) for part in parts]
    except UnitError as error:
        raise UsageError(f"'{text}': {error}") from None
    if other := next((part for part in quantities if not same_dimension(quantities[0], part)), None):
        raise UsageError(f"'{text}': {quantities[0]} and {other} are different quantities")
    return numbers, si_unit(quantities[0]) if quantities else ""


def _range(numbers, text):
    first, last, step = numbers
    count = (last - first) / step if step else np.inf
    if not 0 < count < MOST:
        raise UsageError(f"'{text}' has no values, or more than {MOST}: the step must lead from the first to the last")
    values = first + step * np.arange(int(count + 1e-9) + 1)
    return np.sort(values)
