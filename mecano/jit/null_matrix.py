"""A matrix that discards writes.

Kernels called with NULL_MATRIX in place of their tangents are compiled without them: the compiler drops unused
computations (compiler.py). Only elements A[i, j] may be read (as zero) and written.
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
