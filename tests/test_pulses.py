"""Adaptive steps do not pass over pulses of laws of time, nor over bumps, while nothing else happens."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck

from mecano.deck.build import time_breakpoints, time_landmarks
from mecano.laws.formula import read_formula
from mecano.laws.formula_pulses import pulses
from mecano.laws.law_table import landmarks

MASS = """
    mecano: 1
    gravity: none
    nodes: {m: {position: [0, 0, 0]}}
    elements: {m: {type: point_mass, node: m, mass: 2}}
    signals: {pulse: {type: curve, input: time, law: {bump: {start: 5, length: 10 ms, height: 200}}}}
    loads: {push: {type: force, node: m, direction: [1, 0, 0], value: VALUE}}
    time: {end: 10, step: 1 ms, METHOD, adaptive: {tolerance: 1.0e-4, length_scale: 1}}
"""
BUMP = "{bump: {start: 5, length: 10 ms, height: 200}}"
TABLE = "{table: {points: [[0, 0], [5, 0], [5.005, 200], [5.01, 0], [10, 0]]}}"


@pytest.mark.parametrize("method", ["rho_inf: 0.8", "method: radau"])
@pytest.mark.parametrize("value", [BUMP, TABLE, "pulse"], ids=["bump", "table", "signal"])
def test_a_pulse_of_10_ms_in_10_s_gives_its_impulse(value, method):
    """Its area is 1 N s: half of the height times the length, also of the cubics, whose slopes vanish at its ends."""
    recorded = RecordedRun(deck(MASS.replace("VALUE", value).replace("METHOD", method)))
    assert recorded["nodes/m/velocity"][-1, 0] == pytest.approx(0.5, rel=1e-4)
    assert len(recorded.time) < 400


@pytest.mark.parametrize("method", ["rho_inf: 0.8", "method: radau"])
@pytest.mark.parametrize("gate", ["{type: switch, input: time, upper: 1}", "{type: curve, input: time, law: on}"])
def test_a_wave_that_is_switched_on_acts_although_it_vanishes_at_the_ends_of_long_steps(gate, method):
    """By then steps are 0.1 s, five periods. The mean force is 50 N, for a second."""
    text = f"""
        mecano: 1
        gravity: none
        nodes: {{m: {{position: [0, 0, 0]}}}}
        elements: {{m: {{type: point_mass, node: m, mass: 2}}}}
        signals: {{gate: {gate}}}
        {"laws: {on: {step: {time: 1, rise: 0, from: 0, to: 1}}}" if "law" in gate else ""}
        loads: {{push: {{type: force, node: m, direction: [1, 0, 0], value: 50*gate*(1 - cos(2*pi*50*time))}}}}
        time: {{end: 2, step: 1 ms, {method}, adaptive: {{tolerance: 1.0e-2, length_scale: 1}}}}
    """
    assert RecordedRun(deck(text))["nodes/m/velocity"][-1, 0] == pytest.approx(25.0, rel=1e-2)


@pytest.mark.parametrize("method", ["rho_inf: 0.8", "method: radau"])
@pytest.mark.parametrize(
    "value",
    [
        "1/(0.003*sqrt(pi))*exp(-((time - 3.87654)/0.003)**2)",
        "1/(0.003*sqrt(pi))*exp(-(time - 3.9)*(time - 3.9)/0.000009) + 2*pi*sin(2*pi*time)",
        "200*max(0, 1 - abs(time - 7.01)/0.005)",
        "100*(tanh((time - 5.01)/0.0004) - tanh((time - 5.015)/0.0004))",
    ],
)
def test_a_pulse_of_a_formula_gives_its_impulse(value, method):
    """Its area is 1 N s, and that of the wave beside it zero."""
    recorded = RecordedRun(deck(MASS.replace("VALUE", f'"{value}"').replace("METHOD", method)))
    assert recorded["nodes/m/velocity"][-1, 0] == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize(
    "text", ["sin(time)", "tanh((time - 5)/0.001)", "50*(1 - cos(2*pi*50*time))", "exp(-time)*cos(3*time)", "x*time"]
)
def test_waves_and_edges_are_no_pulses(text):
    assert pulses(read_formula(text).program, 0.0, 10.0) == []


def test_pulses_are_found_between_the_edges_of_a_gate():
    """The two halves of the wave are too short to be sampled; the middle of the gate is its peak."""
    text = "max(0, sin(2*pi*(time - 4)/0.02))*(sign(time - 4) - sign(time - 4.01))"
    assert pulses(read_formula(text).program, 0.0, 10.0) == pytest.approx([4.005], abs=1e-9)


def test_a_foundation_that_jumps_once_shakes_what_it_carries():
    """Base of a slow oscillator, w = 2 rad/s: displaced for 10 ms by 1 m at the most, it gives w^2 0.005 m s."""
    text = """
        mecano: 1
        gravity: none
        nodes: {base: {position: [0, 0, 0]}, m: {position: [0, 0, 1]}}
        elements: {m: {type: rigid_body, node: m, mass: 2, inertia: [1, 1, 1]}}
        joints:
          shaker: {type: prescribed_position, node: base, direction: [1, 0, 0], value: BUMP}
          track: {type: prismatic, nodes: [ground, base], axis: [1, 0, 0]}
          floor: {type: prismatic, nodes: [base, m], axis: [1, 0, 0], sliding_law: {spring: 8}}
        time: {end: 10, step: 1 ms, adaptive: {tolerance: 1.0e-4}}
    """
    recorded = RecordedRun(deck(text.replace("BUMP", BUMP.replace("200", "1"))))
    wanted = 4.0 * 0.005 / 2.0 * np.sin(2.0 * (recorded.time - 5.005)) * (recorded.time > 5.01)
    quiet = np.abs(recorded.time - 5.005) > 0.006
    np.testing.assert_allclose(recorded["nodes/m/position"][quiet, 0], wanted[quiet], atol=2e-4)


PLACES = """
    mecano: 1
    gravity: none
    sections: {wire: {type: circle, diameter: 1 mm, E: 1 MPa, nu: 0.3, density: 2700}}
    nodes: {m: {position: [1, 0, 0]}, n: {position: [0, 1, 0]}, hub: {position: [0, 0, 0.3]}}
    elements:
      m: {type: rigid_body, node: m, mass: 1, inertia: [1, 1, 1]}
      n: {type: rigid_body, node: n, mass: 1, inertia: [1, 1, 1]}
      hub: {type: rigid_body, node: hub, mass: 1, inertia: [1, 1, 1]}
      mount: {type: bushing, nodes: [ground, m], stiffness: [1, 1, 1, 1, 1, 1], natural: {along_1: jolt}}
      wire: {type: beam, nodes: [m, n], section: wire, thermal: {strain: heat}}
      tyre: {type: wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: belt}
    joints:
      drive: {type: generic, nodes: [ground, n], axis: [0, 0, 1], free: [along_2], driven: {along_1: shift}}
    laws:
      jolt: {bump: {start: 1, length: 0.5, height: 0.1}}
      heat: {ramp: {start: 2, end: 3, from: 0, to: 1.0e-3}}
      shift: {step: {time: 4, rise: 0.5, from: 0, to: 0.1}}
      belt: {ramp: {start: 6, end: 8, from: 0, to: 1}}
      grip: {table: {points: [[0, 1], [7, 0.5]]}}
    tire_laws: {rubber: {radius: 0.3, radial: {linear: {slope: 1}}, friction: grip, slip_regularization: 1}}
    grounds: {belt: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}, motion: {direction: [1, 0, 0], speed: belt}}}
    time: {end: 10, step: 1 ms}
"""


def test_laws_of_time_inside_mappings_and_of_grounds_have_corners_and_pulses():
    """A curve of another variable, the friction over the slip speed, has no part in it."""
    checked = deck(PLACES)
    assert time_breakpoints(checked) == (1, 1.5, 2, 3, 4, 4.5, 6, 8)
    assert time_landmarks(checked) == (1.25,)


def test_landmarks_of_a_table_follow_it_within_a_tenth():
    t = np.linspace(0.0, 10.0, 2001)
    y = np.sin(2.0 * math.pi * 0.3 * t)
    law = (("table", {"points": list(zip(t, y, strict=True)), "interpolation": "spline", "beyond": "hold"}),)
    at = np.array(landmarks(law))
    assert np.abs(np.interp(t, at, np.interp(at, t, y)) - y).max() <= 0.1 * np.ptp(y) and len(at) < 20


QUARTER_CAR = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {body: {position: [0, 0, 0.5]}, axle: {position: [0, 0, 0.3]}, hub: {position: [0, 0, 0.3]}}
    elements:
      body: {type: rigid_body, node: body, mass: 300, inertia: [10, 10, 10]}
      axle: {type: rigid_body, node: axle, mass: 20, inertia: [1, 1, 1]}
      rim: {type: rigid_body, node: hub, mass: 10, inertia: [0.4, 0.8, 0.4]}
      tyre: {type: wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}
    joints:
      plane: {type: generic, nodes: [ground, body], axis: [0, 0, 1], axis_1: [1, 0, 0], free: [along_1, along_axis]}
      strut: {type: prismatic, nodes: [body, axle], axis: [0, 0, 1], sliding_law: {spring: 2.0e4, damper: 1500}}
      bearing: {type: hinge, nodes: [axle, hub], axis: [0, 1, 0]}
    tire_laws: {rubber: {radius: 0.3, radial: {linear: {slope: 2.0e5}}, friction: 0.9, slip_regularization: 0.5}}
    grounds:
      road:
        plane: {point: [0, 0, 0], normal: [0, 0, 1]}
        profile: {direction: [1, 0, 0], height: {bump: {start: 6, length: 0.2, height: 1 mm}}}
    initial: {steady: {velocity: [30, 0, 0]}}
    time: {end: 0.4, step: 1 ms, adaptive: {tolerance: 1.0e-4}}
"""


def test_a_wheel_feels_a_bump_that_is_shorter_than_its_steps():
    """At 30 m/s the bump of 0.2 m lasts 6.7 ms, and on the flat road a step could take 19 ms: two masses as linear."""

    def rates(t, y):
        body, axle, v_body, v_axle = y
        s = (30.0 * t - 6.0) / 0.2
        bump = 0.5e-3 * (1.0 - math.cos(2.0 * math.pi * s)) if 0.0 < s < 1.0 else 0.0
        strut = 2.0e4 * (axle - body) + 1500.0 * (v_axle - v_body)
        return v_body, v_axle, strut / 300.0, (2.0e5 * (bump - axle) - strut) / 30.0

    found = solve_ivp(rates, (0.0, 0.4), np.zeros(4), max_step=1e-3, rtol=1e-7, atol=1e-10, dense_output=True)
    recorded = RecordedRun(deck(QUARTER_CAR))
    rise = recorded["nodes/axle/position"][:, 2] - recorded["nodes/axle/position"][0, 2]
    np.testing.assert_allclose(rise, found.sol(recorded.time)[1], atol=5e-6)
    assert np.abs(rise).max() > 1e-4
