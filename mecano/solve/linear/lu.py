"""LU factors of real or complex matrices of one pattern, by LAPACK where they are small and by SuperLU."""

import numpy as np
import scipy.linalg.lapack as lapack
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from mecano.process.memory import reserve_blas_buffer

MOST_DENSE = 150  # equations: larger matrices are sparse


def factors(n: int, rows: np.ndarray, cols: np.ndarray, dtype: np.dtype | type) -> "DenseFactors | SparseFactors":
    """Return a DenseFactors or SparseFactors for the pattern ``rows``, ``cols`` (nnz,), each entry once."""
    reserve_blas_buffer(lapack.dgesv)
    return (DenseFactors if n <= MOST_DENSE else SparseFactors)(n, rows, cols, dtype)


class DenseFactors:
    """LU with partial pivoting of a full matrix.

    Attributes
    ----------
    values : (n**2,) float or complex
        The matrix, to be changed in place.
    place : (nnz,) int
        Where each entry of the pattern stands in ``values``.
    """

    def __init__(self, n: int, rows: np.ndarray, cols: np.ndarray, dtype: np.dtype | type):
        self.values, self.place = np.zeros(n * n, dtype), cols * n + rows
        self._matrix = self.values.reshape(n, n, order="F")
        self._factor, self._solve = (
            (lapack.zgetrf, lapack.zgetrs) if dtype is complex else (lapack.dgetrf, lapack.dgetrs)
        )

    def factor(self) -> bool:
        """Factor the matrix; return whether no pivot is zero; one that is not finite may pass."""
        self._lu, self._exchanges, info = self._factor(self._matrix)
        return info == 0

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return the solution x (n,) of A x = b."""
        return self._solve(self._lu, self._exchanges, b)[0]


class SparseFactors:
    """LU with partial pivoting by SuperLU; attributes as in DenseFactors, with ``values`` (nnz,) by columns."""

    def __init__(self, n: int, rows: np.ndarray, cols: np.ndarray, dtype: np.dtype | type):
        order = np.lexsort((rows, cols))
        self.values, self.place = np.zeros(len(rows), dtype), np.empty(len(rows), np.int64)
        self.place[order] = np.arange(len(rows))
        starts = np.searchsorted(cols[order], np.arange(n + 1))
        self._matrix = sp.csc_matrix((self.values, rows[order].astype(np.int32), starts.astype(np.int32)), (n, n))

    def factor(self) -> bool:
        """Factor the matrix; return whether it is regular and finite."""
        if not np.isfinite(self.values).all():
            return False
        self._matrix.data = self.values
        try:
            self._lu = spla.splu(self._matrix)
        except RuntimeError:  # a pivot is zero
            return False
        return True

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return the solution x (n,) of A x = b."""
        return self._lu.solve(b)
