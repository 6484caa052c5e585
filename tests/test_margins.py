"""Margins of stability of control loops against closed forms, and against the poles of the closed loops."""

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.optimize import brentq, fsolve, minimize_scalar
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.margins import LoopRequest, margins
from mecano.analyses.modal import modes
from mecano.cli import commands
from mecano.errors import ResultsError, UsageError
from mecano.post.info import info
from mecano.post.pictures import post
from mecano.results.margins_file import read_margins

TIME = "time: {end: 1, step: 1.0e-3}"
SECTION = "Signals and control"


def loop(model, signal, low=0.1, high=100.0, **options):
    """Return the Margins of the text of a deck, or of a checked deck."""
    checked = deck(model) if isinstance(model, str) else model
    return margins(checked, None, LoopRequest(signal=signal, low=low, high=high, **options))[1]


def s_of(found):
    return 2j * np.pi * found.frequency


def servo(gain=1.0, late="late: {type: delay, input: error, time: 0.01}"):
    """A mass of 2 kg with a PID controller, an actuator and a sensor that is late."""
    return f"""
mecano: 1
gravity: none
nodes: {{cart: {{position: [0, 0, 0]}}}}
elements: {{body: {{type: point_mass, node: cart, mass: 2}}}}
joints: {{rail: {{type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}}}
signals:
  command: 0*time
  error: command - rail.displacement
  {late}
  thrust: {{type: pid, input: late, proportional: 300, integral: 400, derivative: 40, derivative_time: 0.02}}
  motor: {{type: lag, input: {gain!r}*thrust, time_constant: 0.01}}
loads: {{motor: {{type: joint_force, joint: rail, value: motor}}}}
{TIME}
"""


def of_servo(s, delay=0.01):
    """Return L of the servo."""
    controller, motor = 300 + 400 / s + 40 * s / (1 + 0.02 * s), 1 / (1 + 0.01 * s)
    return controller * motor * np.exp(-delay * s) / (2 * s**2)


@pytest.mark.parametrize("signal", ["error", "late", "thrust", "motor", "motor.value"])
def test_pid_controller_of_a_mass_with_a_delay(verify, signal):
    """L is the same at each signal of the loop; its margins are those that SciPy finds from its formula."""
    found = loop(servo(), signal)
    assert np.abs(found.values / of_servo(s_of(found)) - 1.0).max() < 1e-10
    w = brentq(lambda w: abs(of_servo(1j * w)) - 1.0, 10.0, 40.0, xtol=1e-13)
    margin = np.pi + np.angle(of_servo(1j * w))
    own = found.phase.value, found.delay.value, found.phase.frequency, found.delay.frequency
    exact = margin, margin / w, w / (2 * np.pi), w / (2 * np.pi)
    what = f"mass, PID controller, delay, opened at {signal}: phase margin [rad], delay margin [s], crossover [Hz]"
    verify(SECTION, what, own, exact, "formula of L", relative=1e-9)
    for own, low, high in ((found.gain_reduction, 2.0, 5.0), (found.gain, 30.0, 60.0)):
        w = brentq(lambda w: of_servo(1j * w).imag, low, high, xtol=1e-13)
        assert own == pytest.approx((1.0 / abs(of_servo(1j * w)), w / (2 * np.pi)), rel=1e-9)
    nearest = minimize_scalar(lambda w: abs(1.0 + of_servo(1j * w)), (20.0, 25.0, 30.0), tol=1e-12)
    assert found.sensitivity_peak == pytest.approx((1.0 / nearest.fun, nearest.x / (2 * np.pi)), rel=1e-7)
    assert found.growing == 0 and not found.warnings


@pytest.mark.parametrize(("low", "high"), [(np.nan, np.nan), (0.5, np.nan), (np.nan, 9.0)])
def test_frequencies_follow_from_poles_and_gain(low, high):
    """From a hundredth of the frequency at which abs(L) falls below 1 to ten times that, unless they are given.

    Each pole is faster than a tenth of it.
    """
    found = loop(servo(), "motor", low, high)
    w = brentq(lambda w: abs(of_servo(1j * w)) - 1.0, 10.0, 40.0) / (2 * np.pi)
    first, last = found.frequency[[0, -1]]
    assert first == pytest.approx(low if low == low else 0.01 * w, rel=0.05)
    assert last == pytest.approx(high if high == high else 10.0 * w, rel=0.05)
    assert found.phase.frequency == pytest.approx(w, rel=1e-9)
    assert found.gain_reduction.frequency > 0.0 or low == low
    for bad in (-1.0, 0.0, np.inf):
        with pytest.raises(UsageError, match="finite and greater than zero"):
            loop(servo(), "motor", bad, high)


def test_velocity_feedback_of_an_oscillator():
    """L = g s/(m s^2 + c s + k): |L| = 1 at m w - k/w = -+ r, r^2 = g^2 - c^2, with the phase +- atan(r/c)."""
    m, c, k, g = 2.0, 4.0, 200.0, 30.0
    model = f"""
mecano: 1
gravity: none
nodes: {{hook: {{position: [0, 0, 0], fixed: true}}, weight: {{position: [0.5, 0, 0]}}}}
elements:
  mass: {{type: point_mass, node: weight, mass: {m}}}
  spring: {{type: spring_damper, nodes: [hook, weight], law: {{spring: {k}, damper: {c}}}}}
loads: {{damper: {{type: line_force, nodes: [hook, weight], value: {-g}*weight.velocity.x}}}}
{TIME}
"""
    found = loop(model, "damper.value", 0.1, 20.0)
    s, r = s_of(found), np.sqrt(g**2 - c**2)
    assert np.abs(found.values / (g * s / (m * s**2 + c * s + k)) - 1.0).max() < 1e-10
    slow, fast = (np.sqrt((r / (2 * m)) ** 2 + k / m) + sign * r / (2 * m) for sign in (-1, 1))
    lag = np.pi - np.arctan2(r, c)
    crossed = np.array([one.frequency for one in found.crossovers])
    assert 2 * np.pi * crossed == pytest.approx([slow, fast], rel=1e-10)
    assert [one.phase_margin for one in found.crossovers] == pytest.approx([-lag, lag], rel=1e-10)
    assert found.delay == pytest.approx((lag / fast, fast / (2 * np.pi)), rel=1e-10)
    assert found.crossovers[0].delay_margin == pytest.approx((2 * np.pi - lag) / slow, rel=1e-10)
    assert np.isnan(found.gain.value) and found.static == 0.0 and found.growing == 0


def test_double_pendulum_with_one_loop_opened():
    """The loop of the shoulder, that of the knee closed, from the equations in two angles about their equilibrium."""
    kp, kd, g = 60.0, 8.0, 9.81
    found = loop(input_deck("controlled_double_pendulum", "initial=static"), "shoulder_torque")

    def slopes(q):
        upper, both = np.cos(q[0]), np.cos(q[0] + q[1])
        return -g * np.array([1.5 * upper + 0.5 * both, 0.5 * both])  # of the potential, bars hang below

    a, b = fsolve(lambda q: slopes(q) - kp * (np.array([0.5, -1.0]) - q), [0.5, -1.0], xtol=1e-13)
    cos = np.cos(b)
    M = np.array([[1 / 3 + 1 + 1 / 3 + cos, 1 / 3 + 0.5 * cos], [1 / 3 + 0.5 * cos, 1 / 3]])
    upper, both = np.sin(a), np.sin(a + b)
    K = g * np.array([[1.5 * upper + 0.5 * both, 0.5 * both], [0.5 * both, 0.5 * both]])
    s = s_of(found)[:, None, None]
    knee = np.array([[0.0, 0.0], [0.0, 1.0]]) * (kp + kd * s)
    L = ((kp + kd * s) * np.linalg.inv(M * s**2 + K + knee))[:, 0, 0]
    assert np.abs(found.values / L - 1.0).max() < 1e-8
    assert found.growing == 0 and found.static == pytest.approx(kp * np.linalg.inv(K + [[0, 0], [0, kp]])[0, 0])


def test_inverted_pendulum():
    """Unstable without its controller: L = (kp + kd s)/(I s^2 - m g l) is negative at zero frequency."""
    model = f"""
mecano: 1
gravity: [0, 0, -9.81]
nodes: {{pivot: {{position: [0, 0, 0]}}}}
elements: {{bob: {{type: rigid_body, node: pivot, mass: 2, inertia: [1, 1, 1], center_of_mass: [0, 0, 0.5]}}}}
joints: {{pin: {{type: hinge, nodes: [ground, pivot], axis: [0, 1, 0]}}}}
signals: {{torque: -30*pin.angle - 6*pin.rate}}
loads: {{motor: {{type: joint_moment, joint: pin, value: torque}}}}
{TIME}
"""
    found = loop(model, "torque", 0.05, 20.0)
    s = s_of(found)
    assert np.abs(found.values / ((30 + 6 * s) / (1.5 * s**2 - 9.81)) - 1.0).max() < 1e-10
    assert found.gain_reduction == pytest.approx((9.81 / 30, 0.0), rel=1e-6) and np.isnan(found.gain.value)
    assert found.growing == 0
    weak = loop(model.replace("-30*", "-9*"), "torque", 0.05, 20.0)
    assert weak.growing == 1 and [text for text in weak.warnings if "unstable already" in text]


@pytest.mark.parametrize("late", ["", "late: {type: delay, input: torque, time: 1 ms}"])
def test_growth_slower_than_the_equations_change_does_not_decide_on_stability(late):
    """A falling pendulum turns the axes of its joint; with late feedback its pole is one of those counted."""
    model = f"""
mecano: 1
gravity: [0, 0, -9.81]
nodes: {{pivot: {{position: [0, 0, 0]}}}}
elements: {{bob: {{type: rigid_body, node: pivot, mass: 2, inertia: [1, 1, 1], center_of_mass: [0, 0, 0.5]}}}}
joints: {{pin: {{type: hinge, nodes: [ground, pivot], axis: [0, 1, 0]}}}}
signals: {{torque: -9*pin.angle - 6*pin.rate{", " + late if late else ""}}}
loads: {{motor: {{type: joint_moment, joint: pin, value: {"late" if late else "torque"}}}}}
initial: {{velocities: [{{nodes: [pivot], angular_velocity: [0, 1, 0]}}]}}
{TIME}
"""
    assert loop(model, "torque", 0.05, 20.0).growing is None


def test_a_loop_without_damping():
    """L = kp/(m s^2): the phase margin is zero, the closed loop oscillates at sqrt(kp/m)."""
    late = "late: {type: formula, value: 300*error}"
    found = loop(servo(late=late).replace("value: motor}", "value: late}"), "late")
    assert np.isinf(found.sensitivity_peak.value)
    assert found.phase == pytest.approx((0.0, np.sqrt(150.0) / (2 * np.pi)), rel=1e-9, abs=1e-9)
    assert found.sensitivity_peak.frequency == pytest.approx(np.sqrt(150.0) / (2 * np.pi), rel=1e-9)


def test_an_open_loop_with_a_pole_on_the_axis():
    """L = g s exp(-s T)/(m s^2 + k) passes through infinity from +90 to -90 degrees: no crossover of the phase."""
    model = f"""
mecano: 1
gravity: none
nodes: {{hook: {{position: [0, 0, 0], fixed: true}}, weight: {{position: [0.5, 0, 0]}}}}
elements:
  mass: {{type: point_mass, node: weight, mass: 1}}
  spring: {{type: spring_damper, nodes: [hook, weight], law: {{spring: 100}}}}
signals: {{late: {{type: delay, input: weight.velocity.x, time: 1 ms}}}}
loads: {{damper: {{type: line_force, nodes: [hook, weight], value: -0.2*late}}}}
{TIME}
"""
    found = loop(model, "late", 0.5, 5.0)
    s = s_of(found)
    assert np.abs(found.values * (s**2 + 100) / (0.2 * s * np.exp(-0.001 * s)) - 1.0).max() < 1e-10
    assert [bool(one.gain) for one in found.crossovers] == [True, True] and found.growing == 0
    w = np.sqrt(100.01) + np.array([-0.1, 0.1])
    assert 2 * np.pi * np.array([one.frequency for one in found.crossovers]) == pytest.approx(w, rel=1e-10)
    assert [one.phase_margin for one in found.crossovers] == pytest.approx(
        [-np.pi / 2, np.pi / 2] - 0.001 * w, rel=1e-9
    )


class TestPoles:
    """The poles of the closed loop are on the imaginary axis where the margins say."""

    UNDELAYED = "late: {type: formula, value: error}"

    def nearest(self, model, frequency):
        """Return the pole of `mecano modes` nearest to a frequency [Hz] of the axis, relative to it."""
        values = modes(deck(model), None, number=20)[1].values
        pole = 2j * np.pi * frequency
        return np.abs(values / pole - 1.0).min()

    @pytest.mark.parametrize("name", ["gain", "gain_reduction"])
    def test_gain(self, name):
        margin = getattr(loop(servo(late=self.UNDELAYED), "motor"), name)
        assert self.nearest(servo(gain=margin.value, late=self.UNDELAYED), margin.frequency) < 1e-8
        assert self.nearest(servo(late=self.UNDELAYED), margin.frequency) > 0.1

    def test_delay(self):
        """A Padé approximation of fourth order of the delay, right to 1e-9 at this frequency."""
        margin = loop(servo(late=self.UNDELAYED), "motor").delay
        T = margin.value
        part = np.array([1.0, T / 2, 3 * T**2 / 28, T**3 / 84, T**4 / 1680])
        pade = f"numerator: {(part * [1, -1, 1, -1, 1]).tolist()}, denominator: {part.tolist()}"
        late = f"late: {{type: transfer_function, input: error, {pade}}}"
        assert self.nearest(servo(late=late), margin.frequency) < 1e-8

    @pytest.mark.parametrize(("share", "growing"), [(0.99, 0), (1.01, 2)])
    def test_growing_poles_of_late_feedback(self, share, growing):
        delay = share * loop(servo(late=self.UNDELAYED), "motor").delay.value
        late = f"late: {{type: delay, input: error, time: {delay!r}}}"
        assert loop(servo(late=late), "motor").growing == growing


@pytest.mark.parametrize(("kT", "growing"), [(0.5, 0), (1.5, 0), (1.6, 2), (7.8, 2), (7.9, 4)])
def test_integrator_with_a_delay(kT, growing):
    """x' = -k x(t - T): gain margin pi/(2 k T), phase margin pi/2 - k T; roots cross at k T = (4 n + 1) pi/2."""
    signals = f"x: {{type: integrator, input: {-kT / 0.1!r}*late}}, late: {{type: delay, input: x, time: 0.1}}"
    model = servo().split("signals:")[0] + f"signals: {{{signals}}}\n{TIME}\n"
    found = loop(model, "x")
    assert found.growing == growing
    first = found.crossovers[0] if kT > np.pi / 2 else found.crossovers[1]
    assert (first.frequency, first.gain_margin) == pytest.approx((2.5, np.pi / (2 * kT)), rel=1e-9)
    (gain,) = [one for one in found.crossovers if one.gain]
    turned = (np.pi / 2 - kT + np.pi) % (2 * np.pi) - np.pi
    assert (gain.frequency, gain.phase_margin) == pytest.approx((kT / 0.1 / (2 * np.pi), turned), rel=1e-9)
    assert gain.delay_margin == pytest.approx(turned % (2 * np.pi) / (kT / 0.1), rel=1e-9)


@pytest.mark.parametrize(("gain", "growing"), [(1.0, 0), (5.6, 1)])
def test_a_sampled_loop(verify, gain, growing):
    """A cart of 2 kg, whose force is set every 0.05 s, its position 0.03 s late: difference equations of the samples.

    At 5.50964 times the gain z = -1 is a pole: the margin is at half the sampling frequency.
    """
    h, late = 0.05, 0.03
    law = f"signals.command.input={gain}*(40*(target - position) - 15*rail.velocity)"
    found = loop(input_deck("digital_control", law), "command", 1.0, 200.0, number=6)
    z = np.exp(s_of(found) * h)[:, None, None]
    step, part = ((np.array([[1.0, t], [0.0, 1.0]]), np.array([0.5 * t**2, t]) / 2.0) for t in (h, h - late))
    x = np.linalg.solve(z * np.eye(2) - step[0], np.broadcast_to(step[1][:, None], (len(z), 2, 1)))[:, :, 0]
    position = (x @ part[0].T + part[1])[:, 0] / z[:, 0, 0]
    assert np.abs(found.values / (gain * (40 * position + 15 * x[:, 1])) - 1.0).max() < 1e-5
    assert found.frequency[-1] == pytest.approx(10.0) and found.growing == growing
    own = found.crossovers[-1].gain_margin * gain
    verify(SECTION, f"digital controller, {gain} times its gain: gain margin", own, 5.50964187, "z = -1", relative=1e-5)
    assert not [text for text in found.warnings if "sampled" in text]


@pytest.mark.parametrize(("gain", "grows"), [(5.45, False), (5.57, True)])
def test_runs_beside_the_gain_margin_of_a_sampled_loop(gain, grows):
    """One percent below and above it the command of a run decays and grows."""
    law = f"signals.command.input={gain}*(40*(target - position) - 15*rail.velocity)"
    run = RecordedRun(input_deck("digital_control", law, "time.end=6"))
    early, late = (np.ptp(run["signals/command/value"][(run.time > t) & (run.time <= t + 1)]) for t in (2, 5))
    assert (late > 1.5 * early) if grows else (late < 0.7 * early)


def test_a_sampled_loop_in_which_the_force_is_measured():
    """The sample of the measured force is that before the jump: its part in L is 0.3/z."""
    law = "signals.command.input=40*(target - rail.displacement) - 15*rail.velocity - 0.3*motor.force"
    found = loop(input_deck("digital_control", law), "command", 1.0, 9.0, number=6)
    z, h = np.exp(0.05 * s_of(found)), 0.05
    position, velocity = 0.25 * h**2 * (z + 1.0) / (z - 1.0) ** 2, 0.5 * h / (z - 1.0)
    assert np.abs(found.values / (40 * position + 15 * velocity + 0.3 / z) - 1.0).max() < 1e-5


def test_other_places_of_a_sampled_loop():
    found = loop(input_deck("digital_control"), "position", 0.3, 5.0, number=8)
    assert found.growing is None
    assert [text for text in found.warnings if "half the sampling frequency, 10 Hz; open it at 'command'" in text]
    with pytest.raises(UsageError, match="from 12 Hz: half the sampling frequency of the loop is 10 Hz"):
        loop(input_deck("digital_control"), "command", 12.0, 20.0)


@pytest.mark.parametrize("gain", [1.0, -1.0])
def test_the_stability_of_a_large_model(gain):
    """Only modes nearest to zero are known, of which a damper with the wrong sign makes some grow."""
    model = f"""
mecano: 1
gravity: none
nodes: {{root: {{position: [0, 0, 0], fixed: true}}, tip: {{position: [1, 0, 0]}}}}
sections: {{steel: {{type: rectangle, width: 4 cm, height: 2 cm, E: 210 GPa, nu: 0.3, density: 7850}}}}
elements: {{beam: {{type: beam, nodes: [root, tip], section: steel, up: [0, 0, 1], mesh: 70}}}}
signals: {{damper: {-gain}*tip.velocity.z}}
loads: {{damper: {{type: force, node: tip, direction: [0, 0, 1], value: damper}}}}
{TIME}
"""
    growing = loop(model, "damper", 10.0, 20.0, number=4).growing
    assert growing is None if gain > 0.0 else growing > 0


class TestErrors:
    LIFT = "  lift: {type: prescribed_position, node: other, direction: [0, 0, 1], value: 0}\n"

    @pytest.mark.parametrize(
        ("signal", "message"),
        [
            ("command", "what it drives does not act back on it .*; signals in loops: error, late, thrust, motor"),
            ("idle", "the signal is in no loop: nothing that moves reads it at this state"),
            ("thrst", "there is no signal thrst; did you mean thrust"),
            ("lift.value", "a prescribed motion is a function of time, so it closes no loop"),
        ],
    )
    def test_signals_without_loop(self, signal, message):
        model = servo().replace("nodes: {", "nodes: {other: {position: [0, 1, 0]}, ")
        model = model.replace("elements: {", "elements: {other: {type: point_mass, node: other, mass: 1}, ")
        model = model.replace("joints: {rail: ", "joints:\n  rail: ").replace(
            "1, 0, 0]}}\n", f"1, 0, 0]}}\n{self.LIFT}"
        )
        with pytest.raises(UsageError, match=message):
            loop(model.replace("  command:", "  idle: rail.displacement\n  command:"), signal)

    def test_no_signal_is_in_a_loop(self):
        with pytest.raises(UsageError, match="no signal of the deck is in a loop"):
            loop(servo().replace("value: motor}", "value: command}"), "motor")

    def test_a_controller_at_its_limit(self):
        with pytest.raises(UsageError, match="in no loop: .* at this state"):
            loop(input_deck("position_servo"), "thrust")

    def test_crossovers_beyond_the_range(self):
        found = loop(servo(), "motor", 0.1, 2.0)
        assert [text for text in found.warnings if "the loop gain is not below 1 at 2 Hz" in text]
        assert np.isnan(found.phase.value) and np.isnan(found.delay.value)


class TestCommand:
    """`mecano margins` with its files."""

    @pytest.fixture(autouse=True)
    def folder(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "servo.yaml").write_text(servo())

    def invoke(self, *arguments):
        base = ("margins", "servo.yaml", "--open-loop", "motor", "--from", "0.1", "--to", "100")
        return CliRunner().invoke(commands, [*base, *arguments])

    def test_files(self, tmp_path):
        """Table, file, picture and CSV hold the same numbers."""
        done = self.invoke("--plot", "--csv")
        assert done.exit_code == 0, done.output
        assert "closed loop: stable" in done.output
        file = read_margins("servo_margins.h5")
        assert file.signal == "motor" and file.margins["growing"] == 0.0
        assert f"phase {np.degrees(file.margins['phase']):.6g} deg" in " ".join(done.output.split())
        assert np.abs(file.values / of_servo(2j * np.pi * file.frequency) - 1.0).max() < 1e-10
        assert file.crossovers["of_gain"].tolist() == [0.0, 1.0, 0.0, 0.0]
        rows = np.loadtxt("servo_margins.csv", delimiter=",", skiprows=1)
        assert rows[:, 1] * np.exp(1j * np.radians(rows[:, 2])) == pytest.approx(file.values, rel=1e-11)
        assert rows[:, 3] == pytest.approx(1.0 / np.abs(1.0 + file.values), rel=1e-11)
        assert (tmp_path / "servo_margins.png").stat().st_size > 10_000
        assert "mecano margins" in info("servo_margins.h5")
        assert [path.name for path in post(["servo_margins.h5"], output="drawn")] == ["drawn.png"]

    def test_poles_of_samples_in_table_and_file(self, tmp_path):
        """A mass of 1 kg whose sampled force is -v: v is multiplied by 1 - T each time."""
        (tmp_path / "cart.yaml").write_text("""
mecano: 1
gravity: none
nodes: {cart: {position: [0, 0, 0]}}
elements: {cart: {type: point_mass, node: cart, mass: 1}}
signals: {held: {type: sample_and_hold, input: -cart.velocity.x, period: 0.1}}
loads: {motor: {type: force, node: cart, direction: [1, 0, 0], value: held}}
time: {end: 1, step: 0.01}
""")
        done = CliRunner().invoke(commands, ["margins", "cart.yaml", "--open-loop", "held"])
        assert done.exit_code == 0, done.output
        found, wanted = read_margins("cart_margins.h5").sample_poles, np.log(0.9) / 0.1
        assert np.abs(found - wanted).min() < 1e-9
        assert f"{wanted:.4g}" in done.output.split("pole of the samples")[1]

    @pytest.mark.parametrize(("high", "at_end"), [("3", True), ("100", False)])
    def test_a_sensitivity_that_rises_to_the_end_of_the_range(self, high, at_end):
        """Its peak at 3.8 Hz is beyond the first of these ranges (test_pid_controller_of_a_mass_with_a_delay)."""
        line = next(line for line in self.invoke("--to", high).output.splitlines() if "sensitivity peak" in line)
        assert ("end of range" in line) == at_end

    def test_nothing_is_replaced_unless_asked(self):
        assert self.invoke().exit_code == 0
        assert isinstance(self.invoke().exception, ResultsError)
        assert self.invoke("--force").exit_code == 0

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (["--to", "0.01"], "the highest frequency, 0.01 Hz, is less than"),
            (["--to", "0.1"], "margins need two or more frequencies, the highest greater than 0.1 Hz"),
            (["--number", "1"], "margins need two or more frequencies"),
            (["-o", "a.csv"], "results are HDF5"),
        ],
    )
    def test_errors(self, arguments, message):
        assert message in str(self.invoke(*arguments).exception)
