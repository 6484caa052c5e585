"""Symbolic numbers of compiled code: operations on them emit instructions.

The code of a method runs once for each place where it is compiled, with Symbols for its numbers. It gets no function of
its own, because compiling a function takes longer than emitting these few instructions.
"""

from llvmlite import ir

from mecano.jit.memory import LANES

NUMBER, CONDITION = ir.DoubleType(), ir.IntType(1)
NUMBERS, CONDITIONS = ir.VectorType(NUMBER, LANES), ir.VectorType(CONDITION, LANES)  # of as many elements at once
LANE = ir.IntType(32)
C_NAMES = {name: name for name in ("sqrt", "sin", "cos", "tan", "exp", "log", "atan2")} | {"power": "pow"}
INTRINSIC = ("sin", "cos", "exp", "log", "pow")  # those of them for which numba calls an LLVM intrinsic


class Symbol:
    """A number, or those of LANES elements (``many``); without a builder it is only a placeholder."""

    builder = None

    def __init__(self, builder, value=None, many=False):
        self.builder, self.value = builder, value
        self.many = many if builder is None else value.type == NUMBERS

    def _with(self, instruction, *others):
        if self.builder is None:
            return Symbol(None, many=any_many(others))
        values = values_of(self.builder, others, any_many(others))
        return Symbol(self.builder, getattr(self.builder, instruction)(*values))

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
        many = any_many((self, other))
        if self.builder is None:
            return Condition(None, many=many)
        return Condition(self.builder, self.builder.fcmp_ordered(how, *values_of(self.builder, (self, other), many)))

    def __lt__(self, other):
        return self._compared("<", other) if is_number(other) else NotImplemented

    def __le__(self, other):
        return self._compared("<=", other) if is_number(other) else NotImplemented

    def __gt__(self, other):
        return self._compared(">", other) if is_number(other) else NotImplemented

    def __ge__(self, other):
        return self._compared(">=", other) if is_number(other) else NotImplemented


class Condition:
    """A truth value, or those of LANES elements, for ``select`` only: methods must not branch."""

    builder = None

    def __init__(self, builder, value=None, many=False):
        self.builder, self.value = builder, value
        self.many = many if builder is None else value.type == CONDITIONS

    def __bool__(self):
        raise TypeError("a method cannot branch on the numbers of compiled code: use select")


def is_number(value):
    """Return True for a number, symbolic or constant."""
    return isinstance(value, Symbol | float | int)


def value_of(number):
    """Return the value of a Symbol, or a known number as a constant."""
    return number.value if isinstance(number, Symbol) else ir.Constant(NUMBER, float(number))


def any_many(values):
    """Return whether any of these is a number or a truth value of LANES elements."""
    return any(getattr(value, "many", False) for value in values)


def values_of(builder, numbers, many):
    """Return the values of numbers, all of one element, or of LANES elements if ``many``."""
    values = [value_of(number) for number in numbers]
    return [splat(builder, value) if many and value.type == NUMBER else value for value in values]


def splat(builder, value):
    """Return the number of one element for LANES elements."""
    of = ir.VectorType(value.type, LANES)
    if isinstance(value, ir.Constant):
        return ir.Constant(of, [value] * LANES)
    unknown = ir.Constant(of, ir.Undefined)
    first = builder.insert_element(unknown, value, LANE(0))
    return builder.shuffle_vector(first, unknown, ir.Constant(ir.VectorType(LANE, LANES), None))


def primitive(function, arguments):
    """Return a Generic applied to Symbols: a C function, one of OWN, or its own code."""
    name = function.__name__
    if name in OWN:
        return OWN[name](*arguments)
    return _call(C_NAMES[name], arguments) if name in C_NAMES else function.__wrapped__(*arguments)


def _select(condition, a, b):
    if not isinstance(condition, Condition):
        return a if condition else b
    builder, many = condition.builder, any_many((condition, a, b))
    if builder is None:
        return Symbol(None, many=many)
    return Symbol(builder, builder.select(condition.value, *values_of(builder, (a, b), many)))


def _anywhere(condition):
    return _one_condition(condition, "!=", 0)


def _everywhere(condition):
    return _one_condition(condition, "==", 2**LANES - 1)


def _one_condition(condition, how, bits):
    """Return whether the truth values of all elements, as bits of one number, compare with ``bits`` like this."""
    if not isinstance(condition, Condition) or not condition.many:
        return condition
    if condition.builder is None:
        return Condition(None)
    word = ir.IntType(LANES)
    found = condition.builder.bitcast(condition.value, word)
    return Condition(condition.builder, condition.builder.icmp_unsigned(how, found, word(bits)))


def _constant(a, like):
    """Return the number ``a``, for LANES elements if ``like`` is a number of these."""
    if not any_many([like]):
        return a
    return Symbol(None, many=True) if like.builder is None else Symbol(like.builder, splat(like.builder, value_of(a)))


OWN = {"select": _select, "anywhere": _anywhere, "everywhere": _everywhere, "constant": _constant}
"""Functions that need more than their own code on Symbols, by name."""


def _call(name, arguments):
    builder, many = next(a.builder for a in arguments if isinstance(a, Symbol)), any_many(arguments)
    if builder is None:
        return Symbol(None, many=many)
    values = values_of(builder, arguments, many)
    if not many:
        return Symbol(builder, _call_for_one(builder, name, values))
    if name in ("sqrt", "fabs"):
        return Symbol(builder, builder.call(_function(builder, f"llvm.{name}.v{LANES}f64", NUMBERS, 1), values))
    together = ir.Constant(NUMBERS, ir.Undefined)
    for i in range(LANES):
        found = _call_for_one(builder, name, [builder.extract_element(value, LANE(i)) for value in values])
        together = builder.insert_element(together, found, LANE(i))
    return Symbol(builder, together)


def _call_for_one(builder, name, values):
    name = f"llvm.{name}.f64" if name in INTRINSIC else name
    return builder.call(_function(builder, name, NUMBER, len(values)), values)


def _function(builder, name, number, n):
    """Return the function of this name of n numbers."""
    function_type = ir.FunctionType(number, [number] * n)
    return builder.module.globals.get(name) or ir.Function(builder.module, function_type, name)
