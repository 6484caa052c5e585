"""The decks of docs/decks.md are valid as printed."""

import re
from pathlib import Path

import pytest

from mecano.deck.read import deck_of_bytes
from mecano.errors import DeckError

TEXT = (Path(__file__).parent.parent / "docs" / "decks.md").read_text()
DECKS = re.findall(r"```yaml\n(mecano: 1\n.*?)```", TEXT, re.DOTALL)


def test_there_are_some():
    assert len(DECKS) == 3


@pytest.mark.parametrize("deck", DECKS, ids=["units", "repeat", "templates"])
def test_decks_are_right(deck):
    assert deck_of_bytes(deck.encode(), "deck.yaml").values["nodes"]


@pytest.mark.parametrize("deck,old", [(DECKS[0], "20 kg"), (DECKS[2], "mass: $mass")], ids=["units", "templates"])
def test_messages_are_those_of_the_page(deck, old):
    new = old.replace("20 kg", "20 bar").replace("$mass", "3 bar")
    with pytest.raises(DeckError) as info:
        deck_of_bytes(deck.replace(old, new).encode(), "deck.yaml")
    problem = info.value.problems[0]
    assert f"{problem.mark}: {problem.message}" in TEXT
    assert all(f"placed at {mark}" in TEXT for mark in problem.mark.stack)


def test_names_of_the_page():
    deck = deck_of_bytes(DECKS[2].encode(), "deck.yaml", overrides=["place.front.with.length=1.2"])
    assert {"front_hip", "back_left_toe"} <= set(deck.values["nodes"]) and "front_bone" in deck.values["elements"]
    assert deck.values["elements"]["front_bone"]["mass"] == pytest.approx(2.4)


def test_gravity_of_the_page():
    """The deck of units without its gravity has the message of the page."""
    with pytest.raises(DeckError) as info:
        deck_of_bytes(DECKS[0].replace("gravity: [0, 0, -9.81]\n", "").encode(), "deck.yaml")
    (problem,) = info.value.problems
    assert f"{problem.mark}: {problem.message}; {problem.hint}\n" in TEXT
