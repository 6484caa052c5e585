"""Times at which signals are sampled and arrive, and what a sample is where its input jumps at that instant."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

from mecano.analyses.margins import LoopRequest, margins

CART = """
    mecano: 1
    gravity: none
    nodes: {cart: {position: [0, 0, 0]}}
    elements: {cart: {type: point_mass, node: cart, mass: 2}}
    joints: {rail: {type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}
"""


def last_before(t, start, period):
    """Return the last sampling times before t; a row at a sampling time has the value before."""
    return start + period * np.maximum(np.ceil((t - start) / period - 1e-6) - 1.0, 0.0)


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
@pytest.mark.parametrize("start", [100.0, 1000.0])
def test_samples_keep_their_times(start, method):
    """The sampled time itself, at 1/ms and 1/(0.7 ms): sums of periods would miss samples after a few hundred."""
    m = RecordedRun(
        deck(f"""{CART}
    signals:
      slow: {{type: sample_and_hold, input: time, period: 1 ms}}
      fast: {{type: sample_and_hold, input: time, period: 0.7 ms}}
    loads: {{push: {{type: joint_force, joint: rail, value: slow - fast}}}}
    time: {{start: {start}, end: {start + 0.25}, step: 10 ms, method: {method}}}
    """)
    )
    for name, period in (("slow", 1e-3), ("fast", 0.7e-3)):
        np.testing.assert_allclose(m[f"signals/{name}/value"], last_before(m.time, start, period), rtol=0.0, atol=1e-9)
    assert len(m.time) > 500


def test_a_controller_with_a_sum_a_filter_and_a_force_one_period_late():
    """Its difference equations; the acceleration is constant between samples."""
    m = RecordedRun(
        deck(f"""{CART}
    signals:
      error: {{type: sample_and_hold, input: 0.4 - rail.displacement, period: 20 ms}}
      sum: {{type: integrator, input: error}}
      rate: {{type: sample_and_hold, input: 0.8*rate + 0.2*rail.velocity, period: 20 ms}}
      force: {{type: sample_and_hold, input: 40*(0.4 - rail.displacement) - 15*rate + 30*sum, period: 20 ms}}
      late: {{type: sample_and_hold, input: force, period: 20 ms}}
    loads: {{motor: {{type: joint_force, joint: rail, value: late}}}}
    time: {{end: 1, step: 10 ms}}
    """)
    )
    T, x, v, total, rate, wanted = 0.02, 0.0, 0.0, 0.0, 0.0, []
    error, force, late = 0.4, 16.0, 16.0
    for _ in range(50):
        x, v, total = x + T * v + T * T * late / 4.0, v + T * late / 2.0, total + T * error
        wanted.append(x)
        force, late = 40.0 * (0.4 - x) - 15.0 * rate + 30.0 * total, force
        rate, error = 0.8 * rate + 0.2 * v, 0.4 - x
    found = np.interp(T * np.arange(1, 51), m.time, m["joints/rail/displacement"])
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-12)


DISCRETE = f"""{CART}
    signals:
      error: 0.4 - rail.displacement
      sum: {{type: sample_and_hold, input: sum + 0.02*error, period: 20 ms, initial: 0.05}}
      force: {{type: sample_and_hold, input: 40*error - 15*rail.velocity + 30*sum, period: 20 ms}}
      late: {{type: sample_and_hold, input: force, period: 20 ms, initial: 1.5}}
    loads: {{motor: {{type: joint_force, joint: rail, value: late}}}}
    time: {{end: 1, step: 10 ms}}
"""
T = 0.02


def test_initial_values_are_those_of_the_first_period():
    """A sum, which has no value at rest, and a force that is given late, by their difference equations."""
    m = RecordedRun(deck(DISCRETE))
    x, v, total, force, late, wanted = 0.0, 0.0, 0.05, 17.5, 1.5, []
    for _ in range(50):
        x, v = x + T * v + T * T * late / 4.0, v + T * late / 2.0
        wanted.append(x)
        late, force, total = force, 40.0 * (0.4 - x) - 15.0 * v + 30.0 * total, total + T * (0.4 - x)
    found = np.interp(T * np.arange(1, 51), m.time, m["joints/rail/displacement"])
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-12)


def test_the_poles_of_a_sum_and_of_a_late_force():
    """Eigenvalues of the motion over a period times the samples at its end, in x, v, sum, force, late."""
    motion, samples = np.eye(5), np.eye(5)
    motion[0, 1], motion[0, 4], motion[1, 4] = T, T * T / 4.0, T / 2.0
    samples[2, 0], samples[3], samples[4] = -T, [-40.0, -15.0, 30.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0]
    wanted = np.linalg.eigvals(samples @ motion)
    s = margins(deck(DISCRETE), None, LoopRequest(signal="late"))[1].sample_poles
    z = np.exp(T * np.concatenate([s, s[s.imag > 0.0].conj()]))
    np.testing.assert_allclose(np.sort_complex(z), np.sort_complex(wanted[np.abs(wanted) > 1e-9]), atol=1e-10)


JUMPS = (
    "type: switch, input: time, upper: 0.05, high: 1, low: 0",
    "type: curve, input: time, law: {step: {time: 0.05, rise: 0, from: 0, to: 1}}",
)


@pytest.mark.parametrize("jump", JUMPS)
def test_a_jump_at_a_sampling_time_is_sampled_one_period_later(jump):
    m = RecordedRun(
        deck(f"""{CART}
    signals:
      jump: {{{jump}}}
      held: {{type: sample_and_hold, input: jump, period: 10 ms}}
    loads: {{motor: {{type: joint_force, joint: rail, value: held}}}}
    time: {{end: 0.1, step: 2 ms}}
    """)
    )
    np.testing.assert_allclose(m["signals/held/value"], np.where(m.time > 0.061, 1.0, 0.0))


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
def test_late_samples_keep_their_jumps_in_long_runs(method):
    """A sampled time, 0.35 ms late, at 10000 s, whose spacing of numbers is more than 1e-9 of this delay."""
    m = RecordedRun(
        deck(f"""{CART}
    signals:
      held: {{type: sample_and_hold, input: time, period: 1 ms}}
      late: {{type: delay, input: held, time: 0.35 ms}}
    loads: {{push: {{type: joint_force, joint: rail, value: late - held}}}}
    time: {{start: 10000, end: 10000.05, step: 10 ms, method: {method}}}
    """)
    )
    wanted = last_before(m.time - 0.35e-3, 1e4, 1e-3)
    np.testing.assert_allclose(m["signals/late/value"], wanted, rtol=0.0, atol=1e-9)
    arrivals = 1e4 + 1e-3 * np.arange(1, 49) + 0.35e-3
    assert np.abs(m.time[:, None] - arrivals).min(axis=0).max() < 1e-9, "steps end where the samples arrive"


def test_samples_are_rounded_to_the_resolution():
    """An encoder of 3 mm on a cart that moves at 0.1 m/s, also at the start; the initial value is kept."""
    m = RecordedRun(
        deck(f"""{CART}
    initial: {{velocities: [{{nodes: [cart], velocity: [0.1, 0, 0]}}]}}
    signals:
      fine: {{type: sample_and_hold, input: 0.002 - rail.displacement, period: 10 ms}}
      read: {{type: sample_and_hold, input: 0.002 - rail.displacement, period: 10 ms, resolution: 3 mm}}
      late: {{type: sample_and_hold, input: read, period: 10 ms, initial: 5 mm, resolution: 3 mm}}
    loads: {{motor: {{type: joint_force, joint: rail, value: 0*late}}}}
    time: {{end: 0.1, step: 5 ms}}
    """)
    )
    sampled = 0.002 - 0.1 * last_before(m.time, 0.0, 0.01)
    np.testing.assert_allclose(m["signals/fine/value"], sampled, atol=1e-12)
    np.testing.assert_allclose(m["signals/read/value"], 0.003 * np.round(sampled / 0.003), atol=1e-12)
    before = 0.003 * np.round((0.003 - 0.1 * last_before(m.time, 0.0, 0.01)) / 0.003)
    np.testing.assert_allclose(m["signals/late/value"], np.where(m.time < 0.011, 0.005, before), atol=1e-12)


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
@pytest.mark.parametrize("initial", ["{}", "static"])
def test_samples_and_delays_begin_with_velocities_and_reactions_of_the_start(initial, method):
    """A motor already turns, a rod carries 1 kg, and a ball of 2 kg stands on the floor."""
    m = RecordedRun(
        deck(f"""
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {{hook: {{position: [0, 0, 0], fixed: true}}, bob: {{position: [0, 0, -1]}}, ball: {{position: [1, 0, 0.1]}},
             crank: {{position: [2, 0, 0]}}}}
    elements:
      bob: {{type: point_mass, node: bob, mass: 1}}
      ball: {{type: rigid_body, node: ball, mass: 2, inertia: [0.1, 0.1, 0.1]}}
      floor: {{type: contact, nodes: [ground, ball], plane: {{normal: [0, 0, 1], point: [0, 0, 0]}}, radius: 0.1}}
      crank: {{type: rigid_body, node: crank, mass: 1, inertia: [0.1, 0.1, 0.1]}}
    joints:
      rod: {{type: rigid_rod, nodes: [hook, bob]}}
      pin: {{type: hinge, nodes: [ground, crank], axis: [0, 1, 0]}}
      motor: {{type: prescribed_angle, nodes: [ground, crank], axis: [0, 1, 0], value: {{linear: {{slope: 50}}}}}}
    signals:
      held: {{type: sample_and_hold, input: pin.rate + rod.tension + floor.normal_force, period: 10 ms}}
      late: {{type: delay, input: pin.rate + rod.tension + floor.normal_force, time: 10 ms}}
    initial: {initial}
    time: {{end: 0.03, step: 1 ms, method: {method}}}
    """)
    )
    for name in ("held", "late"):
        np.testing.assert_allclose(m[f"signals/{name}/value"], 50 + 3 * 9.81, rtol=1e-6)
