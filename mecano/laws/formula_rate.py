"""Rates of a formula of the time, as other formulas: its symbolic derivatives."""

import ast
import re

from mecano.laws.formula import BINARY, FormulaError, read_formula, share_of_edge

LONGEST = 100_000  # characters of a formula in which signals are inserted, and of its rates

TOO_LONG = (
    "with its two rates it is too long a formula: give a table of its values with 'interpolation: spline', or "
    "prescribe the motion from which it follows, as that of the tool of an arm for its angles"
)
SMOOTH = {  # function: its derivative, a formula of the argument {0}
    "sin": "cos({0})", "cos": "-sin({0})", "tan": "1 + tan({0})**2", "asin": "1/sqrt(1 - ({0})**2)",
    "acos": "-1/sqrt(1 - ({0})**2)", "atan": "1/(1 + ({0})**2)", "sqrt": "1/(2*sqrt({0}))", "exp": "exp({0})",
    "log": "1/({0})", "tanh": "1 - tanh({0})**2",
}  # fmt: skip
STEPS = {"step": "step_slope", "step_slope": "step_bend"}  # functions of x, a, b: derivatives by (x - a)/(b - a)
ZERO, ONE = "0", "1"
ARGUMENT = "s"  # of formulas of one variable


def with_rates(text):
    """Return a formula (text) of the time alone and its two rates as Formulas.

    Raises FormulaError where it has corners, or is too long together with its rates.
    """
    found = []
    for order in range(3):
        text = rate_of(text) if order else text
        try:
            found.append(read_formula(text, LONGEST))
        except FormulaError:
            raise FormulaError(TOO_LONG) from None
    return found


def with_slopes(text):
    """Return a formula (text) of s alone and its two slopes as Formulas of the time, which stands for s.

    Raises FormulaError as ``with_rates``.
    """
    return with_rates(re.sub(rf"\b{ARGUMENT}\b", "time", text))


def rate_of(text):
    """Return the rate (text) of a formula (text) of the time alone.

    Raises FormulaError where it has corners: in abs, sign, min and max.
    """
    return _rate(ast.parse(text.strip().removeprefix("=").strip(), mode="eval").body)


def _rate(tree):
    if isinstance(tree, ast.Constant):
        return ZERO
    if isinstance(tree, ast.Name):
        return ONE if tree.id == "time" else ZERO  # pi is the other name
    if isinstance(tree, ast.UnaryOp):
        u = _rate(tree.operand)
        return _times("-1", u) if isinstance(tree.op, ast.USub) else u
    if isinstance(tree, ast.BinOp):
        return _of_operation(tree.op, tree.left, tree.right)
    return _of_call(tree.func.id, tree.args)


def _of_operation(op, left, right):
    a, b, u, v = ast.unparse(left), ast.unparse(right), _rate(left), _rate(right)
    if isinstance(op, ast.Add):
        return _plus(u, v)
    if isinstance(op, ast.Sub):
        return _plus(u, _times("-1", v))
    if isinstance(op, ast.Mult):
        return _plus(_times(u, b), _times(a, v))
    if isinstance(op, ast.Div):
        return _plus(_times(u, f"1/({b})"), _times(f"-({a})/({b})**2", v))
    if isinstance(right, ast.Constant) and right.value in (0, 1):
        return u if right.value else ZERO  # without 0*a**(-1), which is not finite for a = 0
    by_base = ZERO if u == ZERO else _times(f"({b})*({a})**(({b}) - 1)", u)
    return _plus(by_base, ZERO if v == ZERO else _times(f"({a})**({b})*log({a})", v))


def _of_call(name, arguments):
    texts, rates = [ast.unparse(x) for x in arguments], [_rate(x) for x in arguments]
    if all(rate == ZERO for rate in rates):
        return ZERO
    if name in SMOOTH:
        return _times(SMOOTH[name].format(*texts), rates[0])
    if name in STEPS:
        return _times(f"{STEPS[name]}({', '.join(texts)})", _rate(share_of_edge(*arguments)))
    if name not in BINARY:
        raise FormulaError(f"'{name}' has a corner: its rates jump")
    (a, b), (u, v) = texts, rates
    if name == "atan2":
        return _times(f"1/(({a})**2 + ({b})**2)", _plus(_times(u, b), _times(f"-({a})", v)))
    return _times(f"1/hypot({a}, {b})", _plus(_times(a, u), _times(b, v)))


def _plus(a, b):
    return b if a == ZERO else a if b == ZERO else f"({a}) + ({b})"


def _times(a, b):
    return ZERO if ZERO in (a, b) else b if a == ONE else a if b == ONE else f"({a})*({b})"
