"""The size of the next step, from how the last one went."""

import math
from dataclasses import dataclass

SAFETY = 0.9
GROWTH = 2.0
SHRINK = 0.2
HOLD = 1.25  # a step that could grow by less keeps its size, because a change costs a projection
RESERVE = 0.85  # a step that must shrink shrinks by that much more, so that the next ones keep their size
AFTER_FAILURE = 0.25
FORGOTTEN = 1e-3  # of the tolerance: the error of one step in what forgets it


@dataclass(frozen=True)
class FixedStep:
    """Steps of one size; smaller only where Newton fails, at events and at times that must be met."""

    step: float
    minimum: float

    @property
    def maximum(self):
        """The longest step."""
        return self.step

    def allowed(self, h):
        """Any error: a fixed step has no error control."""
        return math.inf

    def forgotten(self, lag, h):
        """The error that counts for one which the next steps forget: the same."""
        return lag

    def accept(self, error, h):
        """Always."""
        return True

    def holds(self, error, h):
        """Never: no error keeps a fixed step from growing."""
        return False

    def after(self, error, h):
        """The next step size after an accepted step of size h."""
        return min(self.step, GROWTH * h)


@dataclass(frozen=True)
class AdaptiveStep:
    """Error per unit step: the local errors of a run of ``duration`` [s] add up to ``tolerance`` at most.

    The tolerance is relative to the length scale of the mechanism (or to one radian). The local error falls as h^3,
    its sum as h^2, which gives the exponent 1/2.
    """

    tolerance: float
    duration: float
    minimum: float
    maximum: float

    def allowed(self, h):
        """The share of the tolerance of a step of size h."""
        return self.tolerance * h / self.duration

    def forgotten(self, lag, h):
        """The error in a step of size h that counts for one which the next steps forget: each may be FORGOTTEN."""
        return lag * min(h / self.duration / FORGOTTEN, 1.0)

    def _factor(self, error, h):
        return SAFETY * (self.allowed(h) / error) ** 0.5 if error > 0 else GROWTH

    def accept(self, error, h):
        """True when the error is within its share, or the step was cut to less than the minimum to meet a time."""
        return error <= self.allowed(h) or h < self.minimum

    def holds(self, error, h):
        """True when the error keeps an accepted step of size h from growing."""
        return h < self.maximum and self._factor(error, h) < HOLD

    def after(self, error, h):
        """The next step size after an accepted step of size h."""
        factor = self._factor(error, h)
        if 1.0 <= factor < HOLD:
            return h
        factor = min(factor, GROWTH) if factor > 1.0 else factor * RESERVE
        return min(max(h * factor, self.minimum), self.maximum)

    def retry(self, error, h):
        """The step size to try after a rejected step of size h."""
        return max(h * max(self._factor(error, h), SHRINK), self.minimum)
