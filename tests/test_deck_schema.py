"""`mecano schema`: all decks of inputs/ and starters fit it, wrong ones do not."""

import re
from pathlib import Path

import jsonschema
import pytest
from test_deck_copies import CHAIN, LEG, LISTS

from mecano.deck.compose import compose
from mecano.deck.json_schema import deck_schema
from mecano.deck.sample_decks import starters
from mecano.deck.sections import SECTIONS
from mecano.deck.source import Source
from mecano.elements import KINDS
from mecano.laws import TERMS

INPUTS = sorted((Path(__file__).parent.parent / "inputs").glob("*.yaml"))


@pytest.fixture(scope="module")
def validator():
    jsonschema.Draft7Validator.check_schema(deck_schema())
    return jsonschema.Draft7Validator(deck_schema())


def plain(node):
    if isinstance(node.value, dict):
        return {key: plain(value) for key, (_, value) in node.value.items()}
    return [plain(item) for item in node.value] if isinstance(node.value, list) else node.value


def errors(validator, text):
    """[(path, message)] of a deck as text."""
    found = validator.iter_errors(plain(compose(Source("deck", text), [])))
    return [(".".join(map(str, error.absolute_path)), error.message) for error in found]


@pytest.mark.parametrize("path", INPUTS, ids=[path.stem for path in INPUTS])
def test_inputs_fit(validator, path):
    assert errors(validator, path.read_text()) == []


@pytest.mark.parametrize("name", starters())
def test_starters_fit(validator, name):
    assert errors(validator, starters()[name]) == []


PENDULUM = (Path(__file__).parent.parent / "inputs" / "pendulum.yaml").read_text()
GEAR = (Path(__file__).parent.parent / "inputs" / "nose_landing_gear.yaml").read_text()
WRONG = [  # a deck, what is written in it, what instead, where the schema sees it
    (PENDULUM, "mecano: 1", "mecano: 2", "mecano"),
    (PENDULUM, "nodes:", "nods:", ""),
    (PENDULUM, "type: hinge", "type: hing", "joints.hinge.type"),
    (PENDULUM, "axis: [0, 1, 0]", "axis: [0, 1]", "joints.hinge.axis"),
    (PENDULUM, "axis: [0, 1, 0]", "axsi: [0, 1, 0]", "joints.hinge"),
    (PENDULUM, "axis: [0, 1, 0]", "axis: [0, one, 0]", "joints.hinge.axis.1"),
    (PENDULUM, "mass: 1.0", "mass: -1.0", "elements.bar.mass"),
    (PENDULUM, "mass: 1.0", "mass: heavy", "elements.bar.mass"),
    (PENDULUM, "{position: [0, 0, 0]}", "{}", "nodes.pin"),
    (GEAR, "gas_spring:", "gas_sprung:", "laws.oleo"),
    (PENDULUM, "nodes:", "laws: {two: [{step: {time: 0, rise: 1, from: 0, to: 1, by: 2}}]}\nnodes:", "laws.two"),
    (GEAR, "section: arm}", "section: 3}", "elements.arm_front.section"),
    (GEAR, "type: tube,", "type: tub,", "sections.leg.type"),
    (GEAR, "radius: 0.3225", "radius: [1]", "tire_laws.nose_tire.radius"),
    (GEAR, "every: 5.0e-3", "every: steps", "output.every"),
    (GEAR, "nodes: all", "nodes: al", "initial.velocities.0.nodes"),
]


@pytest.mark.parametrize("deck,old,new,place", WRONG, ids=[new for _, _, new, _ in WRONG])
def test_wrong_decks_do_not_fit(validator, deck, old, new, place):
    assert old in deck and errors(validator, deck) == []
    found = errors(validator, deck.replace(old, new, 1))
    assert any(path == place or path.startswith(f"{place}.") for path, _ in found), found


def test_a_sum_of_terms_of_one_name_fits(validator):
    step = "{step: {time: 0, rise: 1, from: 0, to: 1}}"
    assert errors(validator, PENDULUM + f"laws: {{two: [{step}, {step}], one: {step}}}\n") == []


def test_copies_fit(validator):
    """Decks of test_deck_copies but for the kinds, which are others there."""
    text = re.sub(r"type: body, (node: [^,]*), (mass: [^,}]*)[^}]*", r"type: point_mass, \1, \2", LEG)
    text = re.sub(r"type: spring, (nodes: [^\]]*\]).*", r"type: spring_damper, \1, law: strut}", text)
    text = text.replace("node: toe, value", "node: toe, direction: [0, 0, $length], value")
    assert errors(validator, text) == []
    assert errors(validator, text.replace("template: leg,", "templat: leg,", 1))
    assert errors(validator, text.replace("    joints:", "    joint:"))
    chain = re.sub(r"type: body", "type: point_mass", CHAIN).replace("type: spring,", "type: spring_damper,")
    assert errors(validator, chain) == []
    assert errors(validator, chain.replace("{repeat: {i: 0..$count}, type", "{repeat: 5, type"))


def test_lists_with_repeats_fit(validator):
    """Of names, numbers and mappings; where the number of items is given, nothing is repeated."""
    assert errors(validator, LISTS) == []
    assert errors(validator, LISTS.replace("items: [p$i]", "item: [p$i]", 1))
    assert errors(validator, LISTS.replace("axis: [0, 1, 0]", "axis: [{repeat: {i: 0..2}, items: [$i]}]"))


def test_editors_know_everything():
    """Every kind, term and section is there, its fields with unit, meaning and default."""
    schema = deck_schema()
    assert {field.name for field in SECTIONS} < set(schema["properties"])
    assert all(f"term {name}" in schema["definitions"] for name in TERMS)
    for kind in KINDS.values():
        properties = schema["definitions"][f"kind {kind.name}"]["properties"]
        for field in kind.fields:
            assert properties[field.name]["description"] == field.doc
            assert field.unit == "-" or f"[{field.unit}]" in properties[field.name]["title"]
    assert schema["definitions"]["kind beam"]["properties"]["mesh"]["default"] == 1
