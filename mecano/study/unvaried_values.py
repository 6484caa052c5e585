"""Values of the deck, or of 'set', that a study varies, but that some of its cases do not give."""

from typing import Any

from mecano.deck.compose import Node, compose
from mecano.deck.expressions import is_evaluated
from mecano.deck.source import Unreadable, read_source
from mecano.study.grammar import plain_value, shown_value
from mecano.study.read import Study


def unvaried_values(study: Study) -> dict[str, float | str]:
    """Return {path: value as in tables} of the varied values that some case does not give.

    Expressions are left out, because they may depend on values that vary, and so are entries of templates and includes.
    """
    missing = [path for path in study.paths if any(path not in case.entries for case in study.cases)]
    try:
        source, _ = read_source(study.deck) if missing else (None, "")
    except Unreadable:
        return {}
    root = compose(source, []) if source else None
    common = study.common
    found = {p: plain_value(common[p].node) if p in common else _at(root, p.split(".")) for p in missing}
    return {path: shown_value(value) for path, value in found.items() if _is_plain(value)}


def _at(node: Node | None, keys: list[str]) -> Any:
    """Return the plain data at the end of a path of keys in a tree; None if there is none."""
    for key in keys:
        if node is None or type(node.value) is not dict or key not in node.value:
            return None
        _, node = node.value[key]
    return None if node is None else plain_value(node)


def _is_plain(value):
    return type(value) in (int, float) or (type(value) is str and not is_evaluated(value))
