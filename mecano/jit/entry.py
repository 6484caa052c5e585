"""Compiled functions that are called from Python.

The type hints of an entry are its signature: ``float``, ``int``, ``bool``, a contiguous array of one of the types
below, or a named tuple of these (named_tuple.py); it returns nothing, a number, or several numbers. Each call packs
array addresses and numbers into words of 8 bytes, which the compiled side unpacks (compiler.py); this takes a
microsecond for a dozen words. Arguments that stay the same are packed once (``Entry.bind``).
"""

import ctypes
import struct
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np

from mecano.jit.digest import digest
from mecano.jit.kernel import Kernel
from mecano.jit.machine_code import Code, address
from mecano.jit.named_tuple import leaves, spread


class Array(NamedTuple):
    """A contiguous array with items of one type."""

    dtype: np.dtype
    dimensions: int


Vector, Matrix, Matrices = (Array(np.dtype(np.float64), n) for n in (1, 2, 3))
Indices, Table = (Array(np.dtype(np.int64), n) for n in (1, 2))
Short = Array(np.dtype(np.uint32), 1)  # indices of large tables


def Records(dtype):
    """Return the type of an array (n,) of records."""
    return Array(dtype, 1)


RESULT = {float: ctypes.c_double, int: ctypes.c_int64, bool: ctypes.c_int64}
WORD = {float: "d", int: "q", bool: "?7x"}


class PackedCall(NamedTuple):
    """A call of an entry: the addresses are valid as long as this lives."""

    function: int  # address of the C function
    words: np.ndarray  # (n,) the packed arguments
    values: list  # the arguments, those of named tuples one after the other


class Entry(Kernel):
    """A compiled function for Python; other compiled functions can call it as a kernel."""

    def __init__(self, function):
        super().__init__(function)
        self.parameters = dict(function.__annotations__)
        returns = self.parameters.pop("return", None)
        words = leaves(self.parameters)
        self.names, self.signature = tuple(words), tuple(words.values())
        self.returns = returns if isinstance(returns, tuple) else (returns,) if returns else ()
        self.pack = struct.Struct(_layout(self.signature, "q")).pack

    def bind(self, *first):
        """Return a function of the remaining arguments, like functools.partial, that packs the ``first`` ones once."""
        values = spread([*self.parameters.values()][: len(first)], first)
        n = len(values)
        words = [id(x) if isinstance(hint, Array) else x for hint, x in zip(self.signature, values, strict=False)]
        head = struct.Struct(_layout(self.signature[:n], "q")).pack(id(np.ndarray), *words)
        pack = struct.Struct(_layout(self.signature[n:])).pack
        return _binding(self, len(first))(self, self.function, head, pack, values)

    def call_from_compiled_code(self, *arguments):
        """Return what ``memory.call`` needs for a call with these arguments, as a PackedCall."""
        values = spread(self.parameters.values(), arguments)
        words = [id(x) if isinstance(hint, Array) else x for hint, x in zip(self.signature, values, strict=True)]
        packed = np.frombuffer(self.pack(id(np.ndarray), *words), np.int64).copy()
        return PackedCall(self.address, packed, values)

    @property
    def several(self):
        """True if a call returns a tuple."""
        return len(self.returns) > 1

    @cached_property
    def function(self):
        """The C function of the address of the words and, for several results, that of an array for them."""
        result = None if self.several or not self.returns else RESULT[self.returns[0]]
        return ctypes.PYFUNCTYPE(result, ctypes.c_char_p, ctypes.c_void_p)(self.address)

    @cached_property
    def address(self):
        """The address of the C function."""
        return address(self.code)

    @property
    def code(self):
        """The C function as a Code of the store."""
        name, depends = f"{self.__module__}.{self.__qualname__}", digest(self.__wrapped__)
        return Code(name, depends, lambda compiler: compiler.entry_code(self))

    def is_written(self, place):
        """Return True if the function writes this array: its name, or that of its named tuple, ends in "_out"."""
        return any(name.endswith("_out") for name in self.names[place].split("."))

    def refusal(self, error, *values):
        """Return a TypeError that names the invalid numbers and arrays, or the ``error`` itself if all are valid."""
        wrong = [
            f"{name} must be {_wanted(hint, self.is_written(i))}"
            for i, (name, hint, value) in enumerate(zip(self.names, self.signature, values, strict=True))
            if not _fits(hint, value, self.is_written(i))
        ]
        return TypeError(f"{self.__name__}: {'; '.join(wrong)}") if wrong else error


def _layout(hints, before=""):
    """Return the struct format of the words of the arguments, preceded by ``before``."""
    return "=" + before + "".join(WORD.get(hint, "q") for hint in hints)


def _fits(hint, value, is_written):
    if not isinstance(hint, Array):
        return hint is bool or isinstance(value, (int, np.integer) if hint is int else (int, float, np.number))
    if type(value) is not np.ndarray or (value.dtype, value.ndim) != hint:
        return False
    return value.flags.c_contiguous and value.flags.aligned and (value.flags.writeable or not is_written)


def _wanted(hint, is_written):
    if not isinstance(hint, Array):
        return "a number" if hint is float else "a whole number"
    what = f"a contiguous array of {hint.dtype} with {hint.dimensions} dimensions"
    return f"{what} that can be written" if is_written else what


CALL = """\
def call(self, {given}):
    function = self.function
    try:
        {body}
    except (TypeError, StructError) as error:
        raise self.refusal(error, {values}) from None
"""
BIND = """\
def bind(_entry, function, _head, _pack, _first):
    def call({given}):
        try:
            {body}
        except (TypeError, StructError) as error:
            raise _entry.refusal(error, *_first, {values}) from None
    return call
"""


def entry(function):
    """Return an Entry with a call generated for its signature; a loop over the arguments would be slower."""
    return type("Entry", (Entry,), {"__call__": _first_call})(function)


def _first_call(self, *arguments, **named):
    """Generate the call of an Entry, which most processes only bind, and call it."""
    hints = self.__wrapped__.__annotations__
    type(self).__call__ = _written_out(CALL, self.__qualname__, hints, "self.pack(NDARRAY, {words})")
    return self(*arguments, **named)


@cache
def _binding(entry, n):
    """Return the function that generates the calls of an Entry whose first ``n`` arguments are packed."""
    annotations = dict([*entry.parameters.items()][n:]) | {
        "return": entry.returns if entry.several else (*entry.returns, None)[0]
    }
    return _written_out(BIND, entry.__qualname__, annotations, "_head + _pack({words})")


def _written_out(template, name, annotations, packed):
    """Return the function generated from a template above for arguments and results with these ``annotations``."""
    parameters = {name: hint for name, hint in annotations.items() if name != "return"}
    values = leaves(parameters)
    words = [f"id({value})" if isinstance(hint, Array) else value for value, hint in values.items()]
    returns, packed = annotations.get("return"), packed.format(words=", ".join(words))
    scope = {"addressof": ctypes.addressof, "StructError": struct.error, "NDARRAY": id(np.ndarray)}
    body = f"return {'bool' if returns is bool else ''}(function({packed}, None))"
    if isinstance(returns, tuple):
        scope["Results"] = ctypes.c_double * len(returns)
        numbers = ", ".join(f"{hint.__name__}(results[{i}])" for i, hint in enumerate(returns))
        body = f"results = Results(); function({packed}, addressof(results)); return {numbers}"
    text = template.format(given=", ".join(parameters), values=", ".join(values), body=body)
    exec(compile(text, f"<call of {name}>", "exec"), scope)
    return scope["bind" if template is BIND else "call"]
