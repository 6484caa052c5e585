"""Units of what a study varies, as far as they can be told: SI units, in which the table has its numbers."""

from mecano.deck.unit_of import parameters_of, unit_of


def units_of(study, deck):
    """{path: unit} of what is varied in a study of a checked Deck; "" where it has none, or where it is not known.

    Of a parameter, which is a number alone, the unit is that which a case or the deck gives it.
    """
    in_deck = parameters_of(deck.file, deck.text)
    return {path: unit_of(path, deck.values, [*study.given(path), in_deck.get(path)]) for path in study.paths}
