"""SI units of the varied values of a study, as far as they are known; the table has its numbers in these units."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from mecano.deck.unit_of import parameters_of, unit_of

if TYPE_CHECKING:
    from mecano.deck.deck import Deck
    from mecano.study.read import Study

DECKS = ".yaml", ".yml"


def units_of(study: "Study", deck: "Deck") -> dict[str, str]:
    """Return {path: unit} of the varied values of a study of a checked Deck; "" if there is no unit or it is unknown.

    A parameter is a plain number, whose unit is taken from its value in a case, in the deck or in an included file.
    """
    in_deck: dict[str, Any] = {}
    for name in deck.files:
        source = Path(deck.file).parent / name
        if source.suffix in DECKS and source.exists():
            in_deck |= parameters_of(str(source), source.read_text(encoding="utf-8"))
    in_deck |= parameters_of(deck.file, deck.text)
    return {path: unit_of(path, deck.values, [*study.given(path), in_deck.get(path)]) for path in study.paths}
