"""Delays: how exactly they interpolate their inputs, however long; their memory; the warnings about both."""

import math

import numpy as np
import pytest
from surviving import check_same, contents, resumed
from time_runs import RecordedRun, deck

from mecano.analyses.dynamic import run

OMEGA = 20.0 * np.pi  # rad/s
OSCILLATOR = f"""
    mecano: 1
    gravity: none
    nodes: {{m: {{position: [0, 0, 0]}}}}
    elements: {{m: {{type: point_mass, node: m, mass: 1}}}}
    joints:
      rail: {{type: prismatic, nodes: [ground, m], axis: [1, 0, 0], sliding_law: {{spring: {OMEGA**2!r}}}}}
    signals: {{late: {{type: delay, input: INPUT, time: DELAY}}}}
    initial: {{velocities: [{{nodes: [m], velocity: [{OMEGA!r}, 0, 0]}}]}}
    time: {{end: END, step: STEP}}
    output: {{every: step}}
"""


def oscillator(late, step, end, what="rail.displacement"):
    """Return the deck of an oscillator, sin(OMEGA t), with a delay."""
    text = OSCILLATOR.replace("INPUT", what).replace("DELAY", repr(late)).replace("END", repr(end))
    return deck(text.replace("STEP", step))


def error_of_wave(late, step, end):
    """Return the largest error of a delayed sine at the ends of all steps."""
    m = RecordedRun(oscillator(late, repr(step), end, f"sin({OMEGA!r}*time)"))
    wanted = np.where(m.time > late, np.sin(OMEGA * (m.time - late)), 0.0)
    return np.abs(m["signals/late/value"] - wanted).max()


def test_a_delay_of_twenty_periods(verify):
    """The remainder of polynomials through six values is 225/46080 (OMEGA h)^6 in their middle."""
    errors = []
    for number in (20, 40, 80):
        step = 0.1 / number
        errors.append(error_of_wave(2.0 + 0.5 * step, step, 4.0))
        assert errors[-1] < 3.0 * 225.0 / 46080.0 * (OMEGA * step) ** 6 + 1e-12  # some are not in the middle
    verify(
        "Control of mechanisms", "delay of 20 periods, 20, 40 and 80 steps a period: largest error of a sine", errors,
        [0.0] * 3, "closed form", absolute=1e-5,
    )  # fmt: skip


def test_a_delay_of_many_more_steps_than_are_kept():
    """Of 12000 steps, those apart by 6 steps, or one more, are kept: 14 values a period."""
    assert error_of_wave(12.0005, 1e-3, 14.0) < 3.0 * 225.0 / 46080.0 * (OMEGA * 7e-3) ** 6


def test_a_delay_is_as_accurate_as_adaptive_steps():
    """Of the displacement, which has the errors of its integration."""
    step = "1 ms, method: radau, adaptive: {tolerance: 1.0e-7, length_scale: 1}"
    m = RecordedRun(oscillator(0.7531, step, 2.0))
    late = m["signals/late/value"] - np.where(m.time > 0.7531, np.sin(OMEGA * (m.time - 0.7531)), 0.0)
    now = m["joints/rail/displacement"] - np.sin(OMEGA * m.time)
    assert np.abs(late).max() < 3.0 * np.abs(now).max() < 1e-6
    assert np.abs(m.time - 0.7531).min() == 0.0  # where the value begins to change


@pytest.mark.parametrize("method, error", [("radau", 1e-6), ("generalized_alpha", 1e-4)])
def test_a_delay_knows_the_past_of_long_steps(method, error):
    """x' = -15 x(t - 0.1), x = 1 up to the start: the sum of its method of steps; at first x is a straight line."""
    m = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{m: {{position: [0, 0, 0]}}}}
        elements: {{m: {{type: point_mass, node: m, mass: 1}}}}
        signals:
          x: {{type: integrator, input: -15*late, initial: 1}}
          late: {{type: delay, input: x, time: 0.1}}
        time: {{end: 1.4, step: 1 ms, method: {method}, adaptive: {{tolerance: 1.0e-5, length_scale: 1}}}}
        output: {{every: step}}
    """)
    )
    wanted = 1.0 + sum(
        (-15.0 * np.maximum(m.time - 0.1 * (n - 1), 0.0)) ** n / math.factorial(n) for n in range(1, 16)
    )  # fmt: skip
    np.testing.assert_allclose(m["signals/x/value"], wanted, atol=error)


@pytest.mark.parametrize("step", ["1 ms", "1 ms, adaptive: {tolerance: 1.0e-4, length_scale: 1}"])
def test_a_resumed_delay_has_the_same_bits(step, tmp_path):
    late = oscillator(0.0123, step, 0.2)
    run(late, tmp_path / "whole.h5")
    resumed(late, tmp_path / "resumed.h5", (31, 47, 3))
    check_same(contents(tmp_path / "resumed.h5"), contents(tmp_path / "whole.h5"))


def last_velocity(signals, time):
    """Return the velocity [m/s] at the end of a mass of 1 kg on which one of the ``signals``, ``late`` [N], acts."""
    m = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{m: {{position: [0, 0, 0]}}}}
        elements: {{m: {{type: point_mass, node: m, mass: 1}}}}
        signals: {{{signals}}}
        loads: {{push: {{type: force, node: m, direction: [1, 0, 0], value: late}}}}
        time: {{{time}}}
    """)
    )
    return m["nodes/m/velocity"][-1, 0]


@pytest.mark.parametrize("start", [-5.0, 1000.0])
def test_a_jump_arrives_at_any_time(start):
    """A force of 2 N on 1 kg from 0.1 s to 0.3 s after the start, 70 ms late; steps end where it begins and ends."""
    on = f"on: {{type: switch, input: abs(time - {start + 0.2!r}), upper: 0.1, high: 0, low: 2}}"
    found = last_velocity(
        f"{on}, late: {{type: delay, input: on, time: 70 ms}}", f"start: {start}, end: {start + 1.0}, step: 11 ms"
    )
    assert found == pytest.approx(0.4, abs=1e-8)


@pytest.mark.parametrize("late", ["delay, time: 70 ms", "sample_and_hold, period: 70 ms"])
def test_the_past_of_a_switch_is_that_of_the_start(late):
    """It is on at the start, and off from 1 s on: a force of -3 N on 1 kg in all of the first second, late or not."""
    on = "on: {type: switch, input: 1 - time, upper: 0, high: -3, low: 100}"
    found = last_velocity(f"{on}, late: {{type: {late}, input: on}}", "end: 1, step: 10 ms")
    assert found == pytest.approx(-3.0, abs=1e-9)


def texts(checked):
    return [f"{problem.mark}: {problem.message}" for problem in checked.warnings]


def test_very_long_delays_are_reported():
    (text,) = texts(oscillator(60.0, "1 ms", 100.0))
    assert text.startswith("test.yaml:8:63: delay 'late': 'time' has 60000 steps; values every 0.0293 s are kept")
    assert not texts(oscillator(4.0, "1 ms", 100.0))


@pytest.mark.parametrize("of_time", ["sin(4*time)", "wave"])
def test_inputs_that_adaptive_steps_do_not_resolve_are_reported(of_time):
    text = OSCILLATOR.replace("{late", "{wave: 2*sin(4*time), late").replace("INPUT", of_time).replace("END", "5")
    (text,) = texts(deck(text.replace("DELAY", "2").replace("STEP", "1 ms, adaptive: {tolerance: 1.0e-4}")))
    assert "its input depends on the time alone" in text and "'time - 2'" in text
    assert not texts(oscillator(2.0, "1 ms, adaptive: {tolerance: 1.0e-4}", 5.0))
