"""Values of a parameter at which a mode becomes unstable or stable, found between two neighbouring values."""

from dataclasses import dataclass

from scipy.optimize import brentq

from mecano.solve.tracking import unstable

TOLERANCE = 1e-11  # of the value of the parameter
BISECTIONS = 60
JUMP = 0.1  # an eigenvalue ten times farther off than the ends of the branch are from one another is another one
SMALL = 1e-5  # of the eigenvalue: its real part at the value found, else the branches were mixed up


@dataclass(frozen=True)
class Critical:
    """A mode whose growth changes sign: where, its eigenvalue there [1/s], its branch, the way it goes."""

    place: float
    value: complex
    branch: int
    destabilizes: bool  # as the parameter grows


def critical(spectrum_at, left, right, branch):
    """The Critical between two ends of a branch, or None where the branch does not go through.

    ``spectrum_at(place)`` gives a Spectrum; ``left``, ``right``: (place, eigenvalue, shape), the ends, of which one is
    unstable. Where the other is damped, the root of the real part, where it is neutral, the border of growth.
    """
    trace = _Trace(spectrum_at, left, right)
    low, high = left[0], right[0]
    xtol = TOLERANCE * max(abs(low), abs(high))
    ends = [0.0 if not unstable(v) and not unstable(-v.real + 1j * v.imag) else v.real for _, v, _ in (left, right)]
    if ends[0] * ends[1] < 0.0:
        place = brentq(lambda p: trace(p).real, low, high, xtol=xtol, rtol=4e-16 + TOLERANCE)
        value = trace(place)
        if abs(value.real) > SMALL * max(abs(value), abs(left[1]), abs(right[1])):
            return None
    else:
        place, value = _border(trace, low, high, xtol)
    return Critical(place, complex(value.real, abs(value.imag)), branch, bool(unstable(right[1])))


def _border(trace, low, high, xtol):
    """Where growth sets in, by bisection, and the eigenvalue on the neutral side."""
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


class _Trace:
    """The eigenvalue of a branch between two ends, by what interpolates them."""

    def __init__(self, spectrum_at, left, right):
        self.spectrum_at, self.known = spectrum_at, [left, right]

    def __call__(self, place):
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
        if abs(guess) <= reach < JUMP * abs(value - guess):  # the branch went to zero, among the free motions
            return 0j
        self.known.append((place, value, spectrum.shapes[i]))
        return value
