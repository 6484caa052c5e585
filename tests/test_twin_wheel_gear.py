"""A main landing gear with two wheels and anti-skid brakes: momentum, symmetry, slip, modes."""

import numpy as np
import pytest
from scipy.integrate import trapezoid
from time_runs import INPUTS, RecordedRun, input_deck

from mecano.analyses.modal import modes
from mecano.deck.read import read_deck
from mecano.study.read import read_study, try_deck

MASSES = {"airframe": 9000.0, "cylinder": 90.0, "piston": 60.0, "left_rim": 40.0, "right_rim": 40.0}
WEIGHT = 9.81 * sum(MASSES.values())
STEADY = "initial={steady: {velocity: [$speed, 0, 0]}}", "parameters.lift=0"
LAG = 1.0 / 0.03  # [1/s] of the brakes


@pytest.fixture(scope="module")
def landing():
    return RecordedRun(input_deck("twin_wheel_gear", "time.adaptive.tolerance=1e-3", "time.end=1"))


def test_momentum_is_the_impulse_of_ground_and_lift(landing):
    momentum = sum(mass * landing[f"elements/{name}/velocity"][:, 2] for name, mass in MASSES.items())
    ground = sum(trapezoid(landing[f"elements/{side}_wheel/normal_force"], landing.time) for side in ("left", "right"))
    lift = trapezoid(landing["loads/lift/force"][:, 2], landing.time) - WEIGHT * landing.time[-1]
    assert momentum[-1] - momentum[0] == pytest.approx(ground + lift, rel=1e-3)


def test_spin_is_the_impulse_of_drag(landing):
    moment = -landing["elements/left_wheel/longitudinal_force"] * landing["elements/left_wheel/loaded_radius"]
    assert 3.5 * landing["elements/left_wheel/spin_rate"][-1] == pytest.approx(
        trapezoid(moment, landing.time), rel=1e-4
    )


def test_both_wheels_carry_the_same(landing):
    left, right = (landing[f"elements/{side}_wheel/normal_force"] for side in ("left", "right"))
    np.testing.assert_allclose(left, right, atol=1e-5 * left.max())


def test_the_valves_keep_the_slip_in_its_band():
    """After a second of braking on a wet runway, the slip follows the valve and its lag between 0 and 0.2."""
    changes = "parameters.brake=9000", "parameters.friction=0.3", "parameters.sink=0.3", "time.end=4"
    run = RecordedRun(input_deck("twin_wheel_gear", *changes))
    braking = run.time > 2.0
    slip = run["signals/left_slip/value"][braking]
    assert 0.0 < slip.min() < 0.06 and 0.12 < slip.max() < 0.2
    switched = [h for h in run.event_records if h.element == "switch 'left_valve'" and h.t > 2.0]
    assert len(switched) > 20
    drag = trapezoid(-run["elements/left_wheel/longitudinal_force"][braking], run.time[braking])
    carried = trapezoid(run["elements/left_wheel/normal_force"][braking], run.time[braking])
    assert 0.85 * 0.3 < drag / carried < 0.3


def test_modes_are_those_without_the_control():
    """The valves do not react to small motions: beside both lags, every mode is that of the gear alone."""
    name, signals = "twin_wheel_gear", ("signals={}", "loads.left_brake.torque=0", "loads.right_brake.torque=0")
    controlled, bare = (
        modes(read_deck(INPUTS / f"{name}.yaml", (*STEADY, *more)), None, number=30)[1] for more in ((), signals)
    )
    assert controlled.converged.all() and bare.converged.all()
    lags = np.abs(controlled.values + LAG) < 1e-6 * LAG
    assert lags.sum() == 2
    found, known = (np.sort_complex(values) for values in (controlled.values[~lags], bare.values))
    np.testing.assert_allclose(found, known, rtol=1e-6, atol=1e-6)
    assert (known == 0.0).sum() == 4  # along and across the runway, and the angles of both wheels


@pytest.mark.parametrize(("speed", "damper", "stable"), [(120, 400, True), (123, 400, False), (140, 1500, True)])
def test_shimmy_begins_at_the_documented_speed_and_a_damper_prevents_it(speed, damper, stable):
    change = f"parameters.speed={speed}", f"laws.torque_link.damper.coefficient={damper}"
    found = modes(read_deck(INPUTS / "twin_wheel_gear.yaml", (*STEADY, *change)), None, number=30)[1]
    assert (found.values.real.max() < 1e-6) == stable


@pytest.mark.parametrize("speed", [80, 84.8])
def test_rounding_spins_no_wheel_in_the_air(speed):
    """While the wheels bounce in the search, moments of 1e-28 N m led to spins of 1e9 rad/s, and to no solution."""
    found = modes(read_deck(INPUTS / "twin_wheel_gear.yaml", (*STEADY, f"parameters.speed={speed}")), None, number=30)
    assert found[1].converged.all()


def test_the_load_cases_can_be_run():
    study = read_study(INPUTS / "studies" / "twin_wheel_gear_loads.yaml")
    assert len(study.cases) == 6 and try_deck(study).file.endswith("twin_wheel_gear.yaml")
    assert len(read_study(INPUTS / "studies" / "solar_array_friction.yaml").cases) == 6


def test_the_study_of_free_play_can_be_run():
    study = read_study(INPUTS / "studies" / "twin_wheel_gear_play.yaml")
    law = dict(try_deck(study).values["joints"]["tube"]["turning_law"])
    assert len(study.cases) == 6 and set(law) == {"damper", "dead_band"}
    assert law["dead_band"] == {"stiffness": 150e3, "lower": -1e-3, "upper": 1e-3}
