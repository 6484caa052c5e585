"""The deck of a run as the Source that its results file holds."""

from collections.abc import Mapping, Sequence
from typing import Any

from mecano.deck.deck import Deck
from mecano.results.provenance import Source


def source_of(
    deck: Deck,
    *,
    automatic: Mapping[str, float] | None = None,
    model: Mapping[str, Any] | None = None,
    warnings: Sequence[str] = (),
    resumptions: Sequence[str] = (),
) -> Source:
    """Return the Source of a checked deck.

    ``automatic``: values chosen where the deck says "automatic"; ``model``: its properties (prepare.py); ``warnings``:
    those issued at the start; ``resumptions``: notes of resumptions that change no bit.
    """
    return Source(
        deck.text, deck.resolved(), deck.file, deck.values["title"], deck.overrides, deck.files,
        automatic=dict(automatic or {}), model=dict(model or {}), warnings=warnings,
        resumptions=resumptions,
    )  # fmt: skip
