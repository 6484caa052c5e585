"""Critical values of a parameter, at which a mode becomes unstable or stable, between two neighbouring values.

The error of each value is estimated. Close to a root, the real part is fitted by a parabola; the scatter about the
parabola is the rounding of eigenvalues and states. Where growth starts as (p - p0)^n, two values beyond p0 give n, and
hence the distance from p0 at which growth exceeds rounding.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from mecano.maths.root import root
from mecano.solve.modal.modes import GROWS, unstable
from mecano.solve.modal.tracking import Spectrum

TOLERANCE = 1e-11  # of the value of the parameter
BISECTIONS = 60
JUMP = 0.1  # an eigenvalue ten times farther away than the distance of the branch's ends belongs to another branch
SMALL = 1e-5  # of the eigenvalue: largest real part at the value found; if it is larger, branches were confused
NEAR = 1e-6  # of the distance of the ends: distance from the value found at which the spectrum is sampled
LEAST = 1e-8  # of the value found: lower bound of that distance
AROUND = (-3.0, -2.0, -1.0, 1.0, 2.0, 3.0)  # sample points of the parabola, in units of that distance
SURE = 3.0  # error bound in standard deviations of the scatter


End: TypeAlias = tuple[float, complex, np.ndarray]  # of a branch: place, eigenvalue, shape (n_q,)


def branch_end(spectra: Sequence[Spectrum | None], places: np.ndarray, row: np.ndarray, i: int) -> End:
    """Return the End of a branch at ``places[i]``; ``row`` (n,): indices of the branch in the ``spectra``."""
    spectrum = spectra[i]
    assert spectrum is not None, "a branch ends where a state was found"
    return float(places[i]), spectrum.values[row[i]], spectrum.shapes[row[i]]


@dataclass(frozen=True)
class Critical:
    """A point at which a mode becomes unstable or stable."""

    place: float  # value of the parameter
    value: complex  # eigenvalue there [1/s]
    branch: int
    destabilizes: bool  # True if the mode becomes unstable as the parameter increases
    error: float  # error bound of ``place``


def critical(spectrum_at: Callable[[float], Spectrum], left: End, right: End, branch: int) -> Critical | None:
    """Return the Critical between two ends of a branch, or None if the branch is not continuous between them.

    ``spectrum_at(place)`` returns a Spectrum; ``left``, ``right``: (place, eigenvalue, shape), the ends, one of which
    is unstable. If the other end is damped, the point is the root of the real part; if it is neutral, the point is the
    onset of growth.
    """
    trace = Trace(spectrum_at, left, right)
    low, high = left[0], right[0]
    xtol = TOLERANCE * max(abs(low), abs(high))
    ends = [0.0 if not unstable(v) and not unstable(-v.real + 1j * v.imag) else v.real for _, v, _ in (left, right)]
    if ends[0] * ends[1] < 0.0:
        place = root(lambda p: trace(p).real, low, high, xtol)
        value = trace(place)
        if abs(value.real) > SMALL * max(abs(value), abs(left[1]), abs(right[1])):
            return None
        place, error = _refined(trace, place, low, high, xtol)
    else:
        place, value = _onset(trace, low, high, xtol)
        error = _onset_error(trace, place, low, high) + xtol
    return Critical(place, complex(value.real, abs(value.imag)), branch, bool(unstable(right[1])), error)


def _refined(trace, place, low, high, xtol):
    """Return (root of the parabola fitted to the real parts around ``place``, error bound).

    It is more accurate than ``place``: a real eigenvalue close to zero cannot be separated from free motions.
    """
    reach = min(max(NEAR * (high - low), LEAST * abs(place)), 0.1 * min(place - low, high - place))
    if reach <= 4.0 * np.spacing(abs(place)):
        return place, xtol
    growth = [trace(place + reach * k).real for k in AROUND]
    (value, slope, _), scatter, *_ = np.linalg.lstsq(np.vander(AROUND, 3, increasing=True), growth, rcond=None)
    deviation = math.sqrt(float(scatter[0]) / (len(AROUND) - 3))
    shift = -value / slope if slope else math.inf
    if not abs(shift) < AROUND[-1]:
        return place, max(xtol, AROUND[-1] * reach)
    return float(place + reach * shift), float(reach * SURE * deviation / abs(slope) + 2.0 * np.spacing(abs(place)))


def _onset_error(trace, place, low, high):
    """Return the error bound of an onset of growth found at ``place``, where growth exceeds rounding.

    Growth that increases from zero in proportion to the parameter begins at the place to which it extrapolates.
    """
    side = 1.0 if unstable(trace(high)) else -1.0
    reach = NEAR * (high - low)
    near, far = (trace(min(max(place + side * k * reach, low), high)) for k in (1.0, 2.0))
    if not (unstable(near) and far.real > near.real):
        return 2.0 * reach
    order = math.log2(far.real / near.real)
    straight = reach * near.real / (far.real - near.real)
    return max(2.0 * reach * (GROWS * abs(near) / near.real) ** (1.0 / order), straight)


def _onset(trace, low, high, xtol):
    """Return (onset of growth, found by bisection, eigenvalue at the last point evaluated)."""
    grows, value = bool(unstable(trace(low))), 0j
    for _ in range(BISECTIONS):
        if abs(high - low) <= xtol:
            break
        middle = 0.5 * (low + high)
        value = trace(middle)
        if bool(unstable(value)) == grows:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high), value


class Trace:
    """The eigenvalue of a branch between two ends: at each place the one closest to the interpolated eigenvalue."""

    def __init__(self, spectrum_at: Callable[[float], Spectrum], left: End, right: End):
        self.spectrum_at, self.known = spectrum_at, [left, right]

    def __call__(self, place: float) -> complex:
        """Return the eigenvalue at a place; zero where the branch has reached the free motions."""
        for p, value, _ in self.known:
            if p == place:
                return value
        below = max((k for k in self.known if k[0] < place), key=lambda k: k[0])
        above = min((k for k in self.known if k[0] > place), key=lambda k: k[0])
        share = (place - below[0]) / (above[0] - below[0])
        spectrum = self.spectrum_at(place)
        if not len(spectrum.values):
            return 0j
        guess, shape = below[1] + share * (above[1] - below[1]), (below, above)[share > 0.5][2]
        i = spectrum.nearest(guess, shape)
        value, reach = spectrum.values[i], abs(above[1] - below[1])
        if abs(guess) <= reach < JUMP * abs(value - guess):  # the branch has reached zero, among the free motions
            return 0j
        self.known.append((place, value, spectrum.shapes[i]))
        return value
