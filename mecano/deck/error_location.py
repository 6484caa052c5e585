"""Position of an error in an element: one of its fields, or a value in it, also of the law or ground that it names."""

import re

from mecano.deck.compose import Node, Pair
from mecano.deck.scope import place_of
from mecano.element_interface import Kind
from mecano.schema import SECTION_OF

PATH = r"'(\w+)((?:\.\w+)+)'"


def pointed_at(text: str, kind: Kind, entry: "Pair", root: Node) -> Node:
    """Return the node of the checked tree ``root`` to which an error text on an element of a ``kind`` refers.

    A text that begins with a quoted path, such as 'tire_law.radial', refers to the value at this path; for others see
    ``place_of``. ``entry``: (node of the name of the element, node of its value).
    """
    key, node = entry
    match = re.match(PATH, text)
    field = next((field for field in kind.fields if match and field.name == match[1]), None)
    if match is None or field is None:
        return place_of(text, node, key)
    place, at, words = key, node, [match[1], *match[2][1:].split(".")]
    if field.type.name in SECTION_OF:
        section, (_, named) = SECTION_OF[field.type.name], node.value[field.name]
        (place, at), words = root.value[section][1].value[named.value], words[1:]
    for word in words:
        if type(at.value) is not dict or word not in at.value:
            break
        _, at = at.value[word]
        place = at
    return place
