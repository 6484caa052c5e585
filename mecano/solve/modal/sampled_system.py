r"""Difference equations of a linear system whose signals are sampled and held: stability, and loop transfer functions.

Between samples the held values u are constant, and the rest of the model, x' = A x + B u with the inputs of the
samplers y = C x + D u, moves exactly by (Van Loan 1978)

.. math::  \begin{bmatrix} x \\ u \end{bmatrix}(t + h) =
           \exp\left(h \begin{bmatrix} A & B \\ 0 & 0 \end{bmatrix}\right) \begin{bmatrix} x \\ u \end{bmatrix}(t).

At a sampling time of some samplers their u become their y, with the values of all u before. The product of these
matrices over the common period T of all samplers has the eigenvalues z = exp(s T) of the closed loop: it is unstable if
one of them has a modulus above 1. (Franklin, Powell & Workman, Digital Control of Dynamic Systems.)
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from mecano.errors import UsageError
from mecano.solve.modal.frequency_response import Plant
from mecano.solve.modal.late_feedback import without_late
from mecano.solve.modal.linearize import Linearization
from mecano.solve.modal.state_space import state_space

LARGEST = 400  # motions up to which dense matrices are computed
MOST = 1000  # sampling times in a common period
COMMENSURABLE = 1e-9  # of a ratio of periods
STEADY = 1e-6  # of a modulus 1: rounding error of multiple eigenvalues, such as those of free motions
FORGOTTEN = 1e-12  # smaller eigenvalues z are decays within a period


@dataclass(frozen=True)
class Sampler:
    """A sampled signal: indices of its value and of its input among the unknowns, period [s]."""

    value: int
    input: int
    period: float


class SampledSystem:
    """The closed loop of a Linearization and its ``samplers``, which all sample at the same first time."""

    def __init__(self, lin: Linearization, samplers: Sequence[Sampler]):
        self.samplers = tuple(samplers)
        self.pace = lin.pace
        self._unit, self._counts = _common(self.samplers)
        self.period = self._unit * np.lcm.reduce(self._counts)
        rest = state_space(_rest(lin, self.samplers))
        n, m = rest.B.shape
        self._rate, self._sampled = np.zeros((n + m, n + m)), np.hstack([rest.C, rest.D])
        self._rate[:n] = np.hstack([rest.A, rest.B])
        self._flows: dict[int, np.ndarray] = {}

    def growing(self) -> np.ndarray:
        """Return the eigenvalues s [1/s] (k,) of the closed loop that grow, each of conjugate pairs."""
        s = self._exponents(self._over_period(np.zeros(0, int)))
        return s[s.real * self.period > STEADY]

    def poles(self) -> np.ndarray:
        """Return the eigenvalues s [1/s] (k,) with imaginary parts from 0 to half the sampling frequency."""
        return self._exponents(self._over_period(np.zeros(0, int)))

    def loop(self, number: int) -> "DiscreteLoop":
        """Return the loop transfer function of a sampler, whose period is the common one, with the others closed."""
        Phi = self._over_period(np.array([number]))
        at = len(self._rate) - len(self.samplers) + number
        column = self._rest_of_period()[:, at]
        return DiscreteLoop(Phi, column, -self._sampled[number], self.period, self._exponents(Phi))

    def _over_period(self, opened):
        """Return the matrix over a common period, from before its first samples, without those of ``opened``."""
        first = self._jump(0)
        first[len(self._rate) - len(self.samplers) + opened] = 0.0
        return self._rest_of_period() @ first

    def _rest_of_period(self):
        """Return the matrix from after the first samples of a common period to its end."""
        end = int(np.lcm.reduce(self._counts))
        times = sorted({i for count in self._counts for i in range(count, end, count)})
        found, last = np.eye(len(self._rate)), 0
        for time in times:
            found = self._jump(time) @ (self._flow(time - last) @ found)
            last = time
        return self._flow(end - last) @ found

    def _jump(self, time):
        """Return the matrix of the samples at a ``time`` in units."""
        found = np.eye(len(self._rate))
        for k, count in enumerate(self._counts):
            if time % count == 0:
                found[len(found) - len(self.samplers) + k] = self._sampled[k]
        return found

    def _flow(self, units):
        """Return the matrix of a motion with constant held values, in balanced units."""
        if units not in self._flows:
            A = units * self._unit * self._rate
            size = np.diag(la.matrix_balance(A, permute=False)[1])
            self._flows[units] = size[:, None] * la.expm(A * size / size[:, None]) / size
        return self._flows[units]

    def _exponents(self, Phi):
        """Return s of the eigenvalues z = exp(s T) of a matrix, one of each conjugate pair."""
        z = la.eigvals(Phi)
        z = z[(np.abs(z) > FORGOTTEN) & (z.imag >= 0.0)]
        return np.log(z) / self.period


class DiscreteLoop:
    """The loop transfer function L*(s) (1, 1) of a sampler, a function of exp(s T); ``poles``: its poles [1/s]."""

    def __init__(self, Phi: np.ndarray, column: np.ndarray, row: np.ndarray, period: float, poles: np.ndarray):
        self._T, Q = la.schur(Phi, output="complex")
        self._column, self._row = Q.conj().T @ column, row @ Q
        self.period, self.poles = period, poles

    def __call__(self, s: complex) -> np.ndarray:
        """Return L*(s) (1, 1), infinite at a pole."""
        A = np.exp(s * self.period) * np.eye(len(self._T)) - self._T
        if not np.diag(A).all():
            return np.full((1, 1), np.inf + 0j)
        return np.array([[self._row @ la.solve_triangular(A, self._column, check_finite=False)]])


def sampled_system(lin: Linearization, samplers: Sequence[Sampler]) -> SampledSystem | str:
    """Return the SampledSystem of a Linearization, or why there is none, as text."""
    if lin.n_q > LARGEST:
        return f"the model has more than {LARGEST} motions"
    try:
        return SampledSystem(lin, samplers)
    except UsageError as error:
        return str(error)


def _common(samplers):
    """Return (unit [s], numbers of units of the periods of samplers). Raises UsageError."""
    shortest = min(one.period for one in samplers)
    ratios = [Fraction(one.period / shortest).limit_denominator(MOST) for one in samplers]
    denominator = int(np.lcm.reduce([ratio.denominator for ratio in ratios]))
    counts = np.array([int(ratio * denominator) for ratio in ratios])
    unit = shortest / denominator
    exact = all(
        abs(count * unit / one.period - 1.0) <= COMMENSURABLE for count, one in zip(counts, samplers, strict=True)
    )
    end = int(np.lcm.reduce(counts))
    if not exact or sum(end // count for count in counts.tolist()) > MOST:
        periods = ", ".join(f"{period:g} s" for period in sorted({one.period for one in samplers}))
        raise UsageError(f"the sampling periods {periods} have no common multiple within {MOST} samples")
    return unit, counts


def _rest(lin, samplers) -> Plant:
    """Return the Plant whose inputs are the held values and whose outputs are the inputs of the samplers."""
    n, m = lin.K.shape[0], len(samplers)
    columns, rows = np.zeros((n, m)), np.zeros((m, n))
    columns[[one.value for one in samplers], range(m)] = 1.0
    rows[range(m), [one.input for one in samplers]] = 1.0
    none = sp.csr_matrix((m, n))
    late = [(one.value, one.input, complex) for one in samplers]
    plant = Plant(lin, [columns, 0.0 * columns, 0.0 * columns], [sp.csr_matrix(rows), none, none], late)
    return replace(plant, lin=without_late(plant), late=())
