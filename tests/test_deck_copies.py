"""``include``, ``repeat``, ``templates`` and ``place``."""

import hashlib
import os
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest
from deck_samples import FAKE, problems_of, read_fake

from mecano.deck.check import UNCHECKED
from mecano.deck.format import deck_error_text
from mecano.deck.physics import rotations
from mecano.deck.placing import Placement
from mecano.deck.read import deck_of_bytes, read_deck
from mecano.errors import DeckError

INPUTS = Path(__file__).parent.parent / "inputs"
CHAIN = """\
mecano: 1
parameters: {count: 3, pitch: 250 mm}
nodes:
  p$i: {repeat: {i: 0..$count}, position: ['$i * $pitch', 0, 0]}
elements:
  mass$i: {repeat: {i: 0..$count}, type: body, node: p$i, mass: '2 + $i'}
  spring$(i): {repeat: {i: 1..$count}, type: spring, nodes: [p$(i - 1), p$i], law: {spring: {stiffness: 1e3}}}
time: {end: 1, step: 0.1}
"""
LEG = """\
mecano: 1
nodes:
  deck: {position: [0, 0, 1]}
elements:
  ship: {type: body, node: deck, mass: 100}
laws:
  strut: 7.0
templates:
  leg:
    parameters: {length: 1.0, half: 0.5 * $length, hold: null, mass: 1 kg}
    nodes:
      hip: {position: [$half, 0, 0]}
      toe: {position: [$length, 0, 0], orientation: [0.3, 0, 0]}
    elements:
      bar: {type: body, node: toe, mass: $mass, center_of_mass: [0.1, 0, 0]}
      coil: {type: spring, nodes: [hip, $hold], law: strut, scale: own}
    joints:
      pin: {type: hinge, nodes: [hip, toe], axis: [1, 0, 0]}
    loads:
      push: {type: force, node: toe, value: 3 kN}
    laws:
      own: 2.0
      strut: {spring: {stiffness: 5 N/mm}}
place:
  left: {template: leg, position: [0, 2, 0], orientation: [0, 0, 90 deg], with: {hold: deck}}
  right: {template: leg, with: {hold: deck, length: 3, mass: 4}}
time: {end: 1, step: 0.1}
"""


def test_a_circle_of_parameters_is_refused_once_where_it_is_defined():
    """The copies that use the parameters do not repeat it."""
    circle = "parameters depend on one another in a circle"
    (text,) = problems_of(CHAIN.replace("pitch: 250 mm", "pitch: $gap, gap: $pitch + 1"))
    assert text == f"2:31 parameter 'pitch': {circle}: pitch -> gap -> pitch"
    (text,) = problems_of(LEG.replace("length: 1.0", "length: $half"))
    assert text == f"10:26 parameter 'length': {circle}: length -> half -> length"


def test_repeat():
    values = read_fake(CHAIN).values
    assert {name: node["position"][0] for name, node in values["nodes"].items()} == {
        "p0": 0.0, "p1": 0.25, "p2": 0.5, "p3": 0.75
    }  # fmt: skip
    assert [values["elements"][f"mass{i}"]["mass"] for i in range(4)] == [2.0, 3.0, 4.0, 5.0]
    assert values["elements"]["spring3"]["nodes"] == ["p2", "p3"] and "spring0" not in values["elements"]


def test_repeat_of_lists_and_rows():
    text = CHAIN.replace("{i: 0..$count}, position: ['$i * $pitch', 0, 0]", "{i: [0, 1, 2, 3]}, position: [$i, 0, 0]")
    rows = "{repeat: [{side: left, y: 2}, {side: right, y: -2}], type: body, node: p0, mass: '$y + 3'}"
    pairs = "{repeat: {part: [a, b], j: 4..5}, type: body, node: p$(j - 4), mass: $j}"
    values = read_fake(text.replace("elements:", f"elements:\n  $(side)_wing: {rows}\n  $(part)_$j: {pairs}")).values
    assert (values["elements"]["left_wing"]["mass"], values["elements"]["right_wing"]["mass"]) == (5.0, 1.0)
    assert [name for name in values["elements"] if name[1:2] == "_"] == ["a_4", "a_5", "b_4", "b_5"]
    assert values["elements"]["b_5"]["node"] == "p1"


def test_nodes_of_a_meshed_beam_have_inserts_after_a_dot():
    """The template adds its own name before."""
    text = """
    mecano: 1
    gravity: none
    sections: {tube: {type: tube, diameter: 40 mm, thickness: 1 mm, E: 70 GPa, nu: 0.3, density: 2700}}
    templates:
      mast:
        nodes: {foot: {position: [0, 0, 0], fixed: true}, top: {position: [0, 0, 4]}}
        elements: {pole: {type: beam, nodes: [foot, top], section: tube, mesh: 4}}
        loads: {wind$k: {repeat: {k: 1..3}, type: drag, node: pole.$k, area: 0.1, coefficient: 1.2}}
    place: {m: {template: mast}}
    time: {end: 1, step: 0.01}
    """
    values = deck_of_bytes(dedent(text).encode(), "test.yaml").values
    assert [d["node"] for d in values["loads"].values()] == ["m_pole.1", "m_pole.2", "m_pole.3"]


LISTS = """
mecano: 1
gravity: none
parameters: {last: 3}
nodes:
  hull: {position: [0, 0, 1]}
  p$i: {repeat: {i: 1..$last}, position: [$i, 0, 1]}
  q$i: {repeat: {i: 1..$last}, position: [$i, 0, 0]}
elements:
  hull: {type: rigid_body, node: hull, mass: 1, inertia: [1, 1, 1], attached: [{repeat: {i: 1..$last}, items: [p$i]}]}
  bob$i: {repeat: {i: 1..$last}, type: rigid_body, node: q$i, mass: 1, inertia: [1, 1, 1]}
  rope$k:
    repeat: {k: 1..2}
    type: reeved_cable
    nodes: [hull, {repeat: {i: 2..$last}, items: [q$i, p$(i - k + 1)]}, q1]
    radii: [0, {repeat: {i: 2..$last}, items: [-0.1*$k, 0.1*$i]}, 0]
    axis: [0, 1, 0]
    axial_stiffness: 1000
initial:
  velocities:
    - {nodes: [hull, {repeat: {i: 1..$last}, items: [p$i]}], velocity: [1, 0, 0]}
    - repeat: {i: 1..$last}
      items: [{nodes: [q$i], velocity: [1, 0, 0.5*$i]}]
time: {end: 0.1, step: 0.01}
"""


def test_repeat_in_lists():
    """Of names, numbers and mappings; in an entry with a repeat of its own; outside the sections of names."""
    values = deck_of_bytes(LISTS.encode(), "deck.yaml").values
    assert values["elements"]["hull"]["attached"] == ["p1", "p2", "p3"]
    ropes = [values["elements"][name] for name in ("rope1", "rope2")]
    assert [rope["nodes"] for rope in ropes] == [
        ["hull", "q2", "p2", "q3", "p3", "q1"],
        ["hull", "q2", "p1", "q3", "p2", "q1"],
    ]
    assert [rope["radii"] for rope in ropes] == [[0, -0.1, 0.2, -0.1, 0.1 * 3, 0], [0, -0.2, 0.2, -0.2, 0.1 * 3, 0]]
    moving = values["initial"]["velocities"]
    assert [one["nodes"] for one in moving] == [["hull", "p1", "p2", "p3"], ["q1"], ["q2"], ["q3"]]
    assert [one["velocity"][2] for one in moving] == [0.0, 0.5, 1.0, 1.5]
    none = deck_of_bytes(
        LISTS.replace("attached: [{repeat: {i: 1..$last}", "attached: [{repeat: {i: 1..0}").encode(), "a"
    )
    assert none.values["elements"]["hull"]["attached"] == []


@pytest.mark.parametrize(
    ("repeat", "items", "expected"),
    [
        ("{i: 1..$last}", "item: [p$i]", "10:80: element 'hull': in a list, 'repeat' comes with a list of 'items'"),
        ("{i: 1..$last}", "items: p$i", "10:80: element 'hull': in a list, 'repeat' comes with a list of 'items'"),
        ("{i: 1..$last}", "items: [p$j]", "10:113: element 'hull': unknown parameter 'j'"),
        ("{i: 1..$last}", "items: [r$i]", "10:112: rigid_body 'hull': unknown node 'r1'"),
        ("{i: 1..9.5}", "items: [p$i]", "10:93: element 'hull': a range is of whole numbers, and '9.5' is 9.5"),
    ],
)
def test_wrong_repeats_in_lists(repeat, items, expected):
    text = LISTS.replace("{repeat: {i: 1..$last}, items: [p$i]}]}", f"{{repeat: {repeat}, {items}}}]}}", 1)
    with pytest.raises(DeckError) as info:
        deck_of_bytes(text.encode(), "deck.yaml")
    assert str(info.value).startswith(f"deck.yaml:{expected}")


def test_overrides_reach_parameters_and_single_copies():
    values = read_fake(CHAIN, overrides=["parameters.count=5", "elements.mass4.mass=50"]).values
    assert len(values["nodes"]) == 6 and values["elements"]["mass4"]["mass"] == 50.0
    values = read_fake(LEG, overrides=["place.right.with.length=5", "nodes.left_toe.fixed=true"]).values
    assert values["nodes"]["right_toe"]["position"] == [5.0, 0.0, 0.0] and values["nodes"]["left_toe"]["fixed"]


def test_templates():
    values = read_fake(LEG).values
    nodes, elements = values["nodes"], values["elements"]
    assert set(nodes) == {"deck", "left_hip", "left_toe", "right_hip", "right_toe"}
    assert nodes["left_hip"]["position"] == pytest.approx([0.0, 2.5, 0.0], abs=1e-15)
    assert nodes["right_hip"]["position"] == [1.5, 0.0, 0.0]
    (written,) = rotations(np.array([nodes["left_toe"]["orientation"]]))
    turn, own = rotations(np.array([[0, 0, np.pi / 2], [0.3, 0, 0]]))
    assert np.allclose(written, turn @ own, atol=1e-15)
    (hip,) = rotations(np.array([nodes["left_hip"]["orientation"]]))  # by default along the axes of the template
    assert np.allclose(hip, turn, atol=1e-15)
    assert values["joints"]["left_pin"]["axis"] == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)
    assert elements["left_bar"]["center_of_mass"] == [0.1, 0.0, 0.0]  # in the axes of the node
    assert (elements["left_bar"]["mass"], elements["right_bar"]["mass"]) == (1.0, 4.0)
    assert elements["left_coil"]["nodes"] == ["left_hip", "deck"]
    assert elements["left_coil"]["scale"] is values["laws"]["left_own"]  # the template's own name comes first
    assert elements["left_coil"]["law"] is values["laws"]["left_strut"]
    assert values["loads"]["right_push"]["value"] == (("constant", {"value": 3000.0}),)


def test_names_inside_templates_inside_templates():
    """A name given from outside is looked up outside, level by level, also where the template has it too."""
    text = LEG.replace("place:\n", """\
  pair:
    parameters: {hold: null}
    nodes:
      hip: {position: [0, 0, 5]}
    elements:
      knob: {type: body, node: hip, mass: 1}
    place:
      $side: {repeat: {side: [one, two]}, template: leg, with: {hold: hip, length: 2}}
      far: {template: leg, position: [1, 0, 0], with: {hold: $hold}}
place:
  twin: {template: pair, position: [0, 0, 1], with: {hold: deck}}
""")  # fmt: skip
    values = read_fake(text).values
    assert values["elements"]["twin_one_coil"]["nodes"] == ["twin_one_hip", "twin_hip"]
    assert values["elements"]["twin_far_coil"]["nodes"] == ["twin_far_hip", "deck"]
    assert values["nodes"]["twin_hip"]["position"] == [0.0, 0.0, 6.0]
    assert values["nodes"]["twin_far_hip"]["position"] == [1.5, 0.0, 1.0]


@pytest.mark.parametrize("what", ["point", "direction", "orientation"])
def test_moving_forth_and_back(what):
    rng = np.random.default_rng(3)
    for _ in range(20):
        x, r, value = rng.normal(size=(3, 3))
        value *= min(1.0, 3.0 / np.linalg.norm(value))
        (R,) = rotations(r[None])
        moved = Placement(list(x), list(r)).moved(list(value), what)
        back = Placement(list(-R.T @ x), list(-r)).moved(moved, what)
        assert np.allclose(back, value, atol=1e-14)
        expected = {"point": x + R @ value, "direction": R @ value}.get(what)
        if expected is not None:
            assert np.allclose(moved, expected, atol=1e-14)


def same(a, b, place=""):
    """Places in which two plain decks differ by more than 1e-12, relative to 1 or to the number."""
    if isinstance(a, dict) and isinstance(b, dict) and set(a) == set(b):
        return [found for key in a for found in same(a[key], b[key], f"{place}.{key}")]
    if isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        return [found for i in range(len(a)) for found in same(a[i], b[i], f"{place}.{i}")]
    if isinstance(a, float) and isinstance(b, float) and abs(a - b) <= 1e-12 * max(1.0, abs(a)):
        return []
    return [] if a == b else [place]


def test_the_reflector_on_a_page_is_the_reflector():
    written, page = (read_deck(INPUTS / f"{name}.yaml") for name in ("reflector", "reflector_template"))
    one, other = written.resolved(), page.resolved()
    del one["parameters"], other["parameters"]
    assert same(one, other) == []
    assert len(one["nodes"]) == 110 and len(one["elements"]) == 117 and len(one["joints"]) == 72
    assert len(page.text.splitlines()) <= 105 < len(written.text.splitlines())


WRONG = [  # what is written in LEG, what is written instead, the problems
    ("length: 3,", "lenght: 3,",
     ["26:45 place 'right': the template has no parameter 'lenght'; did you mean 'length'?"]),
    ("length: 3,", "length: 3 furlong,", ["26:53 place 'right': 'length': 'furlong' is not a unit"]),
    ("with: {hold: deck}", "with: {}",
     ["25:3 place 'left': missing 'with.hold', a parameter of the template without a default"]),
    ("{template: leg, with", "{template: lag, with",
     ["26:21 place 'right': unknown template 'lag'; did you mean 'leg'?"]),
    ("{template: leg, with", "{with", ["26:3 place 'right': missing 'template', a text: name of the template"]),
    ("    joints:", "    joint:", ["17:5 template 'leg': unknown section 'joint'; did you mean 'joints'?"]),
    ("mass: $mass", "mass: 3 m", ["15:42 body '{}_bar': 'mass': a mass [kg] is expected, and 'm' is a length"]),
    ("axis: [1, 0, 0]", "axis: [0, 0, 0]",
     ["18:51 joint '{}_pin': 'axis' must be a list of 3 numbers, not all zero, got [0, 0, 0]"]),
    ("  deck:", "  left_hip: {position: [0, 0, 0]}\n  deck:",
     ["13:7 'left_hip' is given twice; first at deck.yaml:3:3"]),
    ("    laws:", "    place:\n      again: {template: leg}\n    laws:",
     2 * ["22:25 place 'again': templates place one another in a circle: leg -> leg"]),
    ("half: 0.5 * $length", "half: 0.5 * $lenth",
     ["10:43 place '{}': unknown parameter 'lenth'; did you mean 'length'?"]),
    ("$half, 0, 0", "$halt, 0, 0", 2 * ["12:24 node 'hip': unknown parameter 'halt'; did you mean 'half'?"]),
    ("hold: deck}", "hold: dock}", ["25:88 spring 'left_coil': unknown node 'dock'; did you mean 'deck'?"]),
    ("$hold], law", "toes], law",
     ["16:41 spring '{}_coil': unknown node 'toes'; did you mean 'toe'?"]),  # the name in the template
]  # fmt: skip


@pytest.mark.parametrize("old,new,expected", WRONG, ids=[new for _, new, _ in WRONG])
def test_wrong_templates(old, new, expected):
    assert LEG.count(old) == 1
    both = [text.format(side) for side in ("left", "right") for text in expected if "{}" in text]
    assert sorted(problems_of(LEG.replace(old, new))) == (both or expected)


def test_a_wrong_word_of_a_repeat_is_reported_where_it_is_written():
    """In the deck and in the copies of a template: not where its parameter is inserted."""
    old = "      bar: {type: body, node: toe, mass: $mass, center_of_mass: [0.1, 0, 0]}\n"
    new = (
        "      $(n)_body:\n        repeat: [{n: toe}, {n: sole}]\n        type: body\n        node: $n\n"
        "        mass: 1\n"
    )
    expected = [f"16:32 body '{side}_sole_body': unknown node 'sole'" for side in ("left", "right")]
    found = problems_of(LEG.replace(old, new))
    assert [text.split(";")[0] for text in sorted(found)] == expected


REPEATS = [  # what stands behind 'repeat' of p$i in CHAIN, the problem
    ("{i: 0..$n}", "4:21 node 'p$i': unknown parameter 'n'; known: count, pitch"),
    ("{i: 0..2.5}", "4:21 node 'p$i': a range is of whole numbers, and '2.5' is 2.5"),
    ("{i: 0..999999}", "4:21 node 'p$i': 'repeat' asks for more than 400000 copies"),
    ("{i: 1..2000, j: 1..2000}", "4:33 node 'p$i': 'repeat' asks for more than 400000 copies"),
    ("{i: 5}", "4:21 node 'p$i': 'repeat' takes a range such as 0..5, or a list"),
    ("{i: 5..0}", "4:21 node 'p$i': a range ascends, and '5..0' does not"),
    ("{i: [1, [2]]}", "4:25 node 'p$i': must be a number, got [2]"),
    ("{}", "4:17 node 'p$i': 'repeat' must be a mapping of names to values, or a list of rows"),
    ("[{i: 1}, 2]", "4:17 node 'p$i': 'repeat' must be a mapping of names to values, or a list of rows"),
    ("{i: [0.5]}", "4:4 node 'p$i': only whole numbers and words can be part of a name; $i is 0.5"),
    ("{j: 0..3}", "4:4 node 'p$i': unknown parameter 'i'; known: j, count, pitch"),
    ("{pitch: 0..3}", "4:4 node 'p$i': unknown parameter 'i'; known: pitch, count"),
    ("{i: [1, 1]}", "4:3 node 'p$i': 'p1' is given twice; first at deck.yaml:4:3"),
]  # fmt: skip


@pytest.mark.parametrize("repeat,expected", REPEATS)
def test_wrong_repeats(repeat, expected):
    first, *_ = problems_of(CHAIN.replace("{i: 0..$count}, position", repeat + ", position"))
    assert first.split("; write")[0] == expected


def test_a_range_may_be_empty():
    """`1..$count` of a chain without members has no number, and 5..0 is a mistake."""
    entries = CHAIN.replace("  mass$i", "  none$i: {repeat: {i: 1..0}, type: body, node: p0, mass: 1}\n  mass$i")
    assert list(read_fake(entries).values["elements"]) == list(read_fake(CHAIN).values["elements"])


def test_a_bracket_in_a_name_that_is_not_closed():
    first, *_ = problems_of(CHAIN.replace("p$i: {repeat", "p$(i + 1: {repeat"))
    assert first == "4:3 node 'p$(i + 1': what follows a $ in a name is a value or in brackets: p$i, p$(i + 1)"


@pytest.mark.parametrize("name", ["p$($i - 1)", "p$(2*($i - 1))"])
def test_a_name_in_brackets_has_no_dollar(name):
    """The same error in each copy, which the command line counts as one."""
    right = name.replace("($i", "(i")
    found = problems_of(CHAIN.replace("[p$(i - 1), p$i]", f"['{name}', p$i]"))
    assert len(found) == 3 and len({*found}) == 1 and f"within $( ) names have no $: write '{right}'" in found[0]


def test_names_of_copies_must_differ():
    (text,) = problems_of(CHAIN.replace("p$i: {repeat", "p: {repeat"))
    assert text == "4:3 node 'p': all copies would have the name 'p'; put a value of 'repeat' into it, as in 'p$(i)'"


def test_copies_count_once_in_the_text_of_errors():
    with pytest.raises(DeckError) as info:
        read_fake(CHAIN.replace("'2 + $i'", "'1 - $i'"))
    assert len(info.value.problems) == 3  # of masses 0, -1, -2
    text = deck_error_text(info.value)
    assert "deck.yaml:6:65: body 'mass1': 'mass' must be greater than zero [kg], got 0.0 (1 - $i)" in text
    with pytest.raises(DeckError) as info:
        read_fake(LEG.replace("mass: $mass", "mass: 3 m"))
    assert deck_error_text(info.value) == (
        "deck.yaml:15:42: body 'left_bar': 'mass': a mass [kg] is expected, and 'm' is a length (and 1 copy of it)\n"
        "          bar: {type: body, node: toe, mass: 3 m, center_of_mass: [0.1, 0, 0]}\n"
        "                                             ^\n"
        "  placed at deck.yaml:25:3\n"
        f"1 error; {UNCHECKED} once this error is fixed"
    )


def test_templates_cannot_explode(monkeypatch):
    """Twelve levels of ten copies each would be 10^12."""
    levels = [f"  t{i}: {{place: {{'c$k': {{repeat: {{k: 1..10}}, template: t{i + 1}}}}}}}" for i in range(11)]
    text = "\n".join(["mecano: 1", "place: {all: {template: t0}}", "templates:", *levels,
                      "  t11: {nodes: {n: {position: [0, 0, 0]}}}"])  # fmt: skip
    monkeypatch.setattr("mecano.deck.copies.MOST_PLACED", 500)
    (problem,) = problems_of(text)
    assert problem.endswith("more than 500 templates are placed")
    chain = [f"  t{i}: {{place: {{c: {{template: t{i + 1}}}}}}}" for i in range(40)]
    (problem,) = problems_of(
        "\n".join(["mecano: 1", "place: {all: {template: t0}}", "templates:", *chain, "  t40: {}"])
    )
    assert problem.endswith("templates are placed more than 12 levels deep")


MAIN = """mecano: 1
include: [parts/leg.yaml, laws.yaml]
nodes:
  top: {position: [0, 0, 1]}
elements:
  load: {type: body, node: top, mass: 5}
time: {end: 1, step: 0.1}
"""
PARTS = """include: more.yaml
nodes:
  foot: {position: [0, 0, 0]}
elements:
  strut: {type: spring, nodes: [foot, top], law: oleo}
loads:
  push: {type: force, node: foot, value: {table: {file: push.csv}}}
"""
LAWS = "mecano: 1\nlaws:\n  oleo: {spring: {stiffness: 7 N/mm}}\n"


def write(folder, **files):
    """Write the files of a deck; the path of the deck."""
    (folder / "parts").mkdir(parents=True)
    texts = {"deck.yaml": MAIN, "parts/leg.yaml": PARTS, "laws.yaml": LAWS, "parts/more.yaml": "laws: {more: 1}",
             "parts/push.csv": "0,0\n1,5\n", **files}  # fmt: skip
    for name, text in texts.items():
        (folder / name).write_text(text)
    return folder / "deck.yaml"


def problems_in(path):
    with pytest.raises(DeckError) as info:
        read_deck(path, **FAKE)
    return [f"{p.mark.file.removeprefix(str(path.parent) + os.sep)}:{p.mark.line}:{p.mark.column} {p.message}"
            for p in info.value.problems]  # fmt: skip


def test_include(tmp_path):
    path = write(tmp_path / "a")
    deck = read_deck(path, **FAKE)
    assert set(deck.values["nodes"]) == {"foot", "top"} and deck.values["laws"]["more"] == (
        ("constant", {"value": 1.0}),
    )
    assert deck.values["elements"]["strut"]["law"] == (("spring", {"stiffness": 7000.0}),)
    points = deck.values["loads"]["push"]["value"][0][1]["points"]
    assert points.tolist() == [[0.0, 0.0], [1.0, 5.0]]  # of the table beside the part
    names = ("laws.yaml", "parts/leg.yaml", "parts/more.yaml", "parts/push.csv")
    assert deck.files == {name: hashlib.sha256((tmp_path / "a" / name).read_bytes()).hexdigest() for name in names}
    assert deck.text == MAIN


VARIANT = """include: deck.yaml
set:
  time.end: 3
  elements.load.mass: 8
  nodes.top.position.2: 2
  loads.push: null
  laws.oleo.spring: 9 N/mm
laws: {another: 4}
"""


def test_a_variant_adds_entries_and_replaces_values(tmp_path):
    """A variant of a variant replaces its values, and the command line those of both."""
    write(tmp_path / "a", **{"variant.yaml": VARIANT, "heavy.yaml": "include: variant.yaml\nset: {time.end: 4}\n"})
    values = read_deck(tmp_path / "a" / "variant.yaml", **FAKE).values
    assert values["time"]["end"] == 3.0 and values["elements"]["load"]["mass"] == 8.0
    assert list(values["nodes"]["top"]["position"]) == [0.0, 0.0, 2.0] and values["loads"] == {}
    assert values["elements"]["strut"]["law"] == (("spring", {"stiffness": 9000.0}),) and "another" in values["laws"]
    heavy = tmp_path / "a" / "heavy.yaml"
    values = read_deck(heavy, **FAKE).values
    assert values["time"]["end"] == 4.0 and values["elements"]["load"]["mass"] == 8.0
    assert read_deck(heavy, ["time.end=5"], **FAKE).values["time"]["end"] == 5.0


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("time.end: 3", "time.ende: 3", "3:8 unknown key 'time.ende'; did you mean 'time.end'?"),
        ("  elements.load.mass: 8", "  elements.lod.mass: 8", "4:12 'elements' has no 'lod'"),
        (
            "  elements.load.mass: 8",
            "  elements..mass: 8",
            "4:3 'elements..mass' is not a path of keys separated by dots",
        ),
        ("laws: {another: 4}", "laws: {oleo: 4}", "8:8 'oleo' is given twice"),
        ("set:\n", "set: [1]\nlaws_:\n", "2:6 'set' must be a mapping of paths in the deck to values"),
    ],
)
def test_wrong_variants(tmp_path, old, new, expected):
    assert VARIANT.count(old) == 1
    write(tmp_path / "a", **{"variant.yaml": VARIANT.replace(old, new)})
    found = problems_in(tmp_path / "a" / "variant.yaml")
    assert found[0].startswith(f"variant.yaml:{expected.partition(';')[0]}"), found


INCLUDES = [  # files written otherwise, the problems
    ({"laws.yaml": LAWS.replace("stiffness", "stifness")},
     ["laws.yaml:3:19 law 'oleo': unknown key 'spring.stifness'"]),
    ({"laws.yaml": "laws: {more: 2}"}, ["laws.yaml:1:8 'more' is given twice; first at {}/parts/more.yaml:1:8"]),
    ({"laws.yaml": LAWS + "time: {end: 2, step: 1}"},
     ["deck.yaml:7:1 'time' is given twice; first at {}/laws.yaml:4:1"]),
    ({"laws.yaml": LAWS.replace("mecano: 1", "mecano: 2")},
     ["laws.yaml:1:9 this program reads decks of version 1, got 2"]),
    ({"parts/more.yaml": "include: leg.yaml"},
     ["parts/more.yaml:1:10 files include one another in a circle: parts/leg.yaml -> parts/more.yaml -> parts"]),
    ({"parts/more.yaml": "include: deck.yaml"},
     ["parts/more.yaml:1:10 file 'deck.yaml' cannot be read: No such file"]),
    ({"parts/more.yaml": "include: ../deck.yaml"},
     ["parts/more.yaml:1:10 files include one another in a circle: deck.yaml -> "]),
    ({"parts/more.yaml": "include: ../../out.yaml"},
     ["parts/more.yaml:1:10 file '../../out.yaml' must lie in the folder"]),
    ({"parts/more.yaml": "include: /etc/passwd"}, ["parts/more.yaml:1:10 file '/etc/passwd' must lie in the folder"]),
    ({"parts/more.yaml": "include: link.yaml"}, ["parts/more.yaml:1:10 file 'link.yaml' must lie in the folder"]),
    ({"parts/more.yaml": "include: {a: 1}"}, ["parts/more.yaml:1:10 'include' must be the name of a file"]),
    ({"parts/more.yaml": "- 1"}, ["parts/more.yaml:1:1 an included file is a mapping of sections"]),
    ({"parts/more.yaml": "laws: [\n"}, ["parts/more.yaml:2:1 not valid YAML"]),
    ({"parts/push.csv": "0,0\n1,x\n"}, ["parts/push.csv:2:3 must be a finite number, got 'x'"]),
]  # fmt: skip


@pytest.mark.parametrize("files,expected", INCLUDES)
def test_wrong_includes(tmp_path, files, expected):
    path = write(tmp_path / "a", **files)
    (tmp_path / "out.yaml").write_text("laws: {}")
    (tmp_path / "a" / "parts" / "link.yaml").symlink_to(tmp_path / "out.yaml")
    found = sorted(problems_in(path))
    assert len(found) >= len(expected)
    for text, start in zip(found, expected, strict=False):
        assert text.startswith(start.format(path.parent))


def test_what_is_given_twice_is_answered_with_the_way_to_replace_it(tmp_path):
    path = write(tmp_path / "a", **{"laws.yaml": "laws: {more: 2}\ntime: {end: 1}"})
    with pytest.raises(DeckError) as info:
        read_deck(path, **FAKE)
    hints = {problem.hint for problem in info.value.problems}
    assert {
        "a variant replaces it by 'set: {laws.more: VALUE}'",
        "a variant changes it by 'set: {time.KEY: VALUE}'",
    } <= hints


def test_a_misspelt_include_is_answered_with_a_similar_file(tmp_path):
    path = write(tmp_path / "a", **{"parts/more.yaml": "include: legs.yml"})
    with pytest.raises(DeckError) as info:
        read_deck(path, **FAKE)
    assert info.value.problems[0].hint == "did you mean 'leg.yaml'?"


def test_an_error_in_an_included_file_names_the_include(tmp_path):
    path = write(tmp_path / "a", **{"laws.yaml": LAWS.replace("7 N/mm", "7 bar")})
    with pytest.raises(DeckError) as info:
        read_deck(path, **FAKE)
    assert deck_error_text(info.value) == (
        f"{path.parent}/laws.yaml:3:30: law 'oleo': 'spring.stiffness': a stiffness or a torsional stiffness "
        "[N/m or N m/rad] is expected, and 'bar' is a pressure\n"
        "      oleo: {spring: {stiffness: 7 bar}}\n"
        "                                 ^\n"
        f"  included at {path}:2:27\n"
        f"1 error; {UNCHECKED} once this error is fixed"
    )


@pytest.mark.parametrize(
    "text",
    ["1 " + "a" * 200_000, "1" + " m" * 100_000, "$(" * 100_000, "$i" * 100_000, "x$(" + "()" * 100_000],
    ids=range(5),
)
def test_long_texts_are_refused_at_once(text):
    (problem, *_) = problems_of(CHAIN.replace("'2 + $i'", f"'{text}'"))
    assert len(problem) < 400


CONTROLLED = """\
mecano: 1
gravity: none
parameters: {offset: -0.5}
templates:
  axis:
    parameters: {base: null, gain: 2.5}
    nodes: {a: {position: [0, 0, 0]}}
    elements: {body: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}
    joints: {slide: {type: prismatic, nodes: [ground, a], axis: [1, 0, 0], release: {when: slide.displacement > $gain}}}
    laws: {swing: {sine: {amplitude: 1, frequency: 1}}}
    signals:
      far: $gain*(a.position.x - $base.position.x) + $offset**2
      slow: {type: lag, input: far + 1, time_constant: 0.1}
      sum: {type: formula, value: "joints.slide.velocity*tanh(time) + 1e-3*min(far, slow) + shared"}
    loads:
      push: {type: force, node: a, direction: [1, 0, 0], value: sum}
      shake: {type: force, node: a, direction: [1, 0, 0], value: swing}
  pair:
    parameters: {a: null}
    nodes: {own: {position: [2, 0, 0]}}
    elements: {own: {type: rigid_body, node: own, mass: 1, inertia: [1, 1, 1]}}
    place: {one: {template: axis, with: {base: own}}, two: {template: axis, with: {base: $a, gain: 3}}}
nodes: {a: {position: [5, 0, 0]}}
elements: {a: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}}
signals:
  shared: 1 + time
  twice_$side: {repeat: {side: [one, two]}, type: formula, value: "2*p_$(side)_sum - $offset*time"}
  nodes_$i: {repeat: {i: 1..2}, type: formula, value: "$i*nodes.a.position.x - shared"}
place: {p: {template: pair, with: {a: a}}}
time: {end: 1, step: 0.1}
"""


def test_formulas_in_copies():
    """Values of parameters are written into them; names of the template come first, those from outside stay."""
    values = deck_of_bytes(CONTROLLED.encode(), "test.yaml").values
    signals = {name: d.get("value", d.get("input")) for name, d in values["signals"].items()}
    assert signals == {
        "shared": "1 + time",
        "twice_one": "2*p_one_sum - (-0.5)*time", "twice_two": "2*p_two_sum - (-0.5)*time",
        "nodes_1": "1*nodes.a.position.x - shared", "nodes_2": "2*nodes.a.position.x - shared",
        "p_one_far": "2.5*(p_one_a.position.x - p_own.position.x) + (-0.5)**2",
        "p_two_far": "3*(p_two_a.position.x - a.position.x) + (-0.5)**2",
        "p_one_slow": "p_one_far + 1", "p_two_slow": "p_two_far + 1",
        "p_one_sum": "joints.p_one_slide.velocity*tanh(time) + 1e-3*min(p_one_far, p_one_slow) + shared",
        "p_two_sum": "joints.p_two_slide.velocity*tanh(time) + 1e-3*min(p_two_far, p_two_slow) + shared",
    }  # fmt: skip
    assert values["joints"]["p_two_slide"]["release"]["when"] == "p_two_slide.displacement > 3"
    assert values["loads"]["p_one_push"]["value"] == "p_one_sum"
    assert values["loads"]["p_one_shake"]["value"] is values["laws"]["p_one_swing"]


@pytest.mark.parametrize(
    ("good", "bad", "message"),
    [
        ("mass: 1, inertia: [1, 1, 1]}}\n    joints", "mass: 2*$gian, inertia: [1, 1, 1]}}\n    joints",
         "unknown parameter 'gian'"),
        ("mass: 1, inertia: [1, 1, 1]}}\n    joints", "mass: $gain kg, inertia: [1, 1, 1]}}\n    joints",
         "the expression '$gain kg' cannot be understood"),
        ("input: far + 1", "input: fra + $gain", "there is no signal 'fra'"),
        ("nodes_$i: {", "nodes_$offset: {", "only whole numbers and words"),
    ],
)  # fmt: skip
def test_mistakes_in_copies_of_formulas(good, bad, message):
    assert good in CONTROLLED
    with pytest.raises(DeckError) as error:
        deck_of_bytes(CONTROLLED.replace(good, bad, 1).encode(), "test.yaml")
    assert message in str(error.value)


UNITS = """\
mecano: 1
gravity: none
parameters: {long: 0.5 rpm, heavy: 5 m}
templates:
  part:
    parameters: {k: 2 kN/m, inner_k: $k, at: 0}
    nodes: {a: {position: [$at, 0, 0]}, b: {position: [1, 0, 0]}}
    elements:
      body: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}
      spring: {type: spring_damper, nodes: [a, b], law: {spring: $inner_k}}
place:
  p: {template: part}
time: {end: 1, step: 0.1}
"""


@pytest.mark.parametrize(
    ("good", "bad", "message"),
    [
        ("mass: 1", "mass: $heavy", "parameter $heavy is 5 m: a mass [kg] is expected, and 'm' is a length"),
        ("{k: 2 kN/m", "{k: 2 kg", "parameter $inner_k is 2 kg: a stiffness [N/m] is expected, and 'kg' is a mass"),
        ("template: part}", "template: part, with: {k: $heavy}}", "parameter $inner_k is 5 m: a stiffness"),
        ("template: part}", "template: part, position: [$long, 0, 0]}", "parameter $long is 0.5 rpm: a length [m]"),
        ("at: 0}", "at: 2 kg}", "parameter $at is 2 kg: a length [m] is expected"),
    ],
)  # fmt: skip
def test_units_of_parameters_in_templates(good, bad, message):
    assert deck_of_bytes(UNITS.encode(), "test.yaml") and good in UNITS
    with pytest.raises(DeckError) as error:
        deck_of_bytes(UNITS.replace(good, bad).encode(), "test.yaml")
    assert message in str(error.value)


def test_what_a_missing_file_defines_is_not_reported(tmp_path):
    (tmp_path / "deck.yaml").write_text("include: [lost.yaml]\nmecano: 1\nnodes: {a: {position: [$length, 0, 0]}}\n")
    with pytest.raises(DeckError) as error:
        read_deck(tmp_path / "deck.yaml")
    text = deck_error_text(error.value)
    assert "file 'lost.yaml' cannot be read" in text and "length" not in text.replace("[$length", "")
    assert UNCHECKED in text


@pytest.mark.parametrize("key", ["template", "templats"])
def test_a_misspelt_section_of_templates_is_one_error(key):
    text = f"""
    mecano: 1
    gravity: none
    {key}:
      leg:
        nodes: {{a: {{position: [0, 0, 0], fixed: true}}, b: {{position: [1, 0, 0]}}}}
        elements: {{m: {{type: point_mass, node: b, mass: 1 kg}}}}
    place: {{l1: {{template: leg}}, l2: {{template: leg}}}}
    time: {{end: 1, step: 1 ms}}
    """
    with pytest.raises(DeckError) as error:
        deck_of_bytes(dedent(text).encode(), "test.yaml")
    assert [problem.message for problem in error.value.problems] == [f"unknown key '{key}'"]


def test_a_misspelt_place_is_not_taken_for_laws():
    with pytest.raises(DeckError) as error:
        deck_of_bytes(b"{mecano: 1, nodes: {}, elements: {}, laws: {}, time: {end: 1}, lace: {}}", "test.yaml")
    assert "unknown key 'lace'; did you mean 'place'?" in deck_error_text(error.value)
