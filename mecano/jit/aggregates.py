"""Arrays and tuples in LLVM: structures whose items need no instruction where they have just been put there.

numba takes the items out of each tuple that it has made, and makes arrays in memory: without both, a kernel has a third
fewer instructions.
"""

from llvmlite import ir
from numba.core import cgutils

from mecano.jit.patched import patched

WORD = ir.IntType(64)
COUNT, ITEM_SIZE, DATA, SHAPE, STRIDES = range(2, 7)  # fields of numba's arrays; two for an owner precede them
_instruction = ir.IRBuilder.extract_value


def item_of(builder, structure, place, name=""):
    """Return the item of a structure at a place (a number, or a sequence of one): where possible the value put there.

    The value has been computed before the structure, and so before each use of it.
    """
    wanted = (place,) if isinstance(place, int) else tuple(place)
    value = structure
    while isinstance(value, ir.instructions.InsertValue) and len(wanted) == 1:
        before, put = value.operands
        if tuple(value.indices) == wanted:
            return put
        value = before
    return _instruction(builder, value, place, name)


def array_at(context, builder, of, data, shape):
    """Return the contiguous array of a numba type with the first item at the pointer ``data``, without an owner."""
    strides, count = [WORD(context.get_abi_sizeof(data.type.pointee))], shape[0]
    for n in shape[1:]:
        count = builder.mul(count, n)
    for n in shape[:0:-1]:
        strides.insert(0, builder.mul(strides[0], n))
    fields = count, strides[-1], data, cgutils.pack_array(builder, shape), cgutils.pack_array(builder, strides)
    array = ir.Constant(context.get_value_type(of), None)  # without an owner
    for place, value in enumerate(fields, start=COUNT):
        array = builder.insert_value(array, value, place)
    return array


def known_items():
    """Return the context in which numba takes no value out of a structure into which it has just been put."""
    return patched((ir.IRBuilder, "extract_value", item_of))
