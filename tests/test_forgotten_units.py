"""Overrides by plain numbers of quantities in other units than those of SI are warned of, where the unit was meant."""

import pytest
from time_runs import deck

from mecano.deck.read import deck_of_bytes, read_deck

DECK = b"""
mecano: 1
gravity: none
parameters: {speed: 72 km/h, length: 2 m, spin: 30 rpm}
nodes: {a: {position: [$length, 0, 0]}}
elements: {a: {type: rigid_body, node: a, mass: 0.3 t, inertia: [1, 1, 1]}}
initial: {velocities: [{nodes: [a], velocity: [$speed, 0, 0], angular_velocity: [0, 0, $spin]}]}
time: {end: 2000 ms, step: 1 ms}
"""


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("parameters.speed=80", "80 without a unit is in m/s, and the deck gives 72 km/h; write '80 km/h' or '80 m/s'"),
        ("parameters.speed=-60", "-60 without a unit is in m/s, and the deck gives 72 km/h"),
        ("parameters.spin=40", "40 without a unit is in rad/s, and the deck gives 30 rpm"),
        ("elements.a.mass=0.4", "0.4 without a unit is in kg, and the deck gives 0.3 t; write '0.4 t' or '0.4 kg'"),
        ("time.step=2", "2 without a unit is in s, and the deck gives 1 ms"),
        ("parameters.speed=25", ""),  # nearer to 20 m/s than to 72 km/h
        ("parameters.speed=80 km/h", ""),
        ("parameters.speed==80/3.6", ""),
        ("parameters.speed=0", ""),
        ("parameters.length=3", ""),
        ("elements.a.mass=400", ""),
        ("time.step=0.002", ""),
        ("elements.a.inertia.0=2", ""),
    ],
)
def test_a_number_in_the_place_of_a_quantity(override, said):
    """Of two readings of the number, that nearer to the value of the deck counts as meant."""
    overrides = [override] if override != "time.step=2" else ["time.end=9 s", override]
    found = deck_of_bytes(DECK, "test.yaml", overrides=overrides).warnings
    assert len(found) == bool(said)
    for problem in found:
        path = override.partition("=")[0]
        assert said in problem.message and problem.message.startswith(f"'{path}': ")
        assert problem.mark.file == f"override {path}"


def test_nothing_is_said_without_overrides():
    assert deck(DECK.decode()).warnings == ()


def test_a_variant_without_the_unit_of_its_base(tmp_path):
    (tmp_path / "base.yaml").write_bytes(DECK)
    (tmp_path / "variant.yaml").write_text("include: base.yaml\nset: {parameters.speed: 80, elements.a.mass: 310}\n")
    (found,) = read_deck(tmp_path / "variant.yaml").warnings
    assert found.message.startswith("'parameters.speed': 80 without a unit is in m/s") and found.mark.line == 2
