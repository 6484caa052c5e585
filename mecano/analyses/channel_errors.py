"""Errors about the names of inputs and outputs of a response."""

from collections.abc import Iterable

from mecano.deck.similar_names import similar
from mecano.errors import UsageError, name_list

MOST = 8  # names in a message


def unknown(option: str, name: str, known: Iterable[str], hint: str = "") -> UsageError:
    """Return the error for an unknown ``name`` of an ``option``, with similar names of the ``known`` ones, or some."""
    known = list(dict.fromkeys(known))
    near = similar(name, known)
    if near:
        hint = f"did you mean {' or '.join(near)}?"
    elif known:
        hint = hint or f"there are {name_list(known, MOST)}"
    what = {"open-loop": "signal"}.get(option, option)
    return UsageError(f"--{option} {name}: it is no {what}" + (f"; {hint}" if hint else ""))
