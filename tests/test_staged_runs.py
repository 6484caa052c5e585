"""Runs that begin with a saved state of another one: ``initial: {from: FILE:TIME}``."""

import re

import numpy as np
import pytest
from click.testing import CliRunner
from time_runs import INPUTS, deck

import mecano
from mecano.analyses.operating_point import operating_point
from mecano.cli import commands
from mecano.deck.read import read_deck
from mecano.errors import DeckError

FALLING = """
mecano: 1
gravity: [0, 0, -10]
nodes: {ball: {position: [0, 0, 0]}, other: {position: [1, 0, 0]}}
elements:
  ball: {type: point_mass, node: ball, mass: 1}
  other: {type: point_mass, node: other, mass: 1}
initial: {velocities: [{nodes: all, velocity: [3, 0, 0]}]}
time: {end: 1, step: 0.01}
output: {every: 0.1}
"""
STAGED = FALLING.replace("other", "third").replace("{velocities: [{nodes: all, velocity: [3, 0, 0]}]}", "{from: s.h5}")


def solved(folder, name, text, **settings):
    (folder / f"{name}.yaml").write_text(text)
    return mecano.run(folder / f"{name}.yaml", folder / f"{name}.h5", quiet=True, set=settings)


@pytest.mark.parametrize(
    ("name", "cut", "end", "tolerance"),
    [
        ("panel_lock", 0.3, 1.0, 1e-6),  # before its latch locks
        ("panel_lock", 0.8, 1.0, 1e-6),  # and after
        ("panel_release", 0.4, 1.0, 2e-6),  # before its cable is cut
        ("panel_release", 0.8, 1.3, 2e-6),  # and after
        ("flexible_pendulum", 0.5, 1.0, 2e-6),
        ("oleo_drop", 0.15, 0.3, 1e-8),
        ("crosswind_landing", 0.5, 0.8, 1e-3),  # tyres that roll and slide, in adaptive steps of a tolerance of 1e-2
        ("position_servo", 0.1, 0.2, 1e-6),  # integral and filter of a controller
        ("bouncing_ball", 0.6, 1.2, 1e-8),  # it has rebounded
    ],
)
def test_two_stages_are_one_run(name, cut, end, tolerance, tmp_path):
    """Motion of all nodes and their rotations at the end; accelerations begin anew, which the integrator notices."""
    text = (INPUTS / f"{name}.yaml").read_text()
    second = re.sub(r"\ninitial:.*\n(?: +.*\n)*", "\n", text) + "\ninitial: {from: s.h5}\n"
    whole = solved(tmp_path, "w", text, **{"time.end": end})
    solved(tmp_path, "s", text, **{"time.end": cut})
    staged = solved(tmp_path, "t", second, **{"time.start": cut, "time.end": end})
    for path in whole.names("nodes/*"):
        scale = tolerance if path.endswith(("position", "rotation")) else 1e3 * tolerance
        np.testing.assert_allclose(
            staged[path].values[-1], whole[path].values[-1], rtol=scale, atol=scale, err_msg=path
        )


TURNING = """
mecano: 1
gravity: none
nodes: {first: {position: [0, 0, 0]}, second: {position: [0.27, 0, 0]}, disc: {position: [0, 1, 0]}}
elements:
  first: {type: rigid_body, node: first, mass: 1, inertia: [0.01, 0.01, 0.02]}
  second: {type: rigid_body, node: second, mass: 1, inertia: [0.01, 0.01, 0.02]}
  disc: {type: rigid_body, node: disc, mass: 1, inertia: [0.01, 0.01, 0.02]}
  coil: {type: torsion_spring_damper, nodes: [second, disc], axis: [0, 0, 1], law: {spring: {stiffness: 0.02}}}
joints:
  pivot: {type: hinge, nodes: [ground, first], axis: [0, 0, 1]}
  pinion: {type: hinge, nodes: [ground, second], axis: [0, 0, 1]}
  spindle: {type: hinge, nodes: [ground, disc], axis: [0, 0, 1]}
  teeth: {type: gear_pair, nodes: [ground, first, second], axis_a: [0, 0, 1], radius_a: 0.1, radius_b: 0.17}
initial:
  velocities:
    - {nodes: [first], angular_velocity: [0, 0, 60]}
    - {nodes: [second], angular_velocity: [0, 0, =-600/17]}
time: {end: 1, step: 1 ms}
output: {every: 0.25}
"""


def turned(t):
    """Angles [rad] of the gear ``second`` and of the disc, by M = k (disc - second) between inertias J and 0.02."""
    ratio, k = 1.7, 0.02
    J, rate = 0.02 + ratio**2 * 0.02, -600 / 17
    w = np.sqrt(k * (1 / J + 1 / 0.02))
    mean, relative = rate * J / (J + 0.02) * t, rate / w * np.sin(w * t)
    return mean + relative * 0.02 / (J + 0.02), mean - relative * J / (J + 0.02)


def test_turns_between_saved_times_are_counted(tmp_path):
    """The gears turn by 15 rad from row to row; their ratio is not whole, and the spring feels each turn."""
    solved(tmp_path, "s", TURNING, **{"time.end": 0.5})
    second = re.sub(r"\ninitial:.*\n(?: +.*\n)*", "\ninitial: {from: s.h5}\n", TURNING)
    staged = solved(tmp_path, "t", second, **{"time.start": 0.5})
    gear, disc = turned(staged.time)
    np.testing.assert_allclose(staged["pivot.angle"].values, -1.7 * gear, rtol=1e-6)
    np.testing.assert_allclose(staged["pinion.angle"].values, gear, rtol=1e-6)
    np.testing.assert_allclose(staged["coil.moment"].values, 0.02 * (disc - gear), rtol=1e-6)
    assert not any("too far apart" in text for text in staged.warnings)


def test_saved_times_too_far_apart_to_count_turns_are_reported(tmp_path):
    """A disc that a motor turns twice from one row to the next: it is at rest in both."""
    text = """
    mecano: 1
    gravity: none
    nodes: {disc: {position: [0, 0, 0]}}
    elements: {disc: {type: rigid_body, node: disc, mass: 1, inertia: [0.01, 0.01, 0.02]}}
    joints:
      spindle: {type: hinge, nodes: [ground, disc], axis: [0, 0, 1]}
      motor: {type: prescribed_angle, nodes: [ground, disc], axis: [0, 0, 1], value: "4*(pi*time - sin(2*pi*time)/2)"}
    time: {end: 1, step: 5 ms}
    output: {every: 1}
    """
    once = solved(tmp_path, "s", text)
    np.testing.assert_allclose(once["spindle.angle"].values, [0, 4 * np.pi], atol=1e-9)
    staged = solved(tmp_path, "t", text + "\n    initial: {from: s.h5}\n", **{"time.start": 1, "time.end": 1.1})
    said = [text for text in staged.warnings if "too far apart" in text]
    assert len(said) == 1 and "wrong joints/spindle/angle by -2;" in said[0]
    solved(tmp_path, "s2", text, **{"output.every": 0.05})
    staged = solved(tmp_path, "t2", text + "\n    initial: {from: s2.h5}\n", **{"time.start": 1, "time.end": 1.1})
    assert not [text for text in staged.warnings if "too far apart" in text or "begins at" in text]
    for at_rest in (False, True):
        point = operating_point(read_deck(tmp_path / "s.yaml"), f"{tmp_path}/s.h5:1", at_rest)
        assert "wrong joints/spindle/angle by -2;" in " ".join(point.warnings)


def test_a_cut_cable_stays_cut(tmp_path):
    """Its trigger, a time of the second run, has not been reached; a longer first run is the same motion."""
    text = (INPUTS / "panel_release.yaml").read_text()
    whole = solved(tmp_path, "w", text, **{"time.end": 1.0})
    solved(tmp_path, "s", text, **{"time.end": 0.8})
    staged = solved(tmp_path, "t", text + "\ninitial: {from: s.h5}\n", **{"time.end": 0.2})
    np.testing.assert_array_equal(staged["elements/tie/tension"].values, 0.0)
    angles = [results["joints/left_hinge/angle"].values[-1] for results in (staged, whole)]
    assert angles[0] == pytest.approx(angles[1], abs=2e-6)
    assert not len(staged.events)


def test_a_run_begins_at_a_saved_time_with_other_elements(tmp_path):
    solved(tmp_path, "s", FALLING)
    third = STAGED.replace("s.h5}", "'s.h5:0.4', velocities: [{nodes: [third], velocity: [0, 1, 0]}]}")
    results = solved(tmp_path, "t", third, **{"time.end": 0.1})
    np.testing.assert_allclose(results["ball.position"].values[0], [1.2, 0, -0.8], atol=1e-9)
    np.testing.assert_allclose(results["ball.velocity"].values[0], [3, 0, -4], atol=1e-9)
    np.testing.assert_allclose(results["third.velocity"].values[0], [0, 1, 0], atol=1e-9)
    np.testing.assert_allclose(results["third.position"].values[0], [1, 0, 0], atol=1e-12)
    notes = "\n".join(results.warnings)
    assert "begins with the state of s.h5 at 0.4 s" in notes and results.resolved["initial"]["from"] == "s.h5:0.4"
    assert "not in that file, and start as in the deck: third" in notes and "but not here: other" in notes


def test_it_can_be_resumed_and_checked(tmp_path):
    solved(tmp_path, "s", FALLING)
    (tmp_path / "t.yaml").write_text(STAGED)
    result = CliRunner().invoke(commands, ["check", str(tmp_path / "t.yaml")])
    assert result.exit_code == 0 and "begins with the state of s.h5" in " ".join(result.output.split())
    with mecano.Simulation(str(tmp_path / "t.yaml"), str(tmp_path / "t.h5")) as simulation:
        simulation.advance(0.5)
    CliRunner().invoke(commands, ["run", str(tmp_path / "t.yaml"), "-o", str(tmp_path / "t.h5"), "--resume"])
    with mecano.Results(tmp_path / "t.h5") as results:
        np.testing.assert_allclose(results["ball.position"].values[-1], [6, 0, -20], atol=1e-9)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ("none.h5", "No such file"),
        ("t.yaml", "not an HDF5 file|cannot be read|not a results file"),
        ("'s.h5:0.45'", "0.45 s is not a saved time of .*; the nearest ones are 0.4 and 0.5 s"),
        ("'s.h5:inf'", "No such file"),
        ("'s.h5:1.5'", "is saved from 0 to 1 s, not at 1.5 s"),
        ("s.h5, static: {}", "'static' and 'from' exclude one another"),
    ],
)
def test_errors_have_places(given, text, tmp_path):
    solved(tmp_path, "s", FALLING)
    with pytest.raises(DeckError, match=text) as caught:
        solved(tmp_path, "t", STAGED.replace("s.h5}", f"{given}}}"))
    assert caught.value.problems[0].mark.line == 8 and caught.value.problems[0].mark.column > 1


def test_another_model_is_refused(tmp_path):
    solved(tmp_path, "s", FALLING)
    with pytest.raises(DeckError, match="has no node of this deck"):
        solved(tmp_path, "t", STAGED.replace("ball", "cube"))


def test_statics_do_not_begin_with_a_run():
    with pytest.raises(DeckError, match="'initial.from' belongs to a deck with 'time'"):
        deck(STAGED.replace("time: {end: 1, step: 0.01}", "static: {}"))


def test_a_run_begins_with_a_static_equilibrium(tmp_path):
    """A cantilever that hangs under its weight stays where statics left it."""
    hanging = """
    mecano: 1
    gravity: [0, 0, -10]
    nodes: {root: {position: [0, 0, 0], fixed: true}, tip: {position: [2, 0, 0]}}
    sections: {rod: {type: circle, diameter: 20 mm, E: 2 GPa, nu: 0.3, density: 2000}}
    elements: {rod: {type: beam, nodes: [root, tip], section: rod, mesh: 6}}
    static: {}
    """
    still = solved(tmp_path, "s", hanging)
    moving = solved(
        tmp_path, "t", hanging.replace("static: {}", "initial: {from: s.h5}\n    time: {end: 1, step: 0.01}")
    )
    rest = still["tip.position"].values[-1]
    assert rest[2] < -0.1
    np.testing.assert_allclose(moving["tip.position"].values - rest, 0.0, atol=1e-8)


def test_touching_contacts_that_separated_at_the_start_are_open(tmp_path):
    """Their gap was -1e-10 m: no event tells that they are open, and the speed of 1 m/s stays that of one ball."""
    text = """
    mecano: 1
    gravity: none
    nodes: {low: {position: [0, 0, 0]}, high: {position: [0, 0, 0.2499999999]}}
    elements:
      low: {type: rigid_body, node: low, mass: 1, inertia: [1, 1, 1]}
      high: {type: rigid_body, node: high, mass: 1, inertia: [1, 1, 1]}
      touch: {type: contact, nodes: [low, high], sphere: {radius: 0.125}, radius: 0.125}
    initial: {velocities: [{nodes: [high], velocity: [0, 0, 1]}]}
    time: {end: 0.02, step: 1.0e-3}
    """
    solved(tmp_path, "s", text)
    second = re.sub(r"initial:.*", "initial: {from: s.h5}", text)
    run = solved(tmp_path, "t", second)
    assert not run["elements/touch/closed"].values.any()
    np.testing.assert_allclose(run["nodes/high/velocity"].values[:, 2], 1.0, atol=1e-12)
    np.testing.assert_allclose(run["nodes/low/velocity"].values[:, 2], 0.0, atol=1e-12)
