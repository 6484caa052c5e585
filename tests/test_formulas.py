"""Formulas of signals: what they are worth, and how wrong ones are refused."""

import math

import numpy as np
import pytest
from time_runs import deck, input_deck

from mecano.analyses.prepare import prepare
from mecano.errors import DeckError
from mecano.laws.formula import FormulaError, evaluate_formula, read_formula
from mecano.maths.dual import Dual
from mecano.model.quantity_names import resolve

VALUES = {"a": 0.7, "b.angle": -1.3, "n.position.z": 2.5}
TEXTS = [
    "1 + 2*3 - 4/5", "-2**2", "2**-1", "a - b.angle - n.position.z", "min(a, b.angle, 3)*max(1, a)", "sqrt(a)**3",
    "hypot(a, b.angle)", "atan2(b.angle, a)", "abs(b.angle) + sign(b.angle)", "exp(-a)*cos(pi*time)", "tanh(a)/log(3)",
    "asin(a) + acos(a) + atan(a) + tan(a) + sin(a)", "((((a + 1)*2 + 1)*2 + 1)*2 + 1)", "+a",
    "step(a, 0.5, 0.8)*step(a, 0.9, a + 1) + step(0.9*a, 0.2, 0.4) + 2*step(time, 0, a)",
]  # fmt: skip


def worth(text, values, time=0.4):
    formula = read_formula(text)
    laws = np.array(formula.numbers)
    q = np.array([0.0, *(values[name] for name in formula.references)], object)
    return evaluate_formula(laws, 0, time, q, 0)


def plain_step(x, a, b):
    return float(np.polyval([6.0, -15.0, 10.0, 0.0, 0.0, 0.0], np.clip((x - a) / (b - a), 0.0, 1.0)))


def plain(text, time=0.4):
    functions = {name: getattr(math, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2", "tanh")}
    functions |= {"sqrt": math.sqrt, "exp": math.exp, "log": math.log, "hypot": math.hypot, "abs": abs, "min": min}
    functions |= {"step": plain_step, "max": max, "pi": math.pi, "time": time, "sign": lambda x: math.copysign(1.0, x)}
    for name, value in VALUES.items():
        text = text.replace(name, f"({value})") if "." in name else text
    return eval(text, functions | {"a": VALUES["a"]})


@pytest.mark.parametrize("text", TEXTS)
def test_values(text):
    assert worth(text, VALUES) == pytest.approx(plain(text), rel=1e-15)


@pytest.mark.parametrize("text", [text for text in TEXTS if "a" in read_formula(text).references])
def test_slopes(text):
    h = 1e-5
    found = worth(text, {name: Dual(value, float(name == "a")) for name, value in VALUES.items()})
    both = [worth(text, VALUES | {"a": VALUES["a"] + d}) for d in (h, -h)]
    slope = found.slope if isinstance(found, Dual) else 0.0
    assert slope == pytest.approx((both[0] - both[1]) / (2.0 * h), rel=1e-8, abs=1e-8)


@pytest.mark.parametrize(
    ("text", "message", "column"),
    [
        ("* 2", "cannot be understood", 0),
        ("min(a", "a bracket is not closed", 0),
        ("2*a) + 1", "a bracket is closed that was not opened", 3),
        ("100 rpm - a", "at '100 r': formulas contain no units", 4),
        ("a1 2", "cannot be understood$", 3),
        ("in + 1", "understood at 'in', which cannot be a name in formulas: choose another name", 0),
        ("2*lambda", "understood at 'lambda', which cannot be a name in formulas", 2),
        ("a*tip.position[2]", "a component is written .x, .y or .z", 2),
        ("a if b else c", "numbers, names, .* and functions only; a signal of the type 'switch' selects", 0),
        ("2*SIN(a)", "there is no function 'SIN'; did you mean 'sin'[?]", 2),
        ("STEP(time, 0, 0, 1, 9)", "no function 'STEP'; did you mean 'step'[?]", 0),
        ("step5(time, 0, 0, 1, 9)", "no function 'step5'; step(x, a, b) is 0 until x = a", 0),
        ("9*DZ(a, b)", "no function 'DZ'; a position is written node.position.x", 2),
        ("IF(time - 1: 0, 0, 1)", "cannot be understood: a signal of the type 'switch' selects", 11),
        ("if(a > 1, 2, 3)", "cannot be understood: a signal of the type 'switch' selects", 0),
        ("2*rod.1.moment.x", "at 'rod.1': formulas do not read nodes and elements of a mesh", 5),
        ("2*degrees(a)", "no function 'degrees'; angles are in radians; multiply by 180/pi", 2),
        ("2*sinus(a)", "no function 'sinus'; known: sin, cos", 2),
        ("sin(a, b)", "'sin' has the wrong number of arguments", 0),
        ("max(a)", "'max' has the wrong number of arguments", 0),
        ("1 + step(a, 0, 1, 2, 3)", "arguments: step(x, a, b) is 0 until x = a, 1 from x = b on", 4),
        ("a[0]", "numbers, names", 0),
        ("2*a^2", r"written with \*\*, as in x\*\*2", 0),
        ("__import__('os')", "no function", 0),
        ("+".join(["(a*b)"] * 101), "at most 500 characters", 0),
        ("a-(a-(a-(a-(a-(a-(a-(a-(a-a))))))))", "too many levels", 0),
        ("a - 1e999", "number that is not finite", 4),
        ("a*" + "9" * 400, "number that is not finite", 2),
    ],
)
def test_wrong_formulas(text, message, column):
    with pytest.raises(FormulaError, match=message.replace("(", "[(]").replace(")", "[)]")) as error:
        read_formula(text)
    assert error.value.column == column


def test_no_formula_is_advised_in_place_of_itself():
    """A text that begins with a quantity is no slip of typing of it."""
    with pytest.raises(DeckError) as error:
        deck(CART.replace("SIGNAL", "30 mm - rail.displacement"))
    (problem,) = error.value.problems
    assert problem.message.endswith("formulas contain no units, give them to a parameter") and not problem.hint


CART = """
    mecano: 1
    gravity: none
    parameters: {k: 3, minus: -2}
    nodes: {cart: {position: [0, 0, 0]}}
    elements: {body: {type: rigid_body, node: cart, mass: 2, inertia: [1, 1, 1]}}
    joints: {rail: {type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}
    signals:
      thrust: SIGNAL
    loads: {push: {type: joint_force, joint: rail, value: thrust}}
    time: {end: 0.1, step: 0.01}
    """


def test_parameters_are_numbers_in_formulas():
    values = deck(CART.replace("SIGNAL", "$k*rail.displacement - $minus")).values["signals"]["thrust"]
    assert values == {"type": "formula", "value": "3.0*rail.displacement - (-2.0)", "unit": None}


@pytest.mark.parametrize(
    ("signal", "message", "hint"),
    [
        ("2*rial.displacement", "there is no 'rial' with a measurable 'displacement'", "'rail'"),
        ("2*rail.angle", "'angle' of 'rail' cannot be measured", "known: displacement, velocity"),
        ("sin(2*t)", "there is no signal 't'; the time is written 'time'", ""),
        ("2*trust", "there is no signal 'trust'", "'thrust'"),
        ("k*rail.velocity", "there is no signal 'k'", "the parameter is written '$k'"),
        ("2*rail.displacement.rate", "cannot be measured: the rate of 'displacement' is 'velocity'", ""),
        ("rail.rate", "'rate' of 'rail' cannot be measured: the rate of 'displacement' is 'velocity'", ""),
        ("cart.position", "'position' of 'cart' cannot be measured", "'position.x'"),
        ("cart.x", "'x' of 'cart' cannot be measured: write position.x or velocity.x", ""),
        ("cart.rotation.z", "'rotation.z' of 'cart' cannot be measured: read the angle of a joint, or", ""),
        ("cart.acceleration.x", "cannot be measured: read the 'washout' of a component of the velocity", ""),
        ("body.mass", "'mass' of 'body' cannot be measured", "kinetic_energy"),
        (".inf", "must be finite", ""),
        ("1e308*rail.velocity", "1e+308 is out of range", ""),
        ("{type: sample_and_hold, input: 1, period: 1e-8}", "asks for 1e+07 sampling times", "2,000,000"),
        (f"{{type: transfer_function, input: 1, numerator: [1], denominator: {[1] * 102}}}", "102 coefficients", ""),
        ("9" * 400, "must be finite", ""),
        ("2*$q", "unknown parameter 'q'", "k, minus"),
        ("{type: lag, input: rail.displacement, time_constant: -1}", "greater than zero", ""),
        ("{type: formula, value: 1, unit: Nn}", "'unit': 'Nn' is not a unit", ""),
        ("{type: formula, value: 1, unit: 1 N}", "'unit': '1 N' is not a unit", ""),
        ("{type: lagg, input: rail.displacement}", "unknown type 'lagg'", "'lag'"),
        ("{type: pid, input: 1, derivative: 2}", "'derivative_time'", ""),
        ("{type: transfer_function, input: 1, numerator: [1, 2, 3], denominator: [1, 2]}", "'numerator'", ""),
        ("{type: state_space, inputs: [1], A: [[1, 2]], B: [[1]], C: [1]}", "'A' must be square", ""),
    ],
)
def test_wrong_signals(signal, message, hint):
    with pytest.raises(DeckError) as error:
        deck(CART.replace("SIGNAL", signal))
    problem = error.value.problems[0]
    assert message in problem.message and hint in problem.hint and problem.mark.line == 9


@pytest.mark.parametrize("name", ["time", "pi"])
def test_a_signal_named_as_something_in_formulas(name):
    with pytest.raises(DeckError, match=f"signal '{name}': in formulas '{name}' is"):
        deck(CART.replace("SIGNAL", "1").replace("thrust", name))


@pytest.mark.parametrize(
    ("load", "message", "hint"),
    [
        ("joint: rail, value: trust", "unknown law or signal 'trust'", "'thrust'"),
        ("joint: rail, force: thrust", "unknown key 'force'", "did you mean 'value'?"),
        ("joint: rail, torque: thrust", "unknown key 'torque'", "here it is called 'value'"),
        ("joint: rial, value: thrust", "unknown joint 'rial'", "'rail'"),
        ("joint: rail, value: 2*cart.velocity.w", "'velocity.w' of 'cart' cannot be measured", "did you mean"),
        ("joint: rail, value: {damper: {coefficient: 2}}", "is required here", ""),
    ],
)
def test_wrong_loads(load, message, hint):
    with pytest.raises(DeckError) as error:
        deck(CART.replace("SIGNAL", "1").replace("joint: rail, value: thrust", load))
    problem = error.value.problems[0]
    assert message in problem.message and hint in problem.hint


def test_a_load_along_a_coordinate_that_a_joint_has_not():
    with pytest.raises(DeckError) as error:
        deck(CART.replace("SIGNAL", "1").replace("joint_force", "joint_moment"))
    (problem,) = error.value.problems
    assert "prismatic 'rail' has no angle along which a load could work" in problem.message
    assert "hinge" in problem.hint


def test_a_name_of_several_things():
    text = CART.replace("rail", "cart").replace("SIGNAL", "cart.velocity.x + joints.cart.velocity")
    assert deck(text).values["signals"]["thrust"]["value"] == "cart.velocity.x + joints.cart.velocity"


class Counted(dict):
    """A mapping that counts how often its keys are read one after another."""

    passes = 0

    def __iter__(self):
        self.passes += 1
        return super().__iter__()


def test_a_name_is_found_without_a_search_of_all_entries():
    """Otherwise the time for n formulas grows with n^2: a thousand took 15 s."""
    system = prepare(input_deck("pendulum")).system
    entries = Counted({(e.kind.section, e.name): (e.kind, e.values) for e in system.model.elements})
    assert resolve("hinge.angle", entries, {"pin"}) == ("joints", "hinge", "angle")
    assert resolve("pin.position.z", entries, {"pin"}) == ("nodes", "pin", "position.z")
    assert resolve("nodes.pin.position.z", entries, {"pin"}) == ("nodes", "pin", "position.z")
    assert entries.passes == 0
    assert resolve("joints.hinge.angle", entries, {"pin"}) == ("joints", "hinge", "angle")
    assert resolve("loads.position.z", entries, {"loads"}) == ("nodes", "loads", "position.z")  # no section here


@pytest.mark.parametrize(
    ("name", "formula", "told"),
    [("my-hinge", "my-hinge.angle", 2), ("a-b-c", "2*a-b-c.rate", 3), ("my-hinge", "my_hinge.angle", 0)],
)
def test_a_name_with_a_hyphen_cannot_stand_in_formulas(name, formula, told):
    """One error for each part; nothing is said about names that are not in the formula."""
    joints = f"{{{name}: {{type: hinge, nodes: [ground, a], axis: [0, 0, 1]}}}}"
    with pytest.raises(DeckError) as error:
        deck(f"""
        mecano: 1
        gravity: none
        nodes: {{a: {{position: [0, 0, 0]}}}}
        elements: {{body: {{type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}}}
        joints: {joints}
        signals: {{read: {formula}}}
        time: {{end: 1, step: 0.1}}
        """)
    hint = f"in formulas '-' is a minus: to read '{name}', name it '{name.replace('-', '_')}'"
    assert [problem.hint for problem in error.value.problems].count(hint) == told
