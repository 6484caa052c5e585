"""Checks of single values that several sections of a deck share: value -> what is wrong, or None."""

import numpy as np

AUTOMATIC = "automatic"
ARITHMETIC = (ArithmeticError, np.linalg.LinAlgError)  # of a calculation with numbers near the ends of their range
BEYOND_FLOATS = "too large or too small, taken together, to calculate with"


def not_empty(value):
    """Check: at least one."""
    return None if value else "must not be empty"


def spectral_radius(value):
    """Check: in [0, 1]."""
    return None if 0.0 <= value <= 1.0 else "must lie between 0 and 1"


def below_one(value):
    """Check: a relative tolerance."""
    return None if 0.0 < value < 1.0 else "must lie between 0 and 1"


def above_rounding(value):
    """Check: a relative tolerance that rounding lets one meet."""
    return None if 1e-14 <= value < 1.0 else "must lie between 1e-14 and 1"


def at_least_one(value):
    """Check: >= 1."""
    return None if value >= 1 else "must be at least 1"
