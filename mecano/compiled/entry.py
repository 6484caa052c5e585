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

from mecano.compiled.closure import digest
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


RESULT = {float: ctypes.c_double, int: ctypes.c_int64, bool: ctypes.c_int64}
WORD = {float: "d", int: "q", bool: "?7x"}


class Entry(Kernel):
    """A compiled function for Python; other compiled functions may call it as a kernel."""

    def __init__(self, function):
        super().__init__(function)
        signature = dict(function.__annotations__)
        returns = signature.pop("return", None)
        self.names, self.signature = tuple(signature), tuple(signature.values())
        self.returns = returns if isinstance(returns, tuple) else (returns,) if returns else ()
        self.pack = struct.Struct("=q" + "".join(WORD.get(kind, "q") for kind in self.signature)).pack

    @property
    def several(self):
        """True when a call gives a tuple."""
        return len(self.returns) > 1

    @cached_property
    def function(self):
        """The C function of the address of the words and, for several results, that of an array for them."""
        name, depends = f"{self.__module__}.{self.__qualname__}", digest(self.__wrapped__)
        found = address(name, depends, lambda compiler: compiler.entry_code(self))
        result = None if self.several or not self.returns else RESULT[self.returns[0]]
        return ctypes.PYFUNCTYPE(result, ctypes.c_char_p, ctypes.c_void_p)(found)

    def is_written(self, place):
        """True for an argument that by its name is an array that the function writes."""
        return self.names[place].endswith("_out")

    def refusal(self, error, *arguments):
        """A TypeError that names the arguments which are not what they must be; the ``error`` itself if all are."""
        wrong = [
            f"{name} must be {_wanted(kind, self.is_written(i))}"
            for i, (name, kind, value) in enumerate(zip(self.names, self.signature, arguments, strict=True))
            if not _fits(kind, value, self.is_written(i))
        ]
        return TypeError(f"{self.__name__}: {'; '.join(wrong)}") if wrong else error


def _fits(kind, value, is_written):
    if not isinstance(kind, Array):
        return kind is bool or isinstance(value, (int, np.integer) if kind is int else (int, float, np.number))
    if type(value) is not np.ndarray or (value.dtype, value.ndim) != kind:
        return False
    return value.flags.c_contiguous and value.flags.aligned and (value.flags.writeable or not is_written)


def _wanted(kind, is_written):
    if not isinstance(kind, Array):
        return "a number" if kind is float else "a whole number"
    what = f"a contiguous array of {kind.dtype} with {kind.dimensions} dimensions"
    return f"{what} that can be written" if is_written else what


def entry(function):
    """An Entry whose call is written out for its signature: what it does for each argument would take longer."""
    names = [name for name in function.__annotations__ if name != "return"]
    words = [f"id({name})" if isinstance(function.__annotations__[name], Array) else name for name in names]
    returns, given = function.__annotations__.get("return"), ", ".join(names)
    packed = f"self.pack({', '.join(['NDARRAY', *words])})"
    if isinstance(returns, tuple):
        numbers = ", ".join(f"{kind.__name__}(results[{i}])" for i, kind in enumerate(returns))
        lines = ["results = Results()", f"function({packed}, addressof(results))", f"return {numbers}"]
    else:
        lines = [f"return {'bool' if returns is bool else ''}(function({packed}, None))"]
    text = [
        f"def call(self, {given}):",
        "    function = self.function",
        "    try:",
        *("        " + line for line in lines),
    ]
    text += ["    except (TypeError, StructError) as error:", f"        raise self.refusal(error, {given}) from None"]
    scope = {"addressof": ctypes.addressof, "StructError": struct.error, "NDARRAY": id(np.ndarray)}
    if isinstance(returns, tuple):
        scope["Results"] = ctypes.c_double * len(returns)
    exec(compile("\n".join(text), f"<call of {function.__qualname__}>", "exec"), scope)
    return type("Entry", (Entry,), {"__call__": scope["call"]})(function)
