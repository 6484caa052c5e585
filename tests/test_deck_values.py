"""Content of a checked deck: values, defaults, replaced names, marks, and the resolved form."""

import json
import math

import numpy as np
import pytest
from deck_samples import FAKE_KINDS, VALID, fake_sections, read_fake

from mecano.deck.check import CHECKS
from mecano.deck.physics import element_nodes, poses
from mecano.deck.sections import SECTIONS
from mecano.elements import KINDS
from mecano.elements.members.cross_section import none_negative
from mecano.errors import DeckError
from mecano.laws import TERMS
from mecano.schema import Field

MINIMAL = """\
mecano: 1
gravity: [0, 0, -9.81]
nodes: {a: {position: [1, 2, 3]}}
elements: {b: {type: body, node: a, mass: 2}}
time: {end: 1, step: 0.1}
"""


def test_defaults_are_filled_in():
    values = read_fake(MINIMAL).values
    assert values == {
        "mecano": 1,
        "title": "",
        "parameters": {},
        "gravity": [0.0, 0.0, -9.81],
        "nodes": {"a": {"position": [1.0, 2.0, 3.0], "orientation": [0.0, 0.0, 0.0], "fixed": False}},
        "elements": {
            "b": {
                "type": "body",
                "node": "a",
                "mass": 2.0,
                "inertia": [1.0, 1.0, 1.0],
                "center_of_mass": [0.0, 0.0, 0.0],
                "attached": [],
                "count": 1,
            }
        },
        "sections": {},
        "joints": {},
        "loads": {},
        "signals": {},
        "laws": {},
        "grounds": {},
        "tire_laws": {},
        "initial": {"static": None, "steady": None, "from": None, "velocities": []},
        "time": {
            "start": 0.0,
            "end": 1.0,
            "until": None,
            "step": 0.1,
            "method": "generalized_alpha",
            "rho_inf": 0.8,
            "adaptive": None,
            "rest_speed": 1e-4,
            "located_events": 100,
            "newton": {"force_tolerance": 1e-7, "constraint_tolerance": 1e-10, "maximum_iterations": 15},
            "scale": {"k": "automatic", "penalty": "automatic"},
        },
        "static": None,
        "output": {"every": "step"},
    }


def test_defaults_are_not_shared():
    text = MINIMAL.replace("elements: {", "elements: {c: {type: body, node: a, mass: 2}, ")
    values = read_fake(text).values
    values["elements"]["b"]["attached"].append("x")
    values["nodes"]["a"]["orientation"][0] = 9.0
    assert values["elements"]["c"]["attached"] == []
    assert read_fake(text).values["nodes"]["a"]["orientation"] == [0.0, 0.0, 0.0]


def test_numbers_are_floats_and_parameters_replaced():
    values = read_fake(VALID).values
    assert values["elements"]["hub"]["mass"] == 82.0
    assert values["initial"]["velocities"][0]["velocity"] == [60.0, 0.0, -3.05]
    assert type(values["gravity"][0]) is float
    assert values["elements"]["leg"]["count"] == 4 and type(values["elements"]["leg"]["count"]) is int
    assert values["parameters"] == {"sink": 3.05, "mass": 82.0, "steps": 4.0}


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("$mass / 4", 20.5), ("-$mass", -82.0), ("-$mass**2", -6724.0), ("=2*pi/3", 2 * math.pi / 3), ("$later+1", 7.1),
        ("$with-dash", 3.0), ("$steps-1", 3.0), ("= max($mass, 100) - hypot(3, 4)", 95.0), ("=1e-3", 1e-3),
        ("sqrt($steps) * sin(radians(30))", 1.0), ("( $mass+-$sink )", 78.95), ("$mass*$mass*0", 0.0),
    ],
)  # fmt: skip
def test_expressions(expression, expected):
    text = VALID.replace("steps: 4}", f"steps: 4, later: $sink * 2, with-dash: 3, here: '{expression}'}}")
    text = text.replace("gravity: [0, 0, -9.81]", "gravity: [0, 0, $here]")
    assert read_fake(text).values["gravity"][2] == pytest.approx(expected, rel=1e-15)
    assert read_fake(text.replace("$here", f"'{expression}'")).values["gravity"][2] == pytest.approx(
        expected, rel=1e-15
    )


def test_expressions_are_no_programs():
    """Nothing but arithmetic comes through, in reasonable time, whatever is written."""
    texts = (
        "=__import__('os').system('true')", "=().__class__", "=[1][0]", "={}", "=lambda: 1", "=1 if 1 else 2",
        "=10**10**10", "=9**9**9**9", "=" + "(" * 300, "=" + "-" * 400 + "1", "=" + "1+" * 240 + "1", "=True", "=1j",
        "=log(0)", "=1e400", "=max()", "=sqrt(1, 2)", "=é", "$", "=", "$mass $mass", "=1<2", "=exp(x=1)", "=f'{1}'",
        "=sqrt", "=abs('a')", "=(yield)", "=(a := 1)", "=*[1]", "= 1\t+ $", "$mass" + "*$mass" * 60, "=(-1)**0.5",
        "=$mass.real", "=$mass\n+2",
    )  # fmt: skip
    for text in texts:
        with pytest.raises(DeckError) as info:
            read_fake(VALID.replace("[0, 0, -9.81]", f"[0, 0, {json.dumps(text)}]"))
        assert len(info.value.problems) == 1 and "'gravity'" not in str(info.value.problems[0].message)[:9], text


def test_a_parameter_may_use_an_earlier_one():
    text = VALID.replace("sink: 3.05,", "sink: 3.05, fall: -$sink,").replace("[60, 0, -$sink]", "[60, 0, $fall]")
    assert read_fake(text).values["initial"]["velocities"][0]["velocity"] == [60.0, 0.0, -3.05]


def test_names_are_replaced_by_their_values():
    values = read_fake(VALID).values
    elements = values["elements"]
    assert elements["absorber"]["law"] is values["laws"]["oleo"]
    assert elements["absorber"]["law"][0] == ("polynomial", {"coefficients": [0.0, 7e10]})
    assert [name for name, _ in elements["absorber"]["law"]] == ["polynomial", "damper", "stop"]
    assert elements["absorber"]["scale"] == (("polynomial", {"coefficients": [1.0, 0.5]}),)
    assert elements["wheel"]["ground"] is values["grounds"]["runway"]
    assert elements["wheel"]["tire_law"] is values["tire_laws"]["nose"]
    assert values["tire_laws"]["nose"]["friction"] == (("constant", {"value": 0.8}),)
    assert values["joints"]["held"]["nodes"] == ["ground", "axle"]


def test_a_number_is_a_constant_curve():
    text = VALID.replace("{table: {points: [[0, 0], [1, 1e3]]}}", "-$sink")
    assert read_fake(text).values["loads"]["push"]["value"] == (("constant", {"value": -3.05}),)


@pytest.mark.parametrize(("short", "full"), [("linear: 4", "slope: 4"), ("polynomial: [1, 4]", "coefficients: [1, 4]")])
def test_the_one_required_field_may_stand_for_its_term(short, full):
    texts = (short, f"{short.split(':')[0]}: {{{full}}}")
    one, other = (
        read_fake(VALID.replace("{table: {points: [[0, 0], [1, 1e3]]}}", f"{{{text}}}")).values["loads"]["push"][
            "value"
        ]
        for text in texts
    )
    assert one == other and one[0][0] == short.split(":")[0]


def test_anchors_may_be_used():
    text = VALID.replace("axis: [0, 1, 0], stop", "axis: &y [0, 1, 0], stop").replace(
        "axle], axis: [0, 1, 0]", "axle], axis: *y"
    )
    assert read_fake(text).values == read_fake(VALID).values


@pytest.mark.parametrize("text", [MINIMAL, VALID])
def test_resolved_form_is_a_deck_with_the_same_values(text):
    deck = read_fake(text, overrides=["gravity=[0, 0, -1.6]"])
    again = read_fake(json.dumps(deck.resolved()))
    assert again.values == deck.values
    assert json.loads(json.dumps(deck.resolved())) == deck.resolved() == again.resolved()


def test_resolved_form_keeps_names_and_opens_everything_else():
    resolved = read_fake(VALID).resolved()
    assert resolved["elements"]["absorber"]["law"] == "oleo"
    assert resolved["elements"]["wheel"]["ground"] == "runway"
    assert resolved["elements"]["hub"]["mass"] == 82.0
    assert resolved["laws"]["oleo"]["stop"] == {"upper": 0.3, "stiffness": 1e6, "damping": 0.0}


def test_nodes_of_an_element():
    values = read_fake(VALID).values["elements"]
    assert element_nodes(FAKE_KINDS["body"], values["leg"]) == ["knee", "top"]
    assert element_nodes(FAKE_KINDS["spring"], values["absorber"]) == ["knee", "axle"]


def test_poses():
    """Rotation by the right-hand rule: a quarter turn about z takes x to y."""
    vector = [0.3, -0.4, 1.2]
    at = poses(
        {
            "a": {"position": [1, 2, 3], "orientation": [0, 0, np.pi / 2]},
            "b": {"position": [0, 0, 0], "orientation": [0, 0, 0]},
            "c": {"position": [0, 0, 0], "orientation": vector},
        }
    )
    assert at["a"][0].tolist() == [1, 2, 3]
    np.testing.assert_allclose(at["a"][1] @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    np.testing.assert_array_equal(at["b"][1], np.eye(3))
    R = at["c"][1]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(R @ vector, vector, atol=1e-15)
    assert np.trace(R) == pytest.approx(1 + 2 * np.cos(1.3), abs=1e-14)  # |vector| = 1.3


def test_ten_thousand_nodes_and_bodies():
    import time

    n = 10_000
    nodes = "".join(f"  n{i}: {{position: [{i}, 0, {i / 2}]}}\n" for i in range(n))
    bodies = "".join(f"  b{i}: {{type: body, node: n{i}, mass: 1.5, inertia: [1, 1, 1]}}\n" for i in range(n))
    start = time.process_time()
    deck = read_fake(f"mecano: 1\nnodes:\n{nodes}elements:\n{bodies}time: {{end: 1, step: 1e-3}}\n")
    assert len(deck.values["elements"]) == n
    assert time.process_time() - start < 8.0  # about 2 s on one core


def declared(fields, where):
    """All fields below the given ones, with the path of each."""
    for field in fields:
        yield f"{where}.{field.name}", field
        type_ = field.type
        while type_.name in ("named", "list", "either"):
            type_ = type_.options[0]
        if type_.name == "mapping":
            yield from declared(type_.options, f"{where}.{field.name}")


ALL_FIELDS = [
    *declared(SECTIONS, "deck"),
    *(pair for kind in KINDS.values() for pair in declared(kind.fields, kind.name)),
    *(pair for term in TERMS.values() for pair in declared(term.fields, term.name)),
]


def test_every_field_is_declared_in_full():
    for path, field in ALL_FIELDS:
        assert field.unit and field.doc and field.name != "type", path
        assert field.type.name in CHECKS, path
        assert "\n" not in field.doc, path


def test_defaults_pass_their_own_checks():
    from mecano.deck.containers import default
    from mecano.deck.scope import INVALID, Scope

    scope = Scope(CHECKS, KINDS, TERMS, "", [])
    for path, field in ALL_FIELDS:
        if not field.required:
            assert default(field, scope) is not INVALID, path
    assert scope.problems == []


def test_sections_may_be_exchanged():
    assert [field.name for field in fake_sections()] == [field.name for field in SECTIONS]
    assert all(isinstance(field, Field) for field in SECTIONS)


def test_the_components_that_are_wrong_are_named():
    assert none_negative([0.5, 0.0, 0.45]) is None
    assert none_negative([0.5, -1.0, -0.45]) == "must not be negative, but [1] is -1 and [2] is -0.45"
