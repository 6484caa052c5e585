"""Runs that begin with a saved state of another one: ``initial: {from: FILE:TIME}``."""

import re

import numpy as np
import pytest
from click.testing import CliRunner
from time_runs import INPUTS, deck

import mecano
from mecano.cli import commands
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
