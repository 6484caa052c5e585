"""Checks of single values: node of the deck -> plain value, or INVALID after reporting the problem to the scope.

A check takes the node, the ``Field`` that declares it and the ``Scope``. Numbers become floats; a text may
be an expression, such as ``$speed / 0.35`` (expressions.py).
"""

import math
import re
from dataclasses import replace
from itertools import combinations
from typing import Any

from mecano.deck.compose import Given, Node
from mecano.deck.scalar import number as number_in
from mecano.deck.scope import INVALID, Invalid, Reference, Scope
from mecano.deck.units import (
    UnitError,
    converted,
    go_together,
    is_in_si,
    is_quantity,
    same_dimension,
    unit_of,
    written_in_si,
)
from mecano.deck.wording import quoted
from mecano.errors import Problem
from mecano.schema import LINE, NODE, NODE_SET, NUMBER, NUMBERS, SECTION_OF, Field, Type

LARGEST = 1e100  # beyond it squares and products overflow; no quantity in SI units is near
SMALLEST = 1e-100  # below it they vanish; zero itself is allowed
END = replace(NODE, name="end")  # one of two nodes, which may be the ground
OF_LINE = replace(NODE, options=LINE.options)  # or the name of a member
PAIR = replace(NUMBERS, expects="two numbers")
ROW = replace(NUMBERS, expects="three numbers")
MEANT = dict.fromkeys(("true", "yes", "on"), "true") | dict.fromkeys(("false", "no", "off"), "false")
SIX = replace(NUMBERS, expects="six numbers")


def plain_number(node: Node, field: Field, scope: Scope) -> int | float | Invalid | None:
    """Return the int or float of a node, expression or quantity; None if it is not a number, INVALID if it is wrong."""
    value = node.value
    if type(node) is Given and _quantity(node, node.given, field, scope, node.text) is INVALID:
        return INVALID
    if type(value) is str and (quoted_number := number_in(value)) is not None:
        return quoted_number
    if type(value) is str and is_quantity(value):
        value = _quantity(node, value, field, scope)
    elif type(value) is str:
        given = scope.quantity_of(value)
        wrong = given and _quantity(node, given, field, scope, value) is INVALID
        value = INVALID if wrong else scope.evaluated(node)
        if not given and value is not INVALID and "$" in node.value:
            _note_units(node, field, scope)
        if value is not INVALID and "(" in node.value:
            note_degrees(node, scope)
    return value if value is INVALID or type(value) in (int, float) else None


def _note_units(node, field, scope):
    """Note a warning if the units of the parameters of an expression do not agree."""
    from mecano.deck.expression_units import doubt  # few decks have such expressions

    text = doubt(node.value, field.unit, scope)
    if text:
        name = scope.name_of(field.name)
        place = [scope.subject, f"the units of the expression {quoted(node.value)} do not agree", text]
        scope.doubts.append(Problem(": ".join(filter(None, [place[0], name and quoted(name), *place[1:]])), node.mark))


def note_degrees(node: Node, scope: Scope) -> None:
    """Note a warning if an angle in the expression or formula of a node looks like degrees."""
    from mecano.deck.degrees_in_functions import meant_degrees  # few decks have functions

    if text := meant_degrees(node.value, scope.parameters):
        scope.doubts.append(Problem(": ".join(filter(None, [scope.subject, text])), node.mark))


def _quantity(node, text, field, scope, parameter=""):
    """Return the number of a quantity, or INVALID; ``parameter``: the text "$name" of one that is given as ``text``."""
    try:
        return converted(text, field.unit)
    except UnitError as error:
        name = scope.name_of(field.name)
        subject = f"{quoted(name)}: " if name else ""
        of = f"parameter {parameter} is {text}: " if parameter else ""
        return scope.refuse(node, f"{subject}{of}{error}", scope.where_given(node) if parameter else "")


def number(node: Node, field: Field, scope: Scope) -> float | Invalid:
    """Return a finite float."""
    value = plain_number(node, field, scope)
    if value is INVALID:
        return INVALID
    if value is None:
        return scope.refuse_value(node, field)
    if in_range(value):
        return float(value)
    if abs(value) < SMALLEST:
        hint = "" if field.check and field.check(0.0) else "write 0"
        return scope.refuse_value(node, field, f"is not zero, but less than {SMALLEST:g}", hint=hint)
    return scope.refuse_value(node, field, "is out of range" if math.isfinite(value) else "must be finite")


def in_range(value: float) -> bool:
    """Return True if a number is finite, and neither it nor its square overflows or vanishes."""
    return SMALLEST <= abs(value) <= LARGEST or value == 0


def integer(node: Node, field: Field, scope: Scope) -> int | Invalid:
    """Return an int; a float without fraction is accepted."""
    value = plain_number(node, field, scope)
    if value is INVALID:
        return INVALID
    if value is None or not abs(value) < 2**53 or value != int(value):
        return scope.refuse_value(node, field)
    return int(value)


def boolean(node: Node, field: Field, scope: Scope) -> bool | Invalid:
    """Return True or False."""
    if type(node.value) is bool:
        return node.value
    meant = MEANT.get(node.value.lower(), "") if type(node.value) is str else ""
    return scope.refuse_value(node, field, hint=meant and f"write {meant}, without quotes")


def text(node: Node, field: Field, scope: Scope) -> str | Invalid:
    """Return a text."""
    return node.value if type(node.value) is str else scope.refuse_value(node, field)


def unit(node: Node, field: Field, scope: Scope) -> str | Invalid:
    """Return the unit of a quantity as written, in which pictures show it; the values are in SI."""
    if type(node.value) is not str:
        return scope.refuse_value(node, field)
    try:
        in_si(node.value)
    except UnitError as error:
        return scope.refuse(node, f"{quoted(scope.name_of(field.name))}: {error}")
    return node.value


def in_si(written: str) -> str:
    """Return the SI unit of a unit as written; "-" in a resolved deck stands for none. Raises UnitError."""
    return written if written == "-" else written_in_si(written)


def choice(node: Node, field: Field, scope: Scope) -> str | Invalid:
    """Return one of the keywords of the type."""
    if type(node.value) is not str:
        return scope.refuse_value(node, field)
    if node.value in field.type.options:
        return node.value
    hint = scope.suggest(node.value, field.type.options)
    return scope.refuse(node, f"{quoted(scope.name_of(field.name))} cannot be {quoted(node.value)}", hint)


def items(node: Node, field: Field, scope: Scope, item_type: Type) -> list[Any] | Invalid:
    """Return a list of values of one type."""
    if type(node.value) is not list:
        return scope.refuse_value(node, field)
    plain = (type(i.value) in (int, float) and type(i) is not Given and in_range(i.value) for i in node.value)
    if item_type is NUMBER and all(plain):
        return [float(item.value) for item in node.value]  # most of a large deck: fast path without a Field for each
    check = scope.checks[item_type.name]
    own = item_type is NUMBER  # each number of a list may have a unit of its own; nested lists share one
    values = []
    for i, item in enumerate(node.value):
        unit = unit_of(field.unit, i, len(node.value)) if own else field.unit
        values.append(check(item, Field(f"{field.name}[{i}]", item_type, unit, field.doc), scope))
    return INVALID if INVALID in values else values


def numbers(node: Node, field: Field, scope: Scope) -> list[float] | Invalid:
    """Return a list of numbers."""
    return items(node, field, scope, NUMBER)


def coefficients(node: Node, field: Field, scope: Scope) -> list[float] | Invalid:
    """Return the coefficients of ascending powers of a polynomial, with consistent units."""
    count = len(node.value) if type(node.value) is list else 0
    known = [_of_power(field.unit, n) for n in range(count)]
    values = items(node, replace(field, unit=", ".join(known)), scope, NUMBER)
    if values is INVALID:
        return INVALID
    units = {n: item for n, item in enumerate(node.value) if type(item.value) is str and is_quantity(item.value)}
    if go_together({n: item.value for n, item in units.items()}):
        return values
    last, given = node.value[max(units)], ", ".join(f"{item.value} (power {n})" for n, item in units.items())
    text = f"units are inconsistent: {given}; each is the unit of the value over that of the argument to the power"
    return scope.refuse(last, f"{quoted(scope.name_of(field.name))}: {text}", "such as [0, 2 kN/mm, 3 N/mm^2]")


def _of_power(unit, n):
    """Return the unit "N/m^p" for the power n; unchanged where the use of a law is unknown."""
    if n > 1 or "unit" in unit:
        return unit.replace("^p", f"^{n}")
    return unit.replace("^p", "") if n else re.sub(r"[/ ]?[^/ ]+\^p", "", unit) or "-"


def vector(node: Node, field: Field, scope: Scope) -> list[float] | Invalid:
    """Return a list of three numbers."""
    if type(node.value) is not list or len(node.value) != 3:
        return scope.refuse_value(node, field)
    return items(node, field, scope, NUMBER)


def direction(node: Node, field: Field, scope: Scope) -> list[float] | Invalid:
    """Return a vector that is not zero."""
    value = vector(node, field, scope)
    if value is INVALID or any(value):
        return value
    return scope.refuse_value(node, field)


def inertia(node: Node, field: Field, scope: Scope) -> list[float] | list[list[float]] | Invalid:
    """Return three or six numbers, or three rows of three, as written."""
    size = len(node.value) if type(node.value) is list else 0
    if size == 6 or (size == 3 and type(node.value[0].value) is not list):
        return items(node, field, scope, NUMBER)
    if size == 3 and all(type(row.value) is list and len(row.value) == 3 for row in node.value):
        return items(node, field, scope, ROW)
    return scope.refuse_value(node, field)


def matrix(node: Node, field: Field, scope: Scope) -> list[list[float]] | Invalid:
    """Return a symmetric matrix of six rows of six numbers."""
    if type(node.value) is not list or len(node.value) != 6 or any(len(_listed(row)) != 6 for row in node.value):
        return scope.refuse_value(node, field)
    rows = items(node, field, scope, SIX)
    if rows is INVALID:
        return rows
    for i, j in combinations(range(6), 2):
        gap, size = abs(rows[i][j] - rows[j][i]), math.sqrt(abs(rows[i][i] * rows[j][j]))
        if gap > ROUNDING * size:
            pair = f"({i + 1}, {j + 1}) and ({j + 1}, {i + 1}) are {rows[i][j]:.9g} and {rows[j][i]:.9g}"
            return scope.refuse(node, f"{quoted(scope.name_of(field.name))} is not symmetric: entries {pair}")
    return [[rows[min(i, j)][max(i, j)] for j in range(6)] for i in range(6)]


ROUNDING = 1e-12  # of the root of both diagonal entries: products of matrices are symmetric to this


def _listed(node):
    return node.value if type(node.value) is list else ()


def matrix_6(node: Node, field: Field, scope: Scope) -> list[float] | list[list[float]] | Invalid:
    """Return six numbers or six rows of six, as written."""
    rows = node.value if type(node.value) is list and len(node.value) == 6 else []
    if rows and type(rows[0].value) is not list:
        return items(node, field, scope, NUMBER)
    if rows and all(type(row.value) is list and len(row.value) == 6 for row in rows):
        return items(node, field, scope, SIX)
    return scope.refuse_value(node, field)


def points(node: Node, field: Field, scope: Scope) -> list[list[float]] | Invalid:
    """Return a list of pairs of numbers."""
    if type(node.value) is not list:
        return scope.refuse_value(node, field)
    if node.value and all(type(item.value) not in (list, dict) for item in node.value):
        return scope.refuse_value(node, field, hint="write [[0, 0], [1, 5]]")
    odd = [i for i, item in enumerate(node.value) if type(item.value) is not list or len(item.value) != 2]
    for i in odd:
        scope.refuse_value(node.value[i], replace(field, name=f"{field.name}[{i}]", type=PAIR))
    values = INVALID if odd else items(node, field, scope, PAIR)
    if values is INVALID or not all(_alike(node, i, field, scope) for i in (0, 1)):
        return INVALID
    return values


def _alike(node, i, field, scope):
    """Return whether the quantities of column ``i`` of pairs have one dimension; report the first other one."""
    cells = [row.value[i] for row in node.value]
    texts = [_with_unit(cell.value, scope) if type(cell.value) is str else "" for cell in cells]
    first = next(filter(None, texts), "")
    odd = next((n for n, text in enumerate(texts) if text and not same_dimension(first, text)), None)
    if odd is None and first and not is_in_si(first):  # numbers alone are
        odd = next((n for n, cell in enumerate(cells) if _is_bare(cell.value)), None)
    if odd is None:
        return True
    of = f"{quoted(scope.name_of(f'{field.name}[{odd}][{i}]'))}: units of a column are inconsistent"
    other = texts[odd] or f"{cells[odd].value}, which has none"
    scope.refuse(cells[odd], f"{of}: {first} and {other}", f"give each a unit as that of {first}, or none")
    return False


def _is_bare(value):
    """Return whether a value is a number other than zero without a unit."""
    return type(value) in (int, float) and value != 0


def _with_unit(text, scope):
    return text if is_quantity(text) else scope.quantity_of(text)


def columns(node: Node, field: Field, scope: Scope) -> list[str | int] | Invalid:
    """Return two columns of a table: headers, or numbers from 1."""
    return _pair(node, field, scope, (str, int))


def units(node: Node, field: Field, scope: Scope) -> list[str] | Invalid:
    """Return two units."""
    return _pair(node, field, scope, (str,))


def _pair(node, field, scope, types):
    items = node.value if type(node.value) is list else ()
    if len(items) != 2 or any(type(item.value) not in types for item in items):
        return scope.refuse_value(node, field)
    return [item.value for item in items]


def node_name(node: Node, field: Field, scope: Scope) -> str | Invalid:
    """Return the name of a node, resolved later."""
    if type(node.value) is not str:
        return scope.refuse_value(node, field)
    scope.references.append(Reference(node.value, "nodes", field.type.name, node, scope.subject, field.type.options))
    return node.value


def node_names(node: Node, field: Field, scope: Scope) -> list[str] | Invalid:
    """Return a list of names of nodes, of the length required by the type; one of a fixed number may be ``ground``."""
    if field.type in (LINE, NODE_SET):
        return nodes_and_members(node, field, scope)
    length = field.type.options[0] if field.type.options else None
    if type(node.value) is not list or (length and len(node.value) != length):
        hint = f"write [{node.value}]" if type(node.value) is str and node.value.isidentifier() and not length else ""
        return scope.refuse_value(node, field, hint=hint)
    values: list[Any] = []
    for i, item in enumerate(node.value):
        if length and item.value == "ground" and "ground" not in values:
            values.append("ground")
        else:
            type_ = END if length else NODE
            values.append(node_name(item, replace(field, name=f"{field.name}[{i}]", type=type_), scope))
    return INVALID if INVALID in values else values


def nodes_and_members(node: Node, field: Field, scope: Scope) -> list[str] | Invalid:
    """Return a list of names of nodes and members; the members are replaced later by their nodes (resolve.py)."""
    items = [node] if type(node.value) is str else node.value
    if type(items) is not list:
        return scope.refuse_value(node, field)
    own = [replace(field, name=f"{field.name}[{i}]", type=OF_LINE) for i in range(len(items))]
    values: list[Any] = [node_name(item, one, scope) for item, one in zip(items, own, strict=True)]
    (scope.lines if field.type == LINE else scope.node_sets).append(values)
    return INVALID if INVALID in values else values


def named(node: Node, field: Field, scope: Scope) -> Reference | Invalid:
    """Return a Reference to a name in the section of the type, replaced later by the entry of this name."""
    if type(node.value) is not str:
        return scope.refuse_value(node, field)
    type_ = field.type
    return Reference(node.value, SECTION_OF[type_.name], type_.name, node, scope.subject, type_.options)
