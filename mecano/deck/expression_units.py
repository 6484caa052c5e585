"""Units of parameters in expressions and formulas, and warnings about expressions in which they do not agree.

Unlike quantities are added, or the result has another dimension. A number in an expression may have any unit, and so
may what it is multiplied with or divided by; angles are numbers.
"""

import ast
import re
from contextlib import suppress
from typing import TypeAlias

from mecano.deck.copied_formulas import OUTER, filled_in
from mecano.deck.expressions import NAME, is_expression
from mecano.deck.scope import Scope
from mecano.deck.units import dimension_of, is_quantity, number_and_unit, unit_of_dimension, written_in_si
from mecano.laws.formula import COMPARISON, INPUT, FormulaError, difference_of, read_formula

Powers: TypeAlias = "tuple[float, ...] | None"  # of m, kg and s; None where they are unknown
LIKE = ("abs", "min", "max", "hypot")  # functions of quantities of one dimension, which is that of their value
MARK = "parameter.n"  # of a parameter in a formula, which is read as a quantity
DEEPEST = 20  # parameters that are expressions of others


class Unlike(Exception):
    """Quantities of two dimensions that are added or compared; the text names both units."""


def doubt(text: str, declared: str, scope: Scope) -> str:
    """Return what is wrong with the units of an expression (text) for a field of the unit ``declared``, or ""."""
    try:
        found = _of_text(text, scope, 0)
    except Unlike as error:
        return str(error)
    wanted = [dimension_of(unit) for unit in declared.split(" or ")]
    if found is None or None in wanted or found in wanted:
        return ""
    return f"it is in {unit_of_dimension(found)}, where {declared} is expected"


def units_in_formula(text: str, scope: Scope) -> dict[int, str]:
    """Return {i: SI unit} of the parameters with units in a formula or condition, its i-th operands (Formula)."""
    names = [match[1] for match in NAME.finditer(text)]
    numbers = iter(range(len(names)))
    return _of_marked(NAME.sub(lambda match: f"{MARK}{next(numbers)}", text), names, scope)


def units_in_copy(text: str, scope: Scope) -> dict[int, str]:
    """Return the same of a formula in a template or ``repeat``, into which values of parameters are written."""
    names: list[str] = []

    def marked(name):
        names.append(name)
        return f"{MARK}{len(names) - 1}"

    found = filled_in(text, scope.parameters, marked).replace(OUTER, "")
    with suppress(FormulaError):  # reported where the copy is read
        return _of_marked(found, names, scope)
    return {}


def _of_marked(text, names, scope):
    """Return {i: SI unit} of a formula in which the parameters ``names`` are the quantities MARK0, MARK1, ..."""
    marked, found = read_formula(difference_of(text) if re.search(COMPARISON, text) else text), {}
    for i, (code, x) in enumerate(marked.operands):
        name = marked.references[int(x)] if code == INPUT else ""
        if name.startswith(MARK) and (unit := _unit_of(names[int(name.removeprefix(MARK))], scope)):
            found[i] = unit
    return found


def _unit_of(name, scope):
    """Return the SI unit of a parameter: "" of a number, or if it is unknown."""
    node = scope.parameters.node(name)
    text = node.value if node is not None and type(node.value) is str else ""
    if is_quantity(text):
        return written_in_si(number_and_unit(text)[1])
    powers = _of_parameter(name, scope, 0) if is_expression(text) else None
    return unit_of_dimension(powers) if powers and any(powers) else ""


def _of_text(text, scope, depth):
    """Return the Powers of an expression, a quantity or the text of a number."""
    if not is_expression(text):
        return dimension_of(text, quantity=True)
    if depth > DEEPEST:
        return None
    return _of_tree(ast.parse(NAME.sub(r"_\1", text.removeprefix("=")).strip(), mode="eval").body, scope, depth)


def _of_tree(tree, scope, depth):
    """Return the Powers of a part of an expression, which has been evaluated before."""
    if isinstance(tree, ast.Name):
        return _of_parameter(tree.id.removeprefix("_"), scope, depth)
    if isinstance(tree, ast.UnaryOp):
        return _of_tree(tree.operand, scope, depth)
    if isinstance(tree, ast.Call):
        inner = [_of_tree(part, scope, depth) for part in tree.args]
        name = ast.unparse(tree.func)
        return _alike(inner) if name in LIKE else _power(inner[0], 0.5) if name == "sqrt" else None
    if not isinstance(tree, ast.BinOp):
        return None
    left, right = _of_tree(tree.left, scope, depth), _of_tree(tree.right, scope, depth)
    if isinstance(tree.op, ast.Add | ast.Sub | ast.Mod):
        return _alike([left, right])
    if isinstance(tree.op, ast.Pow):
        return _power(left, tree.right.value) if isinstance(tree.right, ast.Constant) else None
    if left is None or right is None:
        return None
    sign = 1.0 if isinstance(tree.op, ast.Mult) else -1.0
    return tuple(a + sign * b for a, b in zip(left, right, strict=True))


def _of_parameter(name, scope, depth):
    """Return the Powers of a parameter, found once: each of a chain may occur several times in the next one."""
    found, node = scope.parameters.dimensions, scope.parameters.node(name)
    if name not in found:
        found[name] = None
        if node is not None and type(node.value) is str:
            with suppress(Unlike):  # a warning of its own
                found[name] = _of_text(node.value, scope, depth + 1)
    return found[name]


def _power(powers, exponent):
    return None if powers is None else tuple(exponent * power for power in powers)


def _alike(found):
    """Return the dimension of several quantities of one; raises Unlike."""
    known = [powers for powers in found if powers is not None]
    for other in known[1:]:
        if other != known[0]:
            raise Unlike(f"it adds or compares {unit_of_dimension(known[0])} and {unit_of_dimension(other)}")
    return known[0] if known else None
