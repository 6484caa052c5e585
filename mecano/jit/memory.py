"""Arrays at addresses, calls of functions at addresses, and memory for work: for compiled code only.

These are the names; what the compiler makes of them stands in compiler.py.
"""

import numpy as np


def floats(address, shape):
    """The array of floats of this shape (a number or a tuple) at ``address``."""
    raise RuntimeError("known to compiled code only")


def integers(address, shape):
    """The array of int64 of this shape at ``address``."""
    raise RuntimeError("known to compiled code only")


def items(address, n, dtype):
    """The array (n,) of items of another type, such as records, at ``address``."""
    raise RuntimeError("known to compiled code only")


def call(function, first, second):
    """Call the C function of two addresses that stands at the address ``function``."""
    raise RuntimeError("known to compiled code only")


def take_zeros(shape):
    """Return an array of zeros of this shape (a tuple), which must be given back."""
    return np.zeros(shape)


def give_back(array):
    """Free the memory of an array of ``take_zeros``."""
