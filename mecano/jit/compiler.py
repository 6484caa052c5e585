"""Compilation of functions: numba generates optimized LLVM code, LLVM turns it into machine code for the store.

Only this module and those that it imports use numba. Division by zero gives infinity or nan, as in C; iterations that
meet such values report non-finite results.
"""

import operator
import os

os.environ.setdefault("NUMBA_DISABLE_INTEL_SVML", "1")  # loaded code can call only the C library, without SVML

import llvmlite.binding as llvm
from llvmlite import ir
from numba import cfunc, njit, types
from numba.core.datamodel.models import OpaqueModel
from numba.core.imputils import lower_constant
from numba.core.registry import cpu_target
from numba.extending import overload, register_model

from mecano.jit import convention, image, indexing, memory  # noqa: F401  indexing registers itself
from mecano.jit.aggregates import known_items
from mecano.jit.array_object import ALIGNED, C_CONTIGUOUS, WRITEABLE, fits
from mecano.jit.arrays import array_object, refuse
from mecano.jit.digest import digest
from mecano.jit.entry import Array
from mecano.jit.library import not_loaded
from mecano.jit.named_tuple import classes, gathered
from mecano.jit.null_matrix import NullMatrix
from mecano.jit.numba_methods import register_methods
from mecano.jit.passes import KernelCompiler
from mecano.jit.processor import target
from mecano.jit.shortcuts import shortcuts
from mecano.process.interrupt import call_interruptibly

# Functions that machine code may call: C mathematics, C memory, the rejection of the arguments of a call.
KNOWN = frozenset(
    "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2 expm1 fabs floor fma fmax "
    "fmin fmod frexp hypot ldexp log log10 log1p log2 memcpy memmove memset pow remainder rint round sin sincos sinh "
    "sqrt tan tanh trunc calloc free PyErr_BadArgument".split()
) | {convention.ERROR}
FATAL = b"an error in compiled code of mecano, which should have none\0"


class PlainDispatcher(types.Dispatcher):
    """A function that is compiled once for all constants with which it is called, not for each of them.

    It is compiled for each type of record: numba would also consider the code for a record with fewer fields.
    """

    def get_call_type(self, context, arguments, keywords):
        """Return the signature of a call."""
        plain = {name: types.unliteral(argument) for name, argument in keywords.items()}
        plain_arguments = [types.unliteral(argument) for argument in arguments]
        _, python_signature, given, _ = self.dispatcher.get_call_template(plain_arguments, plain)
        return self.dispatcher.overloads[tuple(given)].signature.replace(pysig=python_signature)


LOOP = types.void(types.int64, types.int64)
NUMBERS = {float: types.float64, int: types.int64, bool: types.int64}


@register_model(PlainDispatcher)
class _PlainModel(OpaqueModel):
    """Value of a function: no data, as for the functions of numba."""


@lower_constant(PlainDispatcher)
def _no_data(context, builder, of, value):
    return ir.Constant(context.get_value_type(of), None)


def fill_tables():
    """Fill the tables of numba and of LLVM, which takes most of a second, before processes are forked that compile."""
    register_methods()
    cpu_target.typing_context.refresh()
    cpu_target.target_context.refresh()


def compiled(function):
    """Return the type of numba of a function that compiled functions call; it compiles it for the types they use."""
    dispatcher = njit(
        error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, pipeline_class=KernelCompiler
    )(function)
    found = PlainDispatcher(dispatcher)
    found.kept = dispatcher  # to which numba's own reference is weak
    return found


def loop_code(function):
    """Return (symbol, machine code) of a C function of two addresses that returns nothing."""
    return _machine_code(LOOP, function, digest(function))


def entry_code(entry):
    """Return (symbol, machine code) of a C function of the addresses of the argument words and of the results
    (entry.py).

    It sets Python's TypeError if an array has the wrong type, number of dimensions or order.
    """
    source, names = _unpacking(entry)
    exec(compile(source, f"<entry {entry.__qualname__}>", "exec"), names)
    result = types.void if entry.several or not entry.returns else NUMBERS[entry.returns[0]]
    return _machine_code(result(types.int64, types.int64), names["entry"], digest(entry.__wrapped__))


def _unpacking(entry):
    """Return the source of the function that unpacks the words and calls an entry, and the names it uses."""
    names = {"function": entry, "word": memory.word, "number": memory.number, "fits": fits, "refuse": refuse}
    lines, given = ["type = word(at)"], []  # the type of arrays precedes the arguments
    refused = "    return" if entry.several or not entry.returns else "    return 0"
    for i, hint in enumerate(entry.signature, start=1):
        at = f"at + {8 * i}"
        if isinstance(hint, Array):
            names[f"array_{i}"] = array_object(hint)
            given.append(f"array_{i}(word({at}))")
            lines += [
                f"if not fits(word({at}), type, {_required(hint, entry.is_written(i - 1))}):",
                "    refuse()",
                refused,
            ]
        else:
            given.append({float: f"number({at})", bool: f"word({at}) != 0"}.get(hint, f"word({at})"))
    hints = entry.parameters.values()
    names |= classes(hints)
    call = f"function({gathered(hints, iter(given))})"
    if entry.several:
        out = ", ".join(f"results[{i}]" for i in range(len(entry.returns)))
        names["floats"] = memory.floats
        lines += [f"results = floats(out, {len(entry.returns)})", f"{out} = {call}"]
    else:
        lines.append(f"return {call}" if entry.returns else call)
    return "def entry(at, out):\n    " + "\n    ".join(lines) + "\n", names


def _required(array: Array, is_written):
    """Return the source of the arguments of ``fits`` that describe the array of an argument."""
    flags = C_CONTIGUOUS | ALIGNED | (WRITEABLE if is_written else 0)
    letters = ord(array.dtype.char) | ord(array.dtype.byteorder) << 8
    return f"{array.dimensions}, {flags}, {letters}, {array.dtype.itemsize}"


def _machine_code(signature, function, key):
    """Return (symbol, machine code) of a Python function as a C function with this numba signature.

    The symbol consists of the ``key``, so that no two functions share one. A signal interrupts the compiler, which
    takes seconds. Raises SystemError if the code needs functions that are not available.
    """
    return call_interruptibly(_code_of, signature, function, key)


def _code_of(signature, function, key):
    register_methods()
    with not_loaded(), shortcuts(), known_items(), convention.without_errors_and_references():
        function = cfunc(signature, error_model="numpy", pipeline_class=KernelCompiler)(function)
    module = function._library.optimized(function.native_name)
    needs = {f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm.")} - KNOWN
    if needs:
        needs = ", ".join(sorted(needs))
        raise SystemError(f"{function.native_name} needs {needs}: a kernel may not allocate, print, or call libraries")
    variables = [variable.name for variable in module.global_variables if variable.is_declaration]
    module.link_in(llvm.parse_assembly(str(_fatal_error(variables))))
    for name in variables:  # avoids a table of addresses, which a loader may place too far away
        module.get_global_variable(name).visibility = "hidden"
    symbol = f"mecano_{key}"
    module.get_function(function.native_name).name = symbol
    return symbol, _target().emit_object(module)


def _fatal_error(variables):
    """Return the function that ends the program at an error, of which kernels have none, and numba's variables."""
    module, pointer = ir.Module(), ir.IntType(8).as_pointer()
    content = ir.Constant(ir.ArrayType(ir.IntType(8), len(FATAL)), bytearray(FATAL))
    text = ir.GlobalVariable(module, content.type, "mecano_fatal")
    text.initializer, text.linkage = content, "internal"
    report = ir.Function(module, ir.FunctionType(ir.VoidType(), [pointer]), "Py_FatalError")
    end = ir.Function(module, ir.FunctionType(ir.VoidType(), []), convention.ERROR)
    end.linkage = "weak"
    builder = ir.IRBuilder(end.append_basic_block())
    builder.call(report, [builder.bitcast(text, pointer)])
    builder.unreachable()
    for name in variables:
        variable = ir.GlobalVariable(module, ir.IntType(64), name)
        variable.initializer, variable.linkage = ir.Constant(ir.IntType(64), 0), "weak"
    return module


def _target():
    name, features = target()
    of, model = llvm.Target.from_default_triple(), {"reloc": "default", "codemodel": "jitdefault"}
    if image.POSSIBLE:
        model = {"reloc": "pic", "codemodel": "small"}
    return of.create_target_machine(cpu=name, features=features, opt=3, **model)


def _is_null_matrix(A):
    return isinstance(A, types.BaseNamedTuple) and A.instance_class is NullMatrix


@overload(operator.setitem)
def _discard_write(A, index, value):
    discards = _is_null_matrix(A) and isinstance(index, types.BaseTuple)
    return (lambda A, index, value: None) if discards else None


@overload(operator.getitem)
def _zero(A, index):
    discards = _is_null_matrix(A) and isinstance(index, types.BaseTuple)
    return (lambda A, index: 0.0) if discards else None
