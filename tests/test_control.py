"""Signals that drive loads: motions with control against independent integrations and closed forms."""

import numpy as np
import pytest
from marching import March, deck, input_deck
from scipy.integrate import solve_ivp

from mecano.errors import AssemblyError

CONTROL = "Signals and control"
G, I_BAR = 9.81, 1.0 / 12.0


def planar_bars(t, y, K, D):
    """Rates of the angles of both bars from the x axis towards -z, and of their rates, with motors in the hinges."""
    a, b, da, db = y
    first, second = K * (0.5 - a) - D * da, K * (-1.0 - (b - a)) - D * (db - da)
    c, s = np.cos(a - b), np.sin(a - b)
    M = np.array([[I_BAR + 1.25, 0.5 * c], [0.5 * c, I_BAR + 0.25]])
    Q = first - second + 1.5 * G * np.cos(a) - 0.5 * s * db**2, second + 0.5 * G * np.cos(b) + 0.5 * s * da**2
    return [da, db, *np.linalg.solve(M, Q)]


def test_controlled_double_pendulum(verify):
    times = np.linspace(0.2, 2.0, 10)
    options = {"rtol": 1e-12, "atol": 1e-13, "method": "DOP853", "args": (60.0, 8.0)}
    y = solve_ivp(planar_bars, (0.0, 2.0), np.zeros(4), t_eval=times, **options).y
    found, balance = [], []
    for h in (1e-3, 5e-4):
        m = March(input_deck("controlled_double_pendulum", f"time.step={h}"))
        steps = np.searchsorted(m.time, times - 0.5 * h)
        found.append(np.stack([m["joints/shoulder/angle"], m["joints/knee/angle"]])[:, steps])
        balance.append(np.ptp(m["energy/balance"]))
    expected = np.stack([y[0], y[1] - y[0]])
    verify(CONTROL, "double pendulum with motors: angles over 2 s [rad]", found[1], expected, "SciPy", absolute=1e-5)
    assert balance[0] / balance[1] == pytest.approx(4.0, abs=0.1)  # the work is summed by the trapezoidal rule
    assert balance[1] <= 3e-4 * np.abs(m["energy/given"]).max()


def oscillator(t, m=2.0, c=12.0, k=500.0, F=30.0):
    """Displacement of a damped oscillator that a constant force begins to push."""
    decay = 0.5 * c / m
    w = np.sqrt(k / m - decay**2)
    return F / k * (1.0 - np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t)))


def test_controlled_cart(verify):
    found = []
    for h in (2e-3, 1e-3):
        m = March(input_deck("controlled_cart", f"time.step={h}"))
        found.append(m["joints/rail/displacement"][np.searchsorted(m.time, np.arange(0.1, 2.0, 0.1) - 0.5 * h)])
    expected = oscillator(np.arange(0.1, 2.0, 0.1))
    verify.second_order(CONTROL, "cart held by a motor: displacement [m]", *found, expected, 1e-7, "closed form")


LOOP = """
    mecano: 1
    gravity: none
    nodes: {cart: {position: [0, 0, 0]}}
    elements: {body: {type: rigid_body, node: cart, mass: 2, inertia: [1, 1, 1]}}
    joints: {rail: {type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}
    signals: {first: SIGNAL, second: "2 + 0.5*first"}
    loads: {push: {type: joint_force, joint: rail, value: first}}
    time: {end: 0.1, step: 0.01}
    """


def test_signals_may_need_one_another():
    m = March(deck(LOOP.replace("SIGNAL", '"1 + second"')))
    np.testing.assert_allclose(m["signals/first/value"], 6.0, rtol=1e-12)
    np.testing.assert_allclose(m["joints/rail/velocity"], 3.0 * m.time, atol=1e-12)


def test_signals_that_do_not_determine_one_another_are_refused():
    with pytest.raises(AssemblyError, match="first.*not determined: signals need one another in a circle"):
        March(deck(LOOP.replace("SIGNAL", '"2*second"')))
