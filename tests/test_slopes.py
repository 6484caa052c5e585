"""Slopes of curves, and other outputs of signals, in formulas."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

from mecano.analyses.prepare import prepare
from mecano.errors import DeckError
from mecano.model.signal_units import signal_units

HEAD = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}}
    elements: {body: {type: point_mass, node: a, mass: 2}}
    time: {end: 1, step: 0.1}
    """
TABLE = "{table: {points: [[0, 0], [0.3333, 2], [0.7777, -1], [2, 0]], interpolation: linear}}"


def with_force(signals, value):
    """Return the deck of a mass on which a force of this ``value`` acts."""
    loads = f"loads: {{push: {{type: force, node: a, direction: [1, 0, 0], value: {value}}}}}"
    return deck(f"{HEAD}signals: {signals}\n    {loads}\n")


def test_the_impulse_of_a_slope_is_the_difference_of_values():
    """Also of one that jumps, as at the corners of a table of lines, where steps end."""
    run = RecordedRun(with_force(f"{{path: {{type: curve, input: time, law: {TABLE}}}}}", "3*path.slope"))
    np.testing.assert_allclose(2.0 * run["nodes/a/velocity"][:, 0], 3.0 * run["signals/path/value"], atol=1e-14)


def test_slopes_are_relative_to_the_input():
    """That of 1 + 3 u^2 with a smooth step u(t), and the product with the rate of u: closed forms of both."""
    signals = """{
        u: {type: curve, input: time, law: {step: {time: 0.1, rise: 0.5, from: 0, to: 3}}, unit: deg},
        square: {type: curve, input: u, law: {polynomial: {coefficients: [1, 0, 3]}}, unit: m},
        rate: square.slope*signals.u.slope}"""
    found = with_force(signals, "rate")
    run = RecordedRun(found)
    s = np.clip((run.time - 0.1) / 0.5, 0.0, 1.0)
    u, u_t = 3.0 * s**3 * (10.0 - 15.0 * s + 6.0 * s**2), 180.0 * s**2 * (1.0 - s) ** 2
    np.testing.assert_allclose(run["signals/u/slope"], u_t, atol=1e-13)
    np.testing.assert_allclose(run["signals/square/slope"], 6.0 * u, atol=1e-12)
    np.testing.assert_allclose(run["signals/rate/value"], 6.0 * u * u_t, atol=1e-11)
    units = signal_units(prepare(found).system.model)
    assert [units[f"signals/{name}"] for name in ("u/slope", "square/slope", "rate/value")] == ["rad/s", "m/rad", "m/s"]


def test_the_slope_of_a_road_at_a_constant_speed_is_per_metre():
    """Although steps end at the corners of a curve of a line of the time whose slope nobody reads."""
    road = "{road: {type: curve, input: 20*time - 3, law: {linear: {slope: 0.05}}}}"
    run = RecordedRun(with_force(road, "road.slope"))
    np.testing.assert_allclose(run["signals/road/slope"], 0.05, rtol=1e-15)


def test_states_of_filters_can_be_read():
    """The second state of a chain of two integrators of 1 is its rate t, and the state of a washout lags behind."""
    signals = """{
        chain: {type: transfer_function, input: "1 + 0*time", numerator: [1], denominator: [0, 0, 1]},
        rate: chain.state_2, error: "sin(5*time)",
        high: {type: washout, input: error, time_constant: 0.2},
        low: high.state, sum: high + high.state}"""
    run = RecordedRun(with_force(signals, "rate"))
    np.testing.assert_allclose(run["signals/rate/value"], run.time, atol=1e-12)
    np.testing.assert_allclose(run["signals/low/value"], run["signals/high/state"], atol=1e-14)
    np.testing.assert_allclose(run["signals/sum/value"], run["signals/error/value"], atol=1e-12)


SET_POINT = """
    joints: {rail: {type: prismatic, nodes: [ground, a], axis: [1, 0, 0], sliding_law: {spring: 10}, FIELD}}
    signals: {path: {type: curve, input: time, law: LAW}}
    """
SMOOTH = "{step: {time: 0.1, rise: 0.5, from: 0, to: 3}}"


@pytest.mark.parametrize(
    ("law", "field", "said"),
    [
        (TABLE, "natural_displacement: path.slope", "a set point must not jump, as the curve 'path.slope' does"),
        (SMOOTH, "natural_displacement: path.value", "the value of a signal is written as its name alone"),
        (SMOOTH, "natural_displacement: path.slop", "did you mean 'slope'?"),
        (SMOOTH, "natural_displacement: path.slope", ""),
        (TABLE, "natural_displacement: path", ""),
    ],
)
def test_outputs_of_signals_as_set_points(law, field, said):
    text = HEAD + SET_POINT.replace("LAW", law).replace("FIELD", field)
    if not said:
        deck(text)
        return
    with pytest.raises(DeckError) as error:
        deck(text)
    assert said in " ".join(str(problem) for problem in error.value.problems)


def test_a_prescribed_motion_is_no_slope():
    driven = "joints: {drive: {type: prescribed_position, node: a, direction: [1, 0, 0], value: path.slope}}"
    signals = f"signals: {{path: {{type: curve, input: time, law: {SMOOTH}}}}}"
    with pytest.raises(DeckError) as error:
        deck(f"{HEAD}{driven}\n    {signals}\n")
    assert "'path.slope' is the output of a signal" in str(error.value.problems[0])
