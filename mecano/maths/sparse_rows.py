"""Small sparse matrices by rows (CSR): to import scipy.sparse would take as long as a short run."""

from typing import NamedTuple

import numpy as np

from mecano.maths.distinct import distinct


class SparseRows(NamedTuple):
    """A square matrix by rows, with ascending columns in each."""

    starts: np.ndarray  # (n + 1,) index of the first entry of each row
    columns: np.ndarray  # (nnz,)
    values: np.ndarray  # (nnz,)

    @property
    def rows(self) -> np.ndarray:
        """Row (nnz,) of each entry."""
        return np.repeat(np.arange(len(self.starts) - 1), np.diff(self.starts))

    @property
    def filled(self) -> np.ndarray:
        """Indices, ascending, of the rows with entries."""
        return np.flatnonzero(np.diff(self.starts))

    def __matmul__(self, x):
        """Return the product (n,) with a vector (n,)."""
        return np.bincount(self.rows, self.values * x[self.columns], len(self.starts) - 1)


def sparse_rows(rows: np.ndarray, columns: np.ndarray, values: np.ndarray, n: int) -> SparseRows:
    """Return the SparseRows (n, n) of entries, the sum of those at the same place."""
    codes = np.asarray(rows, np.int64) * n + np.asarray(columns, np.int64)
    places = distinct(codes.copy())
    values = np.bincount(np.searchsorted(places, codes), values, len(places))
    return SparseRows(np.searchsorted(places, n * np.arange(n + 1)), places % n, values)
