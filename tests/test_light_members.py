"""Heavy bodies with members that are much lighter: modes nine orders of magnitude below others, motion beside them."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck

from mecano.analyses.modal import modes

EI, LENGTH, MASS = np.array([50.0, 100.0]), 2.0, 2.0  # N m2, m, kg

BOOM = """
    mecano: 1
    gravity: none
    parameters: {tension: 0, inertia: 1.0e-9}
    sections:
      light: {type: stiffness, EA: 1.0e9, GA2: 1.0e9, GA3: 1.0e9, GJ: 1.0e3, EI2: 100, EI3: 50, mass_per_length: 1.0e-6,
              rotary_inertia: [2.0e-9, 1.0e-9, 1.0e-9]}
    nodes: {root: {position: [0, 0, 0]}, tip: {position: [2, 0, 0]}}
    elements:
      boom: {type: beam, nodes: [root, tip], section: light, up: [0, 0, 1], mesh: 12}
      body: {type: rigid_body, node: tip, mass: 2, inertia: [$inertia, $inertia, $inertia]}
      other: {type: rigid_body, node: root, mass: 2, inertia: [$inertia, $inertia, $inertia]}
    joints: {clamp: {type: fixed, nodes: [ground, root]}}
    loads: {pull: {type: force, node: tip, direction: [1, 0, 0], value: $tension}}
    initial: static
    time: {end: 1, step: 1 ms}
"""


def stiffness(tension):
    """Lateral stiffness (2,) [N/m] of the tip of a cantilever under a tension along its first direction."""
    if tension == 0.0:
        return 3.0 * EI / LENGTH**3
    a = np.sqrt(tension / EI)
    return tension / (LENGTH - np.tanh(a * LENGTH) / a)


@pytest.mark.parametrize("tension", [0.0, 500.0])
def test_a_heavy_tip_on_a_light_boom(verify, tension):
    _, found, _ = modes(deck(BOOM.replace("tension: 0", f"tension: {tension}")), None, number=3)
    assert found.converged.all()
    exact = [*np.sqrt(stiffness(tension) / MASS), math.sqrt(1e9 / LENGTH / MASS)]
    what = f"heavy tip on a light boom, tension {tension:g} N: three circular frequencies [1/s]"
    verify("Modes", what, np.abs(found.values), exact, "beam under tension, closed form", relative=1e-5)


def test_two_heavy_bodies_on_a_light_boom_in_space(verify):
    """They turn against one another at both ends: J s^2 + 2 EI/L = 0; the six free motions disturb nothing."""
    free = BOOM.replace("inertia: 1.0e-9", "inertia: 0.5").replace("joints:", "# ").replace("initial: static", "")
    _, found, _ = modes(deck(free), None, number=12)
    assert found.converged.all() and found.kinds[:6] == ["free"] * 6
    exact = np.sqrt(2.0 * EI / LENGTH / 0.5)
    nearest = [np.abs(np.abs(found.values) - one).min() + one for one in exact]
    what = "two heavy bodies on a light boom in space: circular frequencies of bending [1/s]"
    verify("Modes", what, nearest, exact, "J s^2 + 2 EI/L = 0", relative=1e-5)


def test_a_light_boom_with_damping(verify):
    """Its own rates of decay are 1e13 times those of the tip; its damping c gives the ratio c omega/2."""
    damped = BOOM.replace("mass_per_length", "damping: 1.0e-3, mass_per_length")
    _, found, _ = modes(deck(damped), None, number=4)
    assert found.converged.all() and found.kinds[:2] == ["oscillation"] * 2
    omega = np.sqrt(stiffness(0.0) / MASS)
    exact = [*omega, *(0.5e-3 * omega)]
    what = "heavy tip on a damped light boom: natural circular frequencies [1/s], damping ratios"
    got = [*np.abs(found.values[:2]), *found.damping_ratio[:2]]
    verify("Modes", what, got, exact, "c omega/2", relative=1e-5)


PENDULUM = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      upper: {{position: [0, 0, 0]}}
      joint: {{position: [0.1, 0, 0]}}
      lower: {{position: [0.1, 0, 0]}}
      heavy: {{position: [5, 0, 0]}}
    elements:
      upper: {{type: rigid_body, node: upper, mass: 0.002, center_of_mass: [0.05, 0, 0], inertia: [1e-7, 2e-6, 2e-6],
               attached: [joint]}}
      lower: {{type: rigid_body, node: lower, mass: 0.001, center_of_mass: [0.05, 0, 0], inertia: [1e-7, 1e-6, 1e-6]}}
      heavy: {{type: rigid_body, node: heavy, mass: {mass}, inertia: [1, 1, 1]}}
    joints:
      shoulder: {{type: hinge, nodes: [ground, upper], axis: [0, 1, 0]}}
      elbow: {{type: hinge, nodes: [joint, lower], axis: [0, 1, 0]}}
      guide: {{type: prismatic, nodes: [ground, heavy], axis: [0, 0, 1], sliding_law: {{spring: {stiffness}}}}}
    time: {{end: 0.4, step: {step}}}
"""


def double_pendulum(end):
    """Height of the elbow at the end, from Lagrange's equations in the angles of both bodies below the horizontal."""
    length, arm, first, second = 0.1, 0.05, 2e-6 + 0.002 * 0.05**2 + 0.001 * 0.1**2, 1e-6 + 0.001 * 0.05**2

    def rates(_, y):
        (a, b), (da, db), g, m = y[:2], y[2:], 9.81, 0.001
        c, s = m * length * arm * np.cos(a - b), m * length * arm * np.sin(a - b)
        right = [g * (0.002 * 0.05 + m * length) * np.cos(a) - s * db**2, g * m * arm * np.cos(b) + s * da**2]
        return [da, db, *np.linalg.solve([[first, c], [c, second]], right)]

    return -length * np.sin(solve_ivp(rates, (0, end), [0.0] * 4, rtol=1e-10, atol=1e-12).y[0, -1])


@pytest.mark.parametrize("mass", [1e-3, 1e3, 1e6])
def test_a_light_mechanism_beside_a_heavy_body(mass):
    """The error is that of the steps, of second order, whatever else the model contains."""
    errors = []
    for step in (1e-3, 5e-4):
        run = RecordedRun(deck(PENDULUM.format(mass=mass, stiffness=1e3 * mass, step=step)))
        errors.append(abs(run["nodes/joint/position"][-1, 2] - double_pendulum(0.4)))
    assert errors[0] < 2e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.2)
