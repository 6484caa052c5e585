"""Addresses in compiled code: arrays at an address, and calls of C functions at an address.

numba calls a compiled function from another only where it is known when the caller is compiled. The loops over the
elements of a kind are found through tables of addresses instead, so that one compiled caller serves every model.
"""

import numpy as np
from llvmlite import ir
from numba import carray, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

LOOP = types.void(types.int64, types.int64)  # the signature of every loop: addresses of two records


@intrinsic
def call(typing_context, loop, first, second):
    """Call the C function of signature LOOP at the address ``loop``."""

    def generate(context, builder, signature, arguments):
        word = ir.IntType(64)
        kind = ir.FunctionType(ir.VoidType(), [word, word])
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64), generate


@intrinsic
def pointer(typing_context, address):
    """The address as a pointer, for carray."""

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.int64), generate


@njit
def floats(address, shape):
    """The array of floats of this shape (a number or a tuple) at ``address``."""
    return carray(pointer(address), shape, np.float64)


@njit
def integers(address, shape):
    """The array of int64 of this shape at ``address``."""
    return carray(pointer(address), shape, np.int64)
