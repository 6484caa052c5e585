"""Access to NumPy arrays from compiled code: heads of PyArrayObject and PyArray_Descr in the documented C API.

After the head of every Python object, an array has: data, number of dimensions, dimensions, strides, base, descriptor,
flags; a descriptor has: the type object, then the characters of kind, type and byte order (little-endian machines
only).
"""

from mecano.jit.kernel import kernel
from mecano.jit.memory import integers

HEAD = object.__basicsize__  # its last word is the type of the object
C_CONTIGUOUS, ALIGNED, WRITEABLE = 0x1, 0x100, 0x400
HAS_RECORDS = ord("V")


@kernel
def word(address):
    """Return the 8 bytes at an address as an integer."""
    return integers(address, 1)[0]


@kernel
def fits(array, ndarray, dimensions, flags, letters, size):
    """Return True for an ``ndarray`` of this number of dimensions, with these flags, item type and item size.

    ``letters`` are the characters of type and byte order; the size is compared only for records.
    """
    if word(array + HEAD - 8) != ndarray or word(array + HEAD + 8) & 0xFFFFFFFF != dimensions:
        return False
    if word(array + HEAD + 48) & flags != flags or (word(word(array + HEAD + 40) + HEAD + 8) >> 8) & 0xFFFF != letters:
        return False
    return letters & 0xFF != HAS_RECORDS or shape_1(array) == 0 or word(word(array + HEAD + 24)) == size


@kernel
def data(array):
    """Return the address of the first item."""
    return word(array + HEAD)


@kernel
def shape_1(array):
    """Return the number of items."""
    return word(word(array + HEAD + 16))


@kernel
def shape_2(array):
    """Return the numbers of rows and columns."""
    at = word(array + HEAD + 16)
    return word(at), word(at + 8)


@kernel
def shape_3(array):
    """Return the three dimensions."""
    at = word(array + HEAD + 16)
    return word(at), word(at + 8), word(at + 16)
