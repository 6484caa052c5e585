"""Digest of everything that the machine code of a function depends on.

The digest covers the code of the function and of all functions that it calls, without docstrings and comments, and the
values of the globals they use: constants, types of records, compile-time types. Editing one element therefore changes
the digests of the objects that contain it, and of no others.
"""

import dis
import hashlib
import threading
import types
from functools import cache

import numpy as np

from mecano.jit.kernel import Kernel
from mecano.jit.methods import Generic, methods_in
from mecano.jit.named_tuple import leaves

OURS = "mecano"  # modules of this package are followed, all others are identified by name
LOAD_GLOBAL, EXTENDED_ARG = dis.opmap["LOAD_GLOBAL"], dis.EXTENDED_ARG
PLAIN = (bool, int, float, str, bytes, frozenset, np.generic)  # types with an exact repr

_digests = {}  # by function; the functions that it calls do not change during the life of the process
_begun = threading.local()  # ``functions`` of which a thread is taking the digest; another one takes it, too


def digest(function):
    """Return the digest (32 hexadecimal digits) of a Python function and everything it uses.

    Raises TypeError if it uses a global whose influence on the machine code is unknown.
    """
    known = _digests.get(function)
    if known is None:
        begun = _begun.__dict__.setdefault("functions", set())
        if function in begun:
            return "recursive"
        begun.add(function)
        try:
            known = _digests[function] = _hash(_describe_function(function))
        finally:
            begun.remove(function)
    return known


def is_digested(function):
    """True when this process has taken the digest of a function: what it uses must not change any more."""
    return function in _digests


def _hash(text):
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def _describe_function(function):
    code, cells = function.__code__, function.__closure__ or ()
    used = {name: function.__globals__[name] for name in sorted(_names(code)) if name in function.__globals__}
    used |= dict(zip(code.co_freevars, (cell.cell_contents for cell in cells), strict=True))
    parts = [_describe_code(code, function.__doc__), _describe(function.__defaults__, ())]
    parts += [f"{name}: {_describe_hint(hint)}" for name, hint in leaves(function.__annotations__).items()]
    parts += [f"{name}={_describe(value, code.co_names)}" for name, value in used.items()]
    return "\n".join(parts)


def _names(code):
    """Return the names of the globals that a code object and its nested ones load; attributes are separate names."""
    operations, arguments = code.co_code[::2], code.co_code[1::2]
    found, i = set(), operations.find(LOAD_GLOBAL)
    while i >= 0:
        more = arguments[i - 1] << 8 if i and operations[i - 1] == EXTENDED_ARG else 0
        found.add(code.co_names[(arguments[i] | more) >> 1])  # the last bit is a flag, since Python 3.11
        i = operations.find(LOAD_GLOBAL, i + 1)
    nested = [inner for inner in code.co_consts if isinstance(inner, types.CodeType)]
    return found.union(*(_names(inner) for inner in nested))


def _describe_code(code, doc=None):
    constants = [
        _describe_code(value) if isinstance(value, types.CodeType) else repr(value)
        for value in code.co_consts
        if doc is None or value != doc
    ]
    counts = f"{code.co_argcount} {code.co_kwonlyargcount} {code.co_flags}"
    return f"{code.co_code.decode('latin-1')} {code.co_names} {counts} {constants}"


def _describe(value, names):
    """Return a text that differs if machine code using ``value`` may differ; ``names`` are those used of a module."""
    if isinstance(value, Kernel):
        return f"{type(value).__name__ == 'Inlined'} {digest(value.__wrapped__)}"
    if isinstance(value, Generic) or (isinstance(value, type) and hasattr(value, "has_methods")):
        return f"{value.__name__} {_describe_methods(value.__module__)}"
    if isinstance(value, types.FunctionType):
        return digest(value) if value.__module__.startswith(OURS) else f"{value.__module__}.{value.__qualname__}"
    if isinstance(value, types.ModuleType):
        return _describe_module(value, names)
    if callable(value):
        return f"{getattr(value, '__module__', '')}.{value.__qualname__} {getattr(value, '_fields', '')}"
    if isinstance(value, tuple | list):
        return f"{type(value).__name__} {[_describe(item, names) for item in value]}"
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {value.tobytes().hex()}"
    if isinstance(value, np.dtype):
        return _describe_type(value)
    if value is None or isinstance(value, PLAIN):
        return f"{type(value).__name__} {value!r}"
    raise TypeError(f"a compiled function uses a global {type(value).__name__}, which machine code cannot depend on")


def _describe_hint(hint):
    """Return the text of an annotation: that of its dtype and of its dimensions if it is an Array (entry.py)."""
    dtype = getattr(hint, "dtype", None)
    return repr(hint) if dtype is None else f"{_describe_type(dtype)} {hint.dimensions}"


@cache
def _describe_type(dtype):
    """Return the text of a dtype; the ``repr`` of a record takes ten times as long."""
    if dtype.fields is None:
        return repr(dtype)
    fields = [f"{name} {_describe_type(one)} {offset}" for name, (one, offset, *_) in dtype.fields.items()]
    return f"{fields} {dtype.itemsize} {dtype.isalignedstruct}"


def _describe_module(module, names):
    if module.__name__.partition(".")[0] != OURS:
        return module.__name__
    return f"{[_describe(getattr(module, name), names) for name in names if hasattr(module, name)]}"


@cache
def _describe_methods(module):
    """Return the digest of all methods that a module defines, and of the functions that they call.

    Methods of one type use those of others, so all are included, each once, independent of the order of requests.
    """
    found, waiting = [], methods_in(module)
    seen = {code for _, code in waiting}
    while waiting:
        name, function = waiting.pop(0)
        used = [function.__globals__[n] for n in sorted(_names(function.__code__)) if n in function.__globals__]
        called = [value.__wrapped__ for value in used if isinstance(value, Kernel)]
        called += [value for value in used if isinstance(value, types.FunctionType)]
        waiting += [(f.__qualname__, f) for f in called if f.__module__ == module and f not in seen]
        seen.update(called)
        constants = [repr(value) for value in used if isinstance(value, PLAIN)]
        found.append(f"{name} {_describe_code(function.__code__, function.__doc__)} {constants}")
    return _hash("\n".join(found))
