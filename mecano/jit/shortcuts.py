"""Work of numba that the compilation of kernels does not need.

numba finds the result type of each call anew, by trying the templates of the function one after the other, reports each
use of LLVM to listeners, and writes the long names of records again and again. After each pass it computes which
variables live at the beginning of each block, which only generators need. Without this work, compilation takes seven
tenths of the time.
"""

from functools import cache

from numba.core import base, event, interpreter
from numba.core.postproc import PostProcessor, VariableLifetime
from numba.core.transforms import canonicalize_cfg
from numba.core.types import Record
from numba.core.types.functions import BaseFunction

from mecano.jit.patched import patched

_by_templates = BaseFunction.get_call_type
_record_text, _takes_location = cache(Record.__repr__), cache(base._has_loc)
_found = {}  # (function, types of its arguments) -> signature


def _remembered(self, context, arguments, keywords):
    """Return the signature of a call; found once for each function and types of arguments."""
    if keywords:
        return _by_templates(self, context, arguments, keywords)
    key = self, arguments
    if key not in _found:
        _found[key] = _by_templates(self, context, arguments, keywords)
    return _found[key]


def _report_nothing(*_, **__):
    """Report nothing, as nothing listens."""


def _unchanged(code):
    """Return code without ``with`` and dictionaries, in which numba would look for both."""
    return code


def _with_lifetimes_on_demand(self, emit_dels=False, extend_lifetimes=False):
    """Update the blocks of a function that is no generator, and the lifetimes of its variables."""
    code = self.func_ir
    code.blocks = canonicalize_cfg(code.blocks)
    code.variable_lifetime, code.generator_info = VariableLifetime(code.blocks), None
    if emit_dels:
        self._insert_var_dels(extend_lifetimes=extend_lifetimes)


def shortcuts():
    """Return the context in which numba does without this work."""
    return patched(
        (BaseFunction, "get_call_type", _remembered),
        (event, "start_event", _report_nothing),
        (event, "end_event", _report_nothing),
        (PostProcessor, "run", _with_lifetimes_on_demand),
        (Record, "__repr__", _record_text),
        (base, "_has_loc", _takes_location),
        (interpreter, "peep_hole_delete_with_exit", _unchanged),
        (interpreter, "peep_hole_fuse_dict_add_updates", _unchanged),
    )
