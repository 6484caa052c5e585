"""numpy's arrays seen from compiled code: the head of PyArrayObject and PyArray_Descr in the documented C API.

After the head of every object stand: data, number of dimensions, dimensions, strides, base, descriptor, flags; in the
descriptor: the type object, then the letters for the kind, the type and the order of bytes (all of a little-endian
machine).
"""

from mecano.jit.kernel import kernel
from mecano.jit.memory import integers

HEAD = object.__basicsize__  # its last word is the type of the object
C_CONTIGUOUS, ALIGNED, WRITEABLE = 0x1, 0x100, 0x400
HAS_RECORDS = ord("V")


@kernel
def word(address):
    """The 8 bytes at an address, as an integer."""
    return integers(address, 1)[0]


@kernel
def fits(array, ndarray, dimensions, flags, letters, size):
    """True for an ``ndarray`` of so many dimensions with these flags, whose items have this type and size.

    ``letters`` are those of the type and of the order of bytes; the size is looked at where they do not tell it.
    """
    if word(array + HEAD - 8) != ndarray or word(array + HEAD + 8) & 0xFFFFFFFF != dimensions:
        return False
    if word(array + HEAD + 48) & flags != flags or (word(word(array + HEAD + 40) + HEAD + 8) >> 8) & 0xFFFF != letters:
        return False
    return letters & 0xFF != HAS_RECORDS or shape_1(array) == 0 or word(word(array + HEAD + 24)) == size


@kernel
def data(array):
    """The address of the first item."""
    return word(array + HEAD)


@kernel
def shape_1(array):
    """The number of items."""
    return word(word(array + HEAD + 16))


@kernel
def shape_2(array):
    """Rows and columns."""
    at = word(array + HEAD + 16)
    return word(at), word(at + 8)


@kernel
def shape_3(array):
    """The three dimensions."""
    at = word(array + HEAD + 16)
    return word(at), word(at + 8), word(at + 16)
