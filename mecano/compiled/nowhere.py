"""A matrix that forgets whatever is written to it.

Kernels that are called with NOWHERE in place of their tangents are compiled without them: what is computed for nothing
is dropped (compiler.py). Only elements A[i, j] are read (as zero) and written.
"""

from typing import NamedTuple


class Nowhere(NamedTuple):
    """The type of NOWHERE."""

    value: float

    def __getitem__(self, index):
        return 0.0

    def __setitem__(self, index, value):
        pass


NOWHERE = Nowhere(0.0)


def wanted(A):
    """False for NOWHERE, true for an array: known to the compiler, which then leaves out what is under it."""
    return not isinstance(A, Nowhere)
