"""Prescribed motions that are formulas of the time: their rates, the motion, the reactions, and what is refused."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from time_runs import RecordedRun, deck, input_deck

from mecano.errors import DeckError
from mecano.laws.formula import evaluate_formula, read_formula
from mecano.laws.formula_rate import rate_of

FORMULAS = (
    "3*time - 2/(1 + time) + time**3 - 0.7", "sin(2*time)*cos(time)", "tan(time/2)", "exp(-time)*log(2 + time)",
    "asin(time/3) + acos(time/4) + atan(3*time)", "sqrt(1 + time**2)", "tanh(time - 1)", "0.3",
    "hypot(time, 2) - atan2(time, 3)",
    "2**time + (1 + time)**time", "-(-time)**2 + pi*time", "sin(2*pi*(time + 0.3*time**2))", "5 - time + +time",
)  # fmt: skip


def _value(text, t):
    formula = read_formula(text, 100_000)
    return float(evaluate_formula(formula.numbers, 0, t, [0.0], 0))


@pytest.mark.parametrize(("text", "second"), [("time**2/2", 1.0), ("3*time**1", 0.0), ("2 + time**0", 0.0)])
def test_second_rates_of_powers_are_finite_at_zero(text, second):
    assert _value(rate_of(rate_of(text)), 0.0) == pytest.approx(second, abs=1e-15)


@pytest.mark.parametrize("text", FORMULAS)
def test_the_rate_of_a_formula_is_its_derivative(text):
    """Both rates, by central differences of fourth order."""
    for once in (text, rate_of(text)):
        for t in (0.4, 0.9):
            h = 2e-4
            near, far = (_value(once, t + n * h) - _value(once, t - n * h) for n in (1, 2))
            assert _value(rate_of(once), t) == pytest.approx((8.0 * near - far) / (12.0 * h), rel=1e-8, abs=1e-9)


def test_a_shaker_sweeps_through_a_resonance(verify):
    w, damping, mass, table = 10.0 * np.pi, 0.05, 2.0, 4.0

    def acceleration(t):
        phase, rate = 2.0 * np.pi * (t + 1.5 * t**2), 2.0 * np.pi * (1.0 + 3.0 * t)
        return 0.01 * (6.0 * np.pi * np.cos(phase) - rate**2 * np.sin(phase))

    def equations(t, x):
        return [x[1], -2.0 * damping * w * x[1] - w**2 * x[0] - acceleration(t)]

    found = []
    for h, stride in ((2e-3, 1), (1e-3, 2)):
        m = RecordedRun(input_deck("swept_sine", f"time.step={h}"))
        found.append([m["elements/mount/extension"][::stride], m["joints/shaker/force"][::stride] / 1000.0])
    times = m.time[::2]
    start = [0.0, -0.01 * 2.0 * np.pi]
    exact = solve_ivp(equations, (0.0, 4.0), start, method="DOP853", t_eval=times, rtol=1e-11, atol=1e-13).y
    spring = mass * (w**2 * exact[0] + 2.0 * damping * w * exact[1])
    known = [exact[0], (table * acceleration(times) - spring) / 1000.0]
    what = "swept sine: extension of the mount [m], force of the shaker [kN]"
    verify.second_order("Mechanisms", what, *np.array(found), np.array(known), 3e-6, "SciPy")


MOTION = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [2, 0, 0]}}
    elements:
      a: {type: rigid_body, node: a, mass: 1, inertia: [0.2, 0.2, 0.2]}
      b: {type: rigid_body, node: b, mass: 1, inertia: [0.2, 0.2, 0.2]}
    joints: {a: {type: hinge, nodes: [ground, a], axis: [0, 0, 1]}, b: {type: prismatic, nodes: [ground, b], axis: X},
             PRESCRIBED}
    signals: {SIGNALS}
    laws: {parabola: {polynomial: [0, 0, 1.5]}}
    time: {end: 1, step: 0.01}
    """
ANGLE = "drive: {type: prescribed_angle, nodes: [ground, a], axis: [0, 0, 1], value: VALUE}"
GENERIC = """drive: {type: generic, nodes: [ground, a], axis: [0, 0, 1], driven: {about_axis: VALUE},
                     free: [along_1, along_2, along_axis, about_1, about_2]}"""
LENGTH = "drive: {type: prescribed_length, nodes: [ground, b], length: VALUE}".replace("ground", "a")


def _deck(prescribed, value, signals="x: 1"):
    text = MOTION.replace("PRESCRIBED", prescribed.replace("VALUE", value)).replace("SIGNALS", signals)
    return deck(text.replace("X", "[1, 0, 0]"))


@pytest.mark.parametrize(
    ("prescribed", "value", "signals", "output", "load", "inertia"),
    [
        (ANGLE, "3*ramp - 1.5*ramp", "ramp: half**2, half: time", "joints/drive/angle", "joints/drive/moment", 0.2),
        (ANGLE, "turn", "turn: {type: curve, input: time, law: {polynomial: [0, 0, 1.5]}}", "joints/drive/angle",
         "joints/drive/moment", 0.2),
        (ANGLE, "turn", "turn: {type: curve, input: time, law: parabola}", "joints/drive/angle",
         "joints/drive/moment", 0.2),
        (ANGLE, "turn", "way: 2*time, turn: {type: curve, input: way - 1, law: {polynomial: [0.375, 0.75, 0.375]}}",
         "joints/drive/angle", "joints/drive/moment", 0.2),
        (LENGTH, "2 + 1.5*time**2", "x: 1", "joints/drive/length", "joints/drive/force", 1.0),
        (GENERIC, "1.5*time**2", "x: 1", "joints/drive/angle", "joints/drive/moment", 0.2),
    ],
)  # fmt: skip
def test_signals_of_time_prescribe_motions(prescribed, value, signals, output, load, inertia):
    """y = 1.5 t^2 by formulas, inserted into one another: the acceleration 3, from the first step on."""
    m = RecordedRun(_deck(prescribed, value, signals))
    np.testing.assert_allclose(m[output] - m[output][0], 1.5 * m.time**2, atol=1e-12)
    along = m[load].reshape(len(m.time), -1)[:, -1]
    np.testing.assert_allclose(along, 3.0 * inertia, rtol=1e-9)
    assert m["energy/given"][-1] == pytest.approx(0.5 * inertia * 9.0, rel=1e-9)


@pytest.mark.parametrize(
    ("value", "signals", "message"),
    [
        ("command", "command: {type: lag, input: time, time_constant: 0.1}", "of time alone: 'command' is a lag"),
        ("0.5*b.displacement", "x: 1", "'b.displacement' depends on the motion"),
        ("one", "one: 2*two, two: 1 + one/3", "the signal 'one' depends on itself"),
        ("abs(time - 0.5)", "x: 1", "'abs' has a corner: its rates jump; a prescribed motion needs "
         "the second rate of its value; write step(time, a, b), which rises smoothly from 0 to 1"),
        ("one", "one: b.velocity", "'b.velocity' depends on the motion"),
        ("*".join(["sin(time)"] * 20), "x: 1", "it is too long a formula: give a table of its values"),
        ("s", "s: {type: curve, input: time**2, law: {linear: {slope: 1}}}", "'s' is a curve, of another input than a"),
        ("2*s", "s: {type: curve, input: time, law: {linear: {slope: 1}}}", "the curve 's' can be the whole value, but "
         "no part of a formula: write the motion as one law, a list of terms such as [{step: {...}}, {step: {...}}]"),
        ("s0", ", ".join(f"s{i}: (s{i + 1} + s{i + 1})*(s{i + 1} - 2)" for i in range(12)) + ", s12: sin(time)",
         "it is too long a formula"),
    ],
)  # fmt: skip
def test_what_prescribes_no_motion(value, signals, message):
    with pytest.raises(DeckError) as error:
        _deck(ANGLE, value, signals)
    text = error.value.problems[0].message
    assert message in text
    remedied = message.startswith(("the signal", "the curve", "it is too long", "'abs' has"))
    assert remedied or "use a spring or a law of the joint with this set point" in text


def test_the_time_is_a_motion_and_a_load():
    """The name "time" alone: a = t, and the force t on 1 kg, b = 2 + t^3/6; the impulse of the force is 1/2."""
    loads = "loads: {push: {type: joint_force, joint: b, value: time}}"
    text = MOTION.replace("PRESCRIBED", ANGLE.replace("VALUE", "time")).replace("SIGNALS", "x: 1")
    m = RecordedRun(deck(text.replace("X", "[1, 0, 0]").replace("laws: {parabola: {polynomial: [0, 0, 1.5]}}", loads)))
    np.testing.assert_allclose(m["joints/drive/angle"], m.time, atol=1e-12)
    np.testing.assert_allclose(m["loads/push/force"], m.time, atol=1e-12)
    assert m["joints/b/velocity"][-1] == pytest.approx(0.5, abs=1e-4)


def test_a_law_of_the_name_time_is_that_law():
    text = (
        MOTION.replace("PRESCRIBED", ANGLE.replace("VALUE", "time"))
        .replace("SIGNALS", "x: 1")
        .replace("X", "[1, 0, 0]")
    )
    m = RecordedRun(deck(text.replace("parabola", "time")))
    np.testing.assert_allclose(m["joints/drive/angle"], 1.5 * m.time**2, atol=1e-12)


def test_the_time_is_no_unknown_name_among_other_errors():
    with pytest.raises(DeckError) as error:
        _deck(ANGLE.replace("axis", "axle"), "time")
    assert not any("unknown law" in problem.message for problem in error.value.problems)
