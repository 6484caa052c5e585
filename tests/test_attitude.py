"""Attitude of a node: a gimbal whose motors give its angles, and SciPy's angles of its rotation."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, input_deck


@pytest.fixture(scope="module")
def gimbal():
    return RecordedRun(input_deck("gimbal"))


def test_the_attitude_of_a_gimbal_is_that_of_its_motors(gimbal):
    t = gimbal.time
    angles = {"yaw": 6.3 * t, "pitch": 1.2 * np.sin(3.0 * t), "roll": 2.0 * t - np.sin(2.0 * t)}
    rates = {"yaw": 6.3 + 0.0 * t, "pitch": 3.6 * np.cos(3.0 * t), "roll": 2.0 - 2.0 * np.cos(2.0 * t)}
    for sensor in ("gyro", "at_nose"):
        for name in angles:
            np.testing.assert_allclose(gimbal[f"elements/{sensor}/{name}"], angles[name], atol=1e-9)
            rate = gimbal[f"elements/{sensor}/{name}_rate"]
            np.testing.assert_allclose(rate, rates[name], atol=3e-4)  # the velocities of the run: 1.3e-4
    assert angles["yaw"][-1] > 4.0 * np.pi and np.ptp(gimbal["elements/gyro/yaw"]) > 4.0 * np.pi


def test_its_angles_are_those_of_the_rotation_by_scipy(gimbal):
    w, x, y, z = gimbal["nodes/inner/rotation"].T
    found = np.stack([gimbal[f"elements/gyro/{name}"] for name in ("yaw", "pitch", "roll")], axis=1)
    apart = Rotation.from_euler("ZYX", found) * Rotation.from_quat(np.stack([x, y, z, w], axis=1)).inv()
    np.testing.assert_allclose(apart.magnitude(), 0.0, atol=1e-12)


def test_the_rates_are_those_of_the_angular_velocity(gimbal):
    """The inverse of the equations of the element, by the angles."""
    theta, phi, yaw, pitch, roll, omega = (
        gimbal[f"elements/gyro/{name}"]
        for name in ("pitch", "roll", "yaw_rate", "pitch_rate", "roll_rate", "angular_velocity")
    )
    p, across = roll - yaw * np.sin(theta), yaw * np.cos(theta)
    q, r = pitch * np.cos(phi) + across * np.sin(phi), across * np.cos(phi) - pitch * np.sin(phi)
    np.testing.assert_allclose(np.stack([p, q, r], axis=1), omega, atol=1e-11)


def test_the_velocity_of_a_point_of_the_body_in_its_axes(gimbal):
    """omega x (0.3, 0, 0)."""
    p, q, r = gimbal["elements/at_nose/angular_velocity"].T
    expected = np.stack([0.0 * p, 0.3 * r, -0.3 * q], axis=1)
    np.testing.assert_allclose(gimbal["elements/at_nose/velocity"], expected, atol=1e-4)  # of the run: 5.6e-5
    assert np.abs(expected).max() > 1.0


def test_signals_read_the_attitude_over_whole_turns(gimbal):
    np.testing.assert_allclose(gimbal["signals/heading/value"], 0.0, atol=1e-9)
