"""Attitude of a node: a gimbal whose motors give its angles, and SciPy's angles of its rotation."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck, input_deck


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


def test_the_acceleration_of_a_point_of_the_body(gimbal):
    """Second differences of its place by the angles of the motors; the specific force is the same in its axes."""
    h, t = 1e-4, gimbal.time[1:]

    def place(t):
        angles = np.stack([6.3 * t, 1.2 * np.sin(3.0 * t), 2.0 * t - np.sin(2.0 * t)], axis=1)
        return Rotation.from_euler("ZYX", angles).apply([0.3, 0.0, 0.0])

    expected = (place(t + h) - 2.0 * place(t) + place(t - h)) / h**2
    found = gimbal["elements/at_nose/acceleration"][1:]
    np.testing.assert_allclose(found, expected, atol=2e-4 * np.abs(expected).max())  # at the start 1.4e-4
    w, x, y, z = gimbal["nodes/nose/rotation"][1:].T
    in_axes = Rotation.from_quat(np.stack([x, y, z, w], axis=1)).apply(found, inverse=True)
    np.testing.assert_allclose(gimbal["elements/at_nose/specific_force"][1:], in_axes, atol=1e-10)


def test_an_accelerometer_at_rest_measures_the_force_that_carries_it():
    """9.81 m/s2 upwards: in its axes, pitched down by 30 degrees, half of it along -x and the rest along z."""
    at_rest = deck("""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {a: {position: [0, 0, 0], orientation: [0, 30 deg, 0]}}
        elements:
          a: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}
          sensor: {type: attitude, node: a}
        joints: {h: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}}
        time: {end: 0.02, step: 0.01}
        """)
    found = RecordedRun(at_rest)["elements/sensor/specific_force"]
    np.testing.assert_allclose(found, np.tile([-0.5 * 9.81, 0.0, np.sqrt(0.75) * 9.81], (len(found), 1)), atol=1e-9)


def test_signals_read_the_attitude_over_whole_turns(gimbal):
    np.testing.assert_allclose(gimbal["signals/heading/value"], 0.0, atol=1e-9)


def test_a_small_difference_in_small_units_is_known_to_rounding():
    """A heading that follows its drive, in nrad: the rounding of 12.6 rad is far above 1e-8 of the signal."""
    run = RecordedRun(input_deck("gimbal", "signals.heading.value=1.0e9*(gyro.yaw - 6.3*time)"))
    assert not run.integrator.cuts
    np.testing.assert_allclose(run["signals/heading/value"], 0.0, rtol=0, atol=16 * 2.2e-16 * 12.6e9)


def turning(_, y):
    """Rates of the quaternion, the angular velocity and those of the wheels of the satellite with reaction wheels."""
    q, w, wheels = np.split(y, [4, 7])
    R = Rotation.from_quat(q).as_matrix()
    error = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    torque = 0.6 * error + 4.0 * w
    momentum = (np.array([12.0, 15.0, 9.0]) + 0.04) * w + 0.02 * wheels
    faster = (-np.cross(w, momentum) - torque) / (np.array([12.0, 15.0, 9.0]) + 0.02)
    return [*0.5 * (q[3] * w + np.cross(q[:3], w)), -0.5 * q[:3] @ w, *faster, *(torque / 0.02 - faster)]


def test_a_satellite_turns_to_the_inertial_axes(verify):
    """By the directions of its axes, although its pitch comes near -90 degrees, where yaw and roll are not unique."""
    start = [*Rotation.from_rotvec([1.511, -1.511, 1.511]).as_quat(), *np.zeros(6)]
    known = solve_ivp(turning, (0.0, 60.0), start, "DOP853", [20.0, 60.0], rtol=1e-11, atol=1e-12).y
    found = []
    for h in (0.04, 0.02):
        run = RecordedRun(input_deck("satellite_slew", f"time.step={h}"))
        wheels = [run[f"joints/satellite_bearing_{c}/rate"] for c in "xyz"]
        rates = np.column_stack([run["elements/satellite_gyro/angular_velocity"], *wheels])
        found.append(rates[[round(20.0 / h), -1]].T)
    assert run["elements/satellite_gyro/pitch"].min() < -1.5
    assert np.abs(rates[:, 3:]).max() == pytest.approx(59.35, abs=0.005)  # that of the deck
    w, x, y, z = run["nodes/satellite_bus/rotation"].T
    axes = np.stack([run[f"elements/satellite_gyro/{c}_axis"] for c in "xyz"], axis=2)
    matrices = Rotation.from_quat(np.stack([x, y, z, w], axis=1)).as_matrix()
    np.testing.assert_allclose(axes, matrices, atol=1e-12)
    what = "reaction wheels: rates of the satellite and its wheels after 20 s and 60 s [rad/s]"
    verify.second_order("Signals and control", what, *found, known[4:], 1e-3, "Euler's equations, SciPy")
