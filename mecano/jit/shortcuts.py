"""Work of numba that the compilation of kernels does not need.

numba finds the result type of each call anew, by trying the templates of the function one after the other, and reports
each use of LLVM to listeners. Without this work, compilation takes four fifths of the time.
"""

from numba.core import event
from numba.core.types.functions import BaseFunction

from mecano.jit.replaced import replaced

_by_templates = BaseFunction.get_call_type
_found = {}  # (function, types of its arguments) -> signature


def _remembered(self, context, arguments, keywords):
    """Return the signature of a call; found once for each function and types of arguments."""
    if keywords:
        return _by_templates(self, context, arguments, keywords)
    key = self, arguments
    if key not in _found:
        _found[key] = _by_templates(self, context, arguments, keywords)
    return _found[key]


def _unreported(*_, **__):
    """Report nothing, as nothing listens."""


def shortcuts():
    """Return the context in which numba finds the type of each call once, and reports nothing."""
    return replaced(
        (BaseFunction, "get_call_type", _remembered),
        (event, "start_event", _unreported),
        (event, "end_event", _unreported),
    )
