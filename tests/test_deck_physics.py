"""Physically impossible models of the kinds that exist are refused, each with one problem at the right place."""

import pytest
from deck_samples import REAL

from mecano.deck.read import deck_of
from mecano.deck.source import Source
from mecano.elements import KINDS
from mecano.errors import DeckError


def problems(text):
    """The problems of a text, in the vocabulary of mecano."""
    try:
        deck_of(Source("deck.yaml", text))
    except DeckError as error:
        return error.problems
    return []


def test_the_deck_is_possible():
    assert problems(REAL) == []


@pytest.mark.parametrize(
    ("old", "new", "caret", "words"),
    [
        ("mass: 2, inertia: [1, 2", "mass: 0, inertia: [1, 2", "0,", "'mass' must be greater than zero [kg], got 0"),
        ("[1, 2, 3]", "[1, 2, -3]", "[1, 2, -3]", "'inertia' must be positive definite"),
        ("[1, 2, 3]", "[1, 1, 0, 0, 0, 0]", "[1, 1, 0", "'inertia' must be positive definite"),
        ("[1, 2, 3]", "[1, 2, 3.1]", "[1, 2, 3.1]", "triangle inequality"),
        ("[1, 2, 3]", "[[1, 0, 0.5], [0, 2, 0], [0, 0, 2]]", "[[1", "symmetric"),
        ("[1, 2, 3]", "[2, 2, 2, 1.9, 0, 0]", "[2, 2, 2, 1.9", "triangle inequality"),  # principal moments 0.1, 2, 3.9
        ("c: {position: [1,", "c: {position: [0,", "", "spring_damper 'coil'"),
        ("axis_b: [0, 1, 0]", "axis_b: [2, 0, 0]", "", "universal 'cross'"),
        ("point: [0, 0, -0.3]", "point: [0, 0, 0.3]", "", "below the ground"),
        ("axis: [0, 1, 0], tire", "axis: [0, 0, 1], tire", "", "lies flat"),
        ("axis: [0, 1, 0], tire", "axis: [0, 0, 0], tire", "[0, 0, 0]", "not all zero"),
        ("  c: {", "  d: {position: [2, 0, 0]}\n  c: {", "d:", "node 'd': no element or joint is connected to it"),
    ],
)
def test_what_cannot_be(old, new, caret, words):
    assert REAL.count(old) == 1
    (problem,) = problems(REAL.replace(old, new))
    assert words in problem.message
    line = 1 + REAL[: REAL.index(old)].count("\n")
    changed = {line + i for i in range(2)} if caret else set(range(8, 15))
    assert problem.mark.line in changed
    assert problem.mark.text[problem.mark.column - 1 :].startswith(caret)


MOTOR = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {a: {position: [0, 0, 0]}}
elements: {body: {type: rigid_body, node: a, mass: 1, inertia: [1, 2, 2]}}
joints:
  pin: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}
  motor: {type: prescribed_angle, nodes: [a, ground], axis: [0, -2, 0], value: 1.0}
time: {end: 1, step: 0.1}
"""


def test_an_angle_is_prescribed_about_the_axis_of_the_hinge():
    assert problems(MOTOR) == []
    (problem,) = problems(MOTOR.replace("[0, -2, 0]", "[0, 1, 1]"))
    assert problem.message == (
        "prescribed_angle 'motor': 'axis' is not that of hinge 'pin' between the same nodes, [0, 1, 0], the only "
        "axis about which they can turn"
    )
    assert problem.mark.text[problem.mark.column - 1 :].startswith("[0, 1, 1]")


WORM = """
mecano: 1
gravity: none
nodes:
  frame: {position: [0, 0, 0]}
  seat: {position: [0, 0, 0.1], orientation: [0.1, 0, 0]}
  worm: {position: [0, 0, 0]}
  wheel: {position: [0, 0, 0.1]}
  rack: {position: [0, 0, 0.2]}
elements:
  housing: {type: rigid_body, node: frame, mass: 1, inertia: [1, 1, 1], attached: [seat]}
  worm: {type: rigid_body, node: worm, mass: 1, inertia: [1, 1, 1]}
  wheel: {type: rigid_body, node: wheel, mass: 1, inertia: [1, 1, 1]}
  rack: {type: rigid_body, node: rack, mass: 1, inertia: [1, 1, 1]}
joints:
  hold: {type: fixed, nodes: [ground, frame]}
  a: {type: hinge, nodes: [frame, worm], axis: [1, 0, 0]}
  b: {type: hinge, nodes: [seat, wheel], axis: [0, -2, 0]}
  guide: {type: prismatic, nodes: [frame, rack], axis: [1, 0, 0]}
  gears: {type: gear_pair, nodes: [ground, worm, wheel], axis_a: [1, 0, 0], axis_b: [0, 1, 0], radius_a: 0.02, ratio: 9}
  teeth: {type: rack_and_pinion, nodes: [rack, wheel], axis: [0, 1, 0], direction: [1, 0, 0], radius: 0.1}
time: {end: 1, step: 0.1}
"""


@pytest.mark.parametrize(
    ("old", "new", "caret", "words"),
    [
        ("axis_a: [1, 0, 0]", "axis_a: [1, 0.1, 0]", "[1, 0.1, 0]", "gear_pair 'gears': 'axis_a' is not that of hinge "
         "'a' between the bodies of 'ground' and 'worm', [1, 0, 0], the only axis about which they can turn"),
        ("axis_b: [0, 1, 0], ", "", "gears:", "gear_pair 'gears': its axis [1, 0, 0], without 'axis_b' that of a, is "
         "not that of hinge 'b' between the bodies of 'ground' and 'wheel', [0, -2, 0], the only axis about which"),
        ("axis: [0, 1, 0], dir", "axis: [0, 0, 1], dir", "[0, 0, 1]", "rack_and_pinion 'teeth': 'axis' is not that of "
         "hinge 'b' between the bodies of 'rack' and 'wheel'"),
    ],
)  # fmt: skip
def test_gears_turn_about_the_axes_of_their_bearings(old, new, caret, words):
    """The carrier is the ground, and the bearings are on a housing fixed to it, or along which a rack slides."""
    assert problems(WORM) == []
    assert WORM.count(old) == 1
    (problem,) = problems(WORM.replace(old, new))
    assert problem.message.startswith(words)
    assert problem.mark.text[problem.mark.column - 1 :].startswith(caret)


@pytest.mark.parametrize(
    ("key", "hint"),
    [("release: {time: 1}", "a hinge with a 'lock' between its wheel"), ("joints: [a, b]", "a relation of the coord")],
)
def test_a_gear_pair_has_no_release_and_no_joints(key, hint):
    (problem,) = problems(WORM.replace("radius_a: 0.02, ratio: 9", f"radius_a: 0.02, ratio: 9, {key}"))
    assert "unknown key" in problem.message and problem.hint.startswith(hint)


def test_a_load_has_no_release():
    load = "loads: {push: {type: force, node: a, direction: [1, 0, 0], value: 1, release: {time: 1}}}\ntime:"
    (problem,) = problems(MOTOR.replace("time:", load))
    assert problem.hint.startswith("a load ends when its value does")


@pytest.mark.parametrize(
    ("old", "new", "words", "hint"),
    [
        ("type: hinge", "type: Revolute_joint", "unknown type 'Revolute_joint'", "here it is called 'hinge'"),
        (
            "type: hinge",
            "type: clockwork",
            "unknown type 'clockwork'",
            "`mecano list` lists all; name the file of a plugin by --plugin",
        ),
        ("axis: [0, 1, 0]", "axis: [0, 1, 0], latch: 1", "'latch' must be a mapping, got 1", "write {angle: 1}"),
        ("{position: [0", "{fixed:1, position: [0", "unknown key 'fixed:1'", "write a space after ':'"),
        ("mass: 1,", "mass: 1,5,", "a key must be a name, got '5'", "a decimal point, not a comma: 1.5"),
        ("[0, -2, 0]", "[0, -2, 0", "not valid YAML", "the bracket opened in line 8 is not closed before this"),
        ("ground, a]", 'ground, "a]', "not valid YAML", "the quotation mark in line 7 is not closed"),
        ("  motor:", "   motor:", "not valid YAML", "keys that belong together begin in the same column"),
        ("mecano: 1", "mecano: 1\nbodies: {}", "unknown key 'bodies'", "here it is called 'elements'"),
        ("mecano: 1", "mecano: 1\nuse: {}", "unknown key 'use'", "here it is called 'place'"),
        ("ground, a], axis", "ground, a], normal", "unknown key 'normal'", "here it is called 'axis'"),
        ("time: {", "time: {solver: radau, ", "unknown key 'time.solver'", "here it is called 'method'"),
        (
            "axis: [0, 1, 0]",
            "axis: [0, 1, 0], turning_law: {spring: {stiffness: 3, preload: 2}}",
            "unknown key 'turning_law.spring.preload'",
            "it is a term of its own: {spring: ..., preload: ...}",
        ),
        ("mass: 1,", "m: 1,", "unknown key 'm'", "here it is called 'mass'"),
        (
            "axis: [0, 1, 0]",
            "axis: [0, 1, 0], law: {spring: 1}",
            "unknown key 'law'",
            "here it is called 'turning_law'",
        ),
        ("axis: [0, 1, 0]", "axis: [0, 1, 0], spring: 1", "unknown key 'spring'", "write it in the 'turning_law': {sp"),
        (
            "axis: [0, 1, 0]",
            "axis: [0, 1, 0], motor: 1",
            "unknown key 'motor'",
            "a torque is a load, {type: joint_moment",
        ),
        ("value: 1.0", "value: 1.0, speed: 2", "unknown key 'speed'", "here it is called 'rate'"),
        (
            "time:",
            "initial: {angles: {pin: 1}}\ntime:",
            "unknown key 'initial.angles'",
            "the positions at the start are those of the nodes",
        ),
        (
            "time:",
            "signals: {a: {type: transfer_function, input: 1, numerator: [1], denominator: [1], num: [1]}}\ntime:",
            "unknown key 'num'",
            "here it is called 'numerator'",
        ),
        (
            "step: 0.1",
            "step: 0.1, adaptive: {tol: 1}",
            "unknown key 'time.adaptive.tol'",
            "here it is called 'tolerance'",
        ),
        ("time:", "output: 1 ms\ntime:", "'output' must be a mapping, got 1 ms", "write {every: 1 ms}"),
        ("value: 1.0", "value: max(time, 2)", "a key must be a name, got '2)'", "put a formula with commas in quotes"),
        (
            "value: 1.0",
            "value: min(time, pi)",
            "a key must be a name, got 'pi)'",
            "put a formula with commas in quotes",
        ),
        ("value: 1.0", "value: {table: {points: [0, 0, 1, 5]}}", "must be a list of [x, y] pairs", "write [[0, 0]"),
        ("value: 1.0", "value: {polynomial: 3}", "must be a list of numbers, got 3", ""),
        (
            "time:",
            "initial: {velocities: {nodes: [a]}}\ntime:",
            "must be a list, each item a",
            "begin each item with '-'",
        ),
        ("time:", "initial: {velocities: [{nodes: a}]}\ntime:", "members or 'all', got the text 'a'", "write [a]"),
        ("mass: 1,", "mass: '1,',", "must be a number [kg], got the text '1,'", "write 1"),
        ("type: rigid_body,", "rigid_body: ,", "unknown key 'rigid_body'", "write 'type: rigid_body'"),
        ("time:", "post: {position: [0, 0, 0]}\ntime:", "unknown key 'post'", "indent it, if it is an entry of the"),
        (
            "mass: 1,",
            "mass: 1, attached: -a,",
            "must be a list of node names, got the text '-a'",
            "write a space after",
        ),
        ("time:", "tire_laws: {t: 3}\ntime:", "tire law 't': must be a mapping, got 3", ""),
        ("mass: 1,", "weight: 1,", "unknown key 'weight'", "here it is called 'mass'"),
        (
            "mass: 1,",
            "mass: '=2*load',",
            "there is no constant 'load'; constants: pi; this value is a number, no formula",
            "",
        ),
        (
            "time:",
            "signals: {s: {type: switch, input: time, threshold: 1}}\ntime:",
            "unknown key 'threshold'",
            "here it is called 'upper'",
        ),
        ("value: 1.0", "torque: 1.0", "unknown key 'torque'", "here it is called 'value'"),
        ("axis: [0, 1, 0]", "axis: [0, 1, 0], rate: 1", "unknown key 'rate'", "a given motion is a joint, {type: pre"),
        ("gravity:", "plane: xz\ngravity:", "unknown key 'plane'", "all models are in space"),
        (
            "time:",
            "initial: {rates: {pin: 1}}\ntime:",
            "unknown key 'initial.rates'",
            "give the velocities of the bodies",
        ),
        (
            "time:",
            "loads: {b: {type: brake, nodes: [ground, a], axis: [0, 1, 0], value: 1}}\ntime:",
            "unknown key 'value'",
            "here it is called 'torque'",
        ),
        ("type: hinge,", "type: hinge, brake: {while: time > 1},", "unknown key 'brake'", "here it is called 'lock'"),
        ("mass: 1,", "mass = 1,", "unknown key 'mass = 1'", "write ': ' instead of '='"),
        ("type: hinge", "kind: hinge", "unknown key 'kind'", "here it is called 'type'"),
        ("joints:", "constraints:", "unknown key 'constraints'", "here it is called 'joints' or 'elements'"),
        ("gravity:", "g:", "unknown key 'g'", "here it is called 'gravity'"),
        ("time:", "times:", "unknown key 'times'", "did you mean 'time'?"),
        ("time:", "simulation:", "unknown key 'simulation'", "here it is called 'time'"),
        ("mecano: 1", "mecano: 1\nname: motor", "unknown key 'name'", "here it is called 'title'"),
        ("ground, a], axis: [0, 1", "ground, body], axis: [0, 1", "unknown node 'body'", "'body' is an element, whose"),
        ("inertia:", "MomentOfInertia:", "unknown key 'MomentOfInertia'", "here it is called 'inertia'"),
        ("step: 0.1", "dt: 0.1", "unknown key 'time.dt'", "here it is called 'step'"),
        ("{position: [0", "{velocity: [1, 0, 0], position: [0", "unknown key 'velocity'", "give it in 'initial': "),
        ("step: 0.1", "step: 0.1, tolerance: 1", "unknown key 'time.tolerance'", "did you mean 'adaptive.tolerance'?"),
        ("[0, -2, 0]", "[0, -2, 0] * $s", "not valid YAML", "'*' begins a reference of YAML; lists have no products"),
        ("mecano: 1", "mecano: 1\ntitle: a: b", "not valid YAML", "put a text with ': ' in quotes"),
    ],
)
def test_slips_are_answered_with_a_correction(old, new, words, hint):
    (problem,) = problems(MOTOR.replace(old, new, 1))
    assert words in problem.message and problem.hint.startswith(hint)


RAIL = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {a: {position: [0, 0, 0]}}
elements: {body: {type: rigid_body, node: a, mass: 1, inertia: [1, 2, 2]}}
joints:
  rail: {type: prismatic, nodes: [ground, a], axis: [0, 0, 1], latch: {displacement: -0.5}, stops: {lower: -500 mm}}
time: {end: 1, step: 0.1}
"""


def test_an_error_of_a_value_names_the_lines_of_its_parameters():
    """The value is wrong where a parameter is used; what to change is where it is given."""
    text = MOTOR.replace("mass: 1,", "mass: $heavy - 3,").replace("mecano: 1", "mecano: 1\nparameters: {heavy: 2}")
    (problem,) = problems(text)
    line = text.splitlines().index("parameters: {heavy: 2}") + 1
    assert problem.message.endswith("'mass' must be greater than zero [kg], got -1.0 ($heavy - 3)")
    assert problem.hint == f"$heavy is given in line {line}"
    assert problem.mark.line == text.splitlines().index(next(x for x in text.splitlines() if "$heavy" in x)) + 1


def test_a_latch_lies_before_the_stops():
    """Otherwise the joint would never come to it; at the stop itself it does."""
    hinge = RAIL.replace("prismatic", "hinge").replace("displacement: -0.5", "angle: 90 deg")
    hinge = hinge.replace("lower: -500 mm", "upper: 90 deg")
    assert problems(RAIL) == problems(hinge) == problems(hinge.replace("upper: 90 deg", "lower: -1")) == []
    (problem,) = problems(RAIL.replace("-500 mm", "-499 mm"))
    assert problem.message == (
        "prismatic 'rail': 'latch.displacement' lies at -0.5 m, beyond the lower stop at -0.499 m: the joint would "
        "never lock"
    )
    assert problem.mark.text[problem.mark.column - 1 :].startswith("-0.5}") and "to -0.5 m or beyond" in problem.hint
    (problem,) = problems(hinge.replace("upper: 90 deg", "upper: 80 deg"))
    assert "'latch.angle' lies at 1.5708 rad, beyond the upper stop at 1.39626 rad" in problem.message


@pytest.mark.parametrize(
    ("value", "words", "hint"),
    [
        ("{type: sine, amplitude: 1}", "a law has no 'type'", "write {sine: {...}}"),
        (
            "[{linear: {slope: 1}}, 3]",
            "each item of a law that is a list is a mapping",
            "{linear: {slope: 2.0}}, {...}]",
        ),
        ("[{step: {time: 0, rise: 1, from: 0, to: 1}}, {stp: {}}]", "unknown term 'value.stp' of a law", "'step'"),
    ],
)
def test_errors_in_laws_show_how_laws_are_written(value, words, hint):
    (problem,) = problems(MOTOR.replace("value: 1.0", f"value: {value}"))
    assert words in problem.message and hint in problem.hint


BAR = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {a: {position: [0, 0, 0], orientation: [0, 0.5, 0]}, b: {position: [1, 0, 0], orientation: [0, 0.5, 0]}}
elements: {bar: {type: rigid_body, node: a, mass: 1, inertia: [1, 2, 2], attached: [b]}}
time: {end: 1, step: 0.1}
"""


def test_attached_nodes_may_have_an_orientation_of_their_own():
    """Their motion is compared in test_markers.py."""
    assert problems(BAR) == []
    assert problems(BAR.replace("1, 0, 0], orientation: [0, 0.5, 0]", "1, 0, 0]")) == []


LINE = """
mecano: 1
nodes: {a: {position: [0, 0, 0], fixed: true}, b: {position: [1, 0, 0]}}
elements: {line: {type: cable, nodes: [a, b], axial_stiffness: 1000}}
time: {end: 1, step: 0.1}
"""


@pytest.mark.parametrize("given", ["", "gravity: null\n"])
@pytest.mark.parametrize(
    ("text", "heavy"),
    [(MOTOR, "body"), (LINE.replace("1000}", "1000, mass_per_length: 0.1}"), "line")],
    ids=["body", "cable"],
)
def test_what_has_mass_asks_for_gravity(text, heavy, given):
    """Reported at the top of the deck, with what would be right, together with all other mistakes."""
    without = "".join(line for line in text.splitlines(keepends=True) if not line.startswith("gravity"))
    (problem,) = problems(without.lstrip() + given)
    assert (problem.mark.line, problem.mark.column) == (1, 1)
    assert problem.message == f"missing 'gravity', the acceleration of gravity [m/s2]: '{heavy}' has mass"
    assert problem.hint == "write 'gravity: [0, 0, -9.81]' or 'gravity: none'"
    assert len(problems(without.replace("end: 1", "end: -1"))) == 2


@pytest.mark.parametrize("mass", ["", ", mass_per_length: 0"])
def test_what_has_no_mass_does_not_ask_for_gravity(mass):
    deck = deck_of(Source("deck.yaml", LINE.replace("1000", f"1000{mass}")))
    assert deck.values["gravity"] == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(("written", "meant"), [("none", [0.0, 0.0, 0.0]), ("[0, 0, -1.62]", [0.0, 0.0, -1.62])])
def test_gravity_is_a_vector_or_none(written, meant):
    deck = deck_of(Source("deck.yaml", MOTOR.replace("[0, 0, -9.81]", written)))
    assert deck.values["gravity"] == deck.resolved()["gravity"] == meant


@pytest.mark.parametrize("kind", [kind for kind in KINDS.values() if kind.section == "elements"], ids=lambda k: k.name)
def test_kinds_with_mass_have_gravity_in_their_record(kind):
    """The record of a kind that has a mass has gravity, too: of it the check of decks knows that it has weight."""
    assert ("mass" in kind.dtype.names) == ("gravity" in kind.dtype.names)
