"""Cables that are released at a time or by a condition: motion, energy lost, and a folded array that deploys."""

import numpy as np
import pytest
from click.testing import CliRunner
from time_runs import INPUTS, RecordedRun, deck, input_deck

import mecano
from mecano.cli import commands
from mecano.errors import DeckError

HANGING = """
    mecano: 1
    gravity: [0, 0, -10]
    nodes:
      top: {position: [0, 0, 0], fixed: true}
      load: {position: [0, 0, -1]}
    elements:
      load: {type: point_mass, node: load, mass: 2}
      rope: {type: cable, nodes: [top, load], axial_stiffness: 1000, natural_length: 0.9803921568627451, MORE}
    time: {end: 0.5, step: 0.005}
    """
STRAIN = 0.02  # 2 kg of 10 m/s2 on 1000 N
LOST = 0.5 * 20 * STRAIN / 1.02  # half of the tension times the extension
REEVED = """
    mecano: 1
    gravity: [0, 0, -10]
    nodes:
      top: {position: [-0.1, 0, 0], fixed: true}
      pulley: {position: [0, 0, -1]}
      other: {position: [0.1, 0, 0], fixed: true}
    elements:
      load: {type: rigid_body, node: pulley, mass: 2, inertia: [1, 1, 1]}
      rope:
        type: reeved_cable
        nodes: [top, pulley, other]
        radii: [0, -0.1, 0]
        axis: [0, 1, 0]
        axial_stiffness: 1000
        pretension: 10
        FRICTION
        release: {time: 0.2}
    time: {end: END, step: 0.005}
    """


def released(run, element):
    (event,) = [h for h in run.event_records if h.element == element and h.name == "releases"]
    return event


@pytest.mark.parametrize("release", ["{time: 0.2}", "{when: time > 0.2}"])
def test_a_load_falls_from_a_cable_that_is_cut(verify, release):
    run = RecordedRun(deck(HANGING.replace("MORE", f"release: {release}")))
    fall = -1.0 - 5.0 * np.maximum(run.time - 0.2, 0.0) ** 2
    verify(
        "Release", "load on a cut cable: height [m]", run["nodes/load/position"][:, 2], fall, "free fall", absolute=1e-8
    )
    event = released(run, "cable 'rope'")
    assert (event.t, event.lost) == (pytest.approx(0.2, abs=1e-12), pytest.approx(LOST, rel=1e-7))
    assert run.run.dissipated == pytest.approx(LOST, rel=1e-7)
    tension, after = run["elements/rope/tension"], run.time > 0.2 + 1e-9
    np.testing.assert_allclose(tension[~after], 20.0, rtol=1e-7)
    np.testing.assert_array_equal(tension[after], 0.0)
    assert np.ptp(run["energy/balance"]) < 1e-8


def test_the_row_at_the_release_holds_the_values_before_it():
    run = RecordedRun(deck(HANGING.replace("MORE", "release: {time: 0.2}")))
    (row,) = np.flatnonzero(np.abs(run.time - 0.2) < 1e-9)[:1]
    assert run["elements/rope/tension"][row] == pytest.approx(20.0, rel=1e-7)


def test_a_cable_released_before_the_start_carries_nothing():
    run = RecordedRun(deck(HANGING.replace("MORE", "release: {time: -1}")))
    np.testing.assert_array_equal(run["elements/rope/tension"], 0.0)
    assert run["nodes/load/position"][-1, 2] == pytest.approx(-1.0 - 5.0 * 0.25, abs=1e-8)


def test_a_heavy_cable_keeps_its_mass():
    """Its velocity is linear from the fixed end: a third of its mass falls with the load, half of its weight pulls."""
    run = RecordedRun(deck(HANGING.replace("MORE", "mass_per_length: 0.5, damping: 0.01, release: {time: 0.2}")))
    mass, after = 0.5 / 1.02, np.flatnonzero(run.time > 0.2 + 1e-9)[[0, -1]]
    (v0, v1), (t0, t1) = run["nodes/load/velocity"][after, 2], run.time[after]
    assert (v1 - v0) / (t1 - t0) == pytest.approx(-10 * (2 + mass / 2) / (2 + mass / 3), rel=1e-6)
    assert np.ptp(run["energy/balance"]) < 2e-5


@pytest.mark.parametrize("friction", ["", "friction: {coefficients: [0.2], regularization: 0.01}"])
def test_a_pulley_falls_when_its_cable_is_cut(friction):
    """The path is 2 m and half a turn long, its tension 10 N: N^2 L/(2 EA) is lost."""
    run = RecordedRun(deck(REEVED.replace("FRICTION", friction).replace("END", "0.6")))
    natural = (2.0 + 0.1 * np.pi) / 1.01
    assert released(run, "reeved_cable 'rope'").lost == pytest.approx(0.5 * 10**2 / 1000 * natural, rel=1e-6)
    assert run["nodes/pulley/position"][-1, 2] == pytest.approx(-1.0 - 5.0 * 0.4**2, abs=1e-7)
    assert np.ptp(run["energy/balance"]) < 1e-6


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("release: {}", "'release' needs either 'time' or 'when'"),
        ("release: {time: 1}, at_full_length: hold", "'release' and 'at_full_length' exclude one another"),
        ("release: {time: 1}, payout_tension: 3", "'release' and 'payout_tension' exclude one another"),
        ("activate: {time: 1}, payout_tension: 3", "'activate' and 'payout_tension' exclude one another"),
    ],
)
def test_wrong_releases(more, message):
    with pytest.raises(DeckError) as error:
        deck(HANGING.replace("MORE", more))
    assert message in error.value.problems[0].message and error.value.problems[0].mark


def test_panels_deploy_when_their_tie_is_cut(verify):
    recorded = [RecordedRun(input_deck("panel_release", f"time.step={h}")) for h in (2e-3, 1e-3)]
    w, found = np.sqrt(6.0), []
    for m in recorded:
        angle = m["joints/left_hinge/angle"]
        held = m.time < 0.5 + 1e-9
        np.testing.assert_allclose(angle[held], 0.0, atol=1e-9)
        np.testing.assert_allclose(m["elements/tie/tension"][held], np.pi, rtol=1e-6)
        np.testing.assert_allclose(m["joints/right_hinge/angle"], angle, atol=1e-9)
        left, right = [h for h in m.event_records if h.name == "locks" or "latch" in h.name]
        assert left.t == pytest.approx(right.t, abs=1e-9)
        found.append(np.array([left.t, -left.impulse, left.lost]))
        assert released(m, "cable 'tie'").lost == pytest.approx(0.5 * np.pi * 0.0005994005994005995, rel=1e-6)
    known = np.array([0.5 + np.pi / (2 * w), np.pi / 2 * w / 3, np.pi**2 / 4])
    what = "panels freed by a cable: instant, impulse and energy of their latches"
    verify.second_order("Release", what, *found, known, 1e-8, "harmonic oscillation")
    m = recorded[1]
    moving = (m.time > 0.5) & (m.time < known[0])
    turned = np.pi / 2 * (1 - np.cos(w * (m.time[moving] - 0.5)))
    np.testing.assert_allclose(m["joints/left_hinge/angle"][moving], turned, atol=5e-6)


def test_info_and_report_give_the_energy_lost_in_a_cable(tmp_path):
    results = mecano.run(INPUTS / "panel_release.yaml", tmp_path / "r.h5", quiet=True, set={"time.step": 0.002})
    results.close()
    lines = CliRunner().invoke(commands, ["info", str(tmp_path / "r.h5")]).output.splitlines()
    (release,) = [line for line in lines if "releases" in line]
    assert release.endswith("(taut -> released)  0.000941536 J lost")
    (title,) = [line for line in lines if line.startswith("Events")]
    assert float(title.split()[-5]) == pytest.approx(np.pi**2 / 2, rel=1e-6)  # of both latches, without the cable
