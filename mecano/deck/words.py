"""Words among the parameters of a deck, which are inserted into names: where they are, and the numbers without them."""

import re
from collections.abc import Collection, Iterator
from typing import TYPE_CHECKING

from mecano.deck.compose import Node
from mecano.deck.expressions import INSERT, inner_text
from mecano.deck.parameters import is_word

if TYPE_CHECKING:
    from mecano.deck.parameters import Parameters

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
JOINED = re.compile(r"[\w.]")  # next to an insert that is part of a name
IN_A_NAME = re.compile(r"[\w)]\$[(A-Za-z_]")  # which begins with a letter


def words_of(root: Node, parameters: "Parameters") -> set[str]:
    """Return the names of the Parameters of the deck ``root`` that are words and, somewhere, a name or part of one.

    A word that is only part of arithmetic is a mistyped number.
    """
    texts = {name for name, node in parameters.nodes.items() if is_word(node) and WORD.fullmatch(node.value)}
    sections = [node for section, (_, node) in root.value.items() if section != "parameters"] if texts else []
    found: set[str] = set()
    for text in (text for section in sections for text in _texts(section)):
        found |= {
            name for match in INSERT.finditer(text) if (name := inner_text(match)) in texts and _names(match, text)
        }
    return found


def _names(match, text):
    """Return whether a match of INSERT is a name or part of one, not a number."""
    before, after = text[: match.start()][-1:], text[match.end() :][:1]
    return text.strip() == match[0] or any(map(JOINED.match, (before, after)))


def mentions(node: Node, words: set[str], parameters: Collection[str]) -> bool:
    """Return whether a text of a tree has an expression with one of the ``words``, or a name with a parameter."""
    for text in _texts(node):
        known = parameters if IN_A_NAME.search(text) else words
        if any(name in known for match in INSERT.finditer(text) for name in WORD.findall(inner_text(match))):
            return True
    return False


def _texts(node: Node) -> Iterator[str]:
    """Yield the texts with a $ in a tree."""
    todo = [node]
    while todo:
        value = todo.pop().value
        if type(value) is str and "$" in value:
            yield value
        elif type(value) is list:
            todo += value
        elif type(value) is dict:
            todo += [one for pair in value.values() for one in pair]


def without(section: Node, names: Collection[str]) -> Node:
    """Return a copy of a section without the entries of these names."""
    kept = {name: pair for name, pair in section.value.items() if name not in names}
    return Node(kept, section.source, section.line, section.column)
