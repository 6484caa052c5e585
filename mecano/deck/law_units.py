"""Check the units in the laws of the section ``laws`` against the value and the argument of each of their uses."""

from dataclasses import replace

from mecano.deck.compose import Node
from mecano.deck.laws import law, units_in
from mecano.deck.scope import Scope
from mecano.deck.values import number
from mecano.deck.wording import quoted
from mecano.schema import NUMBER


def check_named_laws(root: Node, scope: Scope) -> None:
    """Note errors for units in named laws that do not agree with a use; ``root`` is the tree of the checked deck."""
    nodes = {name: node for name, (_, node) in root.value["laws"][1].value.items()} if "laws" in root.value else {}
    checked = set()
    for reference in scope.references:
        use = reference.use
        if use is None:
            continue
        units = units_in(use)
        if not any(units) or reference.name not in nodes or (reference.name, units) in checked:
            continue
        checked.add((reference.name, units))
        first, scope.subject = len(scope.problems), f"law {quoted(reference.name)}"
        _check(nodes[reference.name], replace(use, name=""), units[0], scope)
        for i, problem in enumerate(scope.problems[first:], first):
            hint = "; ".join(filter(None, (problem.hint, _used_by(reference, nodes[reference.name]))))
            scope.problems[i] = replace(problem, hint=hint)


def _check(node, use, unit, scope):
    """Check a law as if it were written in the place of its ``use``, whose value has the ``unit``."""
    if type(node.value) in (dict, list):
        law(node, use, scope)
    elif unit:
        number(node, replace(use, type=NUMBER, unit=unit, check=None), scope)


def _used_by(reference, law_node):
    node = reference.node
    where = f"line {node.line + 1}" if node.source is law_node.source else str(node.mark)
    return f"{reference.subject} uses it in {where}"
