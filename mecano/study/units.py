"""SI units of the varied values of a study, as far as they are known; the table has its numbers in these units."""

from mecano.deck.deck import Deck
from mecano.deck.unit_of import unit_of, written_parameters
from mecano.study.read import Study


def units_of(study: Study, deck: Deck) -> dict[str, str]:
    """Return {path: unit} of the varied values of a study of a checked Deck; "" if there is no unit or it is unknown.

    A parameter is a plain number, whose unit is taken from its value in a case, in the deck or in an included file.
    """
    in_deck = written_parameters(deck)
    return {path: unit_of(path, deck.values, [*study.given(path), in_deck.get(path)]) for path in study.paths}
