"""Structures that deploy and lock: messages and pictures, and messages if they do not."""

import csv
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from time_runs import INPUTS, RecordedRun, deck, input_deck

from mecano.analyses.dynamic import run
from mecano.deck.format import deck_error_text
from mecano.errors import ConvergenceError, DeckError, UnknownNameError
from mecano.post import pictures
from mecano.post.deployment import MARGINS, deployment_sheet, margin_text
from mecano.post.event_groups import groups, shock_sheet
from mecano.post.info import info
from mecano.post.runs import open_runs
from mecano.post.sheets import default_sheets
from mecano.results.reader import open_results
from mecano.study.outputs import Output
from mecano.study.read import read_study, try_deck


@pytest.fixture(scope="module")
def panel(tmp_path_factory):
    """The panel of inputs/, lifted against a gravity of 1 m/s2 by its spring."""
    path = tmp_path_factory.mktemp("deployment") / "panel.h5"
    run(input_deck("panel_lock", "gravity=[0, -1, 0]", "output.every=1e-3"), path)
    return path


def test_a_run_that_ends_by_its_latch_has_the_same_margin(panel, tmp_path):
    """Its last row holds the values after the lock, whose loss of energy does not resist."""
    overrides = ("gravity=[0, -1, 0]", "output.every=1e-3", "time.until=hinge.latched > 0.5")
    run(input_deck("panel_lock", *overrides), tmp_path / "ended.h5")
    with open_results(tmp_path / "ended.h5") as results:
        assert results["hinge.latched"].values[-1] == 1.0
    found, known = (
        [panel.curves[0].y.values for panel in deployment_sheet(open_runs([path])).panels]
        for path in (tmp_path / "ended.h5", panel)
    )
    for values, wanted in zip(found, known, strict=True):
        np.testing.assert_allclose(values[:-1], wanted[:-1], rtol=0, atol=1e-3)
        assert values[-1] == pytest.approx(wanted[-1], abs=1e-3)


def test_margin_is_torque_over_weight(panel):
    """2 (pi/2 - angle) N m of the spring against 0.5 cos(angle) N m of the weight: from 2 pi down to 4."""
    torque, margin = deployment_sheet(open_runs([panel])).panels
    angle = margin.curves[0].x.values
    assert angle[0] < 0.03 and angle[-1] > 1.5
    motor, resisting = (curve.y.values for curve in torque.curves)
    np.testing.assert_allclose(motor, 2.0 * (np.pi / 2.0 - angle), rtol=0, atol=5e-3)
    np.testing.assert_allclose(resisting, 0.5 * np.cos(angle), rtol=0, atol=5e-4)
    wide = angle < 1.3
    np.testing.assert_allclose(margin.curves[0].y.values[wide], (motor / (0.5 * np.cos(angle)))[wide], rtol=0.01)
    assert margin.curves[0].y.unit == "-"


@pytest.mark.parametrize("every", ["1e-2", "2e-2"])
def test_margin_over_a_small_weight_between_rare_saved_times(every, tmp_path):
    """2 (pi/2 - angle) N m of the spring against 0.01 cos(angle) N m: quadrature of second order is off by 25 %."""
    run(input_deck("panel_lock", "gravity=[0, -0.02, 0]", f"output.every={every}"), tmp_path / "panel.h5")
    _, margin = deployment_sheet(open_runs([tmp_path / "panel.h5"])).panels
    (curve,) = margin.curves
    angle, found = curve.x.values[5:-10], curve.y.values[5:-10]  # to 1.2 rad: beyond 1.25 it is less than 1/1000
    np.testing.assert_allclose(found, 200.0 * (np.pi / 2.0 - angle) / np.cos(angle), rtol=0.06)


def test_the_summary_lists_no_instants_of_releases(tmp_path):
    """Which are formulas like those of signals, and have names."""
    run(input_deck("release", "time.end=0.01"), tmp_path / "release.h5")
    assert "formulas: " not in info(tmp_path / "release.h5")
    assert "formulas.time - (" in info(tmp_path / "release.h5", "*")


def test_friction_and_dampers_of_motors_resist(tmp_path):
    """Without weight, the friction of 0.5 N m resists the 2 (pi/2 - angle) N m of the spring."""
    law = "joints.hinge.turning_law={spring: {stiffness: 2}, dry_friction: {force: 0.5, regularization: 1.0e-4}}"
    run(input_deck("panel_lock", law, "output.every=1e-3"), tmp_path / "panel.h5")
    motor, resisting = (c.y for c in deployment_sheet(open_runs([tmp_path / "panel.h5"])).panels[0].curves)
    angle = deployment_sheet(open_runs([tmp_path / "panel.h5"])).panels[0].curves[0].x.values
    np.testing.assert_allclose(motor.values, 2.0 * (np.pi / 2.0 - angle), rtol=0, atol=5e-3)
    np.testing.assert_allclose(resisting.values[1:], 0.5, rtol=0, atol=1e-4)


def test_the_least_margin_is_an_output_of_a_study(tmp_path):
    """Of the means over the last but two and the last of 40 intervals: 2 (pi/2 - angle) N m over 0.5 N m; the path
    ends at the last saved time before the lock."""
    law = "joints.hinge.turning_law={spring: {stiffness: 2}, dry_friction: {force: 0.5, regularization: 1.0e-4}}"
    run(input_deck("panel_lock", law, "output.every=1e-4"), tmp_path / "panel.h5")
    with open_results(tmp_path / "panel.h5") as results:
        found = [Output("m", name, None, "min").value(results) for name in MARGINS]
    assert [unit for _, unit in found] == ["-", "-"]
    np.testing.assert_allclose([margin for margin, _ in found], [np.pi / 8.0, np.pi / 40.0], rtol=0, atol=2e-3)


def test_a_margin_without_resistance_is_within_a_limit(tmp_path):
    """Nothing but its inertia resists the panel: resistance below 1/1000 of the torque counts as that."""
    run(input_deck("panel_lock"), tmp_path / "panel.h5")
    with open_results(tmp_path / "panel.h5") as results:
        assert [Output("m", name, None, "min").value(results) for name in MARGINS] == [(1000.0, "-")] * 2


@pytest.mark.parametrize(
    ("deck", "take", "said"),
    [
        ("panel_lock", "max", "study.yaml:4:40: output 'm': of 'motors.margin' only the least value"),
        ("pendulum", "min", "study.yaml:4:19: output 'm': 'motors.margin': no hinge has a 'turning_law' and a 'latch'"),
        ("panel_lock", "min", ""),
    ],
)
def test_an_output_of_the_margin_needs_motors(deck, take, said, tmp_path):
    (tmp_path / "deck.yaml").write_text((INPUTS / f"{deck}.yaml").read_text())
    study = "study: 1\ndeck: deck.yaml\ngrid: {time.step: [1e-3]}\noutputs: {m: {of: motors.margin, take: TAKE}}\n"
    (tmp_path / "study.yaml").write_text(study.replace("TAKE", take))
    try_it = partial(try_deck, read_study(tmp_path / "study.yaml"))
    if said:
        with pytest.raises(DeckError) as error:
            try_it()
        assert said in deck_error_text(error.value)
    else:
        try_it()


def test_springs_of_hinges_without_a_latch_are_motors(tmp_path):
    """A cable turns the elbow by 2 u while the root turns by u = 2 a/3 to its latch, a the mean of both angles.

    The springs of 2 N m/rad and 1 N m/rad work (pi - 2 u) du + (pi - 2 u) 2 du, over 3 du; friction of 0.1 N m in the
    elbow resists by 0.2/3 N m.
    """
    overrides = (
        "loads=null",
        "joints.root_hinge.turning_law={spring: {stiffness: 2}}",
        "joints.root_hinge.natural_angle=-90 deg",
        "joints.elbow_hinge.turning_law={spring: {stiffness: 1}, dry_friction: {force: 0.1, regularization: 1.0e-4}}",
        "joints.elbow_hinge.natural_angle=180 deg",
        "output.every=1e-3",
    )
    run(input_deck("synchronised_panels", *overrides), tmp_path / "panels.h5")
    torque, resisting = (c.y.values for c in deployment_sheet(open_runs([tmp_path / "panels.h5"])).panels[0].curves)
    angle = deployment_sheet(open_runs([tmp_path / "panels.h5"])).panels[0].curves[0].x.values
    np.testing.assert_allclose(torque, np.pi - 4.0 * angle / 3.0, rtol=0, atol=5e-3)
    np.testing.assert_allclose(resisting[1:], 0.2 / 3.0, rtol=0, atol=1e-3)


def test_other_actuators_leave_no_margin(tmp_path):
    """A motor of 1 N m that helps the spring gives energy that is no resistance; one of -0.2 N m resists."""
    for moment in (1.0, -0.2):
        load = f"loads={{motor: {{type: joint_moment, joint: hinge, value: {moment}}}}}"
        path = tmp_path / f"{moment}.h5"
        run(input_deck("panel_lock", load, "output.every=1e-3"), path)
        panels = deployment_sheet(open_runs([path])).panels
        assert bool(panels) == (moment < 0.0)
    np.testing.assert_allclose(panels[0].curves[1].y.values[1:], 0.2, rtol=0, atol=1e-4)


def test_reaction_wheels_leave_the_margin_as_it_is(tmp_path):
    """A wheel is spun up by a sampled torque beside the panel, and has no effect on it.

    As without it: 2 (pi/2 - angle) N m against 0.5 cos(angle) N m.
    """
    base = input_deck("panel_lock").text
    add = {
        "nodes:": "  rotor: {position: [0, 0, 0]}",
        "elements:": "  rotor: {type: rigid_body, node: rotor, mass: 1.0e-6, inertia: [1.0e-3, 1.0e-3, 1.0e-3]}",
        "joints:": "  axle: {type: hinge, nodes: [ground, rotor], axis: [1, 0, 0]}",
    }
    for section, line in add.items():
        base = base.replace(f"\n{section}\n", f"\n{section}\n{line}\n")
    base += """
signals: {torque: {type: sample_and_hold, input: 0.5 + 0.1*axle.angle, period: 0.1}}
loads: {wheel: {type: joint_moment, joint: axle, value: torque}}
"""
    path = tmp_path / "wheel.h5"
    run(deck(base.replace("gravity: none", "gravity: [0, -1, 0]")), path)
    with open_results(path) as results:
        assert results["energy.given"].values.max() > 50.0  # 100 times the work against the weight
    torque, _ = deployment_sheet(open_runs([path])).panels
    angle = torque.curves[0].x.values
    motor, resisting = (curve.y.values for curve in torque.curves)
    np.testing.assert_allclose(motor, 2.0 * (np.pi / 2.0 - angle), rtol=0, atol=5e-3)
    np.testing.assert_allclose(resisting, 0.5 * np.cos(angle), rtol=0, atol=5e-3)


def test_least_margin_on_the_way_is_not_hidden_by_members_that_tighten_at_its_end():
    """4 - sin(pi a / 2.6) has its least value, 3, in the middle of 40 intervals; the last two bend members."""
    angle = (np.arange(40) + 0.5) * 2.6 / 40
    margin = 4.0 - np.sin(np.pi * angle / 2.6)
    margin[-2:] = 9.0, 2.0
    reported = margin_text(angle, margin)
    assert reported == "least 3 at 1.27 rad; in the last 5% of the way 2 at 2.57 rad"
    margin[-2:] = np.nan
    assert margin_text(angle, margin).endswith("in the last 5% of the way nothing resists")


def test_shocks_are_a_table_and_a_sheet(panel, tmp_path, monkeypatch):
    (lock,) = open_results(panel).events
    names = [sheet.name for sheet in default_sheets(open_runs([panel]))]
    assert {"deployment", "shocks"} <= set(names)
    monkeypatch.setattr(pictures, "default_sheets", lambda runs: [shock_sheet(runs)])
    written = {path.name: path for path in pictures.post([panel], output=f"{tmp_path}/")}
    assert {"panel_shocks.png", "panel_shocks.csv"} <= set(written)
    with open(written["panel_shocks.csv"], newline="") as file:
        heading, line = csv.reader(file)
    assert heading[1] == "time [s]" and heading[5:] == ["impulse", "unit of the impulse", "energy lost [J]"]
    assert line[2:5] == ["1", "hinge 'hinge'", "locks"] and line[6] == "N m s"
    assert [float(line[i]) for i in (1, 5, 7)] == [lock.time, lock.impulse, lock.energy_lost]
    sheet = shock_sheet(open_runs([panel]))
    assert [panel.label for panel in sheet.panels] == ["largest impulse", "energy lost in shocks"]
    assert sheet.panels[0].curves[0].y.values.min() == lock.impulse
    assert sheet.panels[1].curves[0].y.values[-1] == lock.energy_lost


def test_what_is_alike_at_one_instant_is_grouped(panel):
    results = open_results(panel)
    several = SimpleNamespace(time=np.array([0.0, 1.0]), events=results.events * 3, subject=results.subject)
    (group,) = groups(several)
    assert group.title == "3 hinge: hinge, hinge, hinge" and group.lost == 3 * group.events[0].energy_lost
    assert "hinge 'hinge'  locks  (free -> locked)  impulse -" in info(panel)
    (title, line) = info(panel, events="hin*").splitlines()
    assert title.startswith("Events: 1; ") and line in info(panel) and info(panel, events="locks").endswith(line)
    with pytest.raises(UnknownNameError, match="no event of .* matches 'grip'; there are hinge, locks"):
        info(panel, events="grip")


def test_a_torque_that_is_too_weak(tmp_path):
    """A spring of 0.2 N m/rad stands still below the latch, where dampers have taken all that it gave."""
    law = "{spring: {stiffness: 0.2}, damper: {coefficient: 0.5}}"
    weak = input_deck("panel_lock", "gravity=[0, -1, 0]", f"joints.hinge.turning_law={law}", "time.end=12")
    reported = []
    run(weak, tmp_path / "weak.h5", announce=reported.append)
    (text,) = reported
    results = open_results(tmp_path / "weak.h5")
    angle = results["joints/hinge/angle"].values[-1]
    assert 0.2 * (np.pi / 2.0 - angle) == pytest.approx(0.5 * np.cos(angle), rel=1e-3)
    expected = f"1 of 1 latches never closed: hinge 'hinge' at {angle:.4g} of 1.571 rad, moving at "
    assert text.startswith(expected) and abs(float(text.split()[-2])) < 1e-3
    assert results.status == "complete" and text in results.reason


def test_a_latch_that_holds_the_others_back(tmp_path):
    """The latch of the crank of a linkage closes first and holds it, so that the latch of the rocker never closes."""
    latches = ("joints.hinge_a.latch.angle=-0.3", "joints.hinge_d.latch.angle=1.5", "time.end=1.5")
    reported = []
    run(input_deck("four_bar", *latches), tmp_path / "held.h5", announce=reported.append)
    results = open_results(tmp_path / "held.h5")
    assert [event.element for event in results.events if event.name == "locks"] == ["hinge 'hinge_a'"]
    angle = results["joints/hinge_d/angle"].values[-1]
    assert reported[-1].startswith(
        f"1 of 2 latches never closed: hinge 'hinge_d' at {angle:.4g} of 1.5 rad, moving at "
    )
    assert abs(float(reported[-1].split()[-2])) < 1e-9


STOPPED = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {panel: {position: [0, 0, 0]}, bead: {position: [0, 0, 1]}}
    elements:
      panel: {type: rigid_body, node: panel, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [1.0e-4, 0.083, 0.083]}
      bead: {type: point_mass, node: bead, mass: 1.0}
    joints:
      knee: {type: hinge, nodes: [ground, panel], axis: [0, 1, 0], latch: {angle: 3.0}}
      wire: {type: point_on_curve, nodes: [ground, bead], points: [[0, 0, 1], [0.1, 0, 0.9]]}
    time: {end: 1.0, step: 0.01}
"""


def test_a_run_that_cannot_go_on_says_which_latches_are_open(tmp_path):
    with pytest.raises(ConvergenceError, match="end of its curve\n1 of 1 latches never closed: hinge 'knee' at 0."):
        run(deck(STOPPED), tmp_path / "stopped.h5")
    results = open_results(tmp_path / "stopped.h5")
    assert results.status == "failed" and "hinge 'knee' at 0." in info(results.path) and len(results.time) > 5


@pytest.mark.parametrize("release", ["{time: 1}", "{when: time > 1}"])
def test_a_latch_that_is_released_lets_the_panel_swing(release):
    """From 1 rad, at rest, about 2 rad: 2 - cos(w t), with w^2 = 2 N m/rad over 1/3 kg m2. The shock took 3 J."""
    changes = "joints.hinge.natural_angle=2", f"joints.hinge.latch={{angle: 1, release: {release}}}", "time.end=2"
    run = RecordedRun(input_deck("panel_lock", *changes))
    assert [(h.name, h.after) for h in run.event_records] == [("locks", "locked"), ("unlocks", "released")]
    locks, unlocks = run.event_records
    assert (locks.t, unlocks.t) == (pytest.approx(np.arccos(0.5) / np.sqrt(6.0), abs=1e-6), pytest.approx(1.0))
    assert locks.lost == pytest.approx(3.0, rel=1e-5) and unlocks.lost == 0.0
    after = run.time > 1.0 + 1e-9
    known = 2.0 - np.cos(np.sqrt(6.0) * (run.time[after] - 1.0))
    np.testing.assert_allclose(run["joints/hinge/angle"][after], known, atol=2e-6)
    np.testing.assert_array_equal(run["joints/hinge/latch_moment"][after], 0.0)
    np.testing.assert_array_equal(run["joints/hinge/latched"], (run.time > locks.t + 1e-9) & ~after)


@pytest.mark.parametrize("release", ["{time: 0.2}", "{when: time > 0.2}"])
def test_a_latch_that_is_released_before_it_locks_lets_the_panel_pass(release, tmp_path):
    """The panel swings about 2 rad from the start, 2 (1 - cos(w t)); the run reports that it never locked."""
    changes = "joints.hinge.natural_angle=2", f"joints.hinge.latch={{angle: 1, release: {release}}}", "time.end=1"
    run(input_deck("panel_lock", *changes), tmp_path / "r.h5")
    results = open_results(tmp_path / "r.h5")
    assert [(event.name, event.energy_lost) for event in results.events] == [("is held open", 0.0)]
    known = 2.0 * (1.0 - np.cos(np.sqrt(6.0) * results.time))
    np.testing.assert_allclose(results["hinge.angle"].values, known, atol=2e-6)
    (text,) = (text for text in results.warnings if "latches" in text)
    assert text.startswith("1 of 1 latches never closed: hinge 'hinge'") and text.endswith("with a 'release'")


def test_a_latch_locks_once_its_release_is_no_longer_commanded():
    """The panel swings through 1 rad to 4 rad and back, locks only when its command has ended, and is then released."""
    when = (
        "{when: 'abs(time - 2.1) > 1.6'}"  # held open until 0.5 s, after it has passed 1 rad; locks on its second way
    )
    latch = f"joints.hinge.latch={{angle: 1, release: {when}}}"
    found = RecordedRun(input_deck("panel_lock", "joints.hinge.natural_angle=2", latch, "time.end=4"))
    assert [h.name for h in found.event_records] == ["may lock", "locks", "unlocks"]
    passes = (2.0 * np.pi + np.arccos(0.5)) / np.sqrt(6.0)
    assert [h.t for h in found.event_records] == [
        pytest.approx(0.5, abs=1e-6), pytest.approx(passes, abs=1e-5), pytest.approx(3.7, abs=1e-6)
    ]  # fmt: skip


def test_a_release_of_a_latch_needs_a_trigger():
    with pytest.raises(DeckError) as error:
        input_deck("panel_lock", "joints.hinge.latch={angle: 1, release: {}}")
    assert "'latch.release' needs either 'time' or 'when'" in error.value.problems[0].message
