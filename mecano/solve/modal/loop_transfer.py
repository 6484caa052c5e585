r"""Loop transfer function of a signal, its crossovers, and the margins of stability that follow from them.

The loop is opened at a signal: whatever reads it receives an input u in its place, and the signal returns y. Then

.. math::  L(s) = -y/u, \qquad S(s) = \frac{1}{1 + L(s)},

so that the closed loop, u = y + d, has u = S d: of negative feedback L is positive at low frequencies. Where |L| = 1,
the phase margin is pi + arg L, and the delay margin the phase margin, taken from 0 to 2 pi, over the frequency: a delay
of that time in the loop brings two poles to this frequency. Where L = -1/g with a real g, g is a gain margin: the loop
with g times the gain has poles at this frequency. The largest |S| is the sensitivity peak, and 1/|S| the least distance
of L from -1. (Franklin, Powell & Emami-Naeini, Feedback Control of Dynamic Systems; Åström & Murray, Feedback Systems.)
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from mecano.maths.root import root
from mecano.solve.modal.frequency_grid import Sampled, peaks, refine
from mecano.solve.modal.frequency_response import Plant
from mecano.solve.modal.linearize import Linearization

ON_AXIS = 1e-9  # rad: distance of the phase from -180 deg that is rounding
LOCATED = 1e-13  # of the logarithm of a frequency
THROUGH_POLE = 2.8  # rad: change of the phase between two points that is a pole on the axis: L passes through infinity


@dataclass(frozen=True)
class Crossover:
    """A frequency at which L has the magnitude 1 (``gain``) or a phase of -180 degrees."""

    gain: bool
    frequency: float  # [Hz]; 0 for the limit at low frequency
    value: complex  # of L

    @property
    def gain_margin(self) -> float:
        """Factor of the gain that brings poles to this frequency; nan if the phase is another."""
        return np.nan if self.gain else 1.0 / abs(self.value)

    @property
    def phase_margin(self) -> float:
        """Lag [rad] that brings poles to this frequency, negative for a lead; nan if the magnitude is not 1."""
        return float(np.angle(-self.value)) if self.gain else np.nan

    @property
    def delay_margin(self) -> float:
        """Least delay [s] that brings poles to this frequency; nan if the magnitude is not 1."""
        return self.phase_margin % (2.0 * np.pi) / (2.0 * np.pi * self.frequency) if self.gain else np.nan


def opened(plant: Plant, value: int, own: Iterable[int]) -> Plant:
    """Return the Plant in which only the unknowns ``own`` of a signal read its ``value``, an unknown.

    Of its output the sign is reversed: its transfer function is L.
    """
    lin, rows = plant.lin, np.fromiter(own, int)
    M, C, K = (_unread(A, value, rows) for A in (lin.M, lin.C, lin.K))
    n = K.shape[0]
    none = sp.csr_matrix((1, n))
    returned = sp.csr_matrix(([-1.0], ([0], [value])), shape=(1, n))
    late = [one for one in plant.late if one[1] != value or one[0] in rows]
    return replace(plant, lin=replace(lin, M=M, C=C, K=K), outputs=[returned, none, none], late=late)


def _unread(A, column, rows):
    """Return a copy of A in which a column has entries in some rows only."""
    A = A.tocoo(copy=True)
    A.data[(A.col == column) & ~np.isin(A.row, rows)] = 0.0
    return A.tocsr()


def in_loops(lin: Linearization, late: Iterable[tuple[int, int, Callable[[complex], complex]]]) -> np.ndarray:
    """Return the number (n,) of the loop in which each unknown is: unknowns of one loop depend on one another."""
    pattern = sum((abs(A) for A in (lin.M, lin.C)), abs(lin.K)).tolil()
    for row, column, _ in late:
        pattern[row, column] = 1.0
    pattern = pattern.tocsr()
    pattern.eliminate_zeros()
    return connected_components(pattern, directed=True, connection="strong")[1]


def sample(L: Sampled, base: np.ndarray, poles: Iterable[complex]) -> Sampled:
    """Add points to L around ``poles`` [1/s], and where L or S vary fast between those at ``base`` [rad/s]; return S.

    L and S have the shape (1, 1).
    """
    S = Sampled(lambda omega: _sensitivity(L.at(omega)))
    refine(L, base, poles)
    refine(S, base, poles)
    return S


def _sensitivity(L):
    """Return 1/(1 + L), infinite where L is -1 and zero where L is infinite."""
    if not np.isfinite(L).all():
        return np.zeros_like(L)
    with np.errstate(divide="ignore", invalid="ignore"):
        S = 1.0 / (1.0 + L)
    return np.where(np.isfinite(S), S, np.inf + 0j)


def highest(S: Sampled, poles: Iterable[complex]) -> tuple[float, float]:
    """Return (magnitude, frequency [Hz]) of the largest of the sampled S, located; infinite of undamped ``poles``."""
    found = [(abs(peak.value), peak.frequency) for peak in peaks(S, poles)]
    omegas, values = S.values
    found += zip(np.abs(values[:, 0, 0]).tolist(), (omegas / (2.0 * np.pi)).tolist(), strict=True)
    return max(found, key=lambda one: one[0])


def crossovers(L: Sampled, static: float) -> list[Crossover]:
    """Return the Crossovers between the sampled frequencies, located, by ascending frequency.

    ``static``: limit of L at low frequency, nan if there is none; if it is negative, it is the first one.
    """
    found = [Crossover(False, 0.0, complex(static))] if static < 0.0 else []
    omegas, values = L.values
    values = values[:, 0, 0]
    known = np.isfinite(values) & (values != 0.0)
    omegas, values = omegas[known], values[known]
    for gain, distance, most in ((True, _logarithm, np.inf), (False, _from_negative_axis, THROUGH_POLE)):
        for low, high in _sign_changes(omegas, distance(values), most):
            omega = _zero(lambda omega, of=distance: float(of(L.at(omega)[0, 0])), low, high)
            value = complex(L.at(omega)[0, 0])
            if gain or value.real < 0.0:
                found.append(Crossover(gain, omega / (2.0 * np.pi), value))
    return sorted(found, key=lambda one: one.frequency)


def _logarithm(value):
    return np.log(np.abs(value))


def _from_negative_axis(value):
    """Return the angle [rad] from the negative real axis; zero where it is rounding."""
    angle = np.angle(-value)
    return np.where(np.abs(angle) <= ON_AXIS, 0.0, angle)


def _sign_changes(omegas, distance, most) -> Iterator[tuple[float, float]]:
    """Yield the intervals in which a distance (n,) passes through zero, and changes by less than ``most``."""
    away = np.flatnonzero(distance)
    for i, j in zip(away[:-1], away[1:], strict=True):
        if distance[i] * distance[j] < 0.0 and abs(distance[i] - distance[j]) < most:
            yield float(omegas[i]), float(omegas[j])


def _zero(f, low, high):
    """Return the zero of a function of the frequency that changes its sign between two frequencies."""
    return float(np.exp(root(lambda x: f(np.exp(x)), np.log(low), np.log(high), LOCATED)))
