"""Calling convention of compiled functions: an error ends the program where it occurs, so none is ever returned.

numba has each caller test for errors of the function that it calls. Without these tests, and without counts of the
references to arrays, which compiled functions never own, a quarter of the instructions needs no compilation.
"""

from llvmlite import ir
from numba.core import cgutils
from numba.core.callconv import RETCODE_NONE, CPUCallConv, Status, errcode_t, excinfo_ptr_t
from numba.core.cpu import CPUContext
from numba.core.runtime.context import NRTContext

from mecano.jit.replaced import replaced

ERROR = "mecano_error"  # the function without arguments that ends the program
FALSE, TRUE = ir.Constant(ir.IntType(1), 0), ir.Constant(ir.IntType(1), 1)


class Convention(CPUCallConv):
    """The calling convention of numba, in which no function fails."""

    def call_function(self, builder, callee, resty, argtys, args, attrs=None):
        """Call a function; return the status of success and its result."""
        result = cgutils.alloca_once(builder, self.get_return_type(resty).pointee)
        no_error = ir.Constant(excinfo_ptr_t.as_pointer(), None)
        given = self._get_arg_packer(argtys).as_arguments(builder, args)
        code = builder.call(callee, [result, no_error, *given], attrs=attrs or ())
        is_none = builder.icmp_signed("==", code, RETCODE_NONE)
        undefined = ir.Constant(excinfo_ptr_t, ir.Undefined)
        status = Status(code, TRUE, is_none, FALSE, FALSE, FALSE, FALSE, undefined)
        return status, self.context.get_returned_value(builder, resty, builder.load(result))

    def return_status_propagate(self, builder, status):
        """Do nothing, as no status is an error."""

    def return_user_exc(self, builder, exc, exc_args=None, loc=None, func_name=None):
        """End the program."""
        end = cgutils.get_or_insert_function(builder.module, ir.FunctionType(ir.VoidType(), []), ERROR)
        builder.call(end, [])
        builder.ret(ir.Constant(errcode_t, 0))

    def return_dynamic_user_exc(self, builder, exc, exc_args, nb_types, loc=None, func_name=None):
        """End the program."""
        self.return_user_exc(builder, exc)


def _ignore(self, builder, kind, value):
    """Leave the count of references as it is."""


def without_errors_and_references():
    """Return the context in which numba compiles functions by this convention."""
    return replaced(
        (CPUContext, "call_conv", property(Convention)),
        (NRTContext, "incref", _ignore),
        (NRTContext, "decref", _ignore),
    )
