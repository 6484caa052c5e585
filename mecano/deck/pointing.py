"""Where a text on an element points: at one of its fields, or into the law or ground that the field names."""

import re

from mecano.deck.scope import place_of
from mecano.schema import SECTION_OF

PATH = re.compile(r"'(\w+)((?:\.\w+)+)'")


def pointed_at(text, kind, entry, root):
    """The node at which the text on the element of a ``kind`` points, in the checked tree ``root`` of a deck.

    A text that begins with a path in quotes, such as 'tire_law.radial', is on what is found there; otherwise see
    ``place_of``. ``entry``: the nodes of the name of the element, and of what it is.
    """
    key, node = entry
    match = PATH.match(text)
    field = match and next((field for field in kind.fields if field.name == match[1]), None)
    if not field or field.type.name not in SECTION_OF:
        return place_of(text, node, key)
    section, (_, named) = SECTION_OF[field.type.name], node.value[field.name]
    place, at = root.value[section][1].value[named.value]
    for word in match[2][1:].split("."):
        if type(at.value) is not dict or word not in at.value:
            break
        _, at = at.value[word]
        place = at
    return place
