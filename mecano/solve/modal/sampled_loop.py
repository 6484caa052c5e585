r"""Loop transfer function of a sampled loop that is opened at its sample and hold.

The samples of the loop see all frequencies of the held value that differ by multiples of the sampling frequency. With
the period T and the loop transfer function L(s) of sinusoids, in which the value has its mean over a period,

.. math::  L^*(s) = \sum_{k=-\infty}^{\infty} L(s + 2 \pi i k/T) - \tfrac12 g\,(1 - e^{-sT}), \qquad
           L(s) = \frac{1 - e^{-sT}}{s T}\, G(s), \quad g = \lim_{s \to \infty} G(s),

is the loop transfer function of the samples: a function of z = exp(s T), real at half the sampling frequency. The last
term is there because a sample is taken before the held value jumps, and the sum converges to the mean of both sides.
(Franklin, Powell & Workman, Digital Control of Dynamic Systems.) The sum is cut off smoothly at several K, which also
suppresses oscillating terms of delays, and extrapolated in powers of 1/K.
"""

from collections.abc import Callable

import numpy as np

from mecano.solve.modal.encirclements import encirclements

LEVELS = np.array([12, 16, 24, 32])  # K
FLAT = 0.25  # of K, up to where all terms count fully
SLOWEST = 1e-3  # of the lowest frequency: radius of the contour around zero


class SampledLoop:
    """The function L*(s) (1, 1) of a loop transfer function ``L(s)`` (1, 1) with the sampling ``period`` [s].

    ``jumps``: whether what the hold drives may act on its input at once, not after a delay.
    """

    def __init__(self, L: Callable[[complex], np.ndarray], period: float, jumps: bool):
        self._L, self.period, self._jumps = L, period, jumps
        most = LEVELS[-1]
        orders = np.arange(len(LEVELS))
        extrapolated = np.linalg.inv(LEVELS[:, None] ** -orders.astype(float))[0]
        self._numbers = np.arange(-most, most + 1)
        self._weights = extrapolated @ _cut_off(self._numbers / LEVELS[:, None])
        self._limit = np.linalg.inv(LEVELS[:, None] ** (-2.0 * orders))[0]

    def __call__(self, s: complex) -> np.ndarray:
        """Return L*(s) (1, 1), infinite where one of its terms is."""
        shifted = s + 2j * np.pi * self._numbers / self.period
        terms = np.array([self._L(one)[0, 0] for one in shifted])
        if not np.isfinite(terms).all():
            return np.full((1, 1), np.inf + 0j)
        total = self._weights @ terms
        if self._jumps:
            G = terms * shifted * self.period  # times 1 - exp(-s T)
            middle = LEVELS[-1]
            total -= 0.25 * self._limit @ (G[middle + LEVELS] + G[middle - LEVELS])
        return np.array([[total]])

    def turns(self, low: float) -> int | None:
        """Return how many more poles of the samples grow when the loop is closed, None if that is undefined.

        ``low`` [rad/s]: the lowest frequency of interest.
        """
        return encirclements(lambda s: 1.0 + complex(self(s)[0, 0]), SLOWEST * low, np.pi / self.period)


def _cut_off(x):
    """Return a smooth function that is 1 for abs(x) up to FLAT and 0 from 1 on."""
    share = np.clip((np.abs(x) - FLAT) / (1.0 - FLAT), 1e-9, 1.0 - 1e-9)
    before, after = np.exp(-1.0 / (1.0 - share)), np.exp(-1.0 / share)
    return before / (before + after)
