"""Checks of single values shared by several sections of a deck: value -> error text, or None."""

from collections import Counter
from collections.abc import Sequence, Sized

import numpy as np

AUTOMATIC = "automatic"
ARITHMETIC = (ArithmeticError, np.linalg.LinAlgError)  # errors of calculations near the limits of floats
BEYOND_FLOATS = "too large or too small in combination for floating-point arithmetic"


def not_empty(value: Sized) -> str | None:
    """Require at least one entry."""
    return None if value else "must not be empty"


def distinct(names: Sequence[str]) -> str | None:
    """Require at least one name, and each once."""
    twice = [name for name, count in Counter(names).items() if count > 1]
    return not_empty(names) or (f"must not name '{twice[0]}' twice" if twice else None)


def spectral_radius(value: float) -> str | None:
    """Require a value in [0, 1]."""
    return None if 0.0 <= value <= 1.0 else "must lie between 0 and 1"


def below_one(value: float) -> str | None:
    """Require a relative tolerance, between 0 and 1."""
    return None if 0.0 < value < 1.0 else "must lie between 0 and 1"


def resolvable(value: float) -> str | None:
    """Require a relative tolerance of the motion above its rounding errors, some 1e-13 over many steps."""
    return None if 1e-12 <= value < 1.0 else "must lie between 1e-12 and 1"


def above_rounding(value: float) -> str | None:
    """Require a relative tolerance that is larger than rounding."""
    return None if 1e-14 <= value < 1.0 else "must lie between 1e-14 and 1"


def at_least_one(value: float) -> str | None:
    """Require a value >= 1."""
    return None if value >= 1 else "must be at least 1"
