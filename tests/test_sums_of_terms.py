"""Laws with several terms of one name: lists of mappings, in the deck, in overrides and in the resolved deck."""

import json
import textwrap

import numpy as np
import pytest
from time_runs import deck

from mecano.analyses.dynamic import run
from mecano.deck.read import deck_of_bytes
from mecano.laws.probe import curve_at
from mecano.post.curve_values import curve_values, terms_of
from mecano.results.reader import open_results

TRAVEL = """
    mecano: 1
    gravity: none
    nodes: {cart: {position: [0, 0, 0]}}
    elements: {cart: {type: point_mass, node: cart, mass: 2}}
    joints:
      rail: {type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}
      drive: {type: prescribed_position, node: cart, direction: [1, 0, 0], value: there_and_back}
    laws:
      there_and_back:
        - step: {time: 0.1, rise: 0.2, from: 0, to: 300 mm}
          linear: {slope: 0.1}
        - step: {time: 0.5 s, rise: 0.2, from: 0, to: -300 mm}
    time: {end: 0.8, step: 0.01}
"""


def edge(t, begin):
    """An edge of 0.2 s from 0 to 1, u^3 (10 - 15 u + 6 u^2)."""
    u = np.clip((t - begin) / 0.2, 0.0, 1.0)
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2)


def test_two_edges_there_and_back(tmp_path):
    """The position is the sum of the terms."""
    run(deck(TRAVEL), tmp_path / "r.h5")
    with open_results(tmp_path / "r.h5") as results:
        t, x = results["drive.displacement"].time, results["drive.displacement"].values
        np.testing.assert_allclose(x, 0.3 * (edge(t, 0.1) - edge(t, 0.5)) + 0.1 * t, atol=1e-12)


def test_the_resolved_deck_has_the_same_law():
    given = deck(TRAVEL)
    law = given.resolved()["laws"]["there_and_back"]
    assert [list(term) for term in law] == [["step"], ["linear"], ["step"]]
    again = deck_of_bytes(json.dumps(given.resolved()).encode(), "again.yaml")
    assert again.values["laws"]["there_and_back"] == given.values["laws"]["there_and_back"]
    assert curve_at(again.values["laws"]["there_and_back"], 0.45)[0] == pytest.approx(0.345, rel=1e-14)


def test_pictures_draw_such_a_law():
    """From the resolved deck in the results; by name and written in place."""
    plain = json.loads(json.dumps(deck(TRAVEL).resolved()))
    t = np.linspace(0.0, 0.8, 9)
    for law in ("there_and_back", plain["laws"]["there_and_back"]):
        np.testing.assert_allclose(
            curve_values(plain, law, t), 0.3 * (edge(t, 0.1) - edge(t, 0.5)) + 0.1 * t, atol=1e-14
        )
    assert [name for name, _ in terms_of(plain, "there_and_back")] == ["step", "linear", "step"]


def test_a_term_of_a_list_may_be_overridden():
    text = textwrap.dedent(TRAVEL).encode()
    given = deck_of_bytes(text, "test.yaml", overrides=["laws.there_and_back.1.step.to=-0.2"])
    assert curve_at(given.values["laws"]["there_and_back"], 0.8)[0] == pytest.approx(0.3 - 0.2 + 0.08, rel=1e-14)


def test_units_in_a_list_are_compared_with_the_use():
    with pytest.raises(Exception, match="a length \\[m\\] is expected, and 'kg' is a mass"):
        deck(TRAVEL.replace("-300 mm", "-300 kg"))
