"""Rolling radius and rolling resistance of tyres, and lift by signals, against closed forms."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq
from time_runs import INPUTS, RecordedRun, deck, input_deck

import mecano
from mecano.errors import DeckError
from mecano.solve.modal.free_spins import roll_one

FORMULA = "{FNOMIN: 4e3, UNLOADED_RADIUS: 0.3, PCX1: 1.6, PDX1: 1, PKX1: 20, PCY1: 1.3, PDY1: 1, PKY1: -20, PKY2: 2}"
ROLL = (INPUTS / "landing_roll.yaml").read_text()
MASS, SPIN, SPEED, RADIUS, STIFFNESS, WING = 4000.0, 2.5, 60.0, 0.35, 1.5e7, 0.5 * 1.225 * 18 * 0.9
WEIGHT = MASS * 9.81


def slowed(v, t, lift):
    """Speed after the time t under the rolling resistance of the load that the lift ``lift`` v^2 leaves."""
    V = math.sqrt(WEIGHT / lift)
    return V * np.tanh(np.arctanh(v / V) - 0.02 * WEIGHT * t / ((MASS + SPIN / RADIUS**2) * V))


def test_an_aircraft_rolls_out_under_lift_and_rolling_resistance(verify):
    """inputs/landing_roll.yaml: m' v' = -f (m g - c v^2), with a fifth of the lift after the spoilers have opened.

    As the load grows, the rolling radius shrinks; the spin that the wheel gains takes the speed I v d(1/r_e^2)/(2 m).
    """
    recorded = RecordedRun(input_deck("landing_roll"))
    steady = (recorded.time < 3.0) | (recorded.time > 5.0)
    t, v = recorded.time[steady], recorded["nodes/body/velocity"][steady, 0]
    N, spin = (recorded[f"elements/wheel/{name}"].ravel()[steady] for name in ("normal_force", "spin_rate"))
    at_spoilers, r_e = slowed(SPEED, 3.0, WING), RADIUS - N / (3.0 * STIFFNESS)
    exact = np.where(t <= 3.0, slowed(SPEED, t, WING), slowed(at_spoilers, np.maximum(t - 3.0, 0.0), 0.2 * WING))
    exact -= 0.5 * SPIN / MASS * v * (1.0 / r_e**2 - 1.0 / r_e[0] ** 2)
    verify("Tyres", "landing roll, lift by dynamic pressure and rolling resistance: speed lost [m/s]",
           SPEED - v, SPEED - exact, "v = V tanh(artanh(v_0/V) - f m g t/(m' V))", absolute=1e-4)  # fmt: skip
    assert SPEED - v[-1] > 0.8
    lift = np.where(t <= 3.0, 1.0, 0.2) * WING * v**2
    np.testing.assert_allclose(N, WEIGHT - lift, atol=1e-3 * WEIGHT)
    np.testing.assert_allclose(spin, v / r_e, rtol=1e-5)
    assert np.abs(recorded["elements/wheel/longitudinal_slip"]).max() < 1e-3
    assert np.ptp(recorded["energy/balance"]) < 1e-4 * recorded["energy/dissipated"][-1]


def test_the_rolling_radius_is_that_of_a_belt_of_constant_length():
    """radius sin(phi)/phi with radius (1 - cos phi) = w is radius - w/3 to second order in w."""
    for w in (1e-3, 1e-2):
        phi = brentq(lambda phi, w=w: RADIUS * (1.0 - math.cos(phi)) - w, 1e-6, 1.0)
        assert RADIUS * math.sin(phi) / phi == pytest.approx(RADIUS - w / 3.0, abs=0.1 * w * w / RADIUS)


SPUN = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {{axle: {{position: [0, 0, 0.29]}}, hub: {{position: [0, 0, 0.29]}}}}
    elements:
      body: {{type: rigid_body, node: hub, mass: 100.0, inertia: [1, 2, 1]}}
      tire: {{type: {kind}, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: runway}}
    joints:
      level: {{type: held_rotation, nodes: [ground, axle]}}
      tow: {{type: prescribed_position, node: axle, direction: [1, 0, 0], value: {{linear: {{slope: 6}}}}}}
      side: {{type: prescribed_position, node: axle, direction: [0, 1, 0], value: 0.0}}
      bearing: {{type: hinge, nodes: [axle, hub], axis: [0, 1, 0]}}
    tire_laws:
      rubber:
        radius: 0.3
        radial: {{linear: {{slope: 98.1 kN/m}}}}
        rolling_radius_coefficient: 0.25
        {law}
        lateral: {{relaxation: {{cornering_stiffness: 2.0e3, relaxation_length: 0.2}}}}
    grounds: {{runway: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    initial: {{velocities: [{{nodes: all, velocity: [6, 0, 0]}}]}}
    time: {{end: 0.4, step: 1.0e-3}}
"""


@pytest.mark.parametrize("kind", ["wheel", "flexible_wheel"])
def test_the_spin_up_ends_at_the_effective_radius(kind):
    """With the moment r_e mu N about the axle: I W' = r_e mu N, until W = v/r_e; half of the work of towing is lost."""
    recorded = RecordedRun(deck(SPUN.format(kind=kind, law="friction: 0.8\n        slip_regularization: 1.0e-3")))
    spin, time, r_e = recorded["elements/tire/spin_rate"].ravel(), recorded.time, 0.3 - 0.25 * 0.01
    rate = 0.8 * 981.0 * r_e / 2.0
    early = time < 0.95 * 6.0 / r_e / rate
    np.testing.assert_allclose(spin[early], rate * time[early], rtol=1e-6, atol=1e-9)
    assert spin[-1] == pytest.approx(6.0 / r_e, rel=1e-6)
    assert abs(recorded["elements/tire/longitudinal_slip"][-1]) < 1e-6
    assert recorded["energy/dissipated"][-1] == pytest.approx(0.5 * 2.0 * (6.0 / r_e) ** 2, rel=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("coefficient: 1/3", "coefficient: 1.5", "must be from 0 to 1"),
        ("friction: 0.8\n    slip_regularization: 0.01", f"magic_formula: {{coefficients: {FORMULA}}}",
         "'tire_law.rolling_radius_coefficient' is not available with 'magic_formula'"),
        ("resistance: {coefficient: 0.02}", "resistance: {coefficient: -0.02}",
         "'tire_law.rolling_resistance.coefficient' must not be negative"),
        ("type: wheel, node", "type: adhesive_wheel, node", "is not available for an adhesive_wheel"),
    ],
)  # fmt: skip
def test_errors_in_a_rolling_tyre(old, new, said):
    assert ROLL.count(old) == 1
    with pytest.raises(DeckError) as error:
        deck(ROLL.replace(old, new))
    assert said in str(error.value)


def test_moments_that_are_rounding_leave_the_spin_alone():
    """A moment of 1e-14 N m, of a wheel that hardly touches the ground, vanishes at no spin of a wheel."""
    system = SimpleNamespace(assemble=lambda s: SimpleNamespace(residual=1e-14 - 1e-23 * s.v))
    steady, s = SimpleNamespace(system=system, speed=20.0, length=1.0, n_q=1), SimpleNamespace(v=np.array([3.0]))
    roll_one(steady, s, np.ones(1), 1e-12)
    assert s.v == [3.0]


def test_the_rolling_radius_leaves_the_side_force_of_a_twisted_patch(tmp_path):
    """Side force C alpha of inputs/step_steer.yaml: the slip angle is that of the axle, on whatever radius it rolls."""
    forces = []
    for coefficient in (1.0, 1.0 / 3.0):
        changes = {"tire_laws.rubber.rolling_radius_coefficient": coefficient, "time.end": 0.5}
        with mecano.run(INPUTS / "step_steer.yaml", tmp_path / "r.h5", quiet=True, force=True, set=changes) as results:
            forces.append(results["tire.lateral_force"][-1])
    assert forces == pytest.approx([1195.02, 1195.02], rel=1e-5)
