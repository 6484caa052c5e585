"""Files that a deck names: they lie in its folder or below it."""

import hashlib
import os

from mecano.deck.compose import Node
from mecano.deck.include import confined
from mecano.deck.scope import Scope
from mecano.deck.source import Source, Unreadable, decoded, read_bytes
from mecano.deck.wording import quoted, similar_files
from mecano.errors import DeckError


def bytes_of(name: str, node: Node, scope: Scope) -> bytes | None:
    """Return the bytes of a file in the folder of the deck or below it; None after reporting an error."""
    path = confined(scope.folder, name)
    if path is None:
        scope.refuse(node, f"file {quoted(name)} must lie in the folder of the deck")
        return None
    try:
        data = read_bytes(path)
    except Unreadable as error:
        hint = similar_files(path, (os.path.splitext(name)[1],))
        scope.refuse(node, f"file {quoted(name)} cannot be read: {error}", hint)
        return None
    scope.files[name] = hashlib.sha256(data).hexdigest()
    return data


def source_of(name: str, node: Node, scope: Scope) -> Source | None:
    """Return the Source of such a file; None after reporting an error."""
    data = bytes_of(name, node, scope)
    try:
        return None if data is None else decoded(data, os.path.join(scope.folder, name))
    except DeckError as error:
        scope.problems.extend(error.problems)
        return None
