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


def method(function, *kinds):
    """Register the decorated code as a method for arguments of these types; a tuple stands for each of its types."""

    def add(code):
        for key in product(*(kind if isinstance(kind, tuple) else (kind,) for kind in kinds)):
            _methods.setdefault(function, {})[key] = code
        for codes in _known_codes:
            codes.clear()
        return code

    return add


def attribute(kind, name):
    """Register the decorated function as an attribute of the values of a type."""

    def add(function):
        _attributes[kind, name] = function
        setattr(kind, name, property(function))
        return function

    return add


def attribute_of(kind, name):
    """Return the function that implements this attribute of a type, or None."""
    return _attributes.get((kind, name))


def attribute_names():
    """Return the names of all attributes, sorted."""
    return sorted({name for _, name in _attributes})


def code_for(function, kinds):
    """Return the code of a function for arguments of these types, or None."""
    found = _methods.get(function, {}).get(kinds)
    return function.__wrapped__ if found is None and isinstance(function, Generic) else found


def kind_of_record(names):
    """Return the type that a record with these fields represents in compiled code, or None."""
    return _records.get(tuple(names))


def functions():
    """Return all functions with methods."""
    return list(_methods)


def methods_in(module):
    """Return [(name, code)] of all methods and attributes defined in this module, in a fixed order."""
    found = [
        (f"{function.__name__} {[kind.__name__ for kind in kinds]}", code)
        for function, codes in _methods.items()
        for kinds, code in codes.items()
    ]
    found += [(f"{kind.__name__}.{name}", function) for (kind, name), function in _attributes.items()]
    found += [(function.__name__, function.__wrapped__) for function in _methods if isinstance(function, Generic)]
    return sorted((name, code) for name, code in found if code.__module__ == module)


def algebraic(kind):
    """Give a NamedTuple the operators defined by its methods, also in Python."""
    for function, name in UNARY.items():
        setattr(kind, name, _applied_alone(kind, function))
    for function, names in BINARY.items():
        for name, applied in zip(names, (_applied, _applied_reflected), strict=False):
            setattr(kind, name, applied(kind, function))
    kind.has_methods = True
    _records[kind._fields] = kind
    kind.__array_ufunc__ = None  # lets NumPy numbers defer to the operators of this type
    return kind


def _applied_alone(kind, function):
    return lambda a: (code_for(function, (kind,)) or _no_code)(a)


def _applied(kind, function):
    codes = _Codes(lambda of: _code_for_types(function, (kind, of)) or _no_code)
    return lambda a, b: codes[type(b)](a, b)


def _applied_reflected(kind, function):
    codes = _Codes(lambda of: _code_for_types(function, (of, kind)) or _no_code)
    return lambda b, a: codes[type(a)](a, b)


def _no_code(*_):
    return NotImplemented


def _code_for_types(function, types):
    """Return the code for arguments of these types of Python, or None."""
    return code_for(function, tuple(map(_kind, types)))


def _kind(of):
    return of if hasattr(of, "_fields") else tuple if issubclass(of, tuple) else float
