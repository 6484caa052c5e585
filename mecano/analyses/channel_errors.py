"""Errors about the names of inputs and outputs of a response."""

from collections.abc import Iterable

from mecano.deck.similar_names import similar
from mecano.errors import UsageError, name_list

MOST = 8  # names in a message


def unknown(channel: str, name: str, known: Iterable[str], otherwise: str) -> UsageError:
    """Return the error for an unknown ``name`` of an "input", "output" or "signal", with a ``hint``."""
    found = hint(name, known, otherwise)
    return UsageError(f"there is no {channel} {name}" + (f"; {found}" if found else ""))


def hint(name: str, known: Iterable[str], otherwise: str = "") -> str:
    """Return similar names among those ``known`` as a question, or else the text ``otherwise``, or some known names."""
    known = list(dict.fromkeys(known))
    if near := similar(name, known):
        return f"did you mean {' or '.join(near)}?"
    return otherwise or (f"there are {name_list(known, MOST)}" if known else "")
