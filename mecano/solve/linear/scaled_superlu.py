"""Fallback of the multifrontal factorization: SuperLU of the scaled matrix with partial pivoting."""

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from mecano.process.memory import reserve_blas_buffer
from mecano.solve.linear.rounding import TINY

NULL = 1e-6  # entries of the scaled matrix times a unit null vector are smaller


class ScaledSuperLU:
    """LU with partial pivoting by SuperLU of a matrix scaled to a largest entry of 1 in every row and column."""

    def __init__(self, n: int, rows: np.ndarray, cols: np.ndarray, values: np.ndarray, shift: float = 0.0):
        """Factor the scaled matrix plus ``shift`` times the identity; raises RuntimeError where a pivot is zero."""
        reserve_blas_buffer(la.lapack.dgesv)
        self.row_scale = _inverse_maxima(n, rows, np.abs(values))
        scaled = values * self.row_scale[rows]
        self.col_scale = _inverse_maxima(n, cols, np.abs(scaled))
        scaled *= self.col_scale[cols]
        self.matrix = sp.csc_matrix((scaled, (rows, cols)), shape=(n, n))
        self.lu = spla.splu(self.matrix + shift * sp.identity(n, format="csc") if shift else self.matrix)

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return the solution x (n,) of A x = b."""
        return self.col_scale * self.lu.solve(self.row_scale * b)

    def driven_null_vector(self, b: np.ndarray) -> np.ndarray:
        """Return the unit null vector (n,) of the scaled matrix excited by ``b`` (n,): inverse iteration.

        If ``b`` excites none, return one that a vector of ones excites.
        """
        x = self._iterated(self.row_scale * b) if np.any(b) else np.ones(len(b))
        return x if np.abs(self.matrix @ x).max() <= NULL else self._iterated(np.ones(len(b)))

    def _iterated(self, b):
        """Return the unit vector (n,) after three inverse iterations from ``b`` (n,)."""
        for _ in range(3):
            b = self.lu.solve(b)
            b /= np.linalg.norm(b)
        return b

    def reciprocal_condition(self) -> float:
        """Estimate the reciprocal condition number in the 1-norm, of the scaled matrix (Higham & Tisseur 2000).

        Return 0 on overflow.
        """
        n = len(self.row_scale)
        inverse = spla.LinearOperator(
            (n, n), matvec=self.lu.solve, rmatvec=lambda b: self.lu.solve(b, trans="T"), dtype=float
        )
        norms = spla.norm(self.matrix, 1) * spla.onenormest(inverse, t=1)
        return float(1.0 / norms) if np.isfinite(norms) else 0.0


def _inverse_maxima(n, index, values):
    """Return (n,) one over the largest value of each row (or column) numbered in ``index``; 1 if all vanish."""
    largest = np.zeros(n)
    np.maximum.at(largest, index, values)
    return 1.0 / np.where(largest > TINY, largest, 1.0)
