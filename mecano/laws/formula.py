"""Formulas of signals: arithmetic of numbers, the time and named quantities, evaluated with exact derivatives.

A formula is a text, such as ``40*(0.5 - elbow.angle) - 2*elbow.rate``. It becomes a program of the flat table of laws
(law_table.py): pairs of an operation and a number, for a stack of ``DEPTH`` places. One compiled function evaluates the
programs of all formulas, so a new formula compiles nothing.
"""

import ast
import keyword
import math
import re
from itertools import accumulate
from typing import NamedTuple

from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, at_most, atan2, chain, constant, cos, exp, number, select, sin, sqrt, tan, value

DEPTH = 8  # places of the stack
DIFFERENCE = 1e-5  # s, or of the time: of the difference for the rate of a phase
LONGEST, DEEPEST = 500, 50  # characters, levels of brackets

NUMBER, INPUT, TIME = 0, 1, 2
NEGATIVE, SIN, COS, TAN, ASIN, ACOS, ATAN, SQRT, EXP, LOG, TANH, ABS, SIGN, STEP, STEP_SLOPE, STEP_BEND = range(10, 26)
ADD, SUBTRACT, MULTIPLY, DIVIDE, POWER, MIN, MAX, ATAN2, HYPOT = range(30, 39)
UNARY = {
    "sin": SIN, "cos": COS, "tan": TAN, "asin": ASIN, "acos": ACOS, "atan": ATAN, "sqrt": SQRT, "exp": EXP,
    "log": LOG, "tanh": TANH, "abs": ABS, "sign": SIGN,
}  # fmt: skip
BINARY = {"atan2": ATAN2, "hypot": HYPOT}
SEVERAL = {"min": MIN, "max": MAX}  # of two arguments or more
OF_THREE = {"step": STEP, "step_slope": STEP_SLOPE, "step_bend": STEP_BEND}
"""Of x and the ends a, b of the edge: the step, and its first two derivatives by (x - a)/(b - a), for its rates."""
FUNCTIONS = (*UNARY, *BINARY, *SEVERAL, "step")
OPERATORS = {ast.Add: ADD, ast.Sub: SUBTRACT, ast.Mult: MULTIPLY, ast.Div: DIVIDE, ast.Pow: POWER}
CONSTANTS = {"pi": math.pi}
UNIT = r"(?<![\w.$])[0-9.]+(?:[eE][-+]?[0-9]+)? ?(?![eE][-+0-9])[A-Za-z°%]"  # 100 rpm
TOGETHER = "join several by 'and' or 'or', as in 'time > 1 and hinge.angle > 0.5'"
PART = r"(?<![\w.$])[A-Za-z_]\w*\.\d+\b"  # rod.1
WORD = r"(?<![\w.$])[A-Za-z_]\w*"
NOT_CLOSED = "a bracket is not closed: a formula with a comma must be quoted"
COMPARISON = r"(>=|<=|>|<)"


class FormulaError(Exception):
    """An error in a formula, with the index of its character."""

    def __init__(self, message, column=0):
        super().__init__(message)
        self.message, self.column = message, column


class Formula(NamedTuple):
    """A formula that has been read."""

    text: str
    references: tuple  # names of the quantities that it reads, each once: "elbow.angle", "error"
    columns: tuple  # of the text, where each of them first occurs
    program: tuple  # (operation, number) of every step

    @property
    def depends_on_time(self):
        """True if the formula contains the time."""
        return (TIME, 0.0) in self.program

    @property
    def reference(self):
        """The name of the quantity if the formula consists of a single one, otherwise ""."""
        return self.references[0] if self.program == ((INPUT, 0.0),) else ""

    @property
    def operands(self):
        """The steps (operation, number) that are numbers, inputs or the time."""
        return [(code, x) for code, x in self.program if code < NEGATIVE]

    @property
    def numbers(self):
        """The program as stored in the table of laws."""
        return [float(len(self.program)), *(x for step in self.program for x in step)]


def read_formula(text, longest=LONGEST):
    """Return the Formula of a text of at most ``longest`` characters. Raises FormulaError."""
    if len(text) > longest:
        raise FormulaError(f"a formula has at most {longest} characters: define parts of it as signals")
    body = text.strip().removeprefix("=").strip()
    skipped = text.find(body) if body else 0
    try:
        tree = ast.parse(body, mode="eval").body
    except SyntaxError as error:
        if body.count("(") > body.count(")"):
            raise FormulaError(NOT_CLOSED, skipped) from None
        raise FormulaError(_cause(body), skipped + max((error.offset or 1) - 1, 0)) from None
    except (ValueError, MemoryError, RecursionError):
        raise FormulaError("it cannot be understood") from None
    return _Reader(text, skipped).formula(tree)


def _cause(body):
    """Return a text on a formula that is not arithmetic."""
    if body.count("(") < body.count(")"):
        return "a bracket is closed that was not opened"
    if re.search(r"\bif *\(", body, re.IGNORECASE):
        from mecano.laws.other_functions import IN_PLACE  # rarely needed

        return f"it cannot be understood: {IN_PLACE['if']}"
    if unit := re.search(UNIT, body):
        return f"it cannot be understood at '{unit[0]}': formulas contain no units, give them to a parameter"
    if word := next((match[0] for match in re.finditer(WORD, body) if keyword.iskeyword(match[0])), ""):
        return f"it cannot be understood at '{word}', which cannot be a name in formulas: choose another name"
    if part := re.search(PART, body):
        return (
            f"it cannot be understood at '{part[0]}': formulas do not read nodes and elements of a mesh; end the "
            "member at a node of its own and read that, or the reaction of a joint"
        )
    return "it cannot be understood"


def difference_of(condition, level=0):
    """Return the formula that rises through zero where a condition, such as ``hinge.angle > 1.5``, becomes true.

    Comparisons, or conditions in brackets, may be joined by ``and``, which binds more tightly, and ``or``: all are true
    if the smallest of their differences is above zero, one is if the largest is. Raises FormulaError.
    """
    if level > DEEPEST:
        raise FormulaError("it has too many levels of brackets")
    either = [_split(one, "and") for one in _split(condition, "or")]
    return _joined("max", [_joined("min", [_difference(part, level) for part in both]) for both in either])


def _split(condition, word):
    """Return the parts of a condition between a word that is not in brackets."""
    parts, depth, start = [], 0, 0
    for match in re.finditer(rf"[()]|\b{word}\b", condition):
        depth += {"(": 1, ")": -1}.get(match[0], 0)
        if depth < 0:
            raise FormulaError("a bracket is closed that was not opened")
        if match[0] == word and depth == 0:
            parts.append(condition[start : match.start()])
            start = match.end()
    if depth:
        raise FormulaError(NOT_CLOSED)
    return [*parts, condition[start:]]


def _joined(function, differences):
    return differences[0] if len(differences) == 1 else f"{function}({', '.join(differences)})"


def _difference(comparison, level):
    within = comparison.strip()
    if within[:1] == "(" and _closes(within) == len(within) - 1:
        return difference_of(within[1:-1], level + 1)
    parts = re.split(COMPARISON, comparison)
    if len(parts) != 3:
        several = f"; {TOGETHER}" if len(parts) > 3 else ""
        raise FormulaError(f"a condition compares two formulas by > or <, as in 'hinge.angle > 1.5'{several}")
    left, sign, right = parts
    for part in (left, right):
        read_formula(part)
    return f"({left.strip()}) - ({right.strip()})" if sign[0] == ">" else f"({right.strip()}) - ({left.strip()})"


def _closes(text):
    """Return the index of the bracket that closes the first one of a text, or -1."""
    depths = accumulate((letter == "(") - (letter == ")") for letter in text)
    return next((i for i, depth in enumerate(depths) if depth == 0), -1)


def share_of_edge(x, a, b):
    """Return the tree of (x - a)/(b - a), of which a step is a function."""
    return ast.BinOp(ast.BinOp(x, ast.Sub(), a), ast.Div(), ast.BinOp(b, ast.Sub(), a))


class _Reader:
    """One walk through the tree of a formula, which writes its program."""

    def __init__(self, text, skipped):
        self.text, self.skipped, self.references, self.program = text, skipped, {}, []

    def formula(self, tree):
        most = self._put(tree, 0)
        if most > DEPTH:
            raise FormulaError("it has too many levels of brackets: define parts of it as signals")
        return Formula(self.text, tuple(self.references), tuple(self.references.values()), tuple(self.program))

    def _put(self, tree, level):
        """Write the steps of a part of the tree; the places of the stack that they need."""
        if level > DEEPEST:
            raise FormulaError("it has too many levels of brackets", self._column(tree))
        if isinstance(tree, ast.BinOp) and type(tree.op) in OPERATORS:
            return self._pairs(OPERATORS[type(tree.op)], (tree.left, tree.right), level)
        if isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.USub | ast.UAdd):
            return self._one(NEGATIVE if isinstance(tree.op, ast.USub) else None, tree.operand, level)
        if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and not tree.keywords:
            return self._call(tree, level)
        return self._leaf(tree)

    def _one(self, code, operand, level):
        most = self._put(operand, level + 1)
        if code is not None:
            self.program.append((code, 0.0))
        return most

    def _pairs(self, code, operands, level):
        """Append the steps of a binary operation, applied successively to several operands.

        The operand that needs more places of the stack comes first where their order does not matter.
        """
        start, most = len(self.program), self._put(operands[0], level + 1)
        for operand in operands[1:]:
            middle, places = len(self.program), self._put(operand, level + 1)
            if code in (ADD, MULTIPLY) and places > most:
                self.program[start:] = self.program[middle:] + self.program[start:middle]
                most, places = places, most
            most = max(most, 1 + places)
            self.program.append((code, 0.0))
        return most

    def _call(self, tree, level):
        name, count = tree.func.id, len(tree.args)
        if name in UNARY and count == 1:
            return self._one(UNARY[name], tree.args[0], level)
        if (name in BINARY and count == 2) or (name in SEVERAL and count > 1):
            return self._pairs((BINARY | SEVERAL)[name], tree.args, level)
        if name in OF_THREE and count == 3:
            return self._one(OF_THREE[name], share_of_edge(*tree.args), level)
        from mecano.laws.other_functions import refused_call  # rarely needed

        raise FormulaError(refused_call(name, FUNCTIONS), self._column(tree))

    def _leaf(self, tree):
        """Append the step of a number, the time, a constant, or the name of a quantity."""
        if isinstance(tree, ast.Constant) and type(tree.value) in (int, float):
            self.program.append((NUMBER, self._number(tree)))
        elif isinstance(tree, ast.Name) and tree.id in CONSTANTS:
            self.program.append((NUMBER, CONSTANTS[tree.id]))
        elif isinstance(tree, ast.Name) and tree.id == "time":
            self.program.append((TIME, 0.0))
        else:
            name = self._name(tree)
            self.references.setdefault(name, self._column(tree))
            self.program.append((INPUT, float(list(self.references).index(name))))
        return 1

    def _number(self, tree):
        try:
            x = float(tree.value)
        except OverflowError:  # a whole number of more than 308 digits
            x = math.inf
        if not math.isfinite(x):
            raise FormulaError("it has a number that is not finite", self._column(tree))
        return x

    def _name(self, tree):
        if isinstance(tree, ast.Name):
            return tree.id
        if isinstance(tree, ast.Attribute):
            return f"{self._name(tree.value)}.{tree.attr}"
        what = "it may contain numbers, names, + - * / ** ( ) and functions only"
        if isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.BitXor):
            what = "a power is written with **, as in x**2"
        if isinstance(tree, ast.Subscript):
            what += "; a component is written .x, .y or .z, as in tip.position.z"
        if isinstance(tree, ast.IfExp | ast.Compare | ast.BoolOp):
            what += "; a signal of the type 'switch' selects one of two formulas"
        raise FormulaError(what, self._column(tree))

    def _column(self, tree):
        return self.skipped + tree.col_offset


def phases_of_time(formula):
    """Return the programs of the arguments of sin, cos and tan in a Formula that depend on the time alone."""
    starts, found = [], []  # first step of every number on the stack
    for i, (code, _) in enumerate(formula.program):
        if code < NEGATIVE:
            starts.append(i)
        elif code >= ADD:
            starts.pop()
        elif code in (SIN, COS, TAN):
            phase = formula.program[starts[-1] : i]
            codes = {code for code, _ in phase}
            if TIME in codes and INPUT not in codes:
                found.append(phase)
    return found


def phase_rate(program, t):
    """Return |d/dt| [1/s] of a program of the time alone at ``t`` [s], by finite differences; 0 if undefined."""
    laws = [float(len(program)), *(x for step in program for x in step)]
    dt = DIFFERENCE * max(1.0, abs(t))
    try:
        low, high = (value(evaluate_formula(laws, 0, t + by, [0.0], 0)) for by in (-dt, dt))
        rate = abs(high - low) / (2.0 * dt)
    except (ArithmeticError, ValueError, TypeError):  # such as the root of a negative number
        return 0.0
    return rate if math.isfinite(rate) else 0.0


@kernel
def evaluate_formula(laws, start, t, q, own):
    """Return the value of the formula at ``start`` of the table of laws, with its slope.

    Its inputs follow the local unknown number ``own`` in q (n_local,); ``t`` is the time [s].
    """
    like = number(q[own])
    zero = constant(0.0, like)
    a = b = c = d = e = f = g = h = zero  # the stack, a on top
    i = start + 1
    for _ in range(int(laws[start])):
        code, x = int(laws[i]), laws[i + 1]
        if code < NEGATIVE:
            b, c, d, e, f, g, h = a, b, c, d, e, f, g
            a = number(q[own + 1 + int(x)]) if code == INPUT else constant(t if code == TIME else x, like)
        elif code < ADD:
            a = of_one(code, a)
        else:
            a = of_two(code, b, a)
            b, c, d, e, f, g = c, d, e, f, g, h
        i += 2
    return a


@kernel
def of_one(code, a):
    """Return the value of an operation on one number."""
    x = value(a)
    if code == NEGATIVE:
        return -a
    if code == SIN:
        return sin(a)
    if code == COS:
        return cos(a)
    if code == TAN:
        return tan(a)
    if code == ASIN:
        return chain(a, math.asin(x), 1.0 / math.sqrt(1.0 - x * x))
    if code == ACOS:
        return chain(a, math.acos(x), -1.0 / math.sqrt(1.0 - x * x))
    if code == ATAN:
        return chain(a, math.atan(x), 1.0 / (1.0 + x * x))
    if code == SQRT:
        return sqrt(a)
    if code == EXP:
        return exp(a)
    if code == LOG:
        return chain(a, math.log(x), 1.0 / x)
    if code == TANH:
        y = math.tanh(x)
        return chain(a, y, 1.0 - y * y)
    if code == ABS:
        return abs(a)
    if code >= STEP:
        return step_of(code, a)
    return chain(a, select(x > 0.0, 1.0, select(x < 0.0, -1.0, 0.0)), 0.0)


@kernel
def step_of(code, a):
    """Return u^3 (10 - 15 u + 6 u^2), or its first or second derivative by u; u is a, kept between 0 and 1."""
    u = min(max(value(a), 0.0), 1.0)
    slope, bend = 30.0 * u * u * (1.0 - u) * (1.0 - u), 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)
    if code == STEP:
        return chain(a, u * u * u * (10.0 - u * (15.0 - 6.0 * u)), slope)
    if code == STEP_SLOPE:
        return chain(a, slope, bend)
    return chain(a, bend, select(0.0 < u < 1.0, 60.0 - 360.0 * u * (1.0 - u), 0.0))


@kernel
def of_two(code, a, b):
    """Return the value of an operation on two numbers."""
    if code == ADD:
        return a + b
    if code == SUBTRACT:
        return a - b
    if code == MULTIPLY:
        return a * b
    if code == DIVIDE:
        return a / b
    if code == POWER:
        return power(a, b)
    if code == MIN:
        return at_most(a, b)
    if code == MAX:
        return at_least(a, b)
    if code == ATAN2:
        return atan2(a, b)
    return sqrt(a * a + b * b)


@kernel
def power(a, b):
    """Return a**b; of a negative a, the slope by b is taken as zero: b is a whole number there."""
    x, n = value(a), value(b)
    y = x**n
    by_a = n * x ** (n - 1.0) if n != 0.0 else 0.0
    by_b = y * math.log(x) if x > 0.0 else 0.0
    return chain(a, y, by_a) + chain(b, 0.0, by_b)
