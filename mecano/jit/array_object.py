"""Access to NumPy arrays from compiled code: heads of PyArrayObject and PyArray_Descr in the documented C API.

After the head of every Python object, an array has: data, number of dimensions, dimensions, strides, base, descriptor,
flags; a descriptor has: the type object, then the characters of kind, type and byte order (little-endian machines
only).
"""

from mecano.jit.kernel import kernel
from mecano.jit.memory import word

HEAD = object.__basicsize__  # its last word is the type of the object
DATA, SHAPE = HEAD, HEAD + 16  # of the addresses of the first item and of the dimensions
C_CONTIGUOUS, ALIGNED, WRITEABLE = 0x1, 0x100, 0x400
HAS_RECORDS = ord("V")


@kernel
def fits(array, ndarray, dimensions, flags, letters, size):
    """Return True for an ``ndarray`` of this number of dimensions, with these flags, item type and item size.

    ``letters`` are the characters of type and byte order; the size is compared only for records.
    """
    if word(array + HEAD - 8) != ndarray or word(array + HEAD + 8) & 0xFFFFFFFF != dimensions:
        return False
    if word(array + HEAD + 48) & flags != flags or (word(word(array + HEAD + 40) + HEAD + 8) >> 8) & 0xFFFF != letters:
        return False
    return letters & 0xFF != HAS_RECORDS or word(word(array + SHAPE)) == 0 or word(word(array + HEAD + 24)) == size
