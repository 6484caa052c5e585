"""Decks of inputs/ against closed forms derived here; tolerances follow from the order: see convergence.py."""

import numpy as np
import pytest
from convergence import check_second_order, pair
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline
from scipy.special import fresnel
from time_runs import RecordedRun, input_deck

TENTHS = np.arange(1, 21) / 10


def free_vibration(t, natural, damping, start, rate):
    """x'' + 2 damping natural x' + natural^2 x = 0 from x = start, x' = rate."""
    decay, frequency = damping * natural, natural * np.sqrt(1.0 - damping**2)
    wave = start * np.cos(frequency * t) + (rate + decay * start) / frequency * np.sin(frequency * t)
    return np.exp(-decay * t) * wave


V, FREE, FORCED = "Closed forms", "free vibration, closed form", "forced vibration, closed form"


def forced_vibration(t, natural, damping, frequency, drive):
    """The same, driven by the real part of drive exp(i frequency t), from rest at x = 0."""
    steady = drive / (natural**2 - frequency**2 + 2j * damping * natural * frequency)
    transient = free_vibration(t, natural, damping, -steady.real, -(1j * frequency * steady).real)
    return (steady * np.exp(1j * frequency * t)).real + transient


def test_oscillator(verify):
    """m = 2 kg, k = 200 N/m, c = 4 N s/m: 10 rad/s, a tenth of critical damping."""
    sag = 2.0 * 9.81 / 200.0
    exact = -0.5 - sag + free_vibration(TENTHS, 10.0, 0.1, sag, 0.0)
    coarse, fine = pair("oscillator", lambda m: m["nodes/weight/position"][:, 2], TENTHS, 2e-3)
    verify.second_order(V, "damped oscillator: height over 2 s [m]", coarse, fine, exact, 2e-9, FREE)


def test_stewart_platform(verify):
    """Legs l = l_0 + 20 mm (1 - cos(2 pi t)) lift 20 kg by z = sqrt(l^2 - d^2); each bears m (g + z'') l / (6 z)."""
    base, top, height, w, A = 0.6, 0.35, 0.7, 2.0 * np.pi, 0.02
    d = np.sqrt(base**2 + top**2 - 2.0 * base * top * np.cos(np.radians(40.0)))
    l = np.hypot(d, height) + A * (1.0 - np.cos(w * TENTHS))  # noqa: E741
    l1, l2 = A * w * np.sin(w * TENTHS), A * w**2 * np.cos(w * TENTHS)
    z = np.sqrt(l**2 - d**2)
    z1 = l * l1 / z
    force = 20.0 * (9.81 + (l1**2 + l * l2 - z1**2) / z) * l / (6.0 * z)
    coarse, fine = pair("stewart", lambda m: m["nodes/plate/position"][:, 2], TENTHS, 4e-3)
    np.testing.assert_allclose(fine, z, rtol=0.0, atol=1e-10)
    of_legs = lambda m: np.array([m[f"joints/leg{k}/force"] for k in range(1, 7)]).T
    to_rounding = "time.newton.force_tolerance=1e-10"  # the default leaves a tenth of the error of the finer steps
    coarse, fine = pair("stewart", of_legs, TENTHS, 4e-3, to_rounding)
    verify.second_order(
        V, "Stewart platform: forces of six legs [N]", coarse, fine, force[:, None], 1.6e-5, "closed form"
    )


def test_base_excitation(verify):
    """Force k u + c u' of the table's motion u = 5 mm sin(4 pi t) on the mass."""
    w, u = 4.0 * np.pi, -1j * 5e-3
    exact = -0.5 + forced_vibration(TENTHS, 10.0, 0.1, w, (100.0 + 2.0j * w) * u)
    coarse, fine = pair("base_excitation", lambda m: m["nodes/weight/position"][:, 2], TENTHS, 2e-3)
    verify.second_order(V, "mass on a shaking table: height [m]", coarse, fine, exact, 1e-9, FORCED)


def test_base_excitation_of_the_table():
    """The table follows the law exactly and does not turn; the joint that moves it feels table, mass and spring."""
    recorded = RecordedRun(input_deck("base_excitation", "time.end=1"))
    law = 5e-3 * np.sin(4 * np.pi * recorded.time)
    np.testing.assert_allclose(recorded["nodes/table/position"][:, 2], law, rtol=0, atol=1e-10)
    assert np.abs(recorded["nodes/table/position"][:, :2]).max() < 1e-12
    np.testing.assert_allclose(recorded["nodes/table/rotation"], [[1, 0, 0, 0]] * len(law), rtol=0, atol=1e-14)
    pull = 20.0 * (9.81 - (4 * np.pi) ** 2 * law) + recorded["elements/isolator/force"]
    size = np.abs(pull).max()
    np.testing.assert_allclose(recorded["joints/shaker/force"], pull, rtol=0, atol=1e-4 * size)
    np.testing.assert_allclose(recorded["joints/upright/moment"], 0.0, rtol=0, atol=1e-9)


def test_torsion_pendulum(verify):
    """J = 0.5 kg m2, c = 20 N m/rad, d = 0.8 N m s/rad; 3 N m by the motor, 2 N m sin(3 pi t) by the shaking."""
    natural, w = np.sqrt(40.0), 3.0 * np.pi
    damping = 0.8 / (2.0 * np.sqrt(20.0 * 0.5))
    exact = 0.15 + free_vibration(TENTHS, natural, damping, -0.15, 0.0)
    exact += forced_vibration(TENTHS, natural, damping, w, -2j / 0.5)
    coarse, fine = pair("torsion_pendulum", lambda m: m["joints/bearing/angle"], TENTHS, 4e-3)
    verify.second_order(V, "driven torsion pendulum: angle [rad]", coarse, fine, exact, 2e-8, FORCED)
    recorded = RecordedRun(input_deck("torsion_pendulum", "time.end=0.5"))
    angle, rate = recorded["joints/bearing/angle"], recorded["joints/bearing/rate"]
    np.testing.assert_allclose(recorded["elements/wire/moment"], 20.0 * angle + 0.8 * rate, rtol=1e-12, atol=1e-12)


def test_slider_crank(verify):
    """Position exact (constraints on positions), velocity of the piston of second order."""
    r, L, w, times = 0.05, 0.15, 50.0, np.arange(1, 31) / 100

    def position(theta):
        return r * np.cos(theta) + np.sqrt(L**2 - (r * np.sin(theta)) ** 2)

    recorded = RecordedRun(input_deck("slider_crank", "time.step=5e-4"))
    x = recorded["nodes/piston/position"]
    exact = position(w * recorded.time)
    verify(V, "slider-crank: place of the piston [m]", x[:, 0], exact, "closed form", absolute=1e-10)
    np.testing.assert_allclose(recorded["joints/bore/displacement"], x[:, 0] - 0.2, rtol=0, atol=1e-12)
    assert np.abs(x[:, 1:]).max() < 1e-11
    swing = -np.arcsin(r / L * np.sin(w * recorded.time))  # of the rod, against the piston
    np.testing.assert_allclose(recorded["joints/piston_joint/angle"], -swing, rtol=0, atol=1e-9)

    theta = w * times
    exact = -r * w * np.sin(theta) * (1.0 + r * np.cos(theta) / np.sqrt(L**2 - (r * np.sin(theta)) ** 2))
    coarse, fine = pair("slider_crank", lambda m: m["joints/bore/velocity"], times, 5e-4)
    verify.second_order(V, "slider-crank: velocity of the piston [m/s]", coarse, fine, exact, 5e-8, "closed form")


def test_conical_pendulum(verify):
    """It circles at constant height; the rod pulls with m g/cos 30 deg."""
    w = np.sqrt(9.81 / np.cos(np.pi / 6))
    exact = np.stack([0.5 * np.cos(w * TENTHS), 0.5 * np.sin(w * TENTHS)], axis=1)
    coarse, fine = pair("spherical_pendulum", lambda m: m["nodes/ball/position"][:, :2], TENTHS, 5e-3)
    verify.second_order(V, "conical pendulum: path [m]", coarse, fine, exact, 1e-8, "uniform circle")
    recorded = RecordedRun(input_deck("spherical_pendulum"))
    assert np.ptp(recorded["nodes/ball/position"][:, 2]) < 1e-6
    pull = 9.81 / np.cos(np.pi / 6)
    verify(V, "conical pendulum: tension [N]", recorded["joints/rod/tension"], pull, "m g/cos 30 deg", relative=1e-5)


def test_thruster(verify):
    """Velocity 0.5 m/s2 times the Fresnel integrals of the angle 0.1 t^2, and 0.05 t along z."""
    times = np.arange(1, 11) / 2
    scale = np.sqrt(np.pi / 0.2)
    sine, cosine = fresnel(times / scale)
    exact = np.stack([0.5 * scale * cosine, 0.5 * scale * sine, 0.05 * times], axis=1)
    coarse, fine = pair("thruster", lambda m: m["nodes/hull/velocity"], times, 0.02)
    verify.second_order(V, "thruster that turns: velocity [m/s]", coarse, fine, exact, 1e-8, "integrals of Fresnel")


def test_what_the_parts_of_the_thruster_feel():
    """The stern transmits the thrust to the hull; the bolts transmit force and torque that accelerate the cargo."""
    recorded = RecordedRun(input_deck("thruster"))
    np.testing.assert_allclose(recorded["elements/stern/force"], -recorded["loads/push/force"], rtol=0, atol=1e-6)
    t = recorded.time[-1]
    along = np.array([np.cos(0.1 * t**2), np.sin(0.1 * t**2), 0.0])
    across = np.array([-along[1], along[0], 0.0])
    acceleration = 0.5 * along + [0, 0, 0.05] + 0.8 * (0.2 * across - (0.2 * t) ** 2 * along)
    np.testing.assert_allclose(recorded["joints/bolts/force"][-1], 2.0 * acceleration, rtol=0, atol=1e-3)
    np.testing.assert_allclose(recorded["joints/bolts/moment"][-1], [0, 0, 0.1 * 0.2 - 0.2], rtol=0, atol=1e-6)
    assert recorded["energy/given"][-1] == pytest.approx(recorded["energy/total"][-1], rel=1e-4)


def test_a_puck_is_pushed_by_a_turning_magnet(verify):
    """A force that turns at 2 rad/s, and the moment of its reaction on the table."""
    times, source = np.arange(1, 11) / 2, "cycloid, the force turning at a constant rate"
    x, y = 0.5 * (1.0 - np.cos(2.0 * times)), 0.5 * (2.0 * times - np.sin(2.0 * times))
    coarse, fine = pair("magnetic_push", lambda m: m["nodes/puck/position"][:, :2], times, 0.02)
    what = "puck pushed by a turning magnet: "
    verify.second_order(V, what + "place [m]", coarse, fine, np.stack([x, y], axis=1), 1e-7, source)
    moment = x * np.sin(2.0 * times) - y * np.cos(2.0 * times)
    coarse, fine = pair("magnetic_push", lambda m: m["joints/motor/moment"], times, 0.02)
    what += "moment of the motor [N m]"
    verify.second_order(V, what, coarse.ravel(), fine.ravel(), moment, 1e-7, source)


def strut_motion(times):
    """Stroke (n,) of the strut at ``times``, and when it is at the stop."""

    def force(s, v):
        oil = 4000.0 if v > 0 else 20000.0
        return 3000.0 * (0.3 / (0.3 - s)) ** 1.3 + oil * v * abs(v) + 2e6 * max(s - 0.17, 0.0)

    found = solve_ivp(
        lambda t, y: [y[1], 9.81 - force(*y) / 500.0], (0.0, times[-1]), [0.0, 2.5],
        rtol=1e-11, atol=1e-13, max_step=1e-3, t_eval=times, events=lambda t, y: y[0] - 0.17,
    )  # fmt: skip
    return found.y[0], found.t_events[0]


def test_strut():
    """The order is kept through the corner of the stop, which is located to the order, too."""
    exact, touches = strut_motion(TENTHS)
    strokes, events, lost = [], [], []
    for h in (1e-3, 5e-4):
        recorded = RecordedRun(input_deck("strut", f"time.step={h}", "time.end=2"))
        stroke = CubicHermiteSpline(recorded.time, recorded["elements/strut/stroke"], -recorded["elements/strut/rate"])
        strokes.append(stroke(TENTHS))
        events.append(np.array([event.t for event in recorded.event_records]))
        assert [event.name for event in recorded.event_records] == ["lower stop closes", "lower stop opens"]
        lost.append(recorded["energy/balance"][-1] - recorded["energy/balance"][0])
    check_second_order(*strokes, exact, 1e-7)
    check_second_order(*events, touches, 3e-7)
    check_second_order(*lost, 0.0, 4e-4)


def test_rest_of_the_strut():
    """It settles where the air carries the weight."""
    recorded = RecordedRun(input_deck("strut", "time.end=10", "time.step=2e-3"))
    rest = 0.3 * (1.0 - (3000.0 / (500.0 * 9.81)) ** (1.0 / 1.3))
    assert recorded["elements/strut/stroke"][-1] == pytest.approx(rest, abs=1e-3)
