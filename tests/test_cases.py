"""Decks of users that once gave wrong results.

Others are in the tests of their subjects: saved values of all decks (test_saved_values.py), a platform on legs of
prescribed length (test_closed_forms.py), a column beyond Euler's load (test_statics.py), a steady precession
(test_adaptive.py), edges of a load down to 1e-90 s (test_time_integration.py), nothing that moves
(test_deck_limits.py).
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun

from mecano import open_results
from mecano.analyses.dynamic import run
from mecano.deck.read import read_deck
from mecano.study.outputs import Output

CASES = Path(__file__).parent / "cases"
ELASTIC_LEG = "{type: hinge, nodes: [seat, cylinder], axis: [0, 1, 0], turning_law: {spring: {stiffness: 2.0e6}}}"


def test_forces_of_a_deploying_solar_array_are_those_of_the_steps(tmp_path):
    """Steps of 0.1 s, beams 10,000 times faster: hinges bear 2.45 N until the first latch, where 1284 N was saved."""
    run(read_deck(CASES / "solar_array.yaml", ["time.end=7.6"]), tmp_path / "r.h5")
    with open_results(tmp_path / "r.h5") as results:
        force = results["joints/hinge1/force"]
        largest = np.abs(force.values[force.time < 7.5]).max()
    assert largest == pytest.approx(2.45, rel=0.02)


def test_spin_up_and_spring_back_of_an_axle(tmp_path):
    """The axle bears the drag of the ground in the spin-up, then the inertia of the rim as the elastic leg swings back.

    Both are extremes of the force in the bearing, and so outputs of a study; its impulse and that of the ground are the
    momentum of the rim.
    """
    leg = f"templates.gear.joints.mount={ELASTIC_LEG}"
    run(read_deck(CASES / "main_gear.yaml", ["time.end=0.25", "output.every=step", leg]), tmp_path / "r.h5")
    take = lambda of, take: Output("x", of, None, take).value(results)
    with open_results(tmp_path / "r.h5") as results:
        spin_up, spring_back, begins, ends = (
            take("mlg_bearing_left.force.x", x)[0] for x in ("max", "min", "time_of_max", "time_of_min")
        )
        bearing, ground = (
            results["joints/mlg_bearing_left/force"],
            results["elements/mlg_wheel_left/longitudinal_force"],
        )
        w, x, y, z = results["nodes/mlg_end_left/rotation"].values.T
        along = Rotation.from_quat(np.stack([x, y, z, w], 1)).apply(bearing.values[:, [0, 2, 1]] * [1, 1, -1])[:, 0]
        impulse = trapezoid(along + ground.values, bearing.time)
        speed = results["nodes/mlg_left/velocity"].values[:, 0]
    assert 0.9 < -spin_up / ground.values.min() < 1.0 and spring_back < -0.5 * spin_up and begins < ends
    assert impulse == pytest.approx(55.0 * (speed[-1] - speed[0]), rel=0.01)


LATERAL = {
    "relaxation": "{relaxation: {cornering_stiffness: 250 kN/rad, relaxation_length: 0.35}}",
    "string": "{string: {cornering_stiffness: 250 kN/rad, relaxation_length: 0.35, contact_length: 0.3}}",
    "moreland": "{moreland: {lateral_stiffness: 7.1e5, lateral_damping: 500, yaw_coefficient: 4e-6, yaw_time: 2e-3}}",
}


@pytest.mark.parametrize("law", LATERAL)
def test_a_landing_with_drift_and_roll_comes_to_its_end(law):
    """At 6 degrees of drift and 4 of roll runs ended at 0.05 to 0.3 s, the rates of y and psi growing beyond bounds.

    Both wheels land and rebound, with forces within friction that take a fifth of the drift; the budget closes to 1e-4
    of what is dissipated.
    """
    settings = "parameters.drift=6 deg", "parameters.roll=4 deg", "time.end=0.7"
    recorded = RecordedRun(read_deck(CASES / "main_gear.yaml", [*settings, f"tire_laws.tyre.lateral={LATERAL[law]}"]))
    for side in ("left", "right"):
        N, across, along = (
            recorded[f"elements/mlg_wheel_{side}/{way}_force"].ravel() for way in ("normal", "lateral", "longitudinal")
        )
        assert np.all(np.hypot(across, along) <= 0.8 * N + 1e-6 * N.max())
    drift = recorded["nodes/mlg_body/velocity"][:, 1]
    assert drift[0] == pytest.approx(70.0 * np.sin(np.radians(6.0))) and drift[-1] < 0.8 * drift[0]
    names = [event.name for event in recorded.event_records if "wheel" in event.element]
    assert names == ["touch_down", "touch_down", "lift_off", "lift_off"]
    assert np.ptp(recorded["energy/balance"]) < 1e-4 * np.ptp(recorded["energy/dissipated"])
