"""Stability and loop transfer of several sampled signals, against their difference equations."""

import numpy as np
import pytest
from scipy.signal import cont2discrete
from time_runs import deck

from mecano.analyses.control_stability import instability_warnings
from mecano.analyses.dynamic import run
from mecano.analyses.margins import LoopRequest, margins
from mecano.analyses.prepare import integrator_of, prepare
from mecano.deck.sample_decks import starter
from mecano.errors import ConvergenceError

M, K, C = np.diag([2.0, 3.0]), np.array([[80.0, -30.0], [-30.0, 30.0]]), np.array([[5.0, -2.0], [-2.0, 2.0]])
GAINS = np.array([[40.0, 0.0, 15.0, 0.0], [0.0, 60.0, 0.0, 20.0]])  # of displacements, then velocities


def two_carts(periods=(0.05, 0.05), gain=1.0):
    """Two carts in a row, each with its sampled controller."""
    laws = [f"{gain}*({-p}*rail_{i}.displacement - {d}*rail_{i}.velocity)" for i, p, d in ((1, 40, 15), (2, 60, 20))]
    return f"""
mecano: 1
gravity: none
nodes:
  wall: {{position: [-1, 0, 0], fixed: true}}
  cart_1: {{position: [0, 0, 0]}}
  cart_2: {{position: [1, 0, 0]}}
elements:
  mass_1: {{type: point_mass, node: cart_1, mass: 2}}
  mass_2: {{type: point_mass, node: cart_2, mass: 3}}
  spring_1: {{type: spring_damper, nodes: [wall, cart_1], law: {{spring: 50, damper: 3}}}}
  spring_2: {{type: spring_damper, nodes: [cart_1, cart_2], law: {{spring: 30, damper: 2}}}}
joints:
  rail_1: {{type: prismatic, nodes: [ground, cart_1], axis: [1, 0, 0]}}
  rail_2: {{type: prismatic, nodes: [ground, cart_2], axis: [1, 0, 0]}}
signals:
  held_1: {{type: sample_and_hold, input: "{laws[0]}", period: {periods[0]!r}}}
  held_2: {{type: sample_and_hold, input: "{laws[1]}", period: {periods[1]!r}}}
loads:
  motor_1: {{type: joint_force, joint: rail_1, value: held_1}}
  motor_2: {{type: joint_force, joint: rail_2, value: held_2}}
time: {{end: 1, step: 1.0e-3}}
"""


def difference_equations(h):
    """Return A (4, 4), B (4, 2) of the carts with forces that are constant over ``h``."""
    inverse, none = np.linalg.inv(M), np.zeros((2, 2))
    A, B = np.block([[none, np.eye(2)], [-inverse @ K, -inverse @ C]]), np.vstack([none, inverse])
    return cont2discrete((A, B, np.eye(4), np.zeros((4, 2))), h)[:2]


def loop(model, signal="held_1"):
    return margins(deck(model), None, LoopRequest(signal=signal, low=0.1, high=9.9))[1]


@pytest.mark.parametrize("opened", [0, 1])
def test_two_samplers_of_one_period(opened):
    """L has the other sampler closed: opened at one, u = e v - (I - e e^T) G x of the equations by SciPy."""
    found = loop(two_carts(), f"held_{opened + 1}")
    A, B = difference_equations(0.05)
    other = 1 - opened
    Phi = A - B[:, [other]] @ GAINS[[other]]
    z = np.exp(2j * np.pi * 0.05 * found.frequency)[:, None, None]
    x = np.linalg.solve(z * np.eye(4) - Phi, np.broadcast_to(B[:, [opened]], (len(z), 4, 1)))
    assert np.abs(found.values / (GAINS[opened] @ x)[:, 0] - 1.0).max() < 1e-9
    assert found.growing == 0 and not found.warnings
    limit = found.gain
    values = np.linalg.eigvals(Phi - limit.value * B[:, [opened]] @ GAINS[[opened]])
    assert np.abs(values - np.exp(2j * np.pi * 0.05 * limit.frequency)).min() < 1e-6


@pytest.mark.parametrize("signal", ["held_1", "held_2", "motor_2.value"])
@pytest.mark.parametrize("gain", [3.0, 5.5, 12.0])
def test_growing_poles_of_two_samplers(signal, gain):
    A, B = difference_equations(0.05)
    growing = np.sum(np.abs(np.linalg.eigvals(A - gain * B @ GAINS)) > 1.0)
    assert growing == {3.0: 0, 5.5: 1, 12.0: 2}[gain]
    assert loop(two_carts(gain=gain), signal).growing == growing


@pytest.mark.parametrize("gain", [1.0, 4.0, 8.0])
def test_samplers_of_different_periods(gain):
    """Over 0.1 s, the first one samples five times, the second one twice: a chain of intervals of SciPy's equations."""
    times = sorted({round(0.02 * i, 9) for i in range(5)} | {0.0, 0.05})
    found = np.eye(6)
    for t, end in zip(times, [*times[1:], 0.1], strict=True):
        sample, flow = np.eye(6), np.eye(6)
        for k, period in enumerate((0.02, 0.05)):
            if abs(t / period - round(t / period)) < 1e-9:
                sample[4 + k] = [*-gain * GAINS[k], 0.0, 0.0]
        flow[:4, :4], flow[:4, 4:] = difference_equations(end - t)
        found = flow @ sample @ found
    growing = np.sum(np.abs(np.linalg.eigvals(found)) > 1.0)
    assert growing == {1.0: 0, 4.0: 0, 8.0: 1}[gain]
    opened = loop(two_carts((0.02, 0.05), gain), "motor_1.value")
    assert opened.growing == growing
    assert len([text for text in opened.warnings if "is sampled: the loop is that of its mean" in text]) == 2


def test_periods_without_common_multiple_leave_stability_open():
    found = loop(two_carts((0.02, 0.0314159265)), "motor_1.value")
    assert found.growing is None
    message = "the sampling periods 0.02 s, 0.0314159 s have no common multiple within 1000 samples"
    assert [text for text in found.warnings if message in text]


@pytest.mark.parametrize(("share", "grows"), [(1.9, False), (2.2, True)])
def test_a_run_warns_of_samples_that_make_a_mechanism_unstable(share, grows):
    """Rates of two wheels fed back every period T: each has the pole z = 1 - k T/J, beyond -1 for k T/J > 2."""
    text = f"""
mecano: 1
gravity: none
nodes: {{one: {{position: [0, 0, 0]}}, two: {{position: [1, 0, 0]}}}}
elements:
  wheel_one: {{type: rigid_body, node: one, mass: 1, inertia: [0.4, 0.4, 0.4]}}
  wheel_two: {{type: rigid_body, node: two, mass: 1, inertia: [0.1, 0.1, 0.1]}}
joints:
  pin_one: {{type: hinge, nodes: [ground, one], axis: [0, 1, 0]}}
  pin_two: {{type: hinge, nodes: [ground, two], axis: [0, 1, 0]}}
signals:
  held_one: {{type: sample_and_hold, input: -{share * 0.4 / 0.01!r}*pin_one.rate, period: 10 ms}}
  held_two: {{type: sample_and_hold, input: -{1.0 * 0.1 / 0.01!r}*pin_two.rate, period: 10 ms}}
loads:
  push_one: {{type: joint_moment, joint: pin_one, value: held_one}}
  push_two: {{type: joint_moment, joint: pin_two, value: held_two}}
time: {{end: 2, step: 1.0e-3}}
"""
    prepared = prepare(deck(text))
    found = list(instability_warnings(prepared, integrator_of(prepared).begin(prepared.state, 1e-3)))
    assert len(found) == grows
    for warning in found:
        assert f"by the factor e in {0.01 / np.log(share - 1.0):.3g} s, as an oscillation of 50 Hz" in warning
        assert "or the sampling period of 0.01 s too long" in warning


def test_the_starter_of_a_robot_arm_has_the_gain_margin_of_its_reflected_inertia():
    """Half a sample's frequency moves only the motor, of the inertia J = 100^2 1e-4 kg m2 at the joint: 2 J/(k T).

    The root of the link adds less than 1 %.
    """
    found = margins(deck(starter("robot_arm")), None, LoopRequest(signal="held_1", low=10.0, high=125.0))[1]
    assert found.growing == 0
    assert found.gain == pytest.approx((2.0 * 1.0 / (280 * 0.004), 125.0), rel=0.01)


def test_a_run_that_fails_says_that_its_control_was_unstable_from_the_start(tmp_path):
    """A wheel whose rate is fed back with the wrong sign grows by e in 5 ms until no step is short enough."""
    text = """
mecano: 1
gravity: none
nodes: {wheel: {position: [0, 0, 0]}}
elements: {wheel: {type: rigid_body, node: wheel, mass: 1, inertia: [0.1, 0.1, 0.1]}}
joints: {pin: {type: hinge, nodes: [ground, wheel], axis: [0, 1, 0]}}
signals: {torque: 20*pin.rate + 1}
loads: {motor: {type: joint_moment, joint: pin, value: torque}}
time: {end: 2, step: 1 ms, adaptive: {tolerance: 1.0e-4, minimum_step: 0.1 ms}}
"""
    with pytest.raises(ConvergenceError, match="the smallest allowed") as failed:
        run(deck(text), tmp_path / "a.h5")
    last = str(failed.value).splitlines()[-1]
    assert last.startswith(
        "warning: because of the signals, small motions about the start grow by the factor e in 0.005 s"
    )
    assert last.endswith("Growing motions need ever shorter steps: fix this first")


def test_the_frequencies_of_a_sampled_loop_reach_to_half_its_sampling_frequency():
    """A cart whose force acts a period late: its gain margin is far above the frequency at which the loop gain is 1.

    With the gain times its margin an eigenvalue of the difference equations is on the unit circle.
    """
    T = 2e-3
    found = margins(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{cart: {{position: [0, 0, 0]}}}}
        elements: {{cart: {{type: point_mass, node: cart, mass: 2}}}}
        joints: {{rail: {{type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}}}
        signals:
          held: {{type: sample_and_hold, input: -4*rail.displacement - 8*rail.velocity, period: {T}}}
          late: {{type: sample_and_hold, input: held, period: {T}}}
        loads: {{motor: {{type: joint_force, joint: rail, value: late}}}}
        time: {{end: 1, step: 10 ms}}
    """),
        None,
        LoopRequest(signal="held"),
    )[1]
    assert found.stable and found.gain.frequency > 100.0 * found.phase.frequency
    assert found.frequency[-1] == pytest.approx(250.0)
    by_law = found.gain.value * np.array([4.0, 8.0])
    step = np.array([[1.0, T, T * T / 4.0], [0.0, 1.0, T / 2.0], [-by_law[0], -by_law[1], 0.0]])
    assert np.abs(np.linalg.eigvals(step)).max() == pytest.approx(1.0, abs=1e-9)


def test_the_poles_of_the_samples_are_eigenvalues_of_the_difference_equations():
    T = 0.05
    A, B = difference_equations(T)
    wanted = np.linalg.eigvals(A - B @ GAINS)
    found = loop(two_carts()).sample_poles
    z = np.exp(T * np.concatenate([found, found[found.imag > 0.0].conj()]))
    np.testing.assert_allclose(np.sort_complex(z), np.sort_complex(wanted), atol=1e-10)
