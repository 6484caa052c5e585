"""Calling convention of compiled functions: each argument and the result are one LLVM value, and no call fails.

numba has each caller test for errors of the function that it calls, takes arrays and tuples apart into a dozen
arguments each, and returns results through memory. Without this, and without counts of the references to arrays, which
compiled functions never own, less than half of the instructions needs no compilation. An error ends the program where
it occurs.
"""

from llvmlite import ir
from numba.core import base, cgutils
from numba.core.callconv import RETCODE_OK, CPUCallConv, Status
from numba.core.cpu import CPUContext
from numba.core.runtime.context import NRTContext

from mecano.jit.patched import patched

ERROR = "mecano_error"  # the function without arguments that ends the program
FALSE, TRUE = ir.Constant(ir.IntType(1), 0), ir.Constant(ir.IntType(1), 1)
SUCCESS = Status(RETCODE_OK, TRUE, FALSE, FALSE, FALSE, FALSE, FALSE, None)


class Convention(CPUCallConv):
    """A calling convention of numba, in which no function fails."""

    def get_function_type(self, restype, argtypes):
        """Return the LLVM type of a function with a result and arguments of these types."""
        return ir.FunctionType(self.context.get_value_type(restype), map(self.context.get_value_type, argtypes))

    def decorate_function(self, fn, args, fe_argtypes, noalias=False):
        """Name the arguments of a function."""
        for value, name in zip(fn.args, args, strict=True):
            value.name = name

    def get_arguments(self, func):
        """Return the arguments of a function."""
        return func.args

    def decode_arguments(self, builder, argtypes, func):
        """Return the values of the arguments in a function."""
        return func.args

    def call_function(self, builder, callee, resty, argtys, args, attrs=None):
        """Call a function; return the status of success and its result."""
        return SUCCESS, builder.call(callee, args, attrs=attrs or ())

    def return_value(self, builder, retval):
        """Return a result."""
        builder.ret(retval)

    def return_status_propagate(self, builder, status):
        """Do nothing, as no status is an error."""

    def return_user_exc(self, builder, exc, exc_args=None, loc=None, func_name=None):
        """End the program."""
        end = cgutils.get_or_insert_function(builder.module, ir.FunctionType(ir.VoidType(), []), ERROR)
        builder.call(end, [])
        builder.ret(ir.Constant(builder.function.function_type.return_type, ir.Undefined))

    def return_dynamic_user_exc(self, builder, exc, exc_args, nb_types, loc=None, func_name=None):
        """End the program."""
        self.return_user_exc(builder, exc)


def _call_of(function, libraries):
    """Return the implementation of calls of a compiled function, for numba."""

    def call(context, builder, signature, arguments):
        given = [_argument(context, builder, *pair) for pair in zip(function.argtypes, arguments, strict=True)]
        return builder.call(context.declare_function(builder.module, function), given)

    call.signature, call.libs = function.argtypes, tuple(libraries)
    return call


def _argument(context, builder, numba_type, value):
    """Return a value in the form of its numba type.

    numba makes structures of what ``*`` collects, and passes anything for an argument without a value.
    """
    form = context.get_value_type(numba_type)
    if value.type == form:
        return value
    if isinstance(value.type, ir.Aggregate):
        return context.make_tuple(builder, numba_type, cgutils.unpack_tuple(builder, value))
    return ir.Constant(form, ir.Undefined)


def _wrap(self, library, fndesc, env, call_helper):
    """Add the C function that calls a compiled function, with the same arguments and result."""
    module = self.create_module("cfunc_wrapper")
    function_type = self.call_conv.get_function_type(fndesc.restype, fndesc.argtypes)
    wrapper = ir.Function(module, function_type, fndesc.llvm_cfunc_wrapper_name)
    builder = ir.IRBuilder(wrapper.append_basic_block("entry"))
    builder.ret(builder.call(ir.Function(module, function_type, fndesc.llvm_func_name), wrapper.args))
    library.add_ir_module(module)


def _ignore(self, builder, numba_type, value):
    """Leave the count of references as it is."""


def _as_it_is(self, builder, ty, val):
    """Return the value, which is returned in the form in which functions use it."""
    return val


def without_errors_and_references():
    """Return the context in which numba compiles functions by this convention."""
    return patched(
        (CPUContext, "call_conv", property(Convention)),
        (CPUContext, "create_cfunc_wrapper", _wrap),
        (CPUContext, "get_return_value", _as_it_is),
        (NRTContext, "incref", _ignore),
        (NRTContext, "decref", _ignore),
        (base, "user_function", _call_of),
    )
