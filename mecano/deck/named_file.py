"""Files that a deck names: they lie in its folder or below it."""

import os
from typing import TYPE_CHECKING

from mecano.deck.include import confined
from mecano.deck.source import Source, Unreadable, read_source
from mecano.deck.wording import quoted, similar_files
from mecano.errors import DeckError

if TYPE_CHECKING:
    from mecano.deck.compose import Node
    from mecano.deck.scope import Scope


def within(name: str, node: "Node", scope: "Scope") -> str | None:
    """Return the path of a file in the folder of the deck or below it; None after reporting one elsewhere."""
    path = confined(scope.folder, name)
    if path is None:
        scope.refuse(node, f"file {quoted(name)} must lie in the folder of the deck")
    return path


def source_of(name: str, node: "Node", scope: "Scope") -> Source | None:
    """Return the Source of a file in the folder of the deck or below it; None after reporting an error."""
    path = within(name, node, scope)
    if path is None:
        return None
    try:
        source, digest = read_source(path, os.path.join(scope.folder, name))
    except Unreadable as error:
        hint = similar_files(path, (os.path.splitext(name)[1],))
        scope.refuse(node, f"file {quoted(name)} cannot be read: {error}", hint)
        return None
    except DeckError as error:
        scope.problems.extend(error.problems)
        return None
    scope.files[name] = digest
    return source
