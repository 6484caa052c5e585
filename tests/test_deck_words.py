"""Words among the parameters of a deck: names of nodes, of laws, of kinds, and parts of names."""

import jsonschema
import pytest
import yaml
from time_runs import deck

from mecano.deck.json_schema import deck_schema
from mecano.deck.read import deck_of_bytes
from mecano.errors import DeckError

SIDES = """\
mecano: 1
gravity: [0, 0, -9.81]
parameters: {side: left, mass: 2, law: soft, kind: spring_damper}
nodes:
  left: {position: [0, 0, 0]}
  right: {position: [0, 1, 0]}
  anchor: {position: [0, 0, 1], fixed: true}
laws: {soft: {spring: 100}, hard: {spring: 1000}}
elements:
  first: {type: point_mass, node: left, mass: $mass}
  second: {type: point_mass, node: right, mass: 1}
  strut_$side: {type: $kind, nodes: [anchor, $side], law: $law}
signals:
  speed: $side.velocity.z + 2*$mass*strut_$side.force
  height: $side.position.z
initial: {velocities: [{nodes: [$side], velocity: [1, 0, $mass]}]}
time: {end: 1, step: 0.1}
"""


def test_words_are_names():
    """The deck without them has the same values, and a word that chooses leaves entries without a use, unwarned."""
    plain = SIDES.replace("$side", "left").replace("$kind", "spring_damper").replace("law: $law", "law: soft")
    plain = plain.replace("2*$mass", "2*2")
    plain = plain.replace("{side: left, mass: 2, law: soft, kind: spring_damper}", "{mass: 2}")
    found, expected = deck(SIDES), deck(plain)
    assert found.resolved() == expected.resolved()
    assert not found.warnings and [w.message for w in expected.warnings] == ["law 'hard' is not used"]


def test_whole_numbers_are_part_of_names():
    """Also in an entry without a repeat, in a formula and in a list; a number alone stays a number."""
    text = """\
    mecano: 1
    gravity: none
    parameters: {links: 3, mass: 2.5}
    nodes: {p$i: {repeat: {i: 0..$links}, position: [$i, 0, 0]}, hook$(links)a: {position: [$links, 0, 1]}}
    elements:
      pin$i: {repeat: {i: 0..$links}, type: point_mass, node: p$i, mass: $mass}
      hook: {type: point_mass, node: hook$(links)a, mass: 2*$mass}
    joints: {last: {type: rigid_rod, nodes: ['p$(links - 1)', p$links]}}
    signals: {height: 2*$mass*p$links.position.z}
    loads: {weight: {type: force, node: p$links, direction: [0, 0, -1], value: 3*$mass}}
    initial: {velocities: [{nodes: [p$links], velocity: [$links, 0, 0]}]}
    time: {end: 1, step: 0.1}
    """
    plain = text.replace("'p$(links - 1)'", "p2").replace("p$links", "p3").replace("hook$(links)a", "hook3a")
    assert deck(text).resolved() == deck(plain).resolved()
    fewer = deck_of_bytes(text.encode(), "test.yaml", overrides=("parameters.links=2",))
    assert fewer.values["loads"]["weight"]["node"] == "p2"


def test_editors_accept_words():
    """But for a type, for which they complete the names of kinds."""
    validator = jsonschema.Draft7Validator(deck_schema())
    assert not list(validator.iter_errors(yaml.safe_load(SIDES.replace("$kind", "spring_damper"))))


def test_words_may_be_set():
    found = deck_of_bytes(SIDES.encode(), "test.yaml", overrides=("parameters.side=right", "parameters.law=hard"))
    assert found.values["elements"]["strut_right"]["nodes"] == ["anchor", "right"]
    assert found.values["signals"]["height"]["value"] == "right.position.z"


def test_words_go_into_templates_and_repeats_that_do_not_have_the_name():
    """A value of a repeat, or a parameter of a template, of the same name goes before that of the deck."""
    text = """
    mecano: 1
    gravity: none
    parameters: {side: left}
    nodes: {left: {position: [0, 0, 0]}, right: {position: [0, 1, 0]}}
    elements:
      mass_$side: {repeat: {side: [left, right]}, type: point_mass, node: $side, mass: 1}
    templates:
      tip:
        parameters: {side: null}
        loads: {push: {type: force, node: $side, direction: [1, 0, 0], value: 1}}
      outer:
        loads: {push: {type: force, node: $side, direction: [1, 0, 0], value: 1}}
    place:
      own: {template: tip, with: {side: right}}
      of_deck: {template: outer}
      given: {template: tip, with: {side: $side}}
    time: {end: 1, step: 0.1}
    """
    loads = deck(text).values["loads"]
    assert {name: d["node"] for name, d in loads.items()} == {
        "own_push": "right",
        "of_deck_push": "left",
        "given_push": "left",
    }


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("side: left, mass", "side: lefd, mass", ["test.yaml:3:20", "unknown node 'lefd'; did you mean 'left'?"]),
        ("mass: $mass}", "mass: 2*$side}", ["test.yaml:10:", "'mass' must be a number [kg], got the text '2*left'"]),
        (
            "mass: $mass}",
            "mass: $kind}",
            ["test.yaml:3:", "'mass' must be a number [kg], got the text 'spring_damper'"],
        ),
        ("mass: 2,", "mass: two,", ["test.yaml:3:32", "got the text 'two'"]),
        (
            "mass: 2,",
            "mass: 2, spare: word,",
            [
                "test.yaml:3:",
                "parameter 'spare': must be a number, got the text 'word'",
                "no name here contains $spare",
            ],
        ),
        ("mass: 2,", "mass: 2, other: 3*$side,", ["test.yaml:3:", "parameter 'side' is the word 'left', not a number"]),
    ],
)
def test_mistakes_in_words(old, new, said):
    with pytest.raises(DeckError) as error:
        deck(SIDES.replace(old, new, 1))
    texts = [f"{p.mark}: {p.message}; {p.hint}" for p in error.value.problems]
    assert any(all(part in text for part in said) for text in texts), texts
