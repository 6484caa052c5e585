"""Compilation of functions: numba generates optimized LLVM code, LLVM turns it into machine code for the store.

Only this module imports numba. Division by zero gives infinity or nan, as in C; iterations that meet such values
report non-finite results.
"""

import operator
import os
from functools import cache

os.environ.setdefault("NUMBA_DISABLE_INTEL_SVML", "1")  # loaded code can call only the C library, without SVML

import llvmlite.binding as llvm
from llvmlite import ir
from numba import cfunc, njit, types
from numba.core import cgutils
from numba.core.datamodel.models import OpaqueModel
from numba.core.imputils import lower_builtin, lower_constant, lower_getattr
from numba.core.registry import cpu_target
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import overload, register_model

from mecano.jit import convention, indexing, memory, methods, symbols  # noqa: F401  indexing registers itself
from mecano.jit.aggregates import known_items
from mecano.jit.array_object import ALIGNED, C_CONTIGUOUS, WRITEABLE, fits
from mecano.jit.arrays import array_object, refuse
from mecano.jit.digest import digest
from mecano.jit.entry import Array
from mecano.jit.lanes import Lanes, Mask
from mecano.jit.library import not_loaded
from mecano.jit.named_tuple import classes, gathered
from mecano.jit.null_matrix import NullMatrix, wanted
from mecano.jit.passes import KernelCompiler
from mecano.jit.shortcuts import shortcuts
from mecano.jit.store import processor
from mecano.jit.symbols import Condition, Symbol, any_many, is_number, value_of
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
        plain = {name: types.unliteral(kind) for name, kind in keywords.items()}
        plain_arguments = [types.unliteral(kind) for kind in arguments]
        _, python_signature, given, _ = self.dispatcher.get_call_template(plain_arguments, plain)
        return self.dispatcher.overloads[tuple(given)].signature.replace(pysig=python_signature)


NUMERIC = (types.Number, types.Boolean, type(Lanes), type(Mask))
LOOP = types.void(types.int64, types.int64)
NUMBERS = {float: types.float64, int: types.int64, bool: types.int64}


@register_model(PlainDispatcher)
class _PlainModel(OpaqueModel):
    """Value of a function: no data, as for the functions of numba."""


@lower_constant(PlainDispatcher)
def _no_data(context, builder, of, value):
    return ir.Constant(context.get_value_type(of), None)


def get_ready():
    """Fill the tables of numba and of LLVM, which takes most of a second, before processes are forked that compile."""
    _learn_methods()
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
    for i, kind in enumerate(entry.signature, start=1):
        at = f"at + {8 * i}"
        if isinstance(kind, Array):
            names[f"array_{i}"] = array_object(kind)
            given.append(f"array_{i}(word({at}))")
            lines += [
                f"if not fits(word({at}), type, {_required(kind, entry.is_written(i - 1))}):",
                "    refuse()",
                refused,
            ]
        else:
            given.append({float: f"number({at})", bool: f"word({at}) != 0"}.get(kind, f"word({at})"))
    kinds = entry.parameters.values()
    names |= classes(kinds)
    call = f"function({gathered(kinds, iter(given))})"
    if entry.several:
        out = ", ".join(f"results[{i}]" for i in range(len(entry.returns)))
        names["floats"] = memory.floats
        lines += [f"results = floats(out, {len(entry.returns)})", f"{out} = {call}"]
    else:
        lines.append(f"return {call}" if entry.returns else call)
    return "def entry(at, out):\n    " + "\n    ".join(lines) + "\n", names


def _required(kind: Array, is_written):
    """Return the source of the arguments of ``fits`` that describe the array of an argument."""
    flags = C_CONTIGUOUS | ALIGNED | (WRITEABLE if is_written else 0)
    letters = ord(kind.dtype.char) | ord(kind.dtype.byteorder) << 8
    return f"{kind.dimensions}, {flags}, {letters}, {kind.dtype.itemsize}"


def _machine_code(signature, function, key):
    """Return (symbol, machine code) of a Python function as a C function with this numba signature.

    The symbol consists of the ``key``, so that no two functions share one. A signal interrupts the compiler, which
    takes seconds. Raises SystemError if the code needs functions that are not available.
    """
    return call_interruptibly(_code_of, signature, function, key)


def _code_of(signature, function, key):
    _learn_methods()
    with not_loaded(), shortcuts(), known_items(), convention.without_errors_and_references():
        function = cfunc(signature, error_model="numpy", pipeline_class=KernelCompiler)(function)
    module = function._library.optimized(function.native_name)
    needs = {f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm.")} - KNOWN
    if needs:
        needs = ", ".join(sorted(needs))
        raise SystemError(f"{function.native_name} needs {needs}: a kernel may not allocate, print, or call libraries")
    variables = [variable.name for variable in module.global_variables if variable.is_declaration]
    module.link_in(llvm.parse_assembly(str(_ending(variables))))
    for name in variables:  # avoids a table of addresses, which a loader may place too far away
        module.get_global_variable(name).visibility = "hidden"
    symbol = f"mecano_{key}"
    module.get_function(function.native_name).name = symbol
    return symbol, _target().emit_object(module)


def _ending(variables):
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
    name, features = processor()
    of = llvm.Target.from_default_triple()
    return of.create_target_machine(cpu=name, features=features, opt=3, reloc="default", codemodel="jitdefault")


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


@overload(wanted)
def _wanted(A):
    return (lambda A: False) if _is_null_matrix(A) else (lambda A: True)


def _kind(argument):
    """Return the type by which a method is dispatched, for an argument of this numba type."""
    if isinstance(argument, types.BaseNamedTuple):
        return argument.instance_class
    if isinstance(argument, types.Record):
        return methods.kind_of_record(argument.fields)
    return tuple if isinstance(argument, types.BaseTuple) else float if isinstance(argument, NUMERIC) else None


@overload(operator.setitem)
def _store(array, index, value):
    """Store a Dual, or a number as a constant Dual, in an array of records."""
    if not (isinstance(array, types.Array) and isinstance(array.dtype, types.Record)):
        return None
    if isinstance(value, types.Number):
        return _store_number
    return _store_dual if _kind(value) is not None and _kind(value) is _kind(array.dtype) else None


def _store_number(array, index, value):
    item = array[index]
    item.value = value
    item.slope = 0.0


def _store_dual(array, index, value):
    item = array[index]
    item.value = value.value
    item.slope = value.slope


IN_PLACE = {operator.add: operator.iadd, operator.sub: operator.isub, operator.mul: operator.imul}
COMPOSED = (types.BaseNamedTuple, types.Record, type(Lanes))  # types of operands that numba does not know
OPERANDS = (*COMPOSED, types.Float, types.Integer)
_known = set()  # functions with methods that have been registered with numba
methods.Generic.primitive = staticmethod(symbols.primitive)


def _learn_methods():
    """Register operators, functions with methods, and attributes, that numba does not know yet."""
    operators = *methods.UNARY, *methods.BINARY  # those of Lanes need no methods
    for function in [f for f in dict.fromkeys((*operators, *methods.functions())) if f not in _known]:
        for named in {function, IN_PLACE.get(function, function)}:
            _learn(function, named)
        _known.add(function)
    for name in [name for name in methods.attribute_names() if name not in _known]:
        _learn_attribute(name)
        _known.add(name)


def _learn(function, named):
    """Register a function, called under the name ``named``, with numba: its types and its code generation."""

    class Template(AbstractTemplate):
        key = named

        def generic(self, arguments, _):
            result = _result(function, arguments)
            return result and signature(result, *arguments)

    infer_global(named, types.Function(Template))

    def generate(context, builder, of, arguments):
        given = [_symbolic(context, builder, *pair) for pair in zip(of.args, arguments, strict=True)]
        return _instructions(context, builder, of.return_type, function(*given))

    if isinstance(function, methods.Generic):
        lower_builtin(named, types.VarArg(types.Any))(generate)
        return
    unary = [(kind,) for kind in COMPOSED]
    for operands in [*unary, *((a, b) for a in OPERANDS for b in OPERANDS if {a, b} & {*COMPOSED})]:
        lower_builtin(named, *operands)(generate)


def _learn_attribute(name):
    class Attribute(AttributeTemplate):
        key = types.BaseNamedTuple

        def generic_resolve(self, of, attribute):
            code = methods.attribute_of(_kind(of), name) if attribute == name else None
            return code and _type_of(code(_stand_in(of)))

    infer_getattr(Attribute)

    def generate(context, builder, of, value):
        found = methods.attribute_of(_kind(of), name)(_symbolic(context, builder, of, value))
        return _instructions(context, builder, _type_of(found), found)

    lower_getattr(types.BaseNamedTuple, name)(generate)


@cache
def _result(function, arguments):
    """Return the result type of a function for arguments of these types, or None if it has no method for them."""
    kinds = set(map(_kind, arguments))
    plain = kinds == {float} and Lanes not in arguments
    if None in kinds or (plain and not isinstance(function, methods.Generic)):
        return None
    try:
        return _type_of(function(*map(_stand_in, arguments)))
    except TypeError:
        return None


def _stand_in(of):
    """Return a placeholder value of a numba type, without instructions; raise TypeError if it has no methods."""
    kind = _kind(of)
    if kind is None:
        raise TypeError(f"{of} is no operand")
    if kind is float:
        placeholder = Condition if isinstance(of, types.Boolean) or of is Mask else Symbol
        return placeholder(None, many=of in (Lanes, Mask))
    parts = [of.typeof(name) for name in of.fields] if isinstance(of, types.Record) else of.types
    return kind(*map(_stand_in, parts))


def _type_of(value):
    if isinstance(value, Condition | bool):
        return Mask if any_many([value]) else types.boolean
    if is_number(value):
        return Lanes if any_many([value]) else types.float64
    parts = [_type_of(part) for part in value]
    if len(set(parts)) == 1:
        return types.NamedUniTuple(parts[0], len(parts), type(value))
    return types.NamedTuple(parts, type(value))


def _symbolic(context, builder, of, value):
    """Return a value of compiled code as Symbols."""
    kind = _kind(of)
    if of is Lanes:
        return Symbol(builder, value)
    if isinstance(of, types.Boolean) or of is Mask:
        return Condition(builder, value if of is Mask else context.cast(builder, value, of, types.boolean))
    if kind is float:
        return Symbol(builder, context.cast(builder, value, of, types.float64))
    if isinstance(of, types.Record):
        places = [
            cgutils.get_record_member(builder, value, of.offset(name), cgutils.ir.DoubleType()) for name in of.fields
        ]
        return kind(*(Symbol(builder, builder.load(place)) for place in places))
    parts = cgutils.unpack_tuple(builder, value, len(of))
    return kind(*(_symbolic(context, builder, *pair) for pair in zip(of.types, parts, strict=True)))


def _instructions(context, builder, of, value):
    """Return numba's value for a value made of Symbols."""
    if isinstance(value, Condition | bool):
        return value.value if isinstance(value, Condition) else context.get_constant(types.boolean, value)
    if is_number(value):
        return value_of(value)
    parts = [_instructions(context, builder, *pair) for pair in zip(of.types, value, strict=True)]
    return context.make_tuple(builder, of, parts)
