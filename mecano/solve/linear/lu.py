"""LU factors of real or complex matrices of one pattern, by LAPACK where they are small and by SuperLU.

Compiled code factors and solves with the calls ``factor`` and ``solve``.
"""

import ctypes
from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.linalg import lapack

from mecano.jit.entry import PackedCall
from mecano.model.loop_records import record
from mecano.process.memory import reserve_blas_buffer
from mecano.solve.linear.dense_lu import LU, factor_dense, of_lapack, solve_dense

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
    right : (n,) float or complex
        Right-hand side, which ``solve`` replaces by the solution.
    outcome : (1,) int64
        Zero if the last ``factor`` found no pivot that is zero.
    factor, solve : PackedCall
    """

    def __init__(self, n: int, rows: np.ndarray, cols: np.ndarray, dtype: np.dtype | type):
        self.values, self.place = np.zeros(n * n, dtype), cols * n + rows
        self.right, self.outcome = np.zeros(n, dtype), np.zeros(1, np.int64)
        kind = "z" if dtype is complex else "d"
        arrays = {
            "values": self.values, "factors": np.zeros_like(self.values), "right": self.right, "outcome": self.outcome,
            "n": np.array([n], np.int32), "n_right": np.array([1], np.int32), "solved": np.zeros(1, np.int32),
            "exchanges": np.zeros(n, np.int32), "transposed": np.array([b"N"]),
        }  # fmt: skip
        own = record(
            LU, getrf=of_lapack(f"{kind}getrf"), getrs=of_lapack(f"{kind}getrs"),
            n_values=self.values.view(float).size, **{name: array.ctypes.data for name, array in arrays.items()},
        )  # fmt: skip
        self._kept = arrays, own
        self.error: BaseException | None = None  # LAPACK raises none
        self.factor, self.solve = factor_dense.call_from_compiled_code(own), solve_dense.call_from_compiled_code(own)


class SparseFactors:
    """LU with partial pivoting by SuperLU; attributes as in DenseFactors, with ``values`` (nnz,) by columns.

    Where Python raises an exception in a call, ``outcome`` is not zero, and ``error`` is that exception.
    """

    def __init__(self, n: int, rows: np.ndarray, cols: np.ndarray, dtype: np.dtype | type):
        order = np.lexsort((rows, cols))
        self.values, self.place = np.zeros(len(rows), dtype), np.empty(len(rows), np.int64)
        self.right, self.outcome = np.zeros(n, dtype), np.zeros(1, np.int64)
        self.place[order] = np.arange(len(rows))
        starts = np.searchsorted(cols[order], np.arange(n + 1))
        self._matrix = sp.csc_matrix((self.values, rows[order].astype(np.int32), starts.astype(np.int32)), (n, n))
        self.factor, self.solve = _from_compiled_code(self._factor), _from_compiled_code(self._solve)
        self.error: BaseException | None = None

    def _factor(self, *_):
        """Factor the matrix; ``outcome`` is zero if it is regular and finite."""
        self.outcome[0], self.error = 1, None
        if not np.isfinite(self.values).all():
            return
        self._matrix.data = self.values
        try:
            self._lu = spla.splu(self._matrix)
            self.outcome[0] = 0
        except RuntimeError:  # a pivot is zero
            pass
        except BaseException as error:
            self.error = error

    def _solve(self, *_):
        try:
            self.right[:] = self._lu.solve(self.right)
        except BaseException as error:
            self.right[:], self.error = np.nan, error


def _from_compiled_code(method: Callable[..., None]) -> PackedCall:
    """Return the PackedCall by which compiled code calls a method of Python."""
    function = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)(method)
    address = ctypes.cast(function, ctypes.c_void_p).value
    assert address is not None, "a function has an address"
    return PackedCall(address, np.zeros(1, np.int64), [function])
