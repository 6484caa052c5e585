"""Implementation of memory.py for numba: each function becomes the few instructions that it stands for."""

from functools import cache

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.imputils import lower_builtin
from numba.extending import intrinsic, overload, type_callable
from numba.np.numpy_support import from_dtype

from mecano.jit import memory
from mecano.jit.aggregates import WORD, array_at
from mecano.jit.array_object import DATA, SHAPE
from mecano.jit.lanes import DUAL, Lanes, lanes_record
from mecano.jit.memory import LANES
from mecano.jit.symbols import splat


def _load(builder, address, llvm_type=WORD):
    return builder.load(builder.inttoptr(address, llvm_type.as_pointer()))


def _array(context, builder, of, address, shape):
    """Return the contiguous array of a numba type with the first item at ``address``."""
    item = context.get_data_type(of.dtype)
    return array_at(context, builder, of, builder.inttoptr(address, item.as_pointer()), shape)


def _type_of_array(item, shape, aligned=True):
    return types.Array(item, len(shape) if isinstance(shape, types.BaseTuple) else 1, "C", aligned=aligned)


def _register_arrays(function, item, aligned=True):
    """Register a function of memory.py that returns an array of items of one type."""
    type_callable(function)(lambda context: lambda address, shape: _type_of_array(item, shape, aligned))
    lower_builtin(function, types.Any, types.Any)(_generate_array)


def _generate_array(context, builder, signature, arguments):
    address, shape = arguments[:2]
    of = signature.args[1]
    sizes = cgutils.unpack_tuple(builder, shape) if isinstance(of, types.BaseTuple) else [shape]
    size_types = of.types if isinstance(of, types.BaseTuple) else [of]
    sizes = [context.cast(builder, n, size_type, types.intp) for n, size_type in zip(sizes, size_types, strict=True)]
    address = context.cast(builder, address, signature.args[0], types.int64)
    return _array(context, builder, signature.return_type, address, sizes)


_register_arrays(memory.floats, types.float64)
_register_arrays(memory.integers, types.int64)
_register_arrays(memory.lanes, Lanes, aligned=False)
_register_arrays(memory.duals, DUAL, aligned=False)
type_callable(memory.items)(lambda context: lambda address, shape, dtype: _type_of_array(dtype.dtype, shape))
lower_builtin(memory.items, types.Any, types.Any, types.Any)(_generate_array)
type_callable(memory.lanes_items)(
    lambda context: lambda address, shape, dtype: _type_of_array(lanes_record(dtype.dtype.dtype), shape, aligned=False)
)
lower_builtin(memory.lanes_items, types.Any, types.Any, types.Any)(_generate_array)


@lower_builtin(memory.in_lane, types.Any, types.Any)
def _in_lane(context, builder, signature, arguments):
    x, lane = map(context.cast, (builder, builder), arguments, signature.args, (types.float64, types.int64))
    lanes = ir.Constant(ir.VectorType(WORD, LANES), list(range(LANES)))
    there = builder.icmp_signed("==", lanes, splat(builder, lane))
    x = splat(builder, x)
    return builder.select(there, x, ir.Constant(x.type, None))


type_callable(memory.in_lane)(lambda context: lambda x, lane: Lanes)


def _register_number(function, numba_type, llvm_type):
    """Register a function of memory.py that returns a number."""
    type_callable(function)(lambda context: lambda address: numba_type)
    lower_builtin(function, types.Any)(lambda context, builder, _, arguments: _load(builder, arguments[0], llvm_type))


_register_number(memory.word, types.int64, WORD)
_register_number(memory.number, types.float64, ir.DoubleType())


@cache
def array_object(array):
    """Return the compiled function of an array object's address that returns the array, an Array of entry.py."""
    of = types.Array(from_dtype(array.dtype), array.dimensions, "C")

    def generate(context, builder, signature, arguments):
        at = [builder.add(arguments[0], WORD(offset)) for offset in (DATA, SHAPE)]
        data, sizes = (_load(builder, address) for address in at)
        shape = [_load(builder, builder.add(sizes, WORD(8 * i))) for i in range(array.dimensions)]
        return _array(context, builder, of, data, shape)

    return intrinsic(lambda typing_context, address: (of(types.int64), generate))


@intrinsic
def _call(typing_context, function, first, second):
    def generate(context, builder, signature, arguments):
        function_type = ir.FunctionType(ir.VoidType(), [WORD, WORD])
        builder.call(builder.inttoptr(arguments[0], function_type.as_pointer()), arguments[1:])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64), generate


@overload(memory.call)
def _call_at(function, first, second):
    return lambda function, first, second: _call(function, first, second)


@intrinsic
def _call_for_int(typing_context, function, argument):
    def generate(context, builder, signature, arguments):
        function_type = ir.FunctionType(ir.IntType(32), [WORD])
        return builder.call(builder.inttoptr(arguments[0], function_type.as_pointer()), arguments[1:])

    return types.int32(types.int64, types.int64), generate


@overload(memory.call_for_int)
def _call_for_int_at(function, argument):
    return lambda function, argument: _call_for_int(function, argument)


_bad_argument = types.ExternalFunction("PyErr_BadArgument", types.int32())
_calloc = types.ExternalFunction("calloc", types.int64(types.uintp, types.uintp))
_free = types.ExternalFunction("free", types.void(types.uintp))


@intrinsic
def _array_like(typing_context, address, shape, like):
    return _type_of_array(like.dtype, shape)(types.int64, shape, like), _generate_array


@overload(memory.allocate_items)
def _allocate_items(shape, like):
    size = like.dtype.size if isinstance(like.dtype, types.Record) else 8

    def allocate(shape, like):
        n = 1
        for length in shape:
            n *= length
        return _array_like(_calloc(n, size), shape, like)

    return allocate


@overload(memory.free)
def _free_array(array):
    return lambda array: _free(array.ctypes.data)


def refuse():
    """Set Python's TypeError."""


@overload(refuse)
def _refuse_arguments():
    return lambda: _bad_argument()
