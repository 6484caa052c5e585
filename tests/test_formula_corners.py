"""Corners of formulas of the time, at which steps end, and smooth steps in motions."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

from mecano.laws.formula import read_formula
from mecano.laws.formula_corners import corners, crossings

CART = """
    mecano: 1
    gravity: none
    nodes: {cart: {position: [0, 0, 0]}}
    elements: {cart: {type: point_mass, node: cart, mass: 2}}
    joints: {rail: {type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}MOVED}
    LOADS
    time: {end: 2, step: 10 ms, METHOD}
"""


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("3*min(time, 0.3) + 2*abs(time - 0.7)", [0.3, 0.7]),
        ("max(0, sin(pi*time))", [1.0]),  # the start and the end are no corners between
        ("sign(time - 0.5)", []),  # a jump, for which there are switches
        ("a*step(time, 0.2, 1.1) - step(3 - 2*time, 0, 1)", [0.2, 1.0, 1.1, 1.5]),
        ("min(a, time)*abs(a)", []),
        ("abs(sin(1000*time))", []),  # an oscillation
        ("step(time, 3, 4) + exp(time)", []),
    ],
)
def test_places(text, wanted):
    np.testing.assert_allclose(corners(read_formula(text).program, 0.0, 2.0), wanted, rtol=4e-16)


def driven(loads="", moved="", method="rho_inf: 0.8"):
    return RecordedRun(deck(CART.replace("LOADS", loads).replace("MOVED", moved).replace("METHOD", method)))


@pytest.mark.parametrize("method", ["rho_inf: 0.8", "method: radau", "adaptive: {tolerance: 1.0e-5}"])
def test_a_force_with_corners_is_that_of_a_law(method):
    """Radau gives its impulse to rounding: the force is linear between the corners, at which steps end."""
    formula, law = '"8*min(max(time - 0.3333, 0), 0.7777)"', "{ramp: {start: 0.3333, end: 1.111, from: 0, to: 6.2216}}"
    runs = [
        driven(f"loads: {{push: {{type: joint_force, joint: rail, value: {f}}}}}", method=method)
        for f in (formula, law)
    ]
    by_formula, by_law = (run["joints/rail/velocity"][-1] for run in runs)
    assert by_formula == pytest.approx(by_law, rel=1e-13) and len(runs[0].time) == len(runs[1].time)
    if method == "method: radau":
        assert by_law == pytest.approx(4.0 * (0.5 * 0.7777**2 + 0.7777 * (2.0 - 1.111)), rel=1e-13)


def test_a_prescribed_step_is_the_step_of_a_law():
    """With the same rates and corners: the same reactions, of which ends of the edge within steps made oscillations."""

    def prescribed(value):
        return driven(moved=f", drive: {{type: prescribed_position, node: cart, direction: [1, 0, 0], value: {value}}}")

    by_law = prescribed("{step: {time: 0.5, rise: 1, from: 0, to: 0.4}}")
    by_formula = prescribed('"0.4*step(time, 0.5, 1.5)"')
    assert np.array_equal(by_law.time, by_formula.time)
    np.testing.assert_allclose(by_formula["joints/drive/force"], by_law["joints/drive/force"], rtol=0.0, atol=1e-8)
    both = prescribed('"0.4*step(time, 0.5, 1.5) - 0.4*step(time, 1.2, 1.8)"')
    u = np.clip([both.time - 0.5, (both.time - 1.2) / 0.6], 0.0, 1.0)
    exact = 0.4 * (u**3 * (10.0 - 15.0 * u + 6.0 * u * u) * [[1.0], [-1.0]]).sum(axis=0)
    np.testing.assert_allclose(both["joints/drive/displacement"], exact, rtol=0.0, atol=1e-12)
    force = 0.8 * (60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) * [[1.0], [-1.0 / 0.36]]).sum(axis=0)
    np.testing.assert_allclose(both["joints/drive/force"], force, rtol=0.0, atol=0.02 * np.abs(force).max())


FIRST = np.arcsin(0.25) / np.pi


@pytest.mark.parametrize(
    ("text", "wanted"), [("3 - 2*time", [0.25, 1.25]), ("2*sin(pi*time)", [FIRST, 1.0 - FIRST]), ("time/9", [])]
)
def test_levels_that_a_formula_of_the_time_crosses(text, wanted):
    """The level 2.5 is beyond them."""
    found = crossings(read_formula(text).program, [2.5, 0.5], 0.0, 2.0)
    np.testing.assert_allclose(found, wanted, rtol=4e-16)


def test_steps_end_where_an_input_passes_a_corner_of_its_curve():
    law = "{table: {points: [[0, 0], [1, 2], [2, 0]], interpolation: linear}}"
    signals = f"signals: {{c: {{type: curve, input: 2.5 - time, law: {law}}}}}"
    run = driven(
        f"{signals}\n    loads: {{push: {{type: joint_force, joint: rail, value: c}}}}", method="method: radau"
    )
    assert all(np.abs(run.time - t).min() < 1e-12 for t in (0.5, 1.5))
    assert run["joints/rail/velocity"][-1] == pytest.approx(0.5 * (1.0 + 0.75), rel=1e-12)
