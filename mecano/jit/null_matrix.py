"""A matrix that forgets whatever is written to it.

Kernels that are called with NULL_MATRIX in place of their tangents are compiled without them: what is computed for
nothing is dropped (compiler.py). Only elements A[i, j] are read (as zero) and written.
"""

from typing import NamedTuple


class NullMatrix(NamedTuple):
    """The type of NULL_MATRIX."""

    value: float

    def __getitem__(self, index):
        return 0.0

    def __setitem__(self, index, value):
        pass


NULL_MATRIX = NullMatrix(0.0)


def wanted(A):
    """False for NULL_MATRIX, true for an array: known to the compiler, which then leaves out what is under it."""
    return not isinstance(A, NullMatrix)
