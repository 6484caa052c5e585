"""Forces that the steps do not resolve: they alternate from step to step.

A force oscillates faster than the steps if its differences change sign in nearly every step: a period then has fewer
than 16/5 steps. Generalized-alpha damps such a motion, but the computed force is neither the true oscillation nor its
mean. Positions may still be as accurate as the tolerance requires, because stiff members move little.
"""

from collections.abc import Mapping

import numpy as np

from mecano.immutable import immutable
from mecano.jit.entry import Indices, Vector, entry
from mecano.jit.kernel import kernel

STEPS = 8  # last steps in which changes of sign are counted
CHANGES = 5  # least number of them in these steps for a force that alternates
ALL = (1 << STEPS) - 1
SHARE = 0.05  # of its size: a smaller oscillation of a number is not reported


@immutable
class Oscillation:
    """An entry of the row that alternates: index, largest oscillation from step to step, size, and time."""

    column: int
    swing: float
    largest: float  # size of the number in the run
    time: float  # [s]


class OscillationMonitor:
    """Monitor of entries of the row, given by their ``columns`` (n,), at the accepted steps."""

    def __init__(self, columns: np.ndarray):
        n = len(columns)
        self.columns = columns
        self.difference, self.signs = np.zeros(n), np.zeros(n, np.int64)
        self.swing, self.time, self.largest = np.zeros(n), np.zeros(n), np.zeros(n)
        self._take = count_changes.bind(*self.to_plain().values(), columns)

    def begin(self) -> None:
        """Restart after an event, where forces may jump."""
        self.difference[:] = 0.0
        self.signs[:] = 0

    def take(self, t: float, row0: np.ndarray, row: np.ndarray) -> None:
        """Take the rows (row_size,) at the beginning of a step and at its end, at the time t [s]."""
        self._take(t, row0, row)

    def to_plain(self) -> dict[str, np.ndarray]:
        """Return the arrays from which ``from_plain`` continues."""
        return {name: getattr(self, name) for name in ("difference", "signs", "swing", "time", "largest")}

    def from_plain(self, plain: Mapping[str, np.ndarray]) -> None:
        """Continue from the result of ``to_plain``."""
        for name, value in plain.items():
            getattr(self, name)[:] = value

    def found(self, least: np.ndarray) -> list[Oscillation]:
        """Return, in order, an Oscillation for each entry that exceeds ``least`` (n,) and a SHARE of its size."""
        share = self.swing / np.maximum(self.largest, np.finfo(float).tiny)
        worst = np.argsort(-share, kind="stable")
        chosen = [i for i in worst if share[i] > SHARE and self.swing[i] > least[i]]
        return [
            Oscillation(int(self.columns[i]), float(self.swing[i]), float(self.largest[i]), float(self.time[i]))
            for i in chosen
        ]


@kernel
def ones(bits):
    """Return how many bits of a number are set."""
    count = 0
    while bits:
        count += bits & 1
        bits >>= 1
    return count


@entry
def count_changes(
    difference_out: Vector, signs_out: Indices, swing_out: Vector, time_out: Vector, largest_out: Vector,
    columns: Indices, t: float, row0: Vector, row: Vector,
):  # fmt: skip
    """Append to ``signs`` a bit that is 1 for a change of sign; keep the largest difference while signs alternate."""
    for i in range(columns.shape[0]):
        x = row[columns[i]]
        difference = x - row0[columns[i]]
        alternates = difference * difference_out[i] < 0.0
        signs = (signs_out[i] << 1 | int(alternates)) & ALL
        swing = min(abs(difference), abs(difference_out[i]))
        if alternates and swing > swing_out[i] and ones(signs) >= CHANGES:
            swing_out[i] = swing
            time_out[i] = t
        difference_out[i] = difference
        signs_out[i] = signs
        largest_out[i] = max(largest_out[i], abs(x))
