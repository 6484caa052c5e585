"""The decks of docs/decks.md are valid as printed; docs/tyres.md names what exists."""

import re
from itertools import dropwhile, takewhile
from pathlib import Path

import pytest

from mecano.deck.read import deck_of_bytes
from mecano.elements import KINDS
from mecano.elements.wheels.tire_law import TIRE_LAW_FIELDS
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


def rows_of(page, heading):
    """Return the rows, as lists of cells, of the first table after a ``heading`` of a page."""
    lines = (Path(__file__).parent.parent / "docs" / page).read_text().partition(heading)[2].splitlines()
    table = dropwhile(lambda line: not line.startswith("|"), lines)
    return [line.strip("| ").split(" | ") for line in takewhile(lambda line: line.startswith("|"), table)][2:]


def words(cell):
    """Return the words in backticks of a cell, without what follows them in braces."""
    return [word.partition(":")[0] for word in re.findall(r"`([a-z_]+)[`:]", cell)]


def test_names_on_the_page_of_tyres():
    """Kinds, fields of tyre laws and outputs that the page recommends exist under these names."""
    for _, kinds, fields in rows_of("tyres.md", "## Which wheel"):
        assert words(kinds) and all(name in KINDS for name in words(kinds))
        laws = {field.name for field in (*TIRE_LAW_FIELDS, *KINDS["mecanum_wheel"].fields)}
        assert set(words(fields)) <= laws
    assert {name for row in rows_of("tyres.md", "## Tyre data") for name in words(row[1])} <= laws
    wheel = KINDS["flexible_wheel"]
    known = {item.name for item in (*wheel.outputs, *wheel.events)} | {"valid_deformation"}
    found = {name for row in rows_of("tyres.md", "Outputs to look at") for name in words(row[1])}
    assert len(found) > 9 and found <= known
