"""Control of the step size from the error of the last step."""

import math
from typing import Self

from mecano.immutable import immutable
from mecano.jit.kernel import kernel
from mecano.maths.neighbours import predecessor

SAFETY = 0.9
GROWTH = 2.0
SHRINK = 0.2
HOLD = 1.25  # a step that could grow by less keeps its size, because a change costs a projection
RESERVE = 0.85  # a step that must shrink shrinks by that much more, so that the next ones keep their size
AFTER_FAILURE = 0.25
LABORIOUS = 12  # Newton iterations of a step after which the next one shrinks: rejected ones would cost more
EASE = 0.7  # by at least this factor
FORGOTTEN = 1e-3  # of the tolerance: the error of a step in massless unknowns, which relax and so forget it
SUDDEN = 1e-4  # of the tolerance: the error of a step in a signal whose rate may jump, which no step size mends
LEAST = 1e-7  # of the tolerance: what any step may use of it, so that a run of ten million steps uses twice as much
STRETCH = 1.01  # a step becomes so much longer rather than leave a very short one before a time at which steps end
SHORT = 1e-3  # of the planned step: the reactions of a step so much shorter are dominated by rounding
NEGLIGIBLE_TIME = 1e-6  # of a step: no step is made for a remaining time below
AT_ONCE = 1e-300  # s: the duration for which any step is long


@kernel
def allowed(tolerance, duration, h):
    """Return the share of the tolerance of a step of size h: its part of the run, or LEAST.

    A damped transient of amplitude v/r after a shock would otherwise need errors below rounding in steps below 1/r.
    """
    return max(tolerance * h / duration, LEAST * tolerance)


@kernel
def counted(error, least, duration, h):
    """Return an ``error`` reduced in small steps, so that at least the part ``least`` of the tolerance is allowed."""
    return error * min(max(h / duration, LEAST) / least, 1.0)


@kernel
def factor(error, share):
    """Return the change of the step size for which the ``error`` becomes its ``share``; 0 for nan."""
    if error > 0.0 and share < math.inf:
        return SAFETY * math.sqrt(share / error)
    return GROWTH if error >= 0.0 else 0.0


@kernel
def factor_of_order(error, share, order):
    """Return ``factor`` for a method of which the sum of the local errors falls as h to the power ``order``."""
    if order == 2 or not 0.0 < error < math.inf or share == math.inf:
        return factor(error, share)
    return SAFETY * (share / error) ** (1.0 / order)


@kernel
def planned(change, share, h, minimum, maximum, iterations):
    """Return the next step size after an accepted step, whose error allows a ``change`` and was allowed a ``share``.

    After many Newton iterations it is smaller, but not that of fixed steps.
    """
    if iterations >= LABORIOUS and share < math.inf:
        change = min(change, EASE)
    if 1.0 <= change < HOLD:
        return h
    change = min(change, GROWTH) if change > 1.0 else change * RESERVE
    return min(max(h * change, minimum), maximum)


@kernel
def clipped(t, h, stop, jumps):
    """Return the size of a step of planned size h from the time t to ``stop`` at most.

    If forces jump there (``jumps``), the step ends just before. It becomes STRETCH longer rather than leave a very
    short one.
    """
    remaining = stop - t
    if remaining >= STRETCH * h:
        return h
    if not jumps:
        return remaining if abs(remaining - h) > NEGLIGIBLE_TIME * h else h
    remaining = predecessor(stop) - t
    return remaining if t + remaining < stop else predecessor(remaining)  # the sum was rounded up


@kernel
def first_size(t, h, stop, jumps):
    """Return the size for which a history begins at the time t, as ``clipped``, or h if ``stop`` is too near."""
    return clipped(t, h, stop, jumps) if stop - t > SHORT * h else h


@kernel
def retried(change, h, minimum):
    """Return the step size to try after a rejected step of size h whose error requires a ``change`` by this factor."""
    return max(h * max(change, SHRINK), minimum)


@immutable
class StepControl:
    """Error per unit step: the local errors of a run of ``duration`` [s] add up to ``tolerance`` at most.

    Steps shorter than 1e-7 of the run may use 1e-7 of the tolerance each.

    The tolerance is relative to the length scale of the mechanism (or to one radian). The sum of the local errors falls
    as h to the power ``order``. The error of fixed steps is not limited; they are shortened only where Newton's
    iteration fails, at events, and at times at which a step must end.
    """

    tolerance: float
    duration: float
    minimum: float
    maximum: float
    order: int = 2  # of the method

    @classmethod
    def fixed(cls, step: float, minimum: float) -> Self:
        """Return the control of fixed steps."""
        return cls(math.inf, AT_ONCE, minimum, step)

    def _change(self, error, h):
        """Return the change of the step size for which the ``error`` becomes its share of the tolerance."""
        return factor_of_order(error, self.allowed(h), self.order)

    def allowed(self, h: float) -> float:
        """Return the share of the tolerance of a step of size h."""
        return allowed(self.tolerance, self.duration, h)

    @property
    def adaptive(self) -> bool:
        """True if step sizes follow from the errors of the steps."""
        return self.tolerance < math.inf

    def forgotten(self, lag: float, h: float) -> float:
        """Return the reduced error that counts for an ``error`` of massless unknowns in a step of size h."""
        return counted(lag, FORGOTTEN, self.duration, h)

    def accept(self, error: float, h: float) -> bool:
        """Return whether the error is within its share, or the step was cut below the minimum to meet a time."""
        return error <= self.allowed(h) or h < self.minimum

    def holds(self, error: float, h: float) -> bool:
        """Return whether the error keeps an accepted step of size h from growing."""
        return h < self.maximum and self._change(error, h) < HOLD

    def after(self, error: float, h: float, iterations: int = 0) -> float:
        """Return the next step size after an accepted step of size h with so many Newton iterations."""
        share = self.allowed(h)
        change = factor_of_order(error, share, self.order)
        return planned(change, share, h, self.minimum, self.maximum, iterations)

    def retry(self, error: float, h: float) -> float:
        """Return the step size to try after a rejected step of size h."""
        return retried(self._change(error, h), h, self.minimum)
