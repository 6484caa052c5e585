"""Values of ``repeat``: ranges and lists, in all combinations, or rows that belong together."""

from itertools import product

from mecano.deck.compose import Node
from mecano.deck.parameters import is_word
from mecano.deck.scalar import resolved
from mecano.deck.scope import INVALID, Invalid, Scope
from mecano.deck.units import ANY
from mecano.deck.values import number
from mecano.deck.wording import quoted
from mecano.schema import NUMBER, Field

HOW = "write {i: 0..5}, {i: [0, 2, 5]}, or a list of rows such as [{side: left, y: 0.5}, {side: right, y: -0.5}]"
RANGE = Field("", NUMBER, "-", "an end of a range")
VALUE = Field("", NUMBER, ANY, "a value of a copy")


def rows(node: Node, scope: Scope, most: int) -> list[dict[str, Node]] | Invalid:
    """Return [{name: node of a number or word}] of the value of ``repeat``, at most ``most``; or INVALID."""
    if type(node.value) is dict and node.value:
        return _combinations(node, scope, most)
    if type(node.value) is list and node.value and all(type(row.value) is dict and row.value for row in node.value):
        found = [{name: _value(item, scope) for name, (_, item) in row.value.items()} for row in node.value]
        return INVALID if any(INVALID in row.values() for row in found) else found
    return scope.refuse(node, "'repeat' must be a mapping of names to values, or a list of rows", HOW)


def _combinations(node, scope, most):
    values, count = [], 1
    for _, item in node.value.values():
        values.append(_values(item, scope, most))
        if values[-1] is INVALID:
            return INVALID
        count *= len(values[-1])
        if count > most:
            return scope.refuse(item, f"'repeat' asks for more than {most} copies")
    return [dict(zip(node.value, row, strict=True)) for row in product(*values)]


def _values(node, scope, most):
    """Return the values of one name: a range "first..last", both included, or a list; none of "1..0"."""
    if type(node.value) is list:
        found = [_value(item, scope) for item in node.value]
        return INVALID if INVALID in found else found
    ends = node.value.split("..") if type(node.value) is str else ()
    if len(ends) != 2:
        return scope.refuse(node, "'repeat' takes a range such as 0..5, or a list", HOW)
    first, last = (_end(text.strip(), node, scope) for text in ends)
    if INVALID in (first, last):
        return INVALID
    if last < first - 1:
        return scope.refuse(node, f"a range ascends, and {quoted(node.value)} does not", "write the smaller end first")
    if last - first >= most:
        return scope.refuse(node, f"'repeat' asks for more than {most} copies")
    return [Node(i, node.source, node.line, node.column, str(i)) for i in range(first, last + 1)]


def _end(text, node, scope):
    at = Node(resolved(text), node.source, node.line, node.column, text)
    value = number(at, RANGE, scope)
    if value is not INVALID and value != int(value):
        return scope.refuse(node, f"a range is of whole numbers, and {quoted(text)} is {value:g}")
    return value if value is INVALID else int(value)


def _value(node, scope):
    if is_word(node):
        return node
    value = number(node, VALUE, scope)
    return INVALID if value is INVALID else Node(value, node.source, node.line, node.column, node.raw)
