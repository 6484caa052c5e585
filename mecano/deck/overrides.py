"""``--set a.b.c=value``: values of the command line, inserted into the tree of a deck before it is checked."""

import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import accumulate

from mecano.deck.compose import MAX_DEPTH, Node, Pair, compose
from mecano.deck.source import FORBIDDEN, Source
from mecano.deck.wording import quoted, suggestion
from mecano.errors import DeckError, Problem
from mecano.schema import Field

ADDING = (
    "an override changes entries and does not add them: edit the deck, include it in one that adds them, or use "
    "mecano.Deck in Python"
)
INDEX = "[0-9]{1,9}"
INDEXED = r"\[([0-9]{1,9})\]"
ITEM = rf"([^\[\]]+)({INDEXED})+"  # as in messages: nodes[1]


def as_written(value: Node) -> Node:
    """Return the ``value`` of an override."""
    return value


def overridden(
    root: Node,
    overrides: Iterable[str],
    sections: "Iterable[Field]",
    problems: list[Problem],
    expanded: Callable[[Node], Node] = as_written,
) -> Node:
    """Return a copy of the tree with the overrides applied in order.

    ``overrides`` are texts ``path=value``: the keys of the path are separated by dots, items of lists are counted
    from 0, the value is YAML. New keys are allowed where the schema has them; names in a section of names (nodes,
    laws, parameters...) must exist in the deck; null removes them, except parameters, and terms of laws. ``expanded``
    is called with each value. Adds to ``problems``.
    """
    names = {field.name for field in sections if field.type.name == "named"}
    for text in overrides:
        try:
            root = _applied(root, text, names, expanded)
        except DeckError as error:
            problems.extend(error.problems)
    return root


def settled(
    root: Node,
    settings: "Iterable[Pair]",
    sections: "Iterable[Field]",
    problems: list[Problem],
    expanded: Callable[[Node], Node] = as_written,
) -> Node:
    """Return a copy of the tree with the ``settings`` (path, value) of a deck applied in order, as ``overridden``."""
    names = {field.name for field in sections if field.type.name == "named"}
    for path, new in settings:
        keys = str(path.value).split(".")
        try:
            if not all(keys) or len(keys) > MAX_DEPTH:
                _refuse(path, f"{quoted(str(path.value))} is not a path of keys separated by dots, such as 'time.end'")
            root = _replaced(root, _places(keys, path), 0, expanded(new), names)
        except DeckError as error:
            problems.extend(error.problems)
    return root


def shown(path: str) -> str:
    """Return the text shown in place of a file name in messages on an override."""
    printable = "".join(c if c.isprintable() else repr(c)[1:-1] for c in path)
    return f"override {printable if len(printable) <= 60 else printable[:57] + '...'}".strip()


def _applied(root, text, names, expanded):
    path, equals, value = text.partition("=")
    whole = Source(shown(path), text)
    if FORBIDDEN.search(text):
        raise DeckError([Problem("control characters are not allowed", whole.mark(0, 0))])
    keys = path.split(".")
    if not equals or not all(keys) or len(keys) > MAX_DEPTH:
        raise DeckError([Problem("an override is written path.to.key=value", whole.mark(0, 0))])
    source = replace(whole, begin=len(path) + 1)
    problems: list[Problem] = []
    new = compose(source, problems) or Node(None, source)
    if problems:
        raise DeckError(problems)
    return _replaced(root, _places(keys, Node(path, whole)), 0, expanded(new), names)


def _places(keys, path):
    """Return the nodes of the ``keys`` of a path, from its node."""
    columns = accumulate((len(key) + 1 for key in keys), initial=path.column)
    return [Node(key, path.source, path.line, column) for key, column in zip(keys, columns, strict=False)]


def _owner(name, sections, names):
    """Return the section of names that has an entry of this name, or None."""
    owners = (section for section in names & sections.keys() if type(sections[section][1].value) is dict)
    return next((section for section in sorted(owners) if name in sections[section][1].value), None)


def _replaced(node, places, depth, new, names):
    """Return a copy of ``node`` in which the value at places[depth:] is ``new``."""
    if depth == len(places):
        return new
    place, key = places[depth], places[depth].value
    if type(node.value) is dict:
        known = node.value
        if key not in known and depth == 1 and places[0].value in names:
            hints = [suggestion(key, known)] + ([ADDING] if depth + 1 == len(places) else [])
            _refuse(place, f"'{places[0].value}' has no {quoted(key)}", "; ".join(filter(None, hints)))
        if key not in known and (item := re.fullmatch(ITEM, key)) and item[1] in known:
            whole = [*(part.value for part in places[:depth]), re.sub(INDEXED, r".\1", key)]
            _refuse(place, f"unknown key {quoted(key)}", f"an item of a list is written {'.'.join(whole)}")
        owner = _owner(key, known, names) if key not in known and depth == 0 else None
        if owner and (len(places) > 1 or owner == "parameters"):
            _refuse(place, f"unknown key {quoted(key)}", f"write {owner}.{'.'.join(part.value for part in places)}")
        if key not in known and depth + 1 < len(places) and re.fullmatch(INDEX, places[depth + 1].value):
            _refuse(place, f"the deck has no list {quoted(key)} whose item could be set", "set the whole list")
        if key in known and _removes(places, depth, new, names):
            return _like(node, {name: entry for name, entry in known.items() if name != key})
        written, child = known.get(key, (place, _like(place, {})))
        child = _replaced(child, places, depth + 1, new, names)
        return _like(node, {**known, key: (written if depth + 1 < len(places) else place, child)})
    if type(node.value) is list:
        items = list(node.value)
        if not re.fullmatch(INDEX, key) or int(key) >= len(items):
            _refuse(place, f"{quoted(key)} is not an item of a list of {len(items)}", "items are counted from 0")
        items[int(key)] = _replaced(items[int(key)], places, depth + 1, new, names)
        return _like(node, items)
    above = quoted(".".join(p.value for p in places[:depth]))
    _refuse(place, f"{above} is a single value and has no {quoted(key)}")


def _removes(places, depth, new, names):
    """Return whether an override removes an entry of a section, or a term of a law: joints.hinge=null.

    The section may be that of a template: templates.leg.joints.hinge=null.
    """
    if depth + 1 < len(places) or new.value is not None or not new.raw:
        return False
    first = 2 if places[0].value == "templates" and depth > 2 else 0
    section = places[first].value
    return (depth == first + 1 and section in names - {"parameters"}) or (depth == first + 2 and section == "laws")


def _like(node, value):
    return Node(value, node.source, node.line, node.column)


def _refuse(place, message, hint=""):
    raise DeckError([Problem(message, place.mark, hint)])
