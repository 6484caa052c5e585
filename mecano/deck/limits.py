"""Checks of single values shared by several sections of a deck: value -> error text, or None."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from mecano.schema import requirement

AUTOMATIC = "automatic"
ARITHMETIC = (ArithmeticError, np.linalg.LinAlgError)  # errors of calculations near the limits of floats
BEYOND_FLOATS = "too large or too small in combination for floating-point arithmetic"

not_empty = requirement(lambda value: len(value) > 0, "must not be empty")
spectral_radius = requirement(lambda value: 0.0 <= value <= 1.0, "must lie between 0 and 1")
below_one = requirement(lambda value: 0.0 < value < 1.0, "must lie between 0 and 1")
# of the motion: above its rounding errors, some 1e-13 over many steps
resolvable = requirement(lambda value: 1e-12 <= value < 1.0, "must lie between 1e-12 and 1")
above_rounding = requirement(lambda value: 1e-14 <= value < 1.0, "must lie between 1e-14 and 1")
at_least_one = requirement(lambda value: value >= 1, "must be at least 1")


def distinct(names: Sequence[str]) -> str | None:
    """Require at least one name, and each once."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    return not_empty(names) or (f"must not name '{twice[0]}' twice" if twice else None)
