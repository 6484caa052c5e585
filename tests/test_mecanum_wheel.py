"""Mecanum and omni wheels: the motion of a platform, and what a wheel resists."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck, input_deck

from mecano.errors import DeckError

TORQUE, RADIUS, MASS, SPIN, ARMS = 2.2, 0.1, 20.0, 0.005, 0.45
CORNERS = "front_left", "front_right", "rear_left", "rear_right"
YAW = 0.8 + 4 * (1.0 * (0.25**2 + 0.2**2) + 0.003)


def test_a_platform_on_mecanum_wheels_drives_to_all_sides(verify):
    """Lagrange's equations of the platform (inputs/mecanum.yaml): ahead, aside and a turn on the spot."""
    exact = np.array([
        TORQUE / RADIUS / (MASS + 4 * SPIN / RADIUS**2) / 2, TORQUE / RADIUS / (MASS + 4 * SPIN / RADIUS**2) / 2,
        TORQUE * ARMS / RADIUS / (YAW + 4 * SPIN * ARMS**2 / RADIUS**2) / 2,
    ])  # fmt: skip
    found = []
    for step in ("10 ms", "5 ms"):
        run = RecordedRun(input_deck("mecanum", f"time.step={step}"))
        left = run["nodes/front_left/position"][-1] - run["nodes/front_right/position"][-1]
        found.append([*run["nodes/platform/position"][-1, :2], np.arctan2(-left[0], left[1])])
        loads = [run[f"elements/{corner}_wheel/normal_force"][run.time > 2.0] for corner in CORNERS]
        # on the spot each wheel carries a quarter, of which a step shares the redundant part to 1e-3 (theory.md)
        np.testing.assert_allclose(loads, MASS * 9.81 / 4, rtol=1e-3)
    what = "platform on Mecanum wheels: displacements [m] and turn [rad]"
    verify.second_order("Wheels", what, *np.array(found), exact, 1e-6, "Lagrange's equations")
    left, right = (run[f"elements/front_{side}_wheel/lateral_force"].ravel() for side in ("left", "right"))
    np.testing.assert_allclose((left + right)[run.time < 1.0], 0.0, atol=1e-7)  # ahead, the rollers push apart


OMNI = """
    mecano: 1
    gravity: none
    nodes: {{carriage: {{position: [0, 0, 0.1]}}, hub: {{position: [0, 0, 0.1]}}}}
    elements:
      rim: {{type: rigid_body, node: hub, mass: 2, inertia: [0.01, 0.02, 0.01]}}
      wheel: {{type: mecanum_wheel, node: hub, radius: 0.1, axis: [0, 1, 0], ground: floor, roller_angle: {angle}}}
    joints:
      level: {{type: held_rotation, nodes: [ground, carriage]}}
      bearing: {{type: hinge, nodes: [carriage, hub], axis: [0, 1, 0]}}
    loads: {{push: {{type: force, node: carriage, direction: [3, 4, 0], value: 5}}}}
    grounds: {{floor: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    time: {{end: 1, step: 10 ms}}
"""


@pytest.mark.parametrize("angle", [90.0, 45.0, -30.0])
def test_a_wheel_resists_along_its_roller_with_the_inertia_of_its_spin(angle):
    """From F = m a + J/r^2 (a.e)/sin(gamma)^2 e, as the spin (u.e)/(r sin(gamma)) follows from the velocity along e."""
    run = RecordedRun(deck(OMNI.format(angle=f"{angle} deg")))
    e, push = np.array([np.sin(np.radians(angle)), np.cos(np.radians(angle))]), np.array([3.0, 4.0])
    heavy = 2.0 * np.eye(2) + 0.02 / 0.1**2 / e[0] ** 2 * np.outer(e, e)
    acceleration = np.linalg.solve(heavy, push)
    np.testing.assert_allclose(run["nodes/hub/velocity"][-1, :2], acceleration, rtol=1e-9)
    resistance = run["elements/wheel/contact_force"][-1, :2]
    np.testing.assert_allclose(resistance, 2.0 * acceleration - push, rtol=1e-6, atol=1e-9)


def test_rollers_along_the_axle_are_refused():
    with pytest.raises(DeckError) as info:
        deck(OMNI.format(angle="2 deg"))
    assert "'roller_angle' must not be near 0 or 180 deg" in info.value.problems[0].message
