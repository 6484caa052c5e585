"""Warnings of values that have no effect beside others; none where they have one, or where they are not given."""

import pytest
from time_runs import deck, input_deck

from mecano.errors import DeckError

DECK = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {pin: {position: [0, 0, 0]}, tip: {position: [1, 0, 0]}}
    elements:
      bar: {type: rigid_body, node: pin, mass: 1, inertia: [1, 1, 1], attached: [tip]}
      rope: {type: cable, nodes: [pin, tip], axial_stiffness: 1000, natural_length: 2 ROPE}
    joints: {hinge: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}}
    initial: {velocities: [{nodes: [pin], velocity: [0, 0, 0] START}]}
    time: {end: 1, step: 0.01 TIME}
    signals: {demand: {type: pid, input: hinge.angle, proportional: 1 PID}}
"""


def deck_with(place, given):
    """The deck with the text ``given`` at a place."""
    text = DECK.replace(f" {place}", given and f", {given}")
    for other in ("ROPE", "START", "TIME", "PID"):
        text = text.replace(f" {other}", "")
    return deck(text)


@pytest.mark.parametrize(
    ("place", "given", "text"),
    [
        ("ROPE", "mass_distribution: lumped", "'mass_distribution' has no effect: without 'mass_per_length' there is"),
        ("ROPE", "mass_distribution: lumped, mass_per_length: 1", ""),
        (
            "ROPE",
            "at_full_length: hold, damping: 0.1",
            "'damping' has no effect: with 'at_full_length: hold' the cable",
        ),
        ("ROPE", "at_full_length: shock, damping: 0.1", ""),
        ("PID", "derivative_time: 1", "'derivative_time' has no effect: the gain 'derivative' is zero"),
        ("PID", "derivative_time: 1, derivative: 1", ""),
        ("PID", "tracking_time: 1, upper: 1", "'tracking_time' has no effect: the gain 'integral' is zero"),
        ("PID", "tracking_time: 1, integral: 1", "'tracking_time' has no effect: without 'lower' and 'upper' the"),
        ("PID", "tracking_time: 1, integral: 1, upper: 1", ""),
        ("START", "about: [1, 0, 0]", "'about' has no effect without 'angular_velocity'"),
        ("START", "about: [1, 0, 0], angular_velocity: [0, 1, 0]", ""),
        ("TIME", "method: radau, rho_inf: 0.8", ""),  # the default, as in decks of results files
        ("TIME", "method: radau, rho_inf: 0.9", "time: 'rho_inf' has no effect with the method radau"),
        ("TIME", "method: radau, newton: {force_tolerance: 1e-9}", "time: 'newton.force_tolerance' has no effect"),
        ("TIME", "method: radau, scale: {penalty: 1e6}", "time: 'scale.penalty' has no effect with the method radau"),
        ("TIME", "method: radau, scale: {k: 1e6}", ""),
        ("TIME", "rho_inf: 0.8, scale: {penalty: 1e6}", ""),
    ],
)
def test_values_without_effect(place, given, text):
    found = [problem.message for problem in deck_with(place, given).warnings]
    assert len(found) == bool(text) and all(text in message for message in found), found


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("slip_regularization=0.1", "tire law 'tyre': 'slip_regularization' has no effect without 'friction'"),
        ("friction_by_speed=0.9", "tire law 'tyre': 'friction_by_speed' has no effect without 'friction'"),
        ("friction_by_speed=1", ""),
    ],
)
def test_values_of_another_slip_law(given, said):
    """The tyres of the car are brushes (Fiala), which have a friction of their own."""
    found = [problem.message for problem in input_deck("car", f"tire_laws.tyre.{given}").warnings]
    assert found == [said] * bool(said)


@pytest.mark.parametrize("end", ["a", "b"])
def test_a_set_point_of_a_pin_without_its_law_is_refused(end):
    cross = "cross: {type: universal, nodes: [ground, pin], axis_a: [1, 0, 0], axis_b: [0, 1, 0], OPTIONS}}"
    text = DECK.replace("hinge: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}}", cross)
    for place in ("ROPE", "START", "TIME", "PID"):
        text = text.replace(f" {place}", "")
    text = text.replace("input: hinge.angle", "input: cross.angle_a")
    deck(text.replace("OPTIONS", f"natural_angle_{end}: 0.3, turning_law_{end}: {{spring: 1}}"))
    with pytest.raises(DeckError, match=f"'natural_angle_{end}' is that of a 'turning_law_{end}', which is missing"):
        deck(text.replace("OPTIONS", f"natural_angle_{end}: 0.3"))
