"""Words among the parameters of a deck, which are inserted into names: where they are, and the numbers without them."""

import re
from collections.abc import Collection

from mecano.deck.compose import Node
from mecano.deck.expressions import INSERT, WORD, inner_text, texts_in
from mecano.deck.parameters import Parameters, is_word

JOINED = re.compile(r"[\w.]")  # next to an insert that is part of a name


def words_of(root: Node, parameters: Parameters) -> set[str]:
    """Return the names of the Parameters of the deck ``root`` that are words and, somewhere, a name or part of one.

    A word that is only part of arithmetic is a mistyped number.
    """
    texts = {name for name, node in parameters.nodes.items() if is_word(node) and WORD.fullmatch(node.value)}
    sections = [node for section, (_, node) in root.value.items() if section != "parameters"] if texts else []
    found: set[str] = set()
    for text in (text for section in sections for text in texts_in(section)):
        found |= {
            name for match in INSERT.finditer(text) if (name := inner_text(match)) in texts and _names(match, text)
        }
    return found


def _names(match, text):
    """Return whether a match of INSERT is a name or part of one, not a number."""
    before, after = text[: match.start()][-1:], text[match.end() :][:1]
    return text.strip() == match[0] or any(map(JOINED.match, (before, after)))


def without(section: Node, names: Collection[str]) -> Node:
    """Return a copy of a section without the entries of these names."""
    kept = {name: pair for name, pair in section.value.items() if name not in names}
    return Node(kept, section.source, section.line, section.column)
