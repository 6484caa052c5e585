"""Signals that drive loads: motions with control against independent integrations and closed forms."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from convergence import at_times
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from small_motions import eigenvalues
from time_runs import RecordedRun, deck, input_deck

import mecano
from mecano.analyses.control_stability import DENSE, causes_of_failure, instability_warnings
from mecano.analyses.dynamic import run
from mecano.analyses.modal import operating_point
from mecano.analyses.prepare import integrator_of, prepare
from mecano.elements.signals.delay import COUNT, FIRST, NEWEST, _kept
from mecano.errors import AssemblyError, DeckError
from mecano.solve.time import signals
from mecano.solve.time.compiled_signals import CompiledSignals
from mecano.solve.time.signals import _Decomposition, _scales

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
        m = RecordedRun(input_deck("controlled_double_pendulum", f"time.step={h}"))
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
        m = RecordedRun(input_deck("controlled_cart", f"time.step={h}"))
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


PULSES = """
    mecano: 1
    gravity: none
    parameters: {f: 1000, R: 0.5, L: 1e-3, k: 0.05, duty: 0.3}
    nodes: {rotor: {position: [0, 0, 0]}}
    elements: {rotor: {type: rigid_body, node: rotor, mass: 1, inertia: [1e-4, 1e-4, 1e-4]}}
    joints: {axle: {type: hinge, nodes: [ground, rotor], axis: [0, 0, 1]}}
    signals:
      carrier: "abs(atan2(sin(2*pi*$f*time), cos(2*pi*$f*time)))/pi"
      bridge: {type: switch, input: $duty - carrier, high: 24, low: 0}
      current: {type: integrator, input: (bridge - $R*current - $k*axle.rate)/$L}
    loads: {motor: {type: joint_moment, joint: axle, value: $k*current - 1e-4*axle.rate}}
    time: {end: 0.02, step: STEP}
    output: {every: 0.02}
    """


def test_a_motor_is_driven_by_pulses(verify):
    """Each period of 1 ms begins and ends with 0.15 ms at 24 V; the equations between are linear."""
    A, y = np.array([[-500.0, -50.0, 24.0e3], [500.0, -1.0, 0.0], [0.0, 0.0, 0.0]]), np.array([0.0, 0.0, 0.0])
    for _ in range(20):
        for on, duration in ((1.0, 0.15e-3), (0.0, 0.7e-3), (1.0, 0.15e-3)):
            y[2] = on
            y = expm(A * duration) @ y
    runs = [RecordedRun(deck(PULSES.replace("STEP", step))) for step in ("1e-4", "5e-5")]
    found = [np.array([m["signals/current/value"][-1], m["joints/axle/rate"][-1]]) for m in runs]
    assert len(runs[1].event_records) == 40
    what = "motor driven by 20 pulses: current [A] and speed [rad/s]"
    verify.second_order(CONTROL, what, *found, y[:2], 1.5e-4, "matrix exponentials")


def test_signals_may_need_one_another():
    m = RecordedRun(deck(LOOP.replace("SIGNAL", '"1 + second"')))
    np.testing.assert_allclose(m["signals/first/value"], 6.0, rtol=1e-12)
    np.testing.assert_allclose(m["joints/rail/velocity"], 3.0 * m.time, atol=1e-12)


def test_signals_of_very_different_size_may_need_one_another():
    """first = 1 + 1e30 second, second = 0.5e-30 first: first = 2."""
    text = LOOP.replace('"2 + 0.5*first"', '"0.5e-30*first"').replace("SIGNAL", '"1 + 1e30*second"')
    np.testing.assert_allclose(RecordedRun(deck(text))["signals/first/value"], 2.0, rtol=1e-9)


def test_signals_that_do_not_determine_one_another_are_refused():
    """A circle is named, without the signals that it reads and that read it, before a run and at its start."""
    circle = "signals form a loop without a unique solution: formula 'first' -> formula 'second' -> "
    more = '"2*second + rail.velocity", after: 3*first, before: time'
    found = deck(LOOP.replace('"2 + 0.5*first"', '"2 + 0.5*first + before"').replace("SIGNAL", more))
    with pytest.raises(AssemblyError, match=f":7:11: {circle}formula 'first'$"):
        prepare(found)
    with pytest.raises(AssemblyError, match=f"at t = 0 s {circle}"):  # singular there only
        RecordedRun(deck(LOOP.replace("SIGNAL", '"2*second*cos(cart.position.x)"')))


def test_a_loop_of_one_signal_is_refused():
    with pytest.raises(AssemblyError, match="formula 'first' -> formula 'first'$"):
        prepare(deck(LOOP.replace("SIGNAL", '"first + 1"')))


def test_a_sampled_sum_without_an_initial_value_is_refused():
    """In an equilibrium a sample is its input, which a sum does not determine."""
    with pytest.raises(AssemblyError, match="; an 'initial' value of 'first' breaks the loop$"):
        prepare(deck(LOOP.replace("SIGNAL", "{type: sample_and_hold, input: first + rail.velocity, period: 1 ms}")))


def test_a_loop_is_reported_before_values_that_are_not_finite():
    """acos(2 + first) is no number, and would be none of the undetermined signal first = 0."""
    with pytest.raises(AssemblyError, match="formula 'first' -> formula 'first'$"):
        prepare(deck(LOOP.replace("SIGNAL", "first, angle: acos(2 + first)")))


@pytest.mark.parametrize("kind", ["delay, time: 0.05", "sample_and_hold, period: 0.05"])
def test_late_feedback_in_equilibrium(kind, tmp_path):
    """In equilibrium a late value is that of its input: a spring of 100 N/m and 50 N/m (0.4 m - x) hold a cart."""
    model = f"""
        mecano: 1
        gravity: none
        nodes: {{cart: {{position: [0, 0, 0]}}}}
        elements: {{cart: {{type: rigid_body, node: cart, mass: 2, inertia: [1, 1, 1]}}}}
        joints:
          rail: {{type: prismatic, nodes: [ground, cart], axis: [1, 0, 0], sliding_law: {{spring: 100, damper: 20}}}}
        signals: {{late: {{input: 50*(0.4 - rail.displacement), type: {kind}}}}}
        loads: {{motor: {{type: joint_force, joint: rail, value: late}}}}
        time: {{end: 0.3, step: 0.01}}
        """
    still = RecordedRun(deck(model + "initial: static\n"))
    np.testing.assert_allclose(still["joints/rail/displacement"], 20.0 / 150.0, rtol=1e-9)
    run(deck(model), tmp_path / "moving.h5")
    base = operating_point(deck(model), f"{tmp_path / 'moving.h5'}:0.3", at_rest=True)
    cart = base.prepared.system.numbering.x[[node.name for node in base.prepared.system.nodes].index("cart")]
    assert base.state.z[cart] == pytest.approx(20.0 / 150.0, rel=1e-9)


def ramp_response(t, w, d):
    """Response of 1/(s^2/w^2 + 2 d s/w + 1) to the ramp t."""
    damped, decay = w * np.sqrt(1.0 - d * d), np.exp(-d * w * t)
    wave = 2.0 * d / w * np.cos(damped * t) + (2.0 * d * d - 1.0) / damped * np.sin(damped * t)
    return t - 2.0 * d / w + decay * wave


FILTERS = {
    "lag": lambda t: t - 0.2 * (1.0 - np.exp(-5.0 * t)),
    "integral": lambda t: 0.5 + 0.5 * t * t,
    "washout": lambda t: 1.0 - np.exp(-5.0 * t),
    "second_order": lambda t: ramp_response(t, 10.0, 0.3),
    "same_in_space": lambda t: ramp_response(t, 10.0, 0.3),
    "curve": lambda t: 1.0 + 3.0 * t * t,
    "limit": lambda t: np.clip(2.0 * t - 0.5, -0.2, 0.7),
}


@pytest.fixture(scope="module")
def filters():
    return [RecordedRun(input_deck("filters", f"time.step={h}")) for h in (0.01, 0.005)]


@pytest.mark.parametrize("name", FILTERS)
def test_filters_of_a_ramp(filters, verify, name):
    times = np.arange(0.1, 1.0, 0.1)
    found = [at_times(m, m[f"signals/{name}/value"], times) for m in filters]
    expected = FILTERS[name](times)
    if name in ("integral", "curve", "limit"):  # exact for a parabola, or without a rate
        np.testing.assert_allclose(found[1], expected, atol=1e-10)
    else:
        verify.second_order(
            CONTROL, f"{name} of a ramp", *found, expected, 5e-7 if name == "lag" else 2e-6, "closed form"
        )


def test_a_limit_is_reached_and_left_by_events(filters):
    """The input 2 x - 0.5 is at -0.2 for x = t = 0.15, at 0.7 for 0.6; at the start it is below."""
    found = [(e.name, e.t) for e in filters[1].event_records if "limit" in e.element]
    assert found == [("lower limit left", pytest.approx(0.15, abs=1e-9)), ("upper limit", pytest.approx(0.6, abs=1e-9))]


FALL_WITH_LIMIT = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {ball: {position: [0, 0, 0]}}
    elements: {ball: {type: point_mass, node: ball, mass: 1}}
    signals: {speed: {type: limit, input: ball.velocity.z, LIMITS}}
    time: {end: 1, step: 0.1}
    """


@pytest.mark.parametrize(
    ("limits", "text"),
    [
        ("lower: 1, upper: 1", "'lower' must be less than 'upper'"),
        ("unit: N", "at least one of 'lower' and 'upper' must be given"),
    ],
)
def test_limits_that_are_refused(limits, text):
    with pytest.raises(DeckError) as error:
        deck(FALL_WITH_LIMIT.replace("LIMITS", limits))
    assert text in error.value.problems[0].message


class Servo:
    """The cart of position_servo.yaml: x, v, thrust, integral, filtered error."""

    m, kp, ki, kd, td, most, tt, lag = 2.0, 80.0, 60.0, 20.0, 0.02, 15.0, 0.3, 0.01

    def rates(self, t, y):
        e = 0.4 - y[0]
        u = self.kp * e + y[3] + self.kd * (e - y[4]) / self.td
        command = np.clip(u, -self.most, self.most)
        integral = self.ki * e + (command - u) / self.tt
        return [y[1], y[2] / self.m, (command - y[2]) / self.lag, integral, (e - y[4]) / self.td]

    def motion(self, times):
        """The displacement at ``times``; short steps leave the corners at the limits an error of 1e-9."""
        options = {"rtol": 1e-10, "atol": 1e-12, "max_step": 5e-4, "method": "DOP853"}
        return solve_ivp(self.rates, (0.0, times[-1]), np.zeros(5), t_eval=times, **options).y[0]


def test_position_servo(verify):
    times, found = np.arange(0.1, 3.0, 0.1), []
    for h in (1e-3, 5e-4):
        m = RecordedRun(input_deck("position_servo", f"time.step={h}"))
        found.append(CubicHermiteSpline(m.time, m["joints/rail/displacement"], m["joints/rail/velocity"])(times))
        assert m.event_records[-1].name == "upper limit left" and m.event_records[-1].t == pytest.approx(
            0.0681, abs=2e-4
        )
        assert m["signals/command/value"].max() == 15.0
    verify.second_order(
        CONTROL, "cart with a PID controller at its limit [m]", *found, Servo().motion(times), 2e-7, "SciPy"
    )


def test_poles_of_a_closed_loop(verify):
    within_limits = "signals.command.lower=-1e6", "signals.command.upper=1e6"
    found, s = eigenvalues(input_deck("position_servo", *within_limits)), Servo()
    # times s (T_D s + 1): m s^3 (T s + 1)(T_D s + 1) + (K_P s + K_I)(T_D s + 1) + K_D s^2
    plant = np.polymul([s.m, 0.0, 0.0, 0.0], np.polymul([s.lag, 1.0], [s.td, 1.0]))
    control = np.polyadd(np.polymul([s.kp, s.ki], [s.td, 1.0]), [s.kd, 0.0, 0.0])
    poles = np.roots(np.polyadd(plant, control))
    expected = np.array(sorted(poles, key=lambda x: (abs(x), x.imag)))
    verify(CONTROL, "poles of the loop [1/s]", found, expected, "roots of its polynomial", relative=1e-8)


@pytest.fixture(scope="module")
def digital():
    return RecordedRun(input_deck("digital_control"))


def sampled_cart(count, m=2.0, period=0.05, late=0.03):
    """Displacements at the sampling times: constant forces between them move the cart on exactly."""
    x, v, force, found = 0.0, 0.0, 0.0, [0.0]
    before = 0.0
    for _ in range(count):
        force = 40.0 * (0.4 - before) - 15.0 * v
        s = period - late  # when, in this period, the position is taken that the next sample sees
        before = x + v * s + 0.5 * force / m * s * s
        x, v = x + v * period + 0.5 * force / m * period**2, v + force / m * period
        found.append(x)
    return np.array(found)


def test_digital_controller(verify, digital):
    times = 0.05 * np.arange(1, 40)
    found = at_times(digital, digital["joints/rail/displacement"], times)
    verify(CONTROL, "cart with a digital controller [m]", found, sampled_cart(39)[1:], "closed form", absolute=1e-9)


def test_relay_with_hysteresis(verify, digital):
    times = [h.t for h in digital.event_records if h.name in ("switches on", "switches off")]
    verify(CONTROL, "times of a relay [s]", times, 0.04 + 0.08 * np.arange(len(times)), "closed form", absolute=1e-9)
    assert len(times) == 25


def test_a_delay_longer_than_a_step_and_shorter():
    """Of a parabola: exact behind short steps; linear interpolation in long ones misses h^2/8 of its curvature."""
    late = "late: {type: delay, input: rail.displacement, time: 0.025}"
    text = LOOP.replace("SIGNAL", "6").replace("second:", f"{late}, second:")
    for h, error in ((0.01, 1e-12), (0.04, 3.0 * 0.04**2 / 8.0)):
        m = RecordedRun(deck(text.replace("end: 0.1, step: 0.01", f"end: 0.4, step: {h}")))
        wanted = np.where(m.time > 0.025, 1.5 * (m.time - 0.025) ** 2, 0.0)
        np.testing.assert_allclose(m["signals/late/value"], wanted, atol=error)
    assert np.abs(m["signals/late/value"] - wanted).max() > 1e-6


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
def test_a_delay_of_a_jump_and_of_a_wave_in_long_steps(method):
    """A unit force from 0.5 s on, and a wave from 0.3 s on, push 1 kg; steps end where the jump arrives."""
    m = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{cart: {{position: [0, 0, 0]}}}}
        elements: {{body: {{type: rigid_body, node: cart, mass: 1, inertia: [1, 1, 1]}}}}
        joints: {{rail: {{type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}}}
        signals:
          on: {{type: switch, input: time, upper: 0.2}}
          late: {{type: delay, input: on, time: 0.3}}
          wave: {{type: delay, input: sin(5*time), time: 0.3}}
        loads: {{push: {{type: joint_force, joint: rail, value: late + wave}}}}
        time: {{end: 1, step: 0.013, method: {method}, adaptive: {{tolerance: 1.0e-5, length_scale: 1}}}}
    """)
    )
    wanted = 0.5 * 0.5**2 + 0.7 / 5.0 - np.sin(5.0 * 0.7) / 25.0
    assert m["joints/rail/displacement"][-1] == pytest.approx(wanted, abs=3e-5)  # three tolerances
    assert m.run.steps < 200
    np.testing.assert_array_equal(m["signals/late/value"][m.time > 0.5 + 1e-3], 1.0)


@pytest.mark.parametrize("times", ["step: 1 ms", "step: 1 ms, adaptive: {tolerance: 1.0e-4, length_scale: 1}"])
def test_a_pulse_that_arrives_late_acts_for_its_time(times):
    """A force of 50 N for 20 ms gives 1 kg 1 m/s, 4 s later, when steps are long."""
    m = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{m: {{position: [0, 0, 0]}}}}
        elements: {{m: {{type: point_mass, node: m, mass: 1}}}}
        signals:
          on: {{type: switch, input: time, upper: 1, high: 50}}
          ended: {{type: delay, input: on, time: 20 ms}}
          late: {{type: delay, input: on - ended, time: 4}}
        loads: {{push: {{type: force, node: m, direction: [1, 0, 0], value: late}}}}
        time: {{end: 6, {times}}}
    """)
    )
    assert m["nodes/m/velocity"][-1, 0] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("gain", [35.0, 38.0])
def test_a_digital_controller_that_acts_a_period_late(gain):
    """A cart of 2 kg, 100 x + gain x' sampled every 50 ms: its difference equations, stable up to 36.64 N s/m."""
    m = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{cart: {{position: [0, 0, 0]}}}}
        elements: {{cart: {{type: point_mass, node: cart, mass: 2}}}}
        joints: {{rail: {{type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}}}
        signals:
          held: {{type: sample_and_hold, input: -100*rail.displacement - {gain}*rail.velocity, period: 50 ms}}
          late: {{type: delay, input: held, time: 50 ms}}
        loads: {{motor: {{type: joint_force, joint: rail, value: late}}}}
        initial: {{velocities: [{{nodes: [cart], velocity: [1, 0, 0]}}]}}
        time: {{end: 2, step: 10 ms}}
    """)
    )
    T = 0.05
    step = np.array([[1.0, T, T * T / 4.0], [0.0, 1.0, T / 2.0], [-100.0, -gain, 0.0]])  # x, v, force that follows
    assert (np.abs(np.linalg.eigvals(step)).max() > 1.0) == (gain > 36.64)
    state, wanted = np.array([0.0, 1.0, -gain]), []  # before the start the sample is that of the start
    for _ in range(40):
        state = step @ state
        wanted.append(state[0])
    found = [m["joints/rail/displacement"][np.argmin(np.abs(m.time - k * T))] for k in range(1, 41)]
    np.testing.assert_allclose(found, wanted, atol=1e-9)


def test_a_delay_does_not_overshoot():
    """The corners of a ramp, delayed by three steps, in the middle of each step."""
    kept, p = np.zeros(FIRST + 16), SimpleNamespace(time=0.3)
    times, values = np.arange(8) * 0.1, np.array([0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0, 1.0])
    kept[COUNT], kept[NEWEST], kept[FIRST::2], kept[FIRST + 1 :: 2] = 8, 2, np.roll(times, 3), np.roll(values, 3)
    found = np.array([_kept(p, kept, t) for t in np.arange(0.05, 0.7, 0.1)])
    assert np.all(found[[0, 1, 4, 5, 6]] == [0, 0, 1, 1, 1]) and 0.0 < found[2] < 0.4 < found[3] < 1.0
    kept[FIRST + 1 :: 2] = np.roll(times, 3) ** 2
    at = np.array([0.35, 0.52, 0.64])
    np.testing.assert_allclose([_kept(p, kept, t) for t in at], at**2, rtol=1e-12)


class AntiSkid:
    """The wheel of anti_skid.yaml: speed, spin and pressure, while the valve dumps (demand 0) or applies."""

    m, inertia, k, r_valve, lag, full = 6440.0, 5.0, 1e6, 0.336824, 0.03, 12000.0

    def __init__(self):
        self.N = self.m * G
        self.r = 0.4 - self.N / self.k

    def rates(self, t, y, demand):
        slip = y[0] - self.r * y[1]
        x = min(abs(slip) / 2.0, 1.0)
        F = (0.1 + 0.25 * np.exp(-0.08 * abs(slip))) * x * (2.0 - x) * np.sign(slip) * self.N
        return [-F / self.m, (F * self.r - y[2]) / self.inertia, (demand - y[2]) / self.lag]

    def motion(self, end):
        """Times of the switches, and the state at the end."""
        t, y, times, dumps = 0.0, np.array([60.0, 60.0 / self.r_valve, 0.0]), [], False
        while t < end:

            def event(t, y, _, level=0.06 if dumps else 0.12):
                return 1.0 - self.r_valve * y[1] / y[0] - level

            event.terminal, event.direction = True, -1.0 if dumps else 1.0
            sol = solve_ivp(
                self.rates, (t, end), y, args=(0.0 if dumps else self.full,), events=event, rtol=1e-10, atol=1e-9,
                method="DOP853", max_step=2e-3,
            )  # fmt: skip
            t, y, dumps = sol.t[-1], sol.y[:, -1], not dumps
            times += [t] if sol.t_events[0].size else []
        return np.array(times), y


def test_anti_skid_keeps_the_slip_in_a_band(verify):
    switches, (v, _, _) = AntiSkid().motion(2.0)
    speeds, times = [], []
    for h in (2e-3, 1e-3):
        m = RecordedRun(input_deck("anti_skid", "time.end=2", f"time.step={h}"))
        speeds.append(m["nodes/leg/velocity"][-1, 0])
        times.append(np.array([h.t for h in m.event_records if h.element == "switch 'valve'"]))
        slip = m["signals/slip/value"][m.time > 0.2]
        assert 0.0 < slip.min() and slip.max() < 0.2
    assert len(switches) > 25
    verify.second_order(CONTROL, "anti-skid: speed after 2 s [m/s]", *speeds, v, 1e-5, "SciPy")
    verify.second_order(CONTROL, "anti-skid: times of the valve in 2 s [s]", *times, switches, 1e-5, "SciPy")
    locked = RecordedRun(input_deck("anti_skid", "time.end=2", "signals.valve.upper=10"))
    assert locked["signals/slip/value"][-1] > 0.99 and locked["nodes/leg/velocity"][-1, 0] > v + 1.0


def servo_valve(t, y):
    """Rates of displacement, velocity and both pressures of inputs/servo_valve.yaml."""
    x, v, a, b = y
    u = np.clip(20.0 * (0.05 - x), -1.0, 1.0)
    into_a = 1.5e-7 * (max(u, 0.0) * np.sqrt(max(2.1e7 - a, 1.0)) + min(u, 0.0) * np.sqrt(max(a, 1.0)))
    out_of_b = 1.5e-7 * (max(u, 0.0) * np.sqrt(max(b, 1.0)) + min(u, 0.0) * np.sqrt(max(2.1e7 - b, 1.0)))
    rise_a, rise_b = (into_a - 1e-3 * v) / (1e-4 + 1e-3 * x), (1e-3 * v - out_of_b) / (1e-4 - 1e-3 * x)
    return [v, 1e-3 * (a - b) / 100.0, 1.4e9 * rise_a, 1.4e9 * rise_b]


def test_a_servo_valve_moves_a_cylinder(verify):
    """Signals from 1e-4 m3/s to 1e13 Pa/m3 are consistent at the start."""
    times = np.array([0.05, 0.1, 0.15, 0.4])
    options = {"method": "Radau", "rtol": 1e-10, "atol": [1e-12, 1e-12, 1e-3, 1e-3], "t_eval": times}
    exact = solve_ivp(servo_valve, (0.0, 0.4), [0.0, 0.0, 1.05e7, 1.05e7], **options).y
    m = RecordedRun(input_deck("servo_valve"))
    steps = np.searchsorted(m.time, times - 5e-5)
    x, pressure = m["joints/rail/displacement"][steps], m["signals/pressure_a/value"][steps]
    verify(CONTROL, "servo valve: displacement [m]", x, exact[0], "SciPy", relative=1e-5)
    verify(CONTROL, "servo valve: pressure [Pa]", pressure, exact[2], "SciPy", relative=1e-5)


LUGRE = """
    mecano: 1
    gravity: none
    nodes:
      block: {position: [0, 0, 0]}
    elements:
      block: {type: point_mass, node: block, mass: 1}
    joints:
      rail:
        type: prismatic
        nodes: [ground, block]
        axis: [1, 0, 0]
        sliding_law: {spring: 2}
        natural_displacement: 1*time
    parameters: {stiffness: 1.0e4, damping: 100, viscous: 0.4, coulomb: 1, static: 1.5, stribeck: 0.01}
    signals:
      steady: ($coulomb + ($static - $coulomb)*exp(-(rail.velocity/$stribeck)**2))/$stiffness
      rate: rail.velocity - abs(rail.velocity)*bristle/steady
      bristle: {type: integrator, input: rate, unit: m}
      friction: $stiffness*bristle + $damping*rate + $viscous*rail.velocity
    loads:
      friction: {type: joint_force, joint: rail, value: -friction}
    time: {end: 4, step: 1 ms, adaptive: {tolerance: 1.0e-5, length_scale: 1}}
"""


def test_a_friction_with_bristles(verify):
    """A spring drags a block in stick and slip; the bristles' deflection is an integrator of its own rate."""
    times = np.linspace(0.4, 4.0, 10)

    def rates(t, state):
        x, v, z = state
        dz = v - abs(v) * z * 1e4 / (1 + 0.5 * np.exp(-((v / 0.01) ** 2)))
        return [v, 2 * (t - x) - 1e4 * z - 100 * dz - 0.4 * v, dz]

    exact = solve_ivp(rates, (0, 4), [0, 0, 0], "LSODA", times, rtol=1e-8, atol=1e-10).y[0]
    recorded = RecordedRun(deck(LUGRE))
    found = np.interp(times, recorded.time, recorded["joints/rail/displacement"])
    verify(CONTROL, "friction of LuGre: displacement over 4 s [m]", found, exact, "SciPy", absolute=1e-4)


def test_two_bodies_attract_one_another(verify):
    """Ellipses of Kepler, closed after two periods, with the largest distance after half of one."""
    m = RecordedRun(input_deck("two_bodies"))
    at_start = [m[f"nodes/{body}/position"][0] for body in "ab"]
    at_end = [m[f"nodes/{body}/position"][-1] for body in "ab"]
    verify(CONTROL, "two bodies: places after two periods [m]", at_end, at_start, "Kepler", absolute=5e-4)
    distance = m["signals/distance/value"]
    verify(CONTROL, "two bodies: largest distance [m]", distance.max(), 1.5, "Kepler", relative=1e-5)
    half = m.time < 1.0
    assert m.time[half][np.argmax(distance[half])] == pytest.approx(np.pi / 4, abs=2e-3)


WAVES = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}}
    elements: {mass: {type: point_mass, node: a, mass: 1}}
    signals:
      wave: 1.0e7*cos(20*time)
      sum: {type: integrator, input: wave}
      slow: {type: lag, input: wave, time_constant: 0.5}
    time: {end: 1, step: 1.0e-4, method: METHOD, adaptive: {tolerance: TOLERANCE}}
"""


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_errors_of_filters_follow_the_tolerance(method, tolerance):
    """T y' + y = u and y' = u for a wave u, beside a mass at rest; errors of the largest value."""
    run = RecordedRun(deck(WAVES.replace("METHOD", method).replace("TOLERANCE", str(tolerance))))
    w, T, t = 20.0, 0.5, run.time
    lag = (np.cos(w * t) + w * T * np.sin(w * t) - np.exp(-t / T)) / (1.0 + (w * T) ** 2)
    for name, exact in (("sum", 1e7 * np.sin(w * t) / w), ("slow", 1e7 * lag)):
        close = 3.0 * tolerance * np.abs(exact).max()  # as of all errors in adaptive runs (docs/step-control.md)
        np.testing.assert_allclose(run[f"signals/{name}/value"], exact, rtol=0, atol=close)


POWER = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {a: {position: [0, 0, 0]}}
    elements: {bar: {type: rigid_body, node: a, mass: 1000, center_of_mass: [0.75, 0, 0], inertia: [1, 187, 187]}}
    joints:
      hinge: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}
      drive: {type: prescribed_angle, nodes: [ground, a], axis: [0, 1, 0], value: 0.3*sin(6*time)**2}
    signals: {power: drive.moment*drive.rate, work: {type: integrator, input: power}}
    time: TIME
"""


def test_the_work_of_a_motor():
    """It is the energy of the bar, and passes through zero together with the power."""
    run = RecordedRun(deck(POWER.replace("TIME", "{end: 0.6, step: 1.0e-4, adaptive: {tolerance: 1.0e-5}}")))
    energy, work = run["energy/kinetic"] + run["energy/potential"], run["signals/work/value"]
    np.testing.assert_allclose(work, energy - energy[0], rtol=0, atol=3e-5 * np.abs(work).max())


def test_signals_follow_the_rounding_of_reactions():
    """In steps of 0.1 us it is above 1 N m: the power, near zero, changes by more than itself in each correction."""
    run = RecordedRun(deck(POWER.replace("TIME", "{end: 2.0e-5, step: 1.0e-7}")))
    assert sum(info.iterations for info in run.infos) < 2.0 * len(run.infos)


def test_jumps_of_a_signal_do_not_end_the_iterations_of_the_motion():
    """The first correction removes the residual of the signal, 1e14 tolerances, not yet that of the motion."""
    jumps = "signals={jumps: '1.0e5*sign(sin(3000*time + 0.1))'}"
    run = RecordedRun(input_deck("double_pendulum", jumps, "time.step=1e-4", "time.end=0.1"))
    assert max(max(info.norms[:2]) for info in run.infos) <= 1.0  # in such steps above rounding


def test_what_lasts_no_time_is_no_extreme(tmp_path):
    """A switch moves the set point beyond the limits of a controller: two events at one instant."""
    (tmp_path / "deck.yaml").write_text(
        """
        mecano: 1
        gravity: none
        nodes: {m: {position: [0, 0, 0]}}
        elements: {body: {type: rigid_body, node: m, mass: 60, inertia: [1, 1, 1]}}
        joints: {rail: {type: prismatic, nodes: [ground, m], axis: [0, 0, 1]}}
        signals:
          target: {type: switch, input: time, upper: 0.2, high: 0.02, low: 0}
          u: {type: pid, input: target - rail.displacement, proportional: 4.0e+5, lower: -5000, upper: 5000}
        loads: {act: {type: joint_force, joint: rail, value: u}}
        time: {end: 0.25, step: 1 ms}
        """
    )
    with mecano.run(tmp_path / "deck.yaml", tmp_path / "r.h5", quiet=True) as results:
        assert [event.time for event in results.events][:2] == pytest.approx([0.2, 0.2], abs=1e-12)
        assert results.extremes["loads/act/force"].maximum == 5000.0


def test_curves_of_time_and_of_signals():
    """A table of the time, with steps that end at its corners, and the square of what it gives."""
    run = RecordedRun(
        deck("""
        mecano: 1
        gravity: none
        nodes: {a: {position: [0, 0, 0]}}
        elements: {body: {type: point_mass, node: a, mass: 1}}
        signals:
          command:
            {type: curve, input: time,
             law: {table: {points: [[0, 0], [0.3333, 2], [0.7777, -1], [2, 0]], interpolation: linear}}}
          square: {type: curve, input: command, law: {polynomial: {coefficients: [1, 0, 3]}}}
        loads: {push: {type: force, node: a, direction: [1, 0, 0], value: square}}
        time: {end: 1, step: 0.1}
        """)
    )
    command, square = (run[f"signals/{name}/value"] for name in ("command", "square"))
    np.testing.assert_allclose(command, np.interp(run.time, [0, 0.3333, 0.7777, 2], [0, 2, -1, 0]), atol=1e-12)
    np.testing.assert_allclose(square, 1.0 + 3.0 * command**2, rtol=1e-8)  # the tolerance of signals
    assert {0.3333, 0.7777} <= set(run.time.tolist())


def test_a_force_by_a_signal_that_jumps_has_its_whole_impulse():
    """At the corner, the last correction of the time is its rounding, which carries the curve over its jump."""
    run = RecordedRun(
        deck("""
        mecano: 1
        gravity: none
        nodes: {a: {position: [0, 0, 0]}}
        elements: {body: {type: point_mass, node: a, mass: 2}}
        signals:
          on: {type: curve, input: time, law: {step: {time: 0.3333, rise: 0, from: 1, to: 4}}}
        loads: {push: {type: force, node: a, direction: [1, 0, 0], value: 2*on}}
        time: {end: 1, step: 0.1}
        """)
    )
    momentum = 2.0 * run["nodes/a/velocity"][:, 0]
    expected = 2.0 * run.time + 6.0 * np.maximum(run.time - 0.3333, 0.0)  # the integral of 2, then 8 N
    np.testing.assert_allclose(momentum, expected, rtol=1e-13)


def test_compiled_code_settles_signals_as_their_singular_value_decomposition_does(monkeypatch):
    """A loop of formulas that are not linear, filters, a quotient, and a signal that depends on rates of signals."""
    prepared = prepare(
        deck("""
        mecano: 1
        gravity: none
        nodes: {a: {position: [0.3, 0, 0]}}
        elements: {body: {type: point_mass, node: a, mass: 2}}
        signals:
          first: 0.1*cos(second) + a.position.x
          second: first/(4 + a.velocity.x) + time
          low: {type: lag, input: 1e6*first, time_constant: 0.2}
          pushed: {type: pid, input: low - 1e6*second, proportional: 3, integral: 2, derivative: 0.1,
                   derivative_time: 0.1}
          held: {type: sample_and_hold, input: pushed, period: 0.1}
        loads: {push: {type: force, node: a, direction: [1, 0, 0], value: 1e-6*held}}
        time: {end: 1, step: 0.1}
        """)
    )
    start = prepared.state.copy()
    start.v[0], start.t = 0.7, 0.2
    compiled = start.copy()
    assert prepared.system.kept(CompiledSignals).settle(compiled, 1e-4)
    monkeypatch.setattr(CompiledSignals, "settle", lambda *arguments: False)
    signals.settle_signals(prepared.system, start, 1e-4)
    for found, expected, rounding in ((compiled.z, start.z, 1e-12), (compiled.v, start.v, 1e-8)):
        np.testing.assert_allclose(found, expected, rtol=rounding, atol=1e-15)
    np.testing.assert_allclose(compiled.a, start.a, rtol=1e-5)


@pytest.mark.parametrize("formula", ["b*p.position.x", "1/(b - p.velocity.x)"])
def test_compiled_code_leaves_singular_and_infinite_signals_as_they_are(formula):
    """Of the loop a = b x, b = a at x = 1, and of a quotient by zero."""
    prepared = prepare(
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{p: {{position: [1, 0, 0]}}}}
        elements: {{body: {{type: point_mass, node: p, mass: 2}}}}
        signals: {{a: "{formula}", b: {"a" if "*" in formula else "p.velocity.x"}}}
        time: {{end: 1, step: 0.1}}
        """)
    )
    before, s = prepared.state, prepared.state.copy()
    assert not prepared.system.kept(CompiledSignals).settle(s, 1e-4)
    assert all(np.array_equal(getattr(s, name), getattr(before, name)) for name in "zva")


CONTROLLED = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {pin: {position: [0, 0, 0]}}
    elements: {bar: {type: rigid_body, node: pin, mass: MASS, center_of_mass: [0, 0, 1], inertia: [1, 1, 1]}}
    joints: {hinge: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}}
    signals:
      torque: {type: pid, input: 0.1 - hinge.angle, GAINS}
    loads: {motor: {type: joint_moment, joint: hinge, value: torque}}
    time: {end: 10, step: 0.01}
    """


@pytest.mark.parametrize(
    ("mass", "gains", "grows"),
    [
        (1e-9, (100.0, 900.0, 5.0), True),  # the integral gain is too large
        (1e-9, (100.0, 300.0, 5.0), False),
        (1e-9, (-100.0, 0.0, 5.0), True),  # a wrong sign
        (3.0, (10.0, 0.0, 1.0), False),  # a pendulum upside down that the controller does not hold
        (1e-9, (100.0, 650.0, 5.0), False),  # grows by 0.48/s, a factor of 120 in the run
    ],
)
def test_a_controller_that_makes_a_mechanism_unstable_is_reported(mass, gains, grows):
    """Rate of growth of J T s^4 + J s^3 + (K_P T + K_D) s^2 + (K_P + K_I T) s + K_I, with T = 10 ms and J = 1 kg m2."""
    names = ("proportional", "integral", "derivative")
    written = ", ".join(f"{name}: {gain}" for name, gain in zip(names, gains, strict=True))
    text = CONTROLLED.replace("MASS", str(mass)).replace("GAINS", f"{written}, derivative_time: 10 ms")
    prepared = prepare(deck(text))
    found = list(instability_warnings(prepared, integrator_of(prepared).begin(prepared.state, 0.01)))
    assert len(found) == grows
    if grows:
        p, i, d = gains
        poles = np.roots([0.01, 1.0, 0.01 * p + d, p + 0.01 * i, i])
        assert f"by the factor e in {1.0 / poles.real.max():.3g} s" in found[0]
        assert ("as an oscillation of" in found[0]) == bool(i)


@pytest.mark.parametrize("gain", [5.0, -5.0])
def test_control_of_a_large_model_is_examined_by_its_lowest_modes(gain):
    """A cantilever with 108 motions and a force gain v on its end: low modes grow by gain phi^2/(2 m).

    With phi = 2 at the end of a uniform beam of the modal mass m = rho A L (perturbation of the first order).
    """
    text = f"""
        mecano: 1
        gravity: none
        nodes: {{root: {{position: [0, 0, 0], fixed: true}}, end: {{position: [2, 0, 0]}}}}
        sections: {{bar: {{type: circle, diameter: 40 mm, E: 210 GPa, nu: 0.3, density: 7850}}}}
        elements: {{bar: {{type: beam, nodes: [root, end], section: bar, up: [0, 0, 1], mesh: 18}}}}
        signals: {{push: {gain}*end.velocity.z}}
        loads: {{push: {{type: force, node: end, direction: [0, 0, 1], value: push}}}}
        time: {{end: 100, step: 0.01}}
        """
    prepared = prepare(deck(text))
    start = integrator_of(prepared).begin(prepared.state, 0.01)
    assert prepared.system.n_q > DENSE and not list(instability_warnings(prepared, start))
    found = causes_of_failure(prepared, start, [])
    assert len(found) == (gain > 0.0)
    growth = gain * 4.0 / (2.0 * 7850 * np.pi / 4 * 0.04**2 * 2.0)
    for warning in found:
        time = float(re.search(r"by the factor e in (\S+) s", warning)[1])
        assert time == pytest.approx(1.0 / growth, rel=0.02)


@pytest.mark.parametrize(("denominator", "grows"), [("[-50, 1]", True), ("[50, 1]", False), ("[0, 1]", False)])
def test_a_filter_that_grows_by_itself_is_reported(denominator, grows):
    """1/(s - 50) grows by the factor e in 20 ms, although it acts on nothing."""
    prepared = prepare(
        deck(
            "{mecano: 1, gravity: [0, 0, -9.81], nodes: {bar: {position: [0.5, 0, 0]}}, elements: {mass: {type: "
            "rigid_body, node: bar, mass: 1, inertia: [0.1, 0.1, 0.1]}}, joints: {pin: {type: hinge, nodes: [ground, "
            "bar], axis: [0, 1, 0]}}, signals: {out: {type: transfer_function, input: pin.angle, numerator: [1], "
            f"denominator: {denominator}}}}}, time: {{end: 1, step: 0.01}}}}"
        )
    )
    found = list(instability_warnings(prepared, integrator_of(prepared).begin(prepared.state, 0.01)))
    assert ["by the factor e in 0.02 s" in text for text in found] == [True] * grows


def test_a_turn_by_reaction_wheels_is_not_taken_for_unstable():
    """Torques of the attitude's error and of the rates, which only take energy: any turn comes to rest.

    Two eigenvalues of the start, 0.7 rad off, grow by 0.24/s, because the wheels that it accelerates move their axes.
    """
    arms = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1]])
    axes = Rotation.from_rotvec([0.4, -0.3, 0.5]).apply(arms).round(15).tolist()
    nodes = {name: {"position": axes[i]} for i, name in enumerate(("nose", "side", "top"))}
    wheels = {f"wheel_{k}": {"position": [0, 0, 0], "orientation": [0.4, -0.3, 0.5]} for k in "xyz"}
    body = {"type": "rigid_body", "node": "hub", "mass": 200, "inertia": [30, 40, 25, 1.5, 0, -1], "attached": [*nodes]}
    wheel = {"type": "rigid_body", "mass": 5, "inertia": [0.05, 0.05, 0.05]}
    errors = {"x": "side.position.z - top.position.y", "y": "top.position.x - nose.position.z",
              "z": "nose.position.y - side.position.x"}  # fmt: skip
    ends = dict(zip("xyz", nodes, strict=True))
    rates = {k: " + ".join(f"hub.angular_velocity.{c}*{ends[k]}.position.{c}" for c in "xyz") for k in "xyz"}
    text = {
        "mecano": 1, "gravity": "none",
        "nodes": {"hub": {"position": [0, 0, 0], "orientation": [0.4, -0.3, 0.5]}, **nodes, **wheels},
        "elements": {"body": body, **{name: {**wheel, "node": name} for name in wheels}},
        "joints": {k: {"type": "hinge", "nodes": ["hub", f"wheel_{k}"], "axis": axes[i]} for i, k in enumerate("xyz")},
        "signals": {f"torque_{k}": f"4*({errors[k]}) + 30*({rates[k]})" for k in "xyz"},
        "loads": {f"motor_{k}": {"type": "joint_moment", "joint": k, "value": f"torque_{k}"} for k in "xyz"},
        "time": {"end": 60, "step": 0.02},
    }  # fmt: skip
    prepared = prepare(deck(json.dumps(text)))
    assert not list(instability_warnings(prepared, integrator_of(prepared).begin(prepared.state, 0.02)))
    recorded = RecordedRun(deck(json.dumps(text)))
    assert np.abs(recorded["joints/x/rate"][0]) < 1e-12 < 1.0 < np.abs(recorded["joints/x/rate"]).max()
    np.testing.assert_allclose(np.abs(recorded["nodes/hub/rotation"][-1]), [1, 0, 0, 0], atol=1e-8)


@pytest.mark.parametrize(("sign", "grows"), [("-", False), ("", True)])
def test_a_wheel_that_spins_up_does_not_hide_a_wrong_sign(sign, grows):
    """Of J s^2 = +-(k + d s) on the body; the wheel of 0.02 kg m2 begins with 40 rad/s2, beside which s^2 is small."""
    text = f"""
    mecano: 1
    gravity: none
    nodes: {{bus: {{position: [0, 0, 0]}}, wheel: {{position: [0, 0, 0]}}}}
    elements:
      bus: {{type: rigid_body, node: bus, mass: 100, inertia: [50, 50, 50]}}
      wheel: {{type: rigid_body, node: wheel, mass: 2, inertia: [0.01, 0.01, 0.02]}}
      gyro: {{type: attitude, node: bus}}
    joints: {{spin: {{type: hinge, nodes: [bus, wheel], axis: [0, 0, 1]}}}}
    signals: {{torque: 8*(0.1 - gyro.yaw) - 30*gyro.yaw_rate}}
    loads: {{motor: {{type: joint_moment, joint: spin, value: {sign}torque}}}}
    time: {{end: 60, step: 10 ms}}
    """
    prepared = prepare(deck(text))
    found = list(instability_warnings(prepared, integrator_of(prepared).begin(prepared.state, 0.01)))
    growth = np.roots([50.0, -30.0, -8.0]).max()
    assert [f"by the factor e in {1.0 / growth:.3g} s" in text for text in found] == [True] * grows


def test_bodies_that_attract_one_another_are_no_controller():
    """Their orbits are stable; the linearized attraction of bodies at rest would not be."""
    prepared = prepare(input_deck("two_bodies"))
    assert not list(instability_warnings(prepared, integrator_of(prepared).begin(prepared.state, 0.01)))


def test_rates_of_signals_do_not_grow_in_steps_of_changing_size():
    """The rate of a signal is of second order in steps that are cut again and again, and exact of a parabola."""
    text = """
    mecano: 1
    gravity: none
    nodes: {b: {position: [0, 0, 0]}}
    elements: {m: {type: point_mass, node: b, mass: 1}}
    signals: {command: COMMAND}
    loads: {push: {type: force, node: b, direction: [1, 0, 0], value: command}}
    time: {end: 1, step: 1.0e-2}
    """
    for command, rate, allowed in (("3*time**2 - time", lambda t: 6.0 * t - 1.0, 1e-8), ("sin(time)", np.cos, 1e-4)):
        prepared = prepare(deck(text.replace("COMMAND", command)))
        integrator = integrator_of(prepared)
        method, run = integrator.method, integrator.begin(prepared.state, 1e-2)
        s, history, signal = run.motion, run.history, np.flatnonzero(prepared.system.signals)
        for i, size in enumerate([1.0, 1e-2, 2e-2, 1.0, 0.3, 1e-3, 0.5] * 30):
            h = 1e-2 * size
            s, history, info = method.step(s, method.restart(s, history, h), h)
            assert info.ok and (i == 0 or abs(s.v[signal][0] - rate(s.t)) < allowed)


def test_the_resolved_form_of_a_controller_is_a_deck():
    """Its signals without a unit have the unit '-' there."""
    given = input_deck("nose_wheel_steering")
    assert deck(json.dumps(given.resolved())).resolved() == given.resolved()


def test_rows_and_columns_of_signals_of_any_unit_are_balanced():
    """Powers of 2 leave the digits of the entries; the largest of row and column differ by less than 4."""
    rng = np.random.default_rng(3)
    units = 10.0 ** rng.uniform(-150, 150, 12)
    J = rng.normal(size=(12, 12)) * units / units[:, None] + np.eye(12)
    d = _scales(J)
    assert np.all(np.frexp(d)[0] == 0.5)
    size = np.abs(J / d[:, None] * d)
    assert np.all(np.abs(np.log2(size.max(axis=0) / size.max(axis=1))) < 2.0)
    d = _scales(np.array([[1.0, 1e12], [0.0, 1.0]]))
    assert 1e12 * d[1] / d[0] < 4.0
    assert np.all(_scales(np.diag([1.0, 1e200])) == 1.0)


def test_a_huge_quotient_disturbs_no_signal_but_those_that_read_it():
    """v = 3, q = 1/v^2 at v = 1e-30, its derivative there -2e90; d = h = 0.5, u = q + d, and a loop of a and b."""
    v, q, u, d, h, a, b = range(7)
    J = np.eye(7)
    J[q, v], J[u, q], J[u, d], J[d, h], J[a, b], J[b, a], J[a, h] = 2e90, -1.0, -1.0, -1.0, -1.0, -0.5, -1.0
    x = _Decomposition(J).solve(np.array([3.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0]))
    np.testing.assert_allclose(x[[v, h, d, a, b]], [3.0, 0.5, 0.5, 1.0, 0.5], rtol=1e-14)  # a = b + h, b = a/2
    assert x[q] == x[u] == pytest.approx(-6e90)
