r"""Response of small motions to sinusoidal inputs: the transfer functions of a Linearization.

With s = i omega, the columns Q of the inputs u and the rows R of the outputs z, each a polynomial of s,

.. math::
   (s^2 M + s C + K)\, y = (Q_0 + s Q_1 + s^2 Q_2)\, u, \qquad z = (R_0 + s R_1 + s^2 R_2)\, y, \qquad H(s) = z/u.

y are the motions, signals and multipliers together, so the constraints are in the rows of K and C, and a prescribed
motion is the right-hand side of its constraint: its rates follow exactly. One sparse factorization for each frequency
gives the responses to all inputs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from mecano.solve.linear.rounding import TINY
from mecano.solve.modal.linearize import Linearization

ROUNDS = 4  # of the balance of rows and columns
ROUNDED = 1e-14  # of the largest unknown, in balanced units: a smaller response counts as zero
REFINED = 2  # rounds of iterative refinement


@dataclass(frozen=True)
class Plant:
    """A Linearization with inputs and outputs, as polynomials of s."""

    lin: Linearization
    inputs: Sequence[np.ndarray]  # Q0, Q1, Q2, each (n, m)
    outputs: Sequence[sp.csr_matrix]  # R0, R1, R2, each (p, n)
    late: Sequence[tuple[int, int, Callable[[complex], complex]]] = ()
    """(row, column, f) of signals that read earlier values: -f(s) is their entry"""
    late_inputs: Sequence[tuple[int, int, Callable[[complex], complex]]] = ()
    """(row, input, f) of signals that read earlier values of an input: f(s) is its force"""


class TransferFunction:
    """The function H(s) (p, m) of a Plant; ``error`` is the largest backward error of its solutions so far."""

    def __init__(self, plant: Plant):
        self.plant, self.error = plant, 0.0
        parts = [sp.csc_matrix(A) for A in (plant.lin.K, plant.lin.C, plant.lin.M)]
        late = [sp.csc_matrix(([1.0], ([i], [j])), shape=parts[0].shape) for i, j, _ in plant.late]
        self.pattern = sum((abs(A) for A in late), sum((abs(A) for A in parts[1:]), abs(parts[0]))).tocsc()
        self.pattern.sort_indices()
        self.column = np.repeat(np.arange(self.pattern.shape[0]), np.diff(self.pattern.indptr))
        self._balanced: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        self.outputs = [(k, R, abs(R)) for k, R in enumerate(plant.outputs) if R.nnz or k == 0]
        self.data = [_values_on(self.pattern, A) for A in parts]
        self.late = [
            (np.flatnonzero(_values_on(self.pattern, A)), f) for A, (_, _, f) in zip(late, plant.late, strict=True)
        ]

    def __call__(self, s: complex) -> np.ndarray:
        """Return H(s) (p, m); infinite where s is an eigenvalue to rounding."""
        return self.with_size(s)[0]

    def with_size(self, s: complex) -> tuple[np.ndarray, np.ndarray]:
        """Return H(s) (p, m), and its size (p, m) if all unknowns were as large as the largest, in balanced units.

        Entries of H below ROUNDED times that size are set to zero.
        """
        Q0, Q1, Q2 = self.plant.inputs
        Q = Q0 + complex(s) * Q1 + complex(s) ** 2 * Q2
        for row, number, f in self.plant.late_inputs:
            Q[row, number] = f(s)
        found = self._solution(s, Q)
        if found is None:
            return (np.full((self.plant.outputs[0].shape[0], Q0.shape[1]), np.inf + 0j),) * 2
        y, largest = found
        H = sum(complex(s) ** k * (R @ y) for k, R, _ in self.outputs)
        size = sum(abs(s) ** k * (terms @ largest) for k, _, terms in self.outputs)
        return np.where(np.abs(H) > ROUNDED * size, H, 0.0), size

    def _solution(self, s, b):
        """Return y (n, m) and the size of the largest unknown in the units of all (n, m), or None if singular."""
        rows, columns = self._factors(s)
        A = self._matrix(self._values(s) * rows[self.pattern.indices] * columns[self.column])
        try:
            factor = spla.splu(A)
        except RuntimeError:  # exactly singular
            return None
        right = rows[:, None] * b
        x = factor.solve(right)
        for _ in range(REFINED):
            x = x + factor.solve(right - A @ x)
        if not np.isfinite(x).all():
            return None
        largest = np.abs(x).max(axis=0, initial=0.0) + np.zeros(x.shape)
        size = self._matrix(np.abs(A.data)) @ largest + np.abs(right)
        residual = np.abs(A @ x - right)
        self.error = max(self.error, float(np.max(residual / np.maximum(size, TINY), initial=0.0)))
        return columns[:, None] * x, columns[:, None] * largest

    def _factors(self, s):
        """Return the factors of the rows and columns (n,), which are those of a near power of two."""
        octave = round(np.log2(abs(s))) if s else 0
        if octave not in self._balanced:
            self._balanced[octave] = _balance(self._matrix(self._values(2.0**octave * 1j if s else 0.0)))
        return self._balanced[octave]

    def _values(self, s):
        """Return the entries of the matrix on the pattern."""
        K, C, M = self.data
        data = K + complex(s) * C + complex(s) ** 2 * M
        for entry, f in self.late:
            data[entry] = -f(s)
        return data

    def _matrix(self, data):
        return sp.csc_matrix((data, self.pattern.indices, self.pattern.indptr), shape=self.pattern.shape)


def _values_on(pattern, A):
    """Return the values of A on the entries of a ``pattern`` that contains its own, both by columns."""
    A = A.tocoo()
    n = pattern.shape[0]
    own = np.repeat(np.arange(n), np.diff(pattern.indptr)).astype(np.int64) * n + pattern.indices
    out = np.zeros(pattern.nnz)
    np.add.at(out, np.searchsorted(own, A.col.astype(np.int64) * n + A.row), A.data)
    return out


def _balance(A):
    """Return factors of the rows and columns (n,) that make the largest entries of both about one (Ruiz 2001)."""
    B = sp.csc_matrix(abs(A))
    rows, columns = np.ones(A.shape[0]), np.ones(A.shape[0])
    at = np.repeat(np.arange(A.shape[0]), np.diff(B.indptr))
    for _ in range(ROUNDS):
        value = rows[B.indices] * B.data * columns[at]
        of_rows, of_columns = np.zeros(A.shape[0]), np.zeros(A.shape[0])
        np.maximum.at(of_rows, B.indices, value)
        np.maximum.at(of_columns, at, value)
        rows /= np.sqrt(np.where(of_rows > 0.0, of_rows, 1.0))
        columns /= np.sqrt(np.where(of_columns > 0.0, of_columns, 1.0))
    scale_unread(B, rows, columns)
    return rows, columns


def scale_unread(A: sp.spmatrix, rows: np.ndarray, columns: np.ndarray) -> None:
    """Set, in place, the factors of unknowns that no other equation reads, from the unknowns that their equations read.

    ``A`` (n, n) has no negative entries.
    """
    A = A.tocsr()
    own = A.diagonal()
    unread = np.flatnonzero((np.asarray(A.sum(axis=0)).ravel() == own) & (own > 0.0))
    others = (A - sp.diags(own)).tocsr()[unread]
    size = (others @ sp.diags(columns)).max(axis=1).toarray().ravel() / own[unread]
    unread, size = unread[size > 0.0], size[size > 0.0]
    columns[unread], rows[unread] = size, 1.0 / (size * own[unread])
