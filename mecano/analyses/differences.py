"""Central differences of functions of a small step."""

from collections.abc import Callable

import numpy as np

STEP = 1e-4


def difference(function: Callable[[float], np.ndarray | float], h: float) -> np.ndarray:
    """Return the central difference of fourth order of function(step) at 0."""
    return (4.0 * simple_difference(function, h) - simple_difference(function, 2.0 * h)) / 3.0


def simple_difference(function: Callable[[float], np.ndarray | float], h: float) -> np.ndarray:
    """Return the central difference of second order of function(step) at 0."""
    return (np.asarray(function(h)) - np.asarray(function(-h))) / (2.0 * h)
