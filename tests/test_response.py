"""Frequency responses against closed forms, other solutions of the same equations, and runs; state spaces."""

import numpy as np
import pytest
from click.testing import CliRunner
from process import mecano_process
from scipy.linalg import expm
from time_runs import INPUTS, deck, input_deck

import mecano
from mecano.analyses.response import ResponseRequest, response
from mecano.analyses.state_space_file import linear_model
from mecano.cli import commands
from mecano.errors import ResultsError, UsageError
from mecano.post.info import info
from mecano.post.pictures import post
from mecano.results.response_file import read_response
from mecano.solve.modal.state_space import state_space

TIME = "time: {end: 1, step: 1.0e-3}"


def respond(model, inputs, outputs, low=0.1, high=20.0, **options):
    """Return the Response of the text of a deck, or of a checked deck."""
    checked = deck(model) if isinstance(model, str) else model
    request = ResponseRequest(inputs=inputs, outputs=outputs, low=low, high=high, **options)
    return response(checked, None, request)[1]


def error(found, *expected):
    """Return the largest relative error of transfer functions, those of the outputs by the first input."""
    return max(np.abs(found.values[:, i, 0] / one - 1.0).max() for i, one in enumerate(expected))


def s_of(found):
    return 2j * np.pi * found.frequency


def state_space_error(found):
    """Return the largest difference of the state space from the responses, relative to the largest of each pair."""
    model = state_space(found.plant)
    own = np.array([model.C @ model.motion(s) + model.D for s in s_of(found)])
    size = np.abs(found.values).max(axis=0)
    return float((np.abs(own - found.values).max(axis=0) / np.where(size > 0.0, size, np.inf)).max())


OSCILLATOR = f"""
mecano: 1
gravity: [0, 0, -9.81]
nodes: {{hook: {{position: [0, 0, 0], fixed: true}}, weight: {{position: [0, 0, -0.5]}}}}
elements:
  mass: {{type: point_mass, node: weight, mass: 2}}
  spring: {{type: spring_damper, nodes: [hook, weight], law: {{spring: 200, damper: 4}}}}
signals: {{push: 0*time}}
loads: {{push: {{type: force, node: weight, direction: [0, 0, 1], value: push}}}}
initial: static
{TIME}
"""
OF_WEIGHT = ["weight.position.z", "weight.velocity.z", "weight.acceleration.z", "spring.force"]


def test_oscillator():
    """m s^2 + c s + k; the force of the spring is that on the weight, of tension against the push."""
    found = respond(OSCILLATOR, ["push"], OF_WEIGHT)
    s = s_of(found)
    H = 1.0 / (2.0 * s**2 + 4.0 * s + 200.0)
    assert error(found, H, s * H, s**2 * H, -(4.0 * s + 200.0) * H) < 1e-12
    assert found.output_units == ("m", "m/s", "m/s2", "N") and found.input_units == ("N",)
    assert found.static_gain[[0, 3], 0] == pytest.approx([0.005, -1.0], rel=1e-6) and found.static_gain[1, 0] == 0.0
    assert state_space_error(found) < 1e-12
    w, zeta = 10.0, 0.1
    peaks = {one.output: one for one in found.peaks}
    displaced = peaks["weight.position.z"]
    assert displaced.frequency == pytest.approx(w * np.sqrt(1 - 2 * zeta**2) / (2 * np.pi), rel=1e-7)
    assert abs(displaced.value) == pytest.approx(0.005 / (2 * zeta * np.sqrt(1 - zeta**2)), rel=1e-12)
    assert peaks["weight.velocity.z"].frequency == pytest.approx(w / (2 * np.pi), rel=1e-7)


@pytest.mark.parametrize(("spring", "late", "poles"), [(200, False, 0), (-200, False, 1), (200, True, 2)])
def test_a_response_of_an_unstable_system_is_reported(spring, late, poles):
    """2 s^2 + 4 s + k + 150 exp(-0.1 s): without the late force stable for k > 0, with it two poles grow.

    They are near the frequency at which the late force has turned by a quarter of a period and outweighs the damper.
    """
    text = OSCILLATOR.replace("spring: 200", f"spring: {spring}").replace("initial: static", "")
    if late:
        text = text.replace("push: 0*time", "push: 0*time, seen: {type: delay, input: weight.position.z, time: 0.1}")
        text = text.replace("value: push}", "value: push - 150*seen}")
        s = np.roots([2.0, 4.0, 350.0])[0]  # by Newton's method
        for _ in range(20):
            s -= (2 * s**2 + 4 * s + 200 + 150 * np.exp(-0.1 * s)) / (4 * s + 4 - 15 * np.exp(-0.1 * s))
        assert s.real > 0.1
    found = respond(text, ["push"], ["weight.position.z"])
    said = f"unstable, with {poles} pole{'s' if poles > 1 else ''} with a positive real part"
    assert any(said in one for one in found.warnings) == (poles > 0)


def test_a_load_is_an_input_itself():
    """The law of time of a load, with any value, gives the response of a signal in its place."""
    model = OSCILLATOR.replace("value: push}", "value: {sine: {amplitude: 3, frequency: 2}}}")
    found = respond(model, ["push.value"], OF_WEIGHT, refined=False)
    signal = respond(OSCILLATOR, ["push"], OF_WEIGHT, refined=False)
    assert np.abs(found.values / signal.values - 1.0).max() < 1e-10
    assert found.input_units == ("N",)


def test_a_formula_of_outputs_is_an_output():
    found = respond(OSCILLATOR, ["push"], ["spring.force/200 + 2*weight.position.z", "push"])
    s = s_of(found)
    H = 1.0 / (2.0 * s**2 + 4.0 * s + 200.0)
    assert error(found, (2.0 - (4.0 * s + 200.0) / 200.0) * H, 1.0 + 0.0 * s) < 1e-12


def test_transmissibility_and_forces_of_a_shaker():
    """The reaction moves plate and weight: F = M s^2 + m s^2 T, T = (c s + k)/(m s^2 + c s + k)."""
    outputs = ["weight.position.z", "weight.velocity.z", "isolator.extension", "shaker.force", "shaker.displacement"]
    found = respond(input_deck("base_excitation"), ["shaker.value"], outputs)
    s = s_of(found)
    T = (4.0 * s + 200.0) / (2.0 * s**2 + 4.0 * s + 200.0)
    assert error(found, T, s * T, 1.0 - T, 20.0 * s**2 + 2.0 * s**2 * T, 1.0 + 0.0 * s) < 1e-11
    with pytest.raises(UsageError, match="shaker.force to shaker.value grows with the frequency"):
        linear_model(found)
    assert state_space_error(respond(input_deck("base_excitation"), ["shaker.value"], outputs[:3])) < 1e-12


def test_prescribed_motions_by_signals():
    """road drives the table by the slope of its formula; a curve is the whole motion."""
    base = (INPUTS / "base_excitation.yaml").read_text()
    signals = "signals: {road: 0.02, lift: 3*road + 0.1*sin(2*road)}\n"
    by_formula = base.replace("value: motion}", "value: lift + road}") + signals
    found = respond(by_formula, ["road", "lift"], ["weight.position.z"])
    s = s_of(found)
    T = (4.0 * s + 200.0) / (2.0 * s**2 + 4.0 * s + 200.0)
    assert error(found, (4.0 + 0.2 * np.cos(0.04)) * T) < 1e-11
    assert np.abs(found.values[:, 0, 1] / T - 1.0).max() < 1e-11
    curve = "signals: {bump: {type: curve, input: time, law: motion}}\n"
    found = respond(base.replace("value: motion}", "value: bump}") + curve, ["bump"], ["weight.position.z"])
    assert error(found, (4.0 * s_of(found) + 200.0) / (2.0 * s_of(found) ** 2 + 4.0 * s_of(found) + 200.0)) < 1e-11


def row(stiffness, masses, dampers, extra):
    """Masses along x, each on a spring and a damper from the one before; the first stands on a fixed node."""
    n = len(masses)
    nodes = ["p0: {position: [0, 0, 0], fixed: true}", *(f"p{i}: {{position: [{i}, 0, 0]}}" for i in range(1, n + 1))]
    elements = [f"m{i}: {{type: point_mass, node: p{i}, mass: {m}}}" for i, m in enumerate(masses, start=1)]
    elements += [
        f"s{i}: {{type: spring_damper, nodes: [p{i - 1}, p{i}], law: {{spring: {k}, damper: {c}}}}}"
        for i, (k, c) in enumerate(zip(stiffness, dampers, strict=True), start=1)
    ]
    joints = [
        f"h{i}{axis}: {{type: prescribed_position, node: p{i}, direction: {direction}, value: 0}}"
        for i in range(1, n + 1)
        for axis, direction in (("y", "[0, 1, 0]"), ("z", "[0, 0, 1]"))
    ]
    sections = {"nodes": nodes, "elements": elements, "joints": joints}
    text = "".join(f"{name}:\n" + "".join(f"  {line}\n" for line in lines) for name, lines in sections.items())
    return f"mecano: 1\ngravity: none\n{text}{extra}\n{TIME}\n"


PUSH = "loads: {push: {type: force, node: p1, direction: [1, 0, 0], value: 0}}"


def test_absorber_without_damping():
    """The main mass stands still at sqrt(k2/m2); both peaks are infinite, at the roots of the determinant."""
    found = respond(row([1000, 100], [10, 1], [0, 0], PUSH), ["push.value"], ["p1.position.x", "p2.position.x"])
    s = s_of(found)
    D = (10 * s**2 + 1100) * (s**2 + 100) - 100**2
    apart = found.values[:, :, 0] * D[:, None] - np.array([s**2 + 100, 100 + 0 * s]).T
    assert np.abs(apart).max() < 1e-10 * 100  # points within 1e-4 of a pole and of the zero are among them
    squares = np.sort(np.roots([10, 2100, 100 * 1000]).real)[::-1]
    for i in range(2):
        peaks = [one for one in found.peaks if one.output == found.outputs[i]]
        exact = np.sqrt(-squares) / (2 * np.pi)
        assert [one.frequency for one in peaks] == pytest.approx(exact.tolist(), rel=1e-10)
        assert all(np.isinf(one.value) for one in peaks)
    dip = found.frequency[np.argmin(np.abs(found.values[:, 0, 0]))]
    assert dip == pytest.approx(10 / (2 * np.pi), rel=1e-3)


def test_a_single_frequency():
    """A range of no width is one frequency, whatever their number."""
    found = respond(OSCILLATOR, ["push"], ["weight.position.z"], 1.0, 1.0)
    assert found.frequency.tolist() == [1.0] and not found.peaks
    assert error(found, 1.0 / (2.0 * s_of(found) ** 2 + 4.0 * s_of(found) + 200.0)) < 1e-12


def test_a_narrow_resonance_is_not_missed():
    """Damping ratio 1e-5, and ten frequencies over two decades."""
    found = respond(row([1000], [10], [2e-3], PUSH), ["push.value"], ["p1.position.x"], number=10)
    (peak,) = found.peaks
    assert peak.frequency == pytest.approx(10 / (2 * np.pi), rel=1e-9)
    assert abs(peak.value) == pytest.approx(1 / (2e-3 * 10), rel=1e-6)


def test_quarter_car():
    """A signal moves the ground below the tyre: wheel 40 kg on 200 kN/m, body 400 kg on 20 kN/m and 1.5 kN s/m."""
    model = row([20e4, 20e3], [40, 400], [0, 1500], "").replace(", fixed: true", "") + ("signals: {road: 0*time}\n")
    held = "  road_y: {type: prescribed_position, node: p0, direction: [0, 1, 0], value: 0}\n"
    held += "  road_z: {type: prescribed_position, node: p0, direction: [0, 0, 1], value: 0}\n"
    held += "  road: {type: prescribed_position, node: p0, direction: [1, 0, 0], value: road}\n"
    found = respond(
        model.replace("joints:\n", f"joints:\n{held}"), ["road"],
        ["p2.position.x", "p2.acceleration.x", "s1.force", "s2.extension"],
    )  # fmt: skip
    s = s_of(found)
    coupling = 1500 * s + 20e3
    D = (40 * s**2 + coupling + 20e4) * (400 * s**2 + coupling) - coupling**2
    wheel, body = 20e4 * (400 * s**2 + coupling) / D, 20e4 * coupling / D
    assert error(found, body, s**2 * body, 20e4 * (wheel - 1.0), body - wheel) < 1e-10
    assert state_space_error(found) < 1e-10


def receptance(frequency, length, stiffness, shear, mass, rotary):
    """Return the deflection of the tip by a force there of Timoshenko's cantilever, by transfer matrices.

    w' = theta + Q/GA, theta' = M/EI, M' = -Q - rho I w^2 theta, Q' = -rho A w^2 w.
    """
    omega2 = (2 * np.pi * frequency) ** 2
    A = np.array(
        [
            [0, 1, 0, 1 / shear], [0, 0, 1 / stiffness, 0], [0, -rotary * omega2, 0, -1], [-mass * omega2, 0, 0, 0],
        ]
    )  # fmt: skip
    T = expm(A * length)
    root = np.linalg.solve(T[2:, 2:], [0.0, 1.0])  # moment and force there, from those at the tip
    return (T[:2, 2:] @ root)[0]


@pytest.mark.parametrize(("mesh", "tolerance"), [(8, 8e-3), (80, 8e-5)])
def test_cantilever(mesh, tolerance):
    """Dense up to 400 motions, sparse above; second-order elements."""
    model = f"""
mecano: 1
gravity: none
nodes: {{root: {{position: [0, 0, 0], fixed: true}}, tip: {{position: [1, 0, 0]}}}}
sections: {{steel: {{type: rectangle, width: 40 mm, height: 20 mm, E: 210 GPa, nu: 0.3, density: 7850}}}}
elements: {{beam: {{type: beam, nodes: [root, tip], section: steel, up: [0, 0, 1], mesh: {mesh}}}}}
loads: {{push: {{type: force, node: tip, direction: [0, 0, 1], value: 0}}}}
{TIME}
"""
    found = respond(model, ["push.value"], ["tip.position.z"], 2.0, 150.0, number=24, refined=False)
    E, I, area = 210e9, 0.04 * 0.02**3 / 12, 0.04 * 0.02
    shear = 13 / 15.3 * E / 2.6 * area  # Cowper's coefficient, 10 (1 + nu)/(12 + 11 nu)
    exact = np.array([receptance(f, 1.0, E * I, shear, 7850 * area, 7850 * I) for f in found.frequency])
    assert error(found, exact) < tolerance


SERVO = f"""
mecano: 1
gravity: none
nodes: {{cart: {{position: [0, 0, 0]}}}}
elements: {{body: {{type: point_mass, node: cart, mass: 2}}}}
joints: {{rail: {{type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}}}
signals:
  command: 0*time
  error: command - rail.displacement
  thrust: {{type: pid, input: error, proportional: 300, integral: 400, derivative: 40, derivative_time: 0.02}}
  motor: {{type: lag, input: thrust, time_constant: 0.01}}
loads: {{motor: {{type: joint_force, joint: rail, value: motor}}}}
{TIME}
"""


def test_controlled_cart():
    """Closed loop of PID controller, lag and mass; a sinusoid added to a signal with states is seen by its readers."""
    outputs = ["cart.position.x", "error", "thrust", "motor.force"]
    found = respond(SERVO, ["command", "thrust", "motor"], outputs)
    s = s_of(found)
    controller, lag, plant = 300 + 400 / s + 40 * s / (1 + 0.02 * s), 1 / (1 + 0.01 * s), 1 / (2 * s**2)
    loop = controller * lag * plant
    closed, moved = 1 / (1 + loop), np.array([loop, lag * plant, plant]) / (1 + loop)
    assert error(found, moved[0], closed, controller * closed, controller * lag * closed) < 1e-10
    for j in (1, 2):
        assert np.abs(found.values[:, 0, j] / moved[j] - 1).max() < 1e-10
    assert np.abs(found.values[:, 2, 1] - closed).max() < 1e-10  # thrust as it is read
    assert found.static_gain[:2, 0] == pytest.approx([1.0, 0.0], abs=1e-6)
    assert state_space_error(found) < 1e-10
    model = linear_model(found)
    assert sorted(model.states) == sorted(
        ["cart.position.x", "d/dt cart.position.x", "motor", "thrust.integral", "thrust.filtered"]
    )


def test_delays_are_exact():
    """exp(-s T) in a loop; a sampled value that is held, (1 - exp(-s T))/(s T); neither has a state space."""
    late = "late: {type: delay, input: motor, time: 0.02}"
    late = SERVO.replace("value: motor}", "value: late}").replace("  motor: {", f"  {late}\n  motor: {{", 1)
    found = respond(late, ["command"], ["rail.displacement"])
    s = s_of(found)
    loop = (300 + 400 / s + 40 * s / (1 + 0.02 * s)) * np.exp(-0.02 * s) / (1 + 0.01 * s) / (2 * s**2)
    assert error(found, loop / (1 + loop)) < 1e-10
    with pytest.raises(UsageError, match="'delay' or 'sample_and_hold' has no state space"):
        linear_model(found)
    held = late.replace("type: delay", "type: sample_and_hold").replace("motor, time", "motor, period")
    found = respond(held, ["command"], ["rail.displacement"])
    s = s_of(found)
    loop = (300 + 400 / s + 40 * s / (1 + 0.02 * s)) / (1 + 0.01 * s) / (2 * s**2)
    loop *= (1 - np.exp(-0.02 * s)) / (0.02 * s)
    assert error(found, loop / (1 + loop)) < 1e-10
    assert not [text for text in found.warnings if "constant" in text]


def test_late_feedback_damps_a_resonance():
    """Without its delayed damper of 0.02 N s/m the oscillator has none: m s^2 + c s exp(-s T) + k."""
    model = OSCILLATOR.replace(", damper: 4}", "}").replace("value: push}", "value: push - 0.02*late}")
    model = model.replace("push: 0*time}", "push: 0*time, late: {type: delay, input: weight.velocity.z, time: 1 ms}}")
    found = respond(model, ["push"], ["weight.position.z"])
    s = s_of(found)
    assert error(found, 1.0 / (2.0 * s**2 + 0.02 * s * np.exp(-0.001 * s) + 200.0)) < 1e-9
    (peak,) = found.peaks
    assert abs(peak.value) == pytest.approx(1.0 / (0.02 * 10.0), rel=1e-4)


@pytest.mark.parametrize("kind", ["delay", "sample_and_hold"])
def test_an_input_that_is_read_late(kind):
    """A sinusoid of a signal that only a delay, or a sampled value, reads."""
    key = {"delay": "time", "sample_and_hold": "period"}[kind]
    late = f"late: {{type: {kind}, input: motor, {key}: 0.02}}"
    late = SERVO.replace("value: motor}", "value: late}").replace("  motor: {", f"  {late}\n  motor: {{", 1)
    found = respond(late, ["motor"], ["rail.displacement"])
    s = s_of(found)
    H = np.exp(-0.02 * s) if kind == "delay" else (1 - np.exp(-0.02 * s)) / (0.02 * s)
    H = H / (2 * s**2)
    assert error(found, H / (1 + (300 + 400 / s + 40 * s / (1 + 0.02 * s)) / (1 + 0.01 * s) * H)) < 1e-10
    assert not [text for text in found.warnings if "acts on nothing" in text]


def test_a_moving_set_point_acts_through_its_rate():
    """The force of spring and damper is (c s + k) times the set point."""
    model = OSCILLATOR.replace("law: {spring: 200", "natural_length: 0.4 + pull, law: {spring: 200")
    model = model.replace("signals: {push: 0*time}", "signals: {push: 0*time, pull: 0*time}")
    found = respond(model, ["pull"], ["weight.position.z", "spring.force"])
    s = s_of(found)
    H = -(4 * s + 200) / (2 * s**2 + 4 * s + 200)
    assert error(found, H, 2 * s**2 * H) < 1e-11
    assert state_space_error(respond(model, ["pull"], ["weight.position.z", "weight.velocity.z"])) < 1e-11


SPINNING = f"""
mecano: 1
gravity: none
parameters: {{spin: 50}}
nodes: {{cage: {{position: [0, 0, 0]}}, disc: {{position: [0, 0, 0]}}, tip: {{position: [0, 0, 1]}}}}
elements:
  cage: {{type: rigid_body, node: cage, mass: 1, inertia: [0.005, 0.005, 0.005], attached: [tip]}}
  disc: {{type: rigid_body, node: disc, mass: 2, inertia: [0.015, 0.015, 0.03]}}
  bearing:
    {{type: bushing, nodes: [ground, cage], stiffness: [0, 0, 0, 30, 30, 9], damping: [0, 0, 0, 0.1, 0.1, 0]}}
joints:
  pin: {{type: spherical, nodes: [ground, cage]}}
  shaft: {{type: hinge, nodes: [cage, disc], axis: [0, 0, 1]}}
signals: {{tilt: 0*time}}
loads: {{tilt: {{type: moment, node: cage, direction: [1, 0, 0], value: tilt}}}}
initial: {{velocities: [{{nodes: [disc], angular_velocity: [0, 0, $spin]}}]}}
{TIME}
"""


def test_gyroscopic_disc():
    """A a'' + c a' + k a + C n b' = M, A b'' + c b' + k b - C n a' = 0 about inertial axes; the tip is at (b, -a)."""
    found = respond(SPINNING, ["tilt"], ["tip.position.x", "tip.position.y", "tip.acceleration.y"])
    s = s_of(found)
    own, gyro = 0.02 * s**2 + 0.1 * s + 30, 0.03 * 50 * s
    D = own**2 + gyro**2
    assert error(found, gyro / D, -own / D, -(s**2) * own / D) < 1e-9
    assert state_space_error(respond(SPINNING, ["tilt"], ["tip.position.x", "tip.position.y"])) < 1e-9


def test_axes_that_turn_with_a_hub():
    """m (x'' - 2 n y' - n^2 x) + k_1 x = F, m (y'' + 2 n x' - n^2 y) + k_2 y = 0 in axes of the hub; inertial rates."""
    model = f"""
mecano: 1
gravity: none
nodes: {{hub: {{position: [0, 0, 0]}}, bob: {{position: [1, 0, 0]}}}}
elements:
  rotor: {{type: rigid_body, node: hub, mass: 1, inertia: [1, 1, 1]}}
  bob: {{type: point_mass, node: bob, mass: 0.5}}
  springs: {{type: bushing, nodes: [hub, bob], stiffness: [500, 800, 900, 9, 9, 9]}}
joints:
  shaft: {{type: hinge, nodes: [ground, hub], axis: [0, 0, 1]}}
  motor: {{type: prescribed_angle, nodes: [ground, hub], axis: [0, 0, 1], value: {{linear: {{slope: 12}}}}}}
loads: {{push: {{type: line_force, nodes: [hub, bob], value: 0}}}}
initial: {{steady: {{angular_velocity: [0, 0, 12], about: [0, 0, 0]}}}}
{TIME}
"""
    outputs = ["bob.position.x", "bob.position.y", "bob.velocity.x", "bob.acceleration.x", "bob.acceleration.y"]
    found = respond(model, ["push.value"], outputs, frame="hub")
    s, n = s_of(found), 12.0
    own_x, own_y, cross = 0.5 * (s**2 - n**2) + 500, 0.5 * (s**2 - n**2) + 800, n * s
    D = own_x * own_y + cross**2
    x, y = own_y / D, -cross / D
    acceleration = s**2 * x - 2 * n * s * y - n**2 * x, s**2 * y + 2 * n * s * x - n**2 * y
    assert error(found, x, y, s * x - n * y, *acceleration) < 1e-8
    assert not [text for text in found.warnings if "constant" in text]


def test_a_run_has_the_same_amplitude_and_phase(tmp_path):
    """A pendulum in its sagging equilibrium: the steady sine of a run at one frequency, fitted to its last periods."""
    model = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {pivot: {position: [0, 0, 0]}}
elements:
  bob: {type: rigid_body, node: pivot, mass: 2, inertia: [1, 1, 0.02], center_of_mass: [0.3, 0, -1]}
joints: {pin: {type: hinge, nodes: [ground, pivot], axis: [0, 1, 0], turning_law: {spring: 4, damper: 6}}}
signals: {drive: 2 + 0.01*sin(2*pi*0.7*time)}
loads: {drive: {type: joint_moment, joint: pin, value: drive}}
initial: static
time: {end: 20, step: 2 ms}
output: {every: 10 ms}
"""
    outputs = ["pin.angle", "pin.force.x", "pin.force.y"]
    found = respond(model, ["drive"], outputs, 0.7, 0.7, number=1)
    file = tmp_path / "pendulum.yaml"
    file.write_text(model)
    with mecano.run(file, tmp_path / "p.h5", quiet=True) as results:
        late = results.time > 20 - 5 / 0.7
        wave = np.exp(2j * np.pi * 0.7 * results.time[late])
        basis = np.array([np.ones(late.sum()), wave.imag, wave.real]).T
        values = np.array([results["pin.angle"].values[late], *results["pin.force"].values[late, :2].T]).T
    _, sine, cosine = np.linalg.lstsq(basis, values, rcond=None)[0]
    assert np.abs((sine + 1j * cosine) / (0.01 * found.values[0, :, 0]) - 1.0).max() < 1e-4


def test_section_forces_of_a_beam():
    """Those at the clamp balance its reactions; a beam inside it, rotations, nodes between beams."""
    model = f"""
mecano: 1
gravity: [0, 0, -9.81]
nodes: {{root: {{position: [0, 0, 0]}}, tip: {{position: [1, 0, 0]}}}}
sections: {{steel: {{type: rectangle, width: 40 mm, height: 20 mm, E: 210 GPa, nu: 0.3, density: 7850, damping: 1 ms}}}}
elements: {{beam: {{type: beam, nodes: [root, tip], section: steel, up: [0, 0, 1], mesh: 8}}}}
joints: {{clamp: {{type: fixed, nodes: [ground, root]}}}}
loads: {{push: {{type: force, node: tip, direction: [0, 0, 1], value: 0}}}}
initial: static
{TIME}
"""
    outputs = ["beam.1.moment_start.y", "clamp.moment.y", "tip.rotation.y", "beam.4.position.z", "beam.8.strain_energy"]
    found = respond(model, ["push.value"], outputs, 0.5, 60.0, number=30)
    stiffness, sag = 210e9 * 0.04 * 0.02**3 / 12, 5e-3
    assert found.static_gain[:2, 0] == pytest.approx([-1.0, 1.0], abs=sag)
    assert found.static_gain[2, 0] == pytest.approx(-1 / (2 * stiffness), rel=sag)
    assert found.static_gain[3, 0] == pytest.approx(0.5**2 * (3 - 0.5) / (6 * stiffness), rel=sag)
    low = found.frequency < 5.0
    assert np.abs(found.values[low, 0, 0] / found.values[low, 1, 0] + 1.0).max() < 1e-3
    assert found.output_units == ("N m", "N m", "rad", "m", "J")
    assert state_space_error(found) < 1e-7


CANTILEVER = f"""
mecano: 1
gravity: none
parameters: {{length: LENGTH, side: $length/50}}
nodes: {{root: {{position: [0, 0, 0]}}, tip: {{position: [$length, 0, 0]}}}}
sections:
  silicon: {{type: rectangle, width: $side, height: $side, E: 160 GPa, nu: 0.3, density: 2330, damping: 1.0e-4*$length}}
elements: {{beam: {{type: beam, nodes: [root, tip], section: silicon, up: [0, 0, 1], mesh: 4}}}}
joints: {{clamp: {{type: fixed, nodes: [ground, root]}}}}
loads: {{push: {{type: force, node: tip, direction: [0, 0, 1], value: 0}}}}
{TIME}
"""


def test_section_forces_of_a_microbeam():
    """Statics of a cantilever of 0.1 mm, and, over frequencies times length, the values of a large one: similarity."""
    given, outputs = ["push.value"], ["beam.1.force.z", "beam.1.moment_start.y"]
    large, small = (
        respond(CANTILEVER.replace("LENGTH", str(x)), given, outputs, 10.0 / x, 500.0 / x, number=9, refined=False)
        for x in (1.0, 1e-4)
    )
    assert small.static_gain[:, 0] == pytest.approx([1.0, -1e-4], rel=1e-8)
    np.testing.assert_allclose(small.values[:, 0], large.values[:, 0], rtol=1e-8)
    np.testing.assert_allclose(small.values[:, 1] * 1e4, large.values[:, 1], rtol=1e-8)
    assert np.abs(large.values[:, 0]).max() > 1.5  # masses and damping count


def test_forces_of_superelements():
    """Those on both sides of a node are opposite, those at a shaft that is held balance its moment."""
    push = "loads={push: {type: force, node: tip, direction: [0, 1, 0], value: 0}}"
    outputs = ["s8.force_2.y", "s1.moment_1.z", "motor.moment", "s4.moment_2.z", "s5.moment_1.z"]
    model = input_deck("superelement_arm", push, "joints.motor.value=0")
    found = respond(model, ["push.value"], outputs, 0.01, 3.0, number=12, refined=False)
    assert found.static_gain[:, 0] == pytest.approx([1.0, -10.0, -10.0, 5.0, -5.0], rel=1e-6)
    tip, root, shaft, left, right = found.values[:, :, 0].T
    assert np.abs(tip - 1.0).max() < 2e-6
    assert np.abs(root / shaft - 1.0).max() < 1e-6 and np.abs(left / right + 1.0).max() < 2e-6


def test_outputs_of_members_that_are_not_smooth():
    model = input_deck("flexible_pendulum")
    with pytest.raises(UsageError, match="write which of its elements is meant, such as rod.1.moment.y"):
        respond(model, ["hinge.natural_angle"], ["rod.moment.y"])
    with pytest.raises(UsageError, match="rod.8.stress: it has a corner at this state"):
        respond(model, ["hinge.natural_angle"], ["rod.8.stress"])


DOOR = f"""
mecano: 1
gravity: none
nodes: {{door: {{position: [0, 0, 0]}}, above: {{position: [0, 0, 2]}}}}
elements:
  door: {{type: rigid_body, node: door, mass: 20, inertia: [9, 10, 5], center_of_mass: [0.5, 0, 1], attached: [above]}}
joints:
  lower:
    {{type: hinge, nodes: [ground, door], axis: [0, 0, 1], axis_1: [1, 0, 0], turning_law: {{spring: 90, damper: 3}}}}
  upper: {{type: hinge, nodes: [ground, above], axis: [0, 0, 1], axis_1: [1, 0, 0]}}
loads: {{push: {{type: moment, node: door, direction: [0, 0, 1], value: 0}}}}
{TIME}
"""


def test_redundant_constraints_share_their_reactions():
    """A door on two hinges: I a'' + c a' + k a = M; both hinges accelerate its centre of mass, m r a'' along y.

    The compliance of redundant constraints, 1e-11 of the length, is seen at 20 Hz; the state space is without it.
    """
    outputs = ["lower.angle", "lower.force.y + upper.force.y", "lower.force.y", "upper.moment.x"]
    found = respond(DOOR, ["push.value"], outputs)
    s = s_of(found)
    H = 1.0 / ((5 + 20 * 0.25) * s**2 + 3 * s + 90)
    assert error(found, H, 20 * 0.5 * s**2 * H) < 3e-7
    assert state_space_error(found) < 5e-8
    model = state_space(found.plant)
    own = np.array([model.C @ model.motion(one) + model.D for one in s])[:, :2, 0].T
    assert np.abs(own / [H, 20 * 0.5 * s**2 * H] - 1.0).max() < 1e-12


@pytest.mark.parametrize(
    ("name", "source", "output", "states"),
    [
        ("servo_valve", "u", "mass.position.x", 4),  # pressures of 1e7 Pa beside displacements of 1e-2 m
        ("crane", "rope.payout", "hook.position.z", 12),
        ("nose_wheel_steering", "command", "steering.angle", 5),  # a controller, a tyre, a rolling wheel
        ("controlled_double_pendulum", "shoulder_error", "elbow.position.x", 4),
        ("bicycle", "rear_axle.natural_angle", "rear_hub.position.y", 10),  # rolls without slip, nothing drives it
        ("differential", "carrier_bearing.natural_angle", "carrier_bearing.angle", 4),  # nothing is stiff
    ],
)
def test_state_spaces_of_decks(name, source, output, states):
    """They have as many states as the motions and filters have, and the responses of the sparse equations."""
    model = linear_model(respond(input_deck(name), [source], [output], 0.1, 50.0, number=20))
    assert len(model.states) == len(set(model.states)) == states
    assert model.difference < 1e-6


def vehicle(front, rear, relaxation_length):
    """A vehicle of one track on a level plane, with tyres of these cornering stiffnesses [N/rad], at 20 m/s."""
    axles = {"front": (1.2, front), "rear": (-1.5, rear)}
    sections = {
        "nodes": ["body: {position: [0, 0, 0.3]}"],
        "elements": [
            "body: {type: rigid_body, node: body, mass: 1200, inertia: [500, 1500, 1800], attached: [front, rear]}"
        ],
        "joints": [
            "level: {type: planar, nodes: [ground, body], axis: [0, 0, 1]}",
            "pin: {type: hinge, nodes: [front, front_carrier], axis: [0, 0, 1]}",
            "steering: {type: prescribed_angle, nodes: [front, front_carrier], axis: [0, 0, 1], value: steer}",
            "mount: {type: fixed, nodes: [rear, rear_carrier]}",
        ],
        "tire_laws": [],
    }
    for name, (x, stiffness) in axles.items():
        sections["nodes"] += [f"{name}{part}: {{position: [{x}, 0, 0.3]}}" for part in ("", "_carrier", "_hub")]
        sections["elements"] += [
            f"{name}{part}: {{type: rigid_body, node: {name}{part}, mass: 0.01, inertia: [1.0e-4, 1.0e-4, 1.0e-4]}}"
            for part in ("_carrier", "_hub")
        ]
        sections["elements"] += [
            f"{name}_tyre: {{type: adhesive_wheel, node: {name}_hub, axis: [0, 1, 0], tire_law: {name}, ground: road}}"
        ]
        sections["joints"] += [f"{name}_bearing: {{type: hinge, nodes: [{name}_carrier, {name}_hub], axis: [0, 1, 0]}}"]
        lateral = f"{{cornering_stiffness: {stiffness}, relaxation_length: {relaxation_length}}}"
        contact = "radius: 0.32, radial: {linear: {slope: 3.0e5}}, friction: 1, slip_regularization: 0.01"
        sections["tire_laws"] += [f"{name}: {{{contact}, lateral: {{relaxation: {lateral}}}}}"]
    text = "".join(f"{name}:\n" + "".join(f"  {line}\n" for line in lines) for name, lines in sections.items())
    return f"""mecano: 1
gravity: [0, 0, -9.81]
{text}grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
signals: {{steer: 0*time}}
initial: {{steady: {{velocity: [20, 0, 0]}}}}
{TIME}
"""


def test_vehicle_in_steady_running():
    """Yaw rate and lateral acceleration by steering: single-track equations of Riekert & Schunck (1940).

    Forces of the tyres build up over the relaxation length. The wheels have 0.02 kg each; what they turn is neglected.
    """
    outputs = ["body.angular_velocity.z", "body.acceleration.y", "steering.angle"]
    found = respond(vehicle(8e4, 9e4, 0.5), ["steer"], outputs, 0.1, 5.0)
    s, V, m, a, b = s_of(found), 20.0, 1200.04, 1.2, 1.5
    inertia = 1800.0 + 0.02 * (a**2 + b**2)
    front, rear = 8e4 / (1 + 0.5 * s / V), 9e4 / (1 + 0.5 * s / V)
    sideways, turning = np.array([m * s + (front + rear) / V, m * V + (a * front - b * rear) / V])
    moved, turned = (a * front - b * rear) / V, inertia * s + (a**2 * front + b**2 * rear) / V
    D = sideways * turned - turning * moved
    v, r = (front * turned - a * front * turning) / D, (a * front * sideways - front * moved) / D
    assert error(found, r, s * v + V * r, 1.0 + 0.0 * s) < 1e-5
    wheelbase, understeer = a + b, m * (b / 8e4 - a / 9e4) / (a + b)
    assert found.static_gain[0, 0] == pytest.approx(V / (wheelbase + understeer * V**2), rel=1e-4)
    assert state_space_error(respond(vehicle(8e4, 9e4, 0.5), ["steer"], outputs[:1], 0.1, 5.0)) < 1e-5


class TestCommand:
    """`mecano response` with its files."""

    ARGUMENTS = (
        "response",
        str(INPUTS / "base_excitation.yaml"),
        "--input",
        "shaker.value",
        "--from",
        "0.1",
        "--to",
        "20",
    )

    def invoke(self, *arguments):
        return CliRunner().invoke(commands, [*self.ARGUMENTS, *arguments])

    @pytest.fixture(autouse=True)
    def folder(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)

    def test_files(self, tmp_path):
        """Table, file, picture, CSV and matrices hold the same numbers."""
        done = self.invoke("--output", "weight.position.z", "--plot", "--csv", "--state-space", "model.npz")
        assert done.exit_code == 0, done.output
        assert (
            "shaker.value  weight.position.z  m per m            1           2.491    1.57617    5.12277" in done.output
        )
        assert "state space of 6 states, which agrees with the response to" in done.output
        file = read_response("base_excitation_response.h5")
        s = 2j * np.pi * file.frequency
        T = (4.0 * s + 200.0) / (2.0 * s**2 + 4.0 * s + 200.0)
        assert np.abs(file.values[:, 0, 0] / T - 1.0).max() < 1e-11
        assert (file.inputs, file.outputs, file.input_units) == (("shaker.value",), ("weight.position.z",), ("m",))
        assert file.peaks["magnitude"] == pytest.approx([5.12277], rel=1e-6) and file.static[0, 0] == pytest.approx(1.0)
        table = np.loadtxt("base_excitation_response.csv", delimiter=",", skiprows=1)
        assert table[:, 1] * np.exp(1j * np.radians(table[:, 2])) == pytest.approx(T, rel=1e-11)
        with np.load("model.npz") as arrays:
            model = dict(arrays)
        H = model["C"] @ np.linalg.solve(s[0] * np.eye(6) - model["A"], model["B"]) + model["D"]
        assert H[0, 0] == pytest.approx(T[0], rel=1e-11)
        assert list(model["states"][[2, 5]]) == ["weight.position.z", "d/dt weight.position.z"]
        assert list(model["state_units"][[2, 5]]) == ["m", "m/s"]
        assert (tmp_path / "base_excitation_response.png").stat().st_size > 10_000
        assert "mecano response" in info("base_excitation_response.h5")
        assert [path.name for path in post(["base_excitation_response.h5"], output="drawn")] == ["drawn.png"]

    def test_matrices_for_matlab(self):
        from scipy.io import loadmat

        done = self.invoke("--output", "weight.velocity.z", "--state-space", "model.mat")
        assert done.exit_code == 0, done.output
        model = loadmat("model.mat", simplify_cells=True)
        assert model["D"] == pytest.approx(2.0) and model["states"][5] == "d/dt weight.position.z"

    def test_nothing_is_replaced_unless_asked(self):
        assert self.invoke("--output", "weight.position.z").exit_code == 0
        done = self.invoke("--output", "weight.position.z")
        assert done.exit_code != 0 and isinstance(done.exception, ResultsError)
        assert self.invoke("--output", "weight.position.z", "--force").exit_code == 0

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (["--output", "wieght.position.z"], "did you mean weight"),
            (["--output", "weight.position"], "did you mean position.x or position.y"),
            (["--output", "weight.position.z +"], "it cannot be understood"),
            (["--output", "2*time"], "it depends on nothing that moves"),
            (["--output", "weight.position.z", "--input", "shakr.value"], "did you mean shaker.value"),
            (
                [
                    "--output",
                    "weight.position.z",
                    "--input",
                    "isolator.natural_length",
                    "--set",
                    "elements.isolator.natural_length=null",
                ],
                "spring_damper 'isolator' has no 'natural_length' in the deck; give it one [m]: length at",
            ),
            (["--output", "weight.position.z", "--input", "shaker.value"], "the input shaker.value is given twice"),
            (
                ["--output", "weight.position.z", "--from", "-1"],
                "the lowest frequency must be finite and greater than zero, got -1",
            ),
            (
                ["--output", "weight.position.z", "--to", "0.01"],
                "0.01 Hz, is less than the lowest, 0.1 Hz",
            ),
            (
                ["--output", "weight.position.z", "--number", "200000"],
                "must be from 1 to 100000, got 200000",
            ),
            (["--output", "weight.acceleration.z", "--state-space", "a.npz"], "grows with the frequency"),
            (["--output", "weight.position.z", "--state-space", "a.txt"], "must end with .npz or .mat"),
            (["--output", "weight.position.z", "-o", "a.csv"], "results are HDF5"),
        ],
    )
    def test_errors(self, arguments, message):
        done = self.invoke(*arguments)
        assert isinstance(done.exception, UsageError) and message in str(done.exception)

    def test_a_large_state_space_is_refused(self, tmp_path):
        """Before the response is computed."""
        mesh, none = "elements.rod.mesh=256", "loads.turn.value=0"
        arguments = "--input", "turn.value", "--output", "tip.position.x", "--from", "1", "--to", "2"
        model = str(INPUTS / "beam_roll_up.yaml"), "--set", mesh, "--set", none
        done = CliRunner().invoke(commands, ["response", *model, *arguments, "--state-space", "a.npz"])
        assert isinstance(done.exception, UsageError), done.output
        assert "here, up to 3000: reduce flexible parts to superelements" in str(done.exception)
        assert not list(tmp_path.iterdir())

    def test_an_input_that_acts_on_nothing(self):
        done = self.invoke("--output", "weight.position.z", "--input", "idle", "--set", "signals={idle: 0*time}")
        assert "mecano: the input idle acts on nothing: no load, joint or signal reads it" in done.output

    @pytest.mark.parametrize(
        "arguments",
        [
            "modes pendulum.yaml",
            "modes pendulum.yaml --sweep elements.bar.mass=1,2",
            "response base_excitation.yaml --input shaker.value --output weight.position.z --from 1 --to 2",
        ],
    )
    def test_warnings_are_apart_from_the_table(self, tmp_path, arguments):
        """On the standard error, so that a pipe receives the table only."""
        command, model, *options = arguments.split()
        idle = ["--input", "idle", "--set", "signals={idle: 0*time}"] if command == "response" else []
        code, out, errors = mecano_process(command, INPUTS / model, *options, *idle, cwd=tmp_path)
        assert code == 0 and out.count("\n") > 1 and "mecano:" not in out
        assert "mecano: the " in errors

    def test_a_start_that_is_no_equilibrium(self):
        found = respond(input_deck("controlled_cart"), ["cylinder.value"], ["cart.position.x"])
        assert [text for text in found.warnings if "the start is not an equilibrium: the response is that of" in text]
