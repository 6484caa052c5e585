"""Arrays and numbers at addresses, calls of functions at addresses, and work memory, for compiled code only.

Only the names are declared here; arrays.py implements them.
"""

import numpy as np

LANES = 4  # slopes of each Dual; elements that are computed at once where a kind allows it


def floats(address, shape):
    """Return the array of floats of this shape (a number or a tuple) at ``address``."""
    raise RuntimeError("available in compiled code only")


def integers(address, shape):
    """Return the array of int64 of this shape at ``address``."""
    raise RuntimeError("available in compiled code only")


def items(address, shape, dtype):
    """Return the array of this shape of items of another type, such as records, at ``address``."""
    raise RuntimeError("available in compiled code only")


def lanes(address, shape):
    """Return the array of this shape of numbers of LANES elements at ``address``."""
    raise RuntimeError("available in compiled code only")


def duals(address, shape):
    """Return the array of this shape (a number or a tuple) of Duals with LANES slopes each at ``address``."""
    raise RuntimeError("available in compiled code only")


def lanes_items(address, shape, dtype):
    """Return the array of this shape of records of LANES elements each at ``address``, for the ``dtype`` of one."""
    raise RuntimeError("available in compiled code only")


def lanes_dtype(dtype):
    """Return the type of the record of LANES elements: each number four times, each integer once."""
    return np.dtype(
        [
            (name, field.base, field.shape if field.base.kind == "i" else (*field.shape, LANES))
            for name, (field, *_) in dtype.fields.items()
        ],
        align=True,
    )


def in_lane(x, lane):
    """Return a number of LANES elements, x in this lane (if there is such a lane) and zero in the others."""
    raise RuntimeError("available in compiled code only")


def word(address):
    """Return the int64 at ``address``."""
    raise RuntimeError("available in compiled code only")


def number(address):
    """Return the float at ``address``."""
    raise RuntimeError("available in compiled code only")


def call(function, first, second):
    """Call the C function of two addresses at the address ``function``."""
    raise RuntimeError("available in compiled code only")


def call_for_int(function, argument):
    """Call the C function of one address at the address ``function``, and return its int."""
    raise RuntimeError("available in compiled code only")


def allocate_items(shape, like):
    """Return an array of zeros of this shape (a tuple), numbers or Duals as in ``like``, to be freed with ``free``."""
    out, zero = np.empty(shape, like.dtype), 0.0 * like[(0,) * like.ndim]
    for index in np.ndindex(shape):
        out[index] = zero
    return out


def free(array):
    """Free the memory of an array from ``allocate_items``."""
