"""numpy's arrays seen from compiled code: the head of PyArrayObject and PyArray_Descr in the documented C API.

After the head of every object stand: data, number of dimensions, dimensions, strides, base, descriptor, flags; in the
descriptor: the type object, then the letters for the kind and for the type.
"""

from mecano.compiled.kernel import kernel
from mecano.compiled.memory import integers

HEAD = object.__basicsize__
C_CONTIGUOUS = 1


@kernel
def word(address):
    """The 8 bytes at an address, as an integer."""
    return integers(address, 1)[0]


@kernel
def fits(array, dimensions, letter):
    """True for a contiguous array of so many dimensions whose items have this type."""
    if word(array + HEAD + 8) & 0xFFFFFFFF != dimensions or not word(array + HEAD + 48) & C_CONTIGUOUS:
        return False
    return (word(word(array + HEAD + 40) + HEAD + 8) >> 8) & 0xFF == letter


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
