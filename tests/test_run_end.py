"""Runs that a condition ends: a fall, by either method; resuming, warnings, the interface."""

import numpy as np
import pytest
import yaml

import mecano

FALL = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {ball: {position: [0, 0, 5]}}
    elements: {mass: {type: point_mass, node: ball, mass: 2}}
    time: {end: 4, step: 0.01, until: UNTIL}
    output: {every: 0.25}
    """
DURATION = np.sqrt(2.0 * 5.0 / 9.81)  # of the fall to z = 0


def _fall(until="ball.position.z < 0", **time):
    deck = mecano.Deck(yaml.safe_load(FALL.replace("UNTIL", until)))
    for name, value in time.items():
        deck["time"][name] = value
    return deck


@pytest.mark.parametrize("time", [{}, {"method": "radau"}, {"adaptive": {"tolerance": 1e-5, "length_scale": 5.0}}])
def test_a_fall_ends_at_the_ground(tmp_path, time):
    results = mecano.run(_fall(**time), tmp_path / "fall.h5")
    assert results.status == "complete" and results.warnings == []
    assert results.reason == f"ball.position.z < 0 was met at t = {results.time[-1]:.9g} s"
    np.testing.assert_allclose(results.time, [0.0, 0.25, 0.5, 0.75, 1.0, DURATION], atol=1e-9)
    assert results["ball.position.z"].values[-1] == pytest.approx(0.0, abs=1e-8)
    assert [(event.name, event.time) for event in results.events] == [("ends the run", results.time[-1])]


def test_a_stopped_run_is_resumed_to_its_end(tmp_path):
    """With the bits of a run that is not interrupted; then it is complete."""
    whole = mecano.run(_fall(), tmp_path / "whole.h5")
    with mecano.Simulation(_fall(), tmp_path / "parts.h5") as simulation:
        simulation.advance(0.6)
    parts = mecano.run(_fall(), tmp_path / "parts.h5", resume=True)
    assert parts.status == "complete" and parts.reason == whole.reason
    assert parts["ball.position"].values.tobytes() == whole["ball.position"].values.tobytes()


def test_a_simulation_ends_by_the_condition(tmp_path):
    with mecano.Simulation(_fall(), tmp_path / "fall.h5") as simulation:
        simulation.advance(3.0)
        assert simulation.time == pytest.approx(DURATION, abs=1e-9)
        with pytest.raises(mecano.errors.UsageError, match="by the condition of 'time.until'"):
            simulation.advance(0.1)
    assert simulation.results().status == "complete"


@pytest.mark.parametrize(
    ("until", "rows", "text"),
    [
        ("ball.position.z < -200", 17, "'time.until', ball.position.z < -200, did not become true before"),
        ("ball.position.z < 6", 1, "'time.until', ball.position.z < 6, is true at the start: the run has no steps"),
    ],
)
def test_conditions_that_end_no_run_are_warned_of(tmp_path, until, rows, text):
    results = mecano.run(_fall(until), tmp_path / "fall.h5")
    assert results.status == "complete" and len(results.time) == rows
    assert any(text in warning for warning in results.warnings)


def test_a_condition_of_an_unknown_name_is_refused():
    with pytest.raises(mecano.errors.DeckError, match="'bal'"):
        mecano.check(_fall("bal.position.z < 0"))


STANDING = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {ball: {position: [0, 0, 0.1]}, lamp: {position: [1, 0, 2]}}
    elements:
      ball: {type: rigid_body, node: ball, mass: 1, inertia: [0.004, 0.004, 0.004]}
      lamp: {type: rigid_body, node: lamp, mass: 1, inertia: [0.004, 0.004, 0.004]}
      floor: {type: contact, nodes: [ground, ball], plane: {normal: [0, 0, 1], point: [0, 0, 0]}, radius: 0.1}
    joints:
      cord: {type: fixed, nodes: [ground, lamp], release: {when: floor.closed < 0.5}}
    loads:
      lift: {type: force, node: ball, direction: [0, 0, 1], value: {linear: {slope: 98.1}}}
    time: {end: 1, step: 1 ms, until: lamp.position.z < 1.95}
    """


def test_conditions_hold_or_not_with_the_contacts_closed_at_the_start(tmp_path):
    """A ball that stands on the floor is lifted by its weight at 0.1 s; then the lamp falls 50 mm."""
    deck = mecano.Deck(yaml.safe_load(STANDING))
    results = mecano.run(deck, tmp_path / "standing.h5")
    names = [(event.name, event.time) for event in results.events]
    assert [name for name, _ in names] == ["closes", "opens", "releases", "ends the run"]
    np.testing.assert_allclose([t for _, t in names], [0, 0.1, 0.1, 0.1 + np.sqrt(0.1 / 9.81)], atol=1e-9)
    for t, free in ((0.05, 5), (0.15, 12)):  # modes about a saved state find the same phases
        assert list(mecano.modes(deck, at=(results, t), number=20).kinds) == ["free"] * free
    deck["time"]["until"] = "floor.closed < 0.5"
    assert mecano.run(deck, tmp_path / "until.h5").time[-1] == pytest.approx(0.1, abs=1e-9)


HANGING = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {hook: {position: [0, 0, 0], fixed: true}, bob: {position: [0, 0, -1]}, lamp: {position: [1, 0, 2]}}
    elements:
      bob: {type: point_mass, node: bob, mass: 1}
      lamp: {type: rigid_body, node: lamp, mass: 1, inertia: [0.004, 0.004, 0.004]}
    joints:
      rod: {type: rigid_rod, nodes: [hook, bob]}
      cord: {type: fixed, nodes: [ground, lamp], release: {when: WHEN}}
    signals: {level: {type: switch, input: bob.position.z, upper: -2}}
    time: {end: 0.1, step: 1 ms}
"""


@pytest.mark.parametrize(
    ("when", "happens"),
    [
        ("rod.tension < 9", False), ("rod.tension > 9", True), ("cord.force.magnitude < 9", False),
        ("level < 0.5", False), ("level > 0.5", True), ("time > -1", True),
    ],
)  # fmt: skip
@pytest.mark.parametrize("initial", [{}, {"static": True}])
def test_conditions_at_the_start_see_its_reactions_and_switches(when, happens, initial, tmp_path):
    """The rod and the cord carry 9.81 N at the start, which is not known when phases are first chosen."""
    deck = mecano.Deck(yaml.safe_load(HANGING.replace("WHEN", when)))
    deck["initial"] = initial
    results = mecano.run(deck, tmp_path / "hanging.h5")
    assert [(event.name, event.time) for event in results.events] == [("releases", 0.0)] * happens
    assert results["lamp.position.z"][-1] == pytest.approx(2.0 - 0.5 * 9.81 * 0.1**2 * happens, abs=1e-9)
    assert len(mecano.modes(deck, at=(results, 0.05), number=20).kinds) == 2 + 6 * happens


@pytest.mark.parametrize("when", ["rod.tension < 9", "cord.force.magnitude < 9", "level < 0.5"])
def test_conditions_on_a_path_over_time_see_its_first_equilibrium(when, tmp_path):
    """Forces grow from zero in the search for it."""
    deck = mecano.Deck(yaml.safe_load(HANGING.replace("WHEN", when)))
    del deck["time"]
    deck["static"] = {"over": "time", "end": 1, "steps": 2}
    results = mecano.run(deck, tmp_path / "path.h5")
    assert results.events == [] and results["rod.tension"].values == pytest.approx(9.81)


STEADY = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {axle: {position: [0, 0, 0.3]}, hub: {position: [0, 0, 0.3]}}
    elements:
      load: {type: rigid_body, node: axle, mass: 200, inertia: [1, 1, 1]}
      rim: {type: rigid_body, node: hub, mass: 10, inertia: [0.4, 0.7, 0.4]}
      wheel: {type: wheel, node: hub, axis: [0, 1, 0], tire_law: tyre, ground: road}
    joints:
      upright: {type: held_rotation, nodes: [ground, axle]}
      bearing: {type: hinge, nodes: [axle, hub], axis: [0, 1, 0]}
    tire_laws: {tyre: {radius: 0.3, radial: {linear: {slope: 2.0e5}}, friction: 0.9, slip_regularization: 0.1}}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    time: {end: 0.1, step: 1 ms, until: wheel.normal_force < 100}
"""


@pytest.mark.parametrize("initial", [{"static": True}, {"steady": {"velocity": [10, 0, 0]}}])
def test_a_wheel_that_carries_load_at_the_start_has_not_lifted_off(initial, tmp_path):
    """In the deck the tyre is not deformed yet."""
    deck = mecano.Deck(yaml.safe_load(STEADY))
    deck["initial"] = initial
    assert mecano.run(deck, tmp_path / "steady.h5").time[-1] == pytest.approx(0.1)
