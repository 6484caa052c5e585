"""Largest and smallest value of every number of a row over all accepted steps, with their times."""

import math

import numpy as np

from mecano.jit.entry import Vector, entry


class Extremes:
    """Running extremes of rows of ``size`` numbers."""

    def __init__(self, size: int):
        self.high, self.low = np.full(size, -np.inf), np.full(size, np.inf)
        self.high_time, self.low_time = np.full(size, np.nan), np.full(size, np.nan)

    def take(self, t: float, row: np.ndarray) -> int:
        """Update with a row (size,) at the time ``t`` [s]; return the index of a number that is not finite, or -1.

        A row that is not finite is ignored.
        """
        return update(t, row, self.high, self.high_time, self.low, self.low_time)


@entry
def update(
    t: float, row: Vector, high_out: Vector, high_time_out: Vector, low_out: Vector, low_time_out: Vector
) -> int:
    """Compare a row with the extremes; see ``Extremes.take``."""
    for i in range(row.shape[0]):
        if not math.isfinite(row[i]):
            return i
    for i in range(row.shape[0]):
        if row[i] > high_out[i]:
            high_out[i] = row[i]
            high_time_out[i] = t
        if row[i] < low_out[i]:
            low_out[i] = row[i]
            low_time_out[i] = t
    return -1
