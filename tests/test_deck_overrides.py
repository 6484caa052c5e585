"""``--set path=value``."""

import pytest
from deck_samples import VALID, problems_of, read_fake

from mecano.deck.overrides import ADDING
from mecano.deck.read import deck_of_bytes
from mecano.errors import DeckError


def test_values_keys_items_and_parameters():
    deck = read_fake(
        VALID,
        overrides=[
            "nodes.top.position.0=0.5",
            "nodes.axle.position=[1, 2, $sink]",
            "parameters.mass=3e1",
            "time.newton.maximum_iterations=7",
            "time.adaptive.minimum_step=1e-9",
            "initial.velocities.0.nodes=[top, axle]",
            "elements.absorber.law={spring: {stiffness: 5}}",
            "title=no",
            "time.end=2",
            "time.end=3",
        ],
    )
    values = deck.values
    assert values["nodes"]["top"]["position"] == [0.5, 0.0, 2.1]
    assert values["nodes"]["axle"]["position"] == [1.0, 2.0, 3.05]
    assert values["elements"]["hub"]["mass"] == 30.0
    assert values["time"]["newton"]["maximum_iterations"] == 7
    assert values["time"]["adaptive"] == {
        "tolerance": 1e-4, "minimum_step": 1e-9, "maximum_step": "automatic", "length_scale": "automatic"
    }  # fmt: skip
    assert values["initial"]["velocities"][0]["nodes"] == ["top", "axle"]
    assert values["elements"]["absorber"]["law"] == (("spring", {"stiffness": 5.0}),)
    assert (values["title"], values["time"]["end"]) == ("no", 3.0)
    assert deck.overrides[0] == "nodes.top.position.0=0.5" and deck.text == VALID


def test_a_shared_value_is_changed_in_one_place_only():
    text = VALID.replace("axis: [0, 1, 0], stop", "axis: &y [0, 1, 0], stop").replace(
        "axle], axis: [0, 1, 0]", "axle], axis: *y"
    )
    values = read_fake(text, overrides=["joints.held.axis.0=1"]).values
    assert values["joints"]["held"]["axis"] == [1.0, 1.0, 0.0]
    assert values["joints"]["pin"]["axis"] == [0.0, 1.0, 0.0]


@pytest.mark.parametrize("null", ["null", "~", "Null"])
def test_an_optional_field_set_to_null_is_absent(null):
    """In the deck as well as on the command line: it has its default."""
    assert read_fake(VALID).values["time"]["adaptive"] is not None
    assert read_fake(VALID, overrides=[f"time.adaptive={null}"]).values["time"]["adaptive"] is None
    assert read_fake(VALID, overrides=[f"time.rho_inf={null}"]).values["time"]["rho_inf"] == 0.8
    assert read_fake(VALID, overrides=[f"time.newton={null}"]).values["time"]["newton"]["force_tolerance"] == 1e-7
    text = VALID.replace("output: {every: 5e-3}", f"output: {null}")
    assert text != VALID and read_fake(text).values["output"] == {"every": "step"}


def test_null_removes_entries_of_sections_and_terms_of_laws():
    values = read_fake(VALID, overrides=["elements.hub=null"]).values
    assert "hub" not in values["elements"] and "hub" in read_fake(VALID).values["elements"]
    terms = [
        [name for name, _ in read_fake(VALID, overrides=o).values["laws"]["oleo"]]
        for o in ([], ["laws.oleo.damper=null"])
    ]
    assert terms == [["polynomial", "damper", "stop"], ["polynomial", "stop"]]


@pytest.mark.parametrize("removed", ["templates.leg.joints", "templates.leg.joints.pin"])
def test_null_removes_entries_and_sections_of_templates(removed):
    text = (
        VALID
        + """
templates:
  leg:
    nodes: {foot: {position: [9, 0, 0]}}
    elements: {shoe: {type: body, node: foot, mass: 1}}
    joints: {pin: {type: hinge, nodes: [ground, foot], axis: [0, 1, 0]}}
place: {left: {template: leg}}
"""
    )
    assert "left_pin" in read_fake(text).values["joints"]
    values = read_fake(text, overrides=[f"{removed}=null"]).values
    assert "left_pin" not in values["joints"] and "left_shoe" in values["elements"]


@pytest.mark.parametrize(
    ("override", "problem"),
    [
        ("nodes.tpo.position=[1, 2, 3]", "1:7 'nodes' has no 'tpo'; did you mean 'top'?"),
        ("parameters.sikn=3", "1:12 'parameters' has no 'sikn'; did you mean 'sink'?; " + ADDING),
        ("laws.new=3", "1:6 'laws' has no 'new'; known: oleo, smooth; " + ADDING),
        ("joints.pim=null", "1:8 'joints' has no 'pim'; did you mean 'pin'?; " + ADDING),
        ("include=a.yaml", "1:1 unknown key 'include'; 'include' is allowed in the file of the deck only"),
        ("hub.mass=3", "1:1 unknown key 'hub'; write elements.hub.mass"),
        ("mass=3", "1:1 unknown key 'mass'; write parameters.mass"),
        ("gravity[2]=3", "1:1 unknown key 'gravity[2]'; an item of a list is written gravity.2"),
        (
            "joints.pin.nodes[1]=top",
            "1:12 unknown key 'nodes[1]'; an item of a list is written joints.pin.nodes.1",
        ),
        ("tme.end=3", "1:1 unknown key 'tme'; did you mean 'time'?"),
        ("time.edn=3", "1:6 unknown key 'time.edn'; did you mean 'end'?"),
        ("time.newton.iterations=3", "1:13 unknown key 'time.newton.iterations'; did you mean 'maximum_iterations'?"),
        ("nodes.top.position.3=1", "1:20 '3' is not an item of a list of 3; items are counted from 0"),
        ("nodes.top.position.x=1", "1:20 'x' is not an item of a list of 3; items are counted from 0"),
        ("joints.pin.other.2=1", "1:12 the deck has no list 'other' whose item could be set; set the whole list"),
        ("title.x=1", "1:7 'title' is a single value and has no 'x'"),
        ("elements.hub.mass=heavy", "1:19 body 'hub': 'mass' must be a number [kg], got the text 'heavy'"),
        ("elements.hub.mass=-1", "1:19 body 'hub': 'mass' must be greater than zero [kg], got -1"),
        ("elements.hub.mass=", "1:19 body 'hub': 'mass' must be a number [kg], got nothing"),
        ("elements.hub.mass=null", "1:19 body 'hub': 'mass' must be a number [kg], got nothing"),
        ("time.adaptive=", "1:15 'time.adaptive' must be a mapping, got nothing"),
        ("gravity=[0, 0, x]", "1:16 'gravity[2]' must be a number [m/s2], got the text 'x'"),
        (
            "gravity=[0, 0",
            "1:14 not valid YAML: while parsing a flow sequence, did not find expected ',' or ']'; the bracket opened "
            "in line 1 is not closed before this",
        ),
        ("gravity={a: 1, a: 2}", "1:16 duplicate key 'a', first given in line 1"),
        ("elements.wheel.ground=sea", "1:23 wheel 'wheel': unknown ground 'sea'; known: runway"),
        ("mecano=2", "1:8 this program reads decks of version 1, got 2; write 'mecano: 1'"),
        ("gravity", "1:1 an override is written path.to.key=value"),
        ("=3", "1:1 an override is written path.to.key=value"),
        ("time..end=3", "1:1 an override is written path.to.key=value"),
        (".".join("a" * 1000) + "=3", "1:1 an override is written path.to.key=value"),
        ("title=\x1b", "1:1 control characters are not allowed"),
    ],
)
def test_wrong_overrides(override, problem):
    assert problems_of(VALID, [override]) == [problem]
    with pytest.raises(DeckError) as info:
        read_fake(VALID, overrides=[override])
    assert info.value.problems[0].mark.file.startswith("override")


def test_all_wrong_overrides_at_once_with_the_problems_of_the_deck():
    found = problems_of(VALID.replace("title:", "titel:"), ["nodes.tpo.fixed=true", "time.end=x"])
    assert len(found) == 3


REPEATED = """mecano: 1
gravity: none
parameters: {last: 4, side: left}
nodes: {hub: {position: [0, 0, 0]}, left: {position: [0, 0, 1]}, rib$i: {repeat: {i: 1..$last}, position: [$i, 0, 0]}}
elements:
  wing: {type: rigid_body, node: hub, mass: 9, inertia: [1, 1, 1], attached: [$side, rib1, rib2, rib3, rib4]}
time: {end: 1, step: 0.01}
"""


@pytest.mark.parametrize(
    ("attached", "names"),
    [
        ("[{repeat: {i: 1..$last}, items: [rib$i]}, left]", ["rib1", "rib2", "rib3", "rib4", "left"]),
        ("[rib4, rib3, $side, {repeat: {i: 1..2}, items: [rib$i]}]", ["rib4", "rib3", "left", "rib1", "rib2"]),
    ],
)
@pytest.mark.parametrize("of_variant", [False, True])
def test_lists_of_overrides_may_have_repeated_items_and_words(attached, names, of_variant):
    path = "elements.wing.attached"
    if of_variant:
        deck = deck_of_bytes(f"{REPEATED}set: {{{path}: {attached}}}\n".encode(), "deck.yaml")
    else:
        deck = deck_of_bytes(REPEATED.encode(), "deck.yaml", overrides=[f"{path}={attached}"])
    assert deck.values["elements"]["wing"]["attached"] == names
    assert not deck.warnings


def test_wrong_repeated_items_of_overrides_are_reported_there():
    given = "elements.wing.attached=[{repeat: {i: 1..5}, items: [rib$i]}, left]"
    with pytest.raises(DeckError) as info:
        deck_of_bytes(REPEATED.encode(), "deck.yaml", overrides=[given])
    (problem,) = info.value.problems
    assert str(problem.mark) == "override elements.wing.attached:1:53" and "unknown node 'rib5'" in problem.message
