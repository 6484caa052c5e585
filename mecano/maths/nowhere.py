"""A matrix that forgets whatever is written to it.

Kernels that are called with NOWHERE in place of their tangents are compiled without them: what is computed for nothing
is dropped. Only elements A[i, j] are read (as zero) and written.
"""

import operator
from typing import NamedTuple

from numba.core import types
from numba.extending import overload


class Nowhere(NamedTuple):
    """The type of NOWHERE."""

    value: float

    def __getitem__(self, index):
        return 0.0

    def __setitem__(self, index, value):
        pass


NOWHERE = Nowhere(0.0)


def _is_nowhere(A, index):
    named = isinstance(A, types.BaseNamedTuple) and A.instance_class is Nowhere
    return named and isinstance(index, types.BaseTuple)


@overload(operator.setitem)
def _forget(A, index, value):
    return (lambda A, index, value: None) if _is_nowhere(A, index) else None


@overload(operator.getitem)
def _zero(A, index):
    return (lambda A, index: 0.0) if _is_nowhere(A, index) else None


def wanted(A):
    """False for NOWHERE, true for an array: known to the compiler, which then leaves out what is under it."""
    return not isinstance(A, Nowhere)


@overload(wanted)
def _wanted(A):
    named = isinstance(A, types.BaseNamedTuple) and A.instance_class is Nowhere
    return (lambda A: False) if named else (lambda A: True)
