"""Frequencies at which transfer functions are computed: a grid, refined where they vary fast, and their peaks.

A grid alone may miss a lightly damped resonance. Points are therefore added around each mode of the model, then between
any two points whose responses differ much, and each peak is located.
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from mecano.solve.linear.rounding import TINY

LIGHT = 0.5  # damping ratio below which a mode has a resonance
UNDAMPED = 1e-9  # damping ratio that counts as zero: the peak is infinite
NARROWEST = 1e-4  # of a frequency: least distance of added points
STEP = 0.35  # largest change of the logarithm of a response between two points
MOST = 10  # largest number of points, over the number requested
PROMINENT = 1.01  # ratio of a peak to the valleys beside it
LOCATED = 1e-9  # of its frequency: change at which a peak is located
ROUNDS = 12
SIDES = -1.0, 1.5  # factors of the distances below and above a resonance; unequal, to avoid the midpoint


class Peak(NamedTuple):
    """A local maximum of the magnitude of a transfer function."""

    output: int  # index
    input: int  # index
    frequency: float  # [Hz]
    value: complex  # of the transfer function; infinite if the mode has no damping


class Sampled:
    """A transfer function ``evaluate(omega)`` -> (p, m), with its values at the frequencies evaluated so far."""

    def __init__(self, evaluate: Callable[[float], np.ndarray]):
        self._evaluate, self._found = evaluate, dict[float, np.ndarray]()

    def at(self, omega: float) -> np.ndarray:
        """Return H (p, m) at ``omega`` [rad/s], computed once."""
        if omega not in self._found:
            self._found[omega] = self._evaluate(omega)
        return self._found[omega]

    @property
    def values(self) -> tuple[np.ndarray, np.ndarray]:
        """The circular frequencies (n,) [rad/s], ascending, and the responses (n, p, m)."""
        omegas = np.array(sorted(self._found))
        return omegas, np.array([self._found[omega] for omega in omegas.tolist()])


def grid(low: float, high: float, number: int, linear: bool = False) -> np.ndarray:
    """Return frequencies (number,) from ``low`` to ``high``, at equal ratios or, if ``linear``, equal distances."""
    found = np.linspace(low, high, number) if linear or number == 1 else np.geomspace(low, high, number)
    found[0], found[-1] = low, high if number > 1 else low
    return found


def refine(sampled: Sampled, base: np.ndarray, poles: Iterable[complex]) -> None:
    """Add points near the resonances of ``poles`` [1/s] and where responses at ``base`` (n,) [rad/s] vary fast."""
    low, high, most = base[0], base[-1], MOST * len(base)
    for omega in base.tolist():
        sampled.at(omega)
    if not low < high:
        return
    for pole in poles:
        for omega in _around(pole, np.log(high / low) / len(base)):
            if low < omega < high:
                sampled.at(omega)
    while True:
        omegas, H = sampled.values
        with np.errstate(divide="ignore", invalid="ignore"):
            change = np.abs(np.log(H[1:] / H[:-1])).reshape(len(omegas) - 1, -1)
        change[~np.isfinite(change)] = 0.0
        wide = (omegas[1:] / omegas[:-1] > 1.0 + NARROWEST) & (change.max(axis=1, initial=0.0) > STEP)
        if not wide.any() or len(omegas) + wide.sum() > most:
            return
        for omega in np.sqrt(omegas[1:] * omegas[:-1])[wide].tolist():
            sampled.at(omega)


def _around(pole, spacing):
    """Return frequencies [rad/s] at, and at growing distances from, the resonance of a pole; none if it is well damped.

    The distances end at ``spacing`` times the frequency.
    """
    size, omega = abs(pole), abs(pole.imag)
    if not size or -pole.real > LIGHT * size:
        return []
    share = max(abs(pole.real) / size, NARROWEST)
    distances = [share * 2.0**k for k in range(-1, 20) if share * 2.0**k < spacing]
    own = [omega] if abs(pole.real) > UNDAMPED * size else []
    return own + [omega * (1.0 + factor * by) for by in distances for factor in SIDES]


def peaks(sampled: Sampled, poles: Iterable[complex]) -> list[Peak]:
    """Return the Peaks between the first and the last frequency, located, in the order of outputs, inputs, frequency.

    Their frequencies are added to those of ``sampled``.
    """
    omegas, H = sampled.values
    free = np.array([abs(pole.imag) for pole in poles if pole.imag and abs(pole.real) <= UNDAMPED * abs(pole)])
    found = []
    for i in range(H.shape[1]):
        for j in range(H.shape[2]):
            size = np.abs(H[:, i, j])
            for k in _maxima(size):
                inside = free[(free > omegas[k - 1]) & (free < omegas[k + 1])]
                if len(inside):
                    omega, value = float(inside[0]), complex(np.inf)
                else:
                    omega = _located(sampled, i, j, omegas[k - 1 : k + 2].tolist())
                    value = complex(sampled.at(omega)[i, j])
                found.append(Peak(i, j, omega / (2.0 * np.pi), value))
    return found


def _maxima(size):
    """Return the indices of those local maxima of ``size`` (n,) that stand out from the valleys on both sides."""
    found = []
    for k in range(1, len(size) - 1):
        if size[k] <= size[k - 1] or size[k] < size[k + 1]:
            continue
        valleys = []
        for side in (size[k - 1 :: -1], size[k + 1 :]):
            higher = np.flatnonzero(side > size[k])
            valleys.append(side[: higher[0] if len(higher) else len(side)].min())
        if size[k] > PROMINENT * max(valleys):
            found.append(k)
    return found


def _located(sampled, i, j, bracket):
    """Return the frequency [rad/s] of the peak within three frequencies, of which the middle one has the largest value.

    1/abs(H)^2 of a single resonance is a parabola of the square of the frequency; its lowest point is found repeatedly.
    """
    for _ in range(ROUNDS):
        x = np.array(bracket) ** 2
        f = np.array([1.0 / max(abs(sampled.at(omega)[i, j]) ** 2, TINY) for omega in bracket])
        if not np.isfinite(1.0 / np.maximum(f, TINY)).all():
            break
        u, v = x - x[1], f - f[1]
        below = u[0] * v[2] - u[2] * v[0]
        if below == 0.0:
            break
        shift = 0.5 * (u[0] ** 2 * v[2] - u[2] ** 2 * v[0]) / below
        best = float(np.sqrt(np.clip(x[1] + shift, x[0], x[2])))
        if abs(best - bracket[1]) <= LOCATED * best or best in bracket:
            break
        points = sorted([*bracket, best], key=lambda omega: -abs(sampled.at(omega)[i, j]))
        inner = points[0]
        around = sorted([*bracket, best])
        at = around.index(inner)
        if not 0 < at < len(around) - 1:
            break
        bracket = around[at - 1 : at + 2]
    return bracket[1]
