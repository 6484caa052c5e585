"""Functions dispatched on the types of their arguments: operators of vectors, mathematics of dual numbers.

The method is chosen by the argument types when the function is compiled, or when Python calls it. ``float`` stands for
a number of any type. The code of a method runs once at each place where it is compiled (symbols.py).
"""

import operator
from itertools import product

UNARY = {operator.neg: "__neg__", abs: "__abs__"}
BINARY = {
    operator.add: ("__add__", "__radd__"),
    operator.sub: ("__sub__", "__rsub__"),
    operator.mul: ("__mul__", "__rmul__"),
    operator.truediv: ("__truediv__", "__rtruediv__"),
    operator.matmul: ("__matmul__", "__rmatmul__"),
    operator.lt: ("__lt__",),
    operator.le: ("__le__",),
    operator.gt: ("__gt__",),
    operator.ge: ("__ge__",),
}
_methods = {}  # function -> {argument types: code}
_attributes = {}  # (type, name) -> function of the value
_records = {}  # names of fields -> type that records with these fields represent
_known_codes = []  # all tables _Codes


class _Codes(dict):
    """Codes by the types of arguments, found when first asked for: plain Python would search most of the time."""

    def __init__(self, find):
        super().__init__()
        self._find = find
        _known_codes.append(self)

    def __missing__(self, types):
        code = self[types] = self._find(types)
        return code


class Generic:
    """A function with methods; its own code applies to all other arguments.

    Compiled code contains the code itself instead of a call, so the code must not branch except with ``select``.
    """

    primitive = None  # set by the compiler: (function, arguments) -> value of a function of symbols.py

    def __init__(self, function):
        self.__wrapped__, self.__name__, self.__doc__ = function, function.__name__, function.__doc__
        self.__module__ = function.__module__
        self._codes = _Codes(self._code_for)
        _methods[self] = {}

    def __call__(self, *arguments):  # noqa: D102
        return self._codes[tuple(map(type, arguments))](*arguments)

    def _code_for(self, types):
        """Return the code for arguments of these types of Python."""
        code = _code_for_types(self, types)
        if code is self.__wrapped__ and any(hasattr(of, "builder") for of in types):
            return lambda *arguments: Generic.primitive(self, arguments)
        return code


def method(function, *types):
    """Register the decorated code as a method for arguments of these types; a tuple stands for each of its types."""

    def add(code):
        for key in product(*(of if isinstance(of, tuple) else (of,) for of in types)):
            _methods.setdefault(function, {})[key] = code
        for codes in _known_codes:
            codes.clear()
        return code

    return add


def attribute(cls, name):
    """Register the decorated function as an attribute of the values of a type."""

    def add(function):
        _attributes[cls, name] = function
        setattr(cls, name, property(function))
        return function

    return add


def attribute_of(cls, name):
    """Return the function that implements this attribute of a type, or None."""
    return _attributes.get((cls, name))


def attribute_names():
    """Return the names of all attributes, sorted."""
    return sorted({name for _, name in _attributes})


def code_for(function, types):
    """Return the code of a function for arguments of these types, or None."""
    found = _methods.get(function, {}).get(types)
    return function.__wrapped__ if found is None and isinstance(function, Generic) else found


def type_of_record(names):
    """Return the type that a record with these fields represents in compiled code, or None."""
    return _records.get(tuple(names))


def functions():
    """Return all functions with methods."""
    return list(_methods)


def methods_in(module):
    """Return [(name, code)] of all methods and attributes defined in this module, in a fixed order."""
    found = [
        (f"{function.__name__} {[of.__name__ for of in types]}", code)
        for function, codes in _methods.items()
        for types, code in codes.items()
    ]
    found += [(f"{cls.__name__}.{name}", function) for (cls, name), function in _attributes.items()]
    found += [(function.__name__, function.__wrapped__) for function in _methods if isinstance(function, Generic)]
    return sorted((name, code) for name, code in found if code.__module__ == module)


def algebraic(cls):
    """Give a NamedTuple the operators defined by its methods, also in Python."""
    for function, name in UNARY.items():
        setattr(cls, name, _applied_alone(cls, function))
    for function, names in BINARY.items():
        for name, applied in zip(names, (_applied, _applied_reflected), strict=False):
            setattr(cls, name, applied(cls, function))
    cls.has_methods = True
    _records[cls._fields] = cls
    cls.__array_ufunc__ = None  # lets NumPy numbers defer to the operators of this type
    return cls


def _applied_alone(cls, function):
    return lambda a: (code_for(function, (cls,)) or _no_code)(a)


def _applied(cls, function):
    codes = _Codes(lambda of: _code_for_types(function, (cls, of)) or _no_code)
    return lambda a, b: codes[type(b)](a, b)


def _applied_reflected(cls, function):
    codes = _Codes(lambda of: _code_for_types(function, (of, cls)) or _no_code)
    return lambda b, a: codes[type(a)](a, b)


def _no_code(*_):
    return NotImplemented


def _code_for_types(function, types):
    """Return the code for arguments of these types of Python, or None."""
    return code_for(function, tuple(map(_dispatched_type, types)))


def _dispatched_type(of):
    """Return the type by which a method is dispatched, for an argument of this type of Python."""
    return of if hasattr(of, "_fields") else tuple if issubclass(of, tuple) else float
