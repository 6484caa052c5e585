"""Impulses of motors whose velocities jump at a corner of their law do the work by which the kinetic energy changes."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

MOTOR = """
    mecano: 1
    gravity: none
    nodes: {hub: {position: [0, 0, 0]}, elbow: {position: [1, 0, 0]}, arm: {position: [1, 0, 0]}}
    elements:
      hub: {type: rigid_body, node: hub, mass: 2, inertia: [1, 1, 1], attached: [elbow]}
      arm: {type: rigid_body, node: arm, mass: 2, center_of_mass: [0.5, 0, 0], inertia: [1, 1, 1]}
    joints:
      bearing: {type: hinge, nodes: [ground, hub], axis: [0, 0, 1]}
      elbow: {type: ELBOW, nodes: [elbow, arm]}
      motor: {type: prescribed_angle, nodes: [ground, hub], axis: [0, 0, 1], value: LAW}
    time: {end: 3, step: 10 ms, METHOD}
""".replace("LAW", "{table: {points: [[0, 0], [1, 1], [2, 3], [3, 2.5]], interpolation: linear}}")
METHODS = ["rho_inf: 0.8", "method: radau", "adaptive: {tolerance: 1.0e-6}"]


@pytest.mark.parametrize("method", METHODS)
def test_the_work_on_a_rotor_is_the_change_of_its_energy(method):
    """The inertia is 1 + (1 + 2 1.5^2) kg m^2; the motor turns it at 1, 2 and -0.5 rad/s."""
    text = MOTOR.replace("METHOD", method).replace("ELBOW", "fixed")
    recorded = RecordedRun(deck(text))
    given = np.interp([0.5, 1.5, 2.5], recorded.time, recorded["energy/given"])
    assert given == pytest.approx(0.5 * 6.5 * (np.array([1.0, 2.0, -0.5]) ** 2 - 1.0), abs=1e-6)  # trapezoidal rule


@pytest.mark.parametrize(("method", "tolerance"), [*zip(METHODS, [1e-3, 1e-6, 1e-5], strict=True)])
def test_the_energy_of_an_arm_on_a_jerked_hub_is_balanced(method, tolerance):
    """Without the work of the impulses the balance would jump by 4.5 J; the steps of 10 ms err by (h w)^2."""
    text = MOTOR.replace("METHOD", method).replace("ELBOW", "hinge, axis: [0, 0, 1]")
    recorded = RecordedRun(deck(text))
    kinetic, given = recorded["energy/kinetic"], recorded["energy/given"]
    assert np.ptp(kinetic) > 4.0
    assert np.ptp(kinetic - given) < tolerance
