"""Compiled functions that Python calls.

The annotations of an entry are its signature: ``float``, ``int``, ``bool``, or a contiguous array of the types below;
it returns nothing, a number, or several. Every call packs the addresses of its arrays, and its numbers, into words of 8
bytes, which the compiled side takes apart (compiler.py): a microsecond for a dozen arguments.
"""

import ctypes
import struct
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mecano.compiled.kernel import Kernel
from mecano.compiled.store import address


class Array(NamedTuple):
    """A contiguous array with items of one type."""

    dtype: np.dtype
    dimensions: int


Vector, Matrix, Matrices = (Array(np.dtype(np.float64), n) for n in (1, 2, 3))
Indices, Table = (Array(np.dtype(np.int64), n) for n in (1, 2))
Short = Array(np.dtype(np.uint32), 1)  # indices of large tables


def Records(dtype):
    """An array (n,) of records."""
    return Array(dtype, 1)


RESULT = {None: None, float: ctypes.c_double, int: ctypes.c_int64, bool: ctypes.c_int64}


class Entry(Kernel):
    """A compiled function for Python; other compiled functions may call it as a kernel."""

    def __init__(self, function):
        super().__init__(function)
        signature = dict(function.__annotations__)
        returns = signature.pop("return", None)
        self.names, self.signature = tuple(signature), tuple(signature.values())
        self.returns = returns if isinstance(returns, tuple) else (returns,) if returns else ()
        self.pack = struct.Struct("=" + "".join("d" if kind is float else "q" for kind in self.signature)).pack

    @property
    def several(self):
        """True when a call gives a tuple."""
        return len(self.returns) > 1

    @cached_property
    def function(self):
        """The C function of the address of the words and, for several results, that of an array for them."""
        found = address(f"{self.__module__}.{self.__qualname__}", lambda compiler: compiler.entry_code(self))
        result = None if self.several or not self.returns else RESULT[self.returns[0]]
        return ctypes.PYFUNCTYPE(result, ctypes.c_char_p, ctypes.c_void_p)(found)

    def refusal(self, *arguments):
        """A TypeError that names the arrays which are not of their type, dimension and order."""
        found = [
            f"{name} must be a contiguous array of {kind.dtype} with {kind.dimensions} dimensions"
            for name, kind, value in zip(self.names, self.signature, arguments, strict=True)
            if isinstance(kind, Array)
            and not (isinstance(value, np.ndarray) and (value.dtype, value.ndim) == kind and value.flags.c_contiguous)
        ]
        return TypeError(f"{self.__name__}: {'; '.join(found)}")


def entry(function):
    """An Entry whose call is written out for its signature: what it does for each argument would take longer."""
    names = [name for name in function.__annotations__ if name != "return"]
    kinds = [function.__annotations__[name] for name in names]
    words = ", ".join(
        f"id({name})" if isinstance(kind, Array) else name for name, kind in zip(names, kinds, strict=True)
    )
    returns = function.__annotations__.get("return")
    result = f"self.function(self.pack({words}), None)"
    if isinstance(returns, tuple):
        numbers = ", ".join(f"{kind.__name__}(results[{i}])" for i, kind in enumerate(returns))
        lines = ["results = Results()", f"self.function(self.pack({words}), addressof(results))", f"return {numbers}"]
    else:
        lines = [f"return bool({result})" if returns is bool else f"return {result}"]
    given = ", ".join(names)
    text = [f"def call(self, {given}):", "    try:", *(f"        {line}" for line in lines)]
    text += ["    except TypeError:", f"        raise self.refusal({given}) from None"]
    scope = {"addressof": ctypes.addressof}
    if isinstance(returns, tuple):
        scope["Results"] = ctypes.c_double * len(returns)
    exec(compile("\n".join(text), f"<call of {function.__qualname__}>", "exec"), scope)
    return type("Entry", (Entry,), {"__call__": scope["call"]})(function)
