"""Symbolic numbers of compiled code: operations on them emit instructions.

The code of a method runs once for each place where it is compiled, with Symbols for its numbers. It gets no function of
its own, because compiling a function takes longer than emitting these few instructions.
"""

from llvmlite import ir

NUMBER, CONDITION = ir.DoubleType(), ir.IntType(1)
MATHEMATICS = ("sqrt", "sin", "cos", "tan", "exp", "atan2")  # functions of the C library, by name
INTRINSIC = ("sin", "cos", "exp")  # those of them for which numba calls an LLVM intrinsic


class Symbol:
    """A number; without a builder it is only a placeholder."""

    builder = None

    def __init__(self, builder, value=None):
        self.builder, self.value = builder, value

    def _with(self, instruction, *others):
        if self.builder is None:
            return Symbol(None)
        return Symbol(self.builder, getattr(self.builder, instruction)(*(value_of(other) for other in others)))

    def __add__(self, other):
        return self._with("fadd", self, other) if is_number(other) else NotImplemented

    def __radd__(self, other):
        return self._with("fadd", other, self)

    def __sub__(self, other):
        return self._with("fsub", self, other) if is_number(other) else NotImplemented

    def __rsub__(self, other):
        return self._with("fsub", other, self)

    def __mul__(self, other):
        return self._with("fmul", self, other) if is_number(other) else NotImplemented

    def __rmul__(self, other):
        return self._with("fmul", other, self)

    def __truediv__(self, other):
        return self._with("fdiv", self, other) if is_number(other) else NotImplemented

    def __rtruediv__(self, other):
        return self._with("fdiv", other, self)

    def __neg__(self):
        return self._with("fneg", self)

    def __abs__(self):
        return _call("fabs", (self,))

    def _compared(self, how, other):
        if self.builder is None:
            return Condition(None)
        return Condition(self.builder, self.builder.fcmp_ordered(how, self.value, value_of(other)))

    def __lt__(self, other):
        return self._compared("<", other) if is_number(other) else NotImplemented

    def __le__(self, other):
        return self._compared("<=", other) if is_number(other) else NotImplemented

    def __gt__(self, other):
        return self._compared(">", other) if is_number(other) else NotImplemented

    def __ge__(self, other):
        return self._compared(">=", other) if is_number(other) else NotImplemented


class Condition:
    """A truth value, for ``select`` only: methods must not branch."""

    builder = None

    def __init__(self, builder, value=None):
        self.builder, self.value = builder, value

    def __bool__(self):
        raise TypeError("a method cannot branch on the numbers of compiled code: use select")


def is_number(value):
    """Return True for a number, symbolic or constant."""
    return isinstance(value, Symbol | float | int)


def value_of(number):
    """Return the value of a Symbol, or a known number as a constant."""
    return number.value if isinstance(number, Symbol) else ir.Constant(NUMBER, float(number))


def primitive(function, arguments):
    """Return a Generic applied to Symbols: a C function, ``select``, or its own code."""
    if function.__name__ == "select":
        return _select(*arguments)
    return _call(function.__name__, arguments) if function.__name__ in MATHEMATICS else function.__wrapped__(*arguments)


def _select(condition, a, b):
    if not isinstance(condition, Condition):
        return a if condition else b
    if condition.builder is None:
        return Symbol(None)
    return Symbol(condition.builder, condition.builder.select(condition.value, value_of(a), value_of(b)))


def _call(name, arguments):
    builder = next(a.builder for a in arguments if isinstance(a, Symbol))
    if builder is None:
        return Symbol(None)
    name = f"llvm.{name}.f64" if name in INTRINSIC else name
    kind = ir.FunctionType(NUMBER, [NUMBER] * len(arguments))
    found = builder.module.globals.get(name) or ir.Function(builder.module, kind, name)
    return Symbol(builder, builder.call(found, [value_of(a) for a in arguments]))
