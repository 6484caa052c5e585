"""Adaptive steps do not pass over a pulse of a law of time while nothing else happens."""

import math

import numpy as np
import pytest
from time_runs import RecordedRun, deck

from mecano.laws.table import landmarks

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


def test_landmarks_of_a_table_follow_it_within_a_tenth():
    t = np.linspace(0.0, 10.0, 2001)
    y = np.sin(2.0 * math.pi * 0.3 * t)
    law = (("table", {"points": list(zip(t, y, strict=True)), "interpolation": "spline", "beyond": "hold"}),)
    at = np.array(landmarks(law))
    assert np.abs(np.interp(t, at, np.interp(at, t, y)) - y).max() <= 0.1 * np.ptp(y) and len(at) < 20
