"""Redundant and contradictory constraints: all joints involved are named, also those that share unknowns.

The joints involved are known from statics: a group is a set of constraints that can load one another, and leaving
any of its joints out makes what is left isostatic.
"""

import numpy as np
import pytest
from time_runs import RecordedRun, deck, input_deck

from mecano.analyses.prepare import prepare, startup_warnings
from mecano.analyses.summary import summary
from mecano.errors import AssemblyError

HEAD = "mecano: 1\ngravity: none\ntime: {end: 1, step: 0.1}\n"
ARRAY = """
    mecano: 1
    gravity: none
    nodes:
      bus: {position: [0, 0, 0]}
      root: {position: [0, 0.8, 0]}
      p1: {position: [0, 0.8, 0]}
      e1: {position: [2, 0.8, 0]}
      p2: {position: [2, 0.8, 0]}
    elements:
      bus: {type: rigid_body, node: bus, attached: [root], mass: 900, inertia: [500, 400, 600]}
      one: {type: rigid_body, node: p1, attached: [e1], mass: 8, center_of_mass: [1, 0, 0], inertia: [0.96, 2.67, 3.63]}
      two: {type: rigid_body, node: p2, mass: 8, center_of_mass: [-1, 0, 0], inertia: [0.96, 2.67, 3.63]}
    laws: {drive: {spring: {stiffness: 0.6}}}
    joints:
      h1:
        {type: hinge, nodes: [root, p1], axis: [0, 0, 1], turning_law: drive, natural_angle: 110 deg,
         latch: {angle: 90 deg}}
      h2:
        {type: hinge, nodes: [e1, p2], axis: [0, 0, -1], turning_law: drive, natural_angle: 220 deg,
         latch: {angle: 180 deg}}
      cable: {type: coupler, angles: [h1, h2], factors: [2, -1]}
    time: {end: 10, step: 0.01}
    """
BODY = "type: rigid_body, mass: 1, inertia: [1, 1, 1]"
# two bodies at the same places, a with the nodes a1, a2 and a3 of a triangle, b with b1, b2 and b3
PLACES = {"1": "[0, 0, 0]", "2": "[1, 0, 0]", "3": "[0, 1, 0]"}
PAIR = "nodes: {a: {position: [0, 0, 1]}, b: {position: [0, 0, 2]}, " + ", ".join(
    f"{body}{i}: {{position: {x}}}" for body in "ab" for i, x in PLACES.items()
)
PAIR += f"""}}
elements:
  body_a: {{{BODY}, node: a, attached: [a1, a2, a3]}}
  body_b: {{{BODY}, node: b, attached: [b1, b2, b3]}}
joints:
"""
# two links of 1 m in a line, from the ground at 0 to 2 m
TOGGLE = f"""nodes:
  a: {{position: [0, 0, 0]}}
  a2: {{position: [1, 0, 0]}}
  b: {{position: [1, 0, 0]}}
  b2: {{position: [2, 0, 0]}}
elements:
  one: {{{BODY}, node: a, attached: [a2]}}
  two: {{{BODY}, node: b, attached: [b2]}}
joints:
"""
ONE = f"""nodes: {{a: {{position: [0, 0, 0]}}, tip: {{position: [1, 0, 0]}}, side: {{position: [0, 1, 0]}}}}
elements: {{body: {{{BODY}, node: a, attached: [tip, side]}}}}
joints:
"""


def joints(**lines):
    """Lines of the section ``joints``, "type between"."""
    text = ""
    for name, line in lines.items():
        kind, nodes, *more = line.split(" ", 2)
        text += f"  {name}: {{type: {kind}, nodes: [{nodes}]{', ' if more else ''}{''.join(more)}}}\n"
    return text


Y, Z = "axis: [0, 1, 0]", "axis: [0, 0, 1]"
BAD = {  # what it is: text, redundant constraints, joints that take part
    "two fixed": (PAIR + joints(f="fixed a1,b1", g="fixed a2,b2", free="spherical ground,a3"), 6, "f g"),
    "two fixed at one node": (PAIR + joints(f="fixed a1,b1", g="fixed a1,b1"), 6, "f g"),
    "three sphericals": (PAIR + joints(r="spherical a1,b1", s="spherical a2,b2", t="spherical a3,b3"), 3, "r s t"),
    "straight toggle": (
        TOGGLE + joints(r=f"hinge ground,a {Y}", s=f"hinge a2,b {Y}", t="spherical ground,b2"), 2, "r s t"),
    "straight toggle of sphericals": (
        TOGGLE + joints(r="spherical ground,a", s="spherical a2,b", t="spherical ground,b2"), 1, "r s t"),
    "two hinges on one axis": (PAIR + joints(r="hinge a1,b1 axis: [1, 0, 0]", s="hinge a2,b2 axis: [1, 0, 0]"),
                               5, "r s"),
    "motor on what is held": (
        TOGGLE + joints(f="fixed ground,a", m=f"prescribed_angle ground,a2 {Y}, value: 0", s="spherical a2,b"),
        1, "f m"),
    "two prismatics": (PAIR + joints(r=f"prismatic a1,b1 {Z}", s=f"prismatic a2,b2 {Z}"), 5, "r s"),
    "fixed and a hinge": (PAIR + joints(f="fixed a1,b1", h=f"hinge a2,b2 {Z}"), 5, "f h"),
    "fixed and a hinge with an open latch": (
        PAIR + joints(f="fixed a1,b1 release: {time: 1}", h=f"hinge a2,b2 {Z}, latch: {{angle: 1}}"), 5, "f h"),
    "rod and spherical": (
        PAIR + joints(r="spherical a1,b1", s="spherical a2,b2", t="rigid_rod a1,b2"), 2, "r s t"),
}  # fmt: skip


def named(groups):
    """Names of the joints of some groups."""
    return {text.split("'")[1] for group in groups for text in group.names if not text.startswith("rigid_body")}


@pytest.mark.parametrize("name", BAD)
def test_all_joints_that_take_part_are_named(name):
    text, count, expected = BAD[name]
    prepared = prepare(deck(HEAD + text))
    assert sum(group.count for group in prepared.redundant) == count
    assert named(prepared.redundant) == set(expected.split())
    said = summary(prepared.deck)
    assert f"redundant        {count} constraint(s)" in said
    assert all(f" '{joint}'" in said.partition("redundant  ")[2] for joint in expected.split())
    assert any("redundant constraint(s) among" in text for text in startup_warnings(prepared))


GOOD = {
    "one fixed": PAIR + joints(f="fixed a1,b1", free="spherical ground,a3"),
    "one spherical": PAIR + joints(r="spherical a1,b1"),
    "spherical and rod": PAIR + joints(r="spherical a1,b1", s="rigid_rod a2,b3"),
    "toggle that is bent": TOGGLE.replace("b2: {position: [2, 0, 0]}", "b2: {position: [1.6, 0, 0.8]}")
    + joints(r=f"hinge ground,a {Y}", s="spherical a2,b", t="spherical ground,b2"),
    "straight open chain": TOGGLE + joints(r=f"hinge ground,a {Y}", s=f"hinge a2,b {Y}"),
    "fixed chain": TOGGLE + joints(r=f"hinge ground,a {Y}", s="fixed a2,b"),
    "motor on a hinge": ONE
    + joints(r=f"hinge ground,a {Y}")
    + f"  motor: {{type: prescribed_angle, nodes: [ground, a], {Y}, value: 0}}\n",
    "six rods": PAIR
    + joints(**{f"r{i}{j}": f"rigid_rod a{i},b{j}" for i, j in ("12", "23", "31")}, s="spherical ground,a1"),
    "prismatic": PAIR + joints(r=f"prismatic a1,b1 {Z}"),
    "hinge and cylindrical": PAIR + joints(r=f"cylindrical a1,b1 {Z}"),
}


@pytest.mark.parametrize("name", GOOD)
def test_no_false_alarm(name):
    prepared = prepare(deck(HEAD + GOOD[name]))
    assert prepared.redundant == () and not any("redundant" in text for text in startup_warnings(prepared))


INPUTS_WITHOUT = ("pendulum", "double_pendulum", "hanging_chain", "slider_crank", "gears", "free_body")


@pytest.mark.parametrize("name", INPUTS_WITHOUT)
def test_no_false_alarm_of_decks(name):
    prepared = prepare(input_deck(name))
    assert prepared.redundant == () == prepared.analysis.redundant


def test_the_count_is_that_of_the_shared_unknowns():
    """Taken apart, a model has the same redundant constraints, where nothing is identified twice."""
    for name in ("four_bar", "n_four_bar"):
        prepared = prepare(input_deck(name))
        counts = [sum(group.count for group in groups) for groups in (prepared.redundant, prepared.analysis.redundant)]
        assert counts[0] == counts[1] > 0


def test_groups_of_the_same_names_are_one():
    """Two hinges that lie on one axis repeat one another about both axes across it."""
    groups = prepare(deck(HEAD + BAD["two hinges on one axis"][0])).redundant
    assert len({group.names for group in groups}) == len(groups)


def test_reactions_of_latches_that_cables_repeat_are_quiet():
    """Without gravity, compliances suit what moves: a folded array, at rest after its latches, keeps still moments.

    The latches hold against the springs, 0.6 N m/rad * 20 and 40 deg; the couplers repeat what they hold, and bear the
    moments that rounding of the angles leaves between both.
    """
    run = RecordedRun(deck(ARRAY))
    last = run.time > run.event_records[-1].t + 1.0
    assert len(run.event_records) == 2 and last.sum() > 200
    for name, degrees in (("h1", 20.0), ("h2", 40.0)):
        held = run[f"joints/{name}/latch_moment"][last]
        np.testing.assert_allclose(held.mean(), -0.6 * np.radians(degrees), rtol=0.05)
        assert held.std() < 0.02


def test_what_cannot_be_met_together_is_named():
    """A rod that is too short for where sphericals hold a body; the other rod does not take part."""
    text = ONE.replace(
        "nodes: {", "nodes: {pin: {position: [1, 0, 0], fixed: true}, far: {position: [3, 0, 0], fixed: true}, "
    )
    text += joints(s="spherical ground,a", t="spherical pin,tip", short="rigid_rod far,tip length: 0.5")
    text += joints(apart="rigid_rod far,side")
    with pytest.raises(AssemblyError) as error:
        prepare(deck(HEAD + text))
    taking_part, *places = str(error.value).splitlines()[-3:]
    assert taking_part == "  taking part: spherical 't', rigid_rod 'short'"
    assert [place.partition(" is at")[0] for place in places] == ["rigid_rod 'short'", "spherical 't'"]


def test_contradictory_joints_are_named_in_large_models():
    """Of a thousand bodies on sphericals, more than 3000 constraints, a rod holds one at a distance it cannot reach."""
    many = range(1000)
    text = "nodes: {pin: {position: [7, -1, 0], fixed: true}, "
    text += ", ".join(f"a{i}: {{position: [{i}, 0, 0]}}, tip{i}: {{position: [{i}, 1, 0]}}" for i in many)
    text += "}\nelements:\n" + "".join(f"  body{i}: {{{BODY}, node: a{i}, attached: [tip{i}]}}\n" for i in many)
    text += "joints:\n" + joints(**{f"t{i}": f"spherical ground,a{i}" for i in many})
    text += joints(far="rigid_rod tip7,pin length: 9")
    with pytest.raises(AssemblyError, match=r"taking part: rigid_body 'body7', spherical 't7', rigid_rod 'far'\n"):
        prepare(deck(HEAD + text))


def test_a_shaft_between_two_cardan_joints_turns_through_positions_without_forces():
    """Pins at right angles: tan(theta_2) = cos(b)^2 tan(theta_1); all forces vanish at quarter turns of the input."""
    c, s = np.cos(0.5), np.sin(0.5)
    body = "type: rigid_body, mass: 1, inertia: [0.01, 0.01, 0.01]"
    run = RecordedRun(
        deck(f"""
        mecano: 1
        gravity: none
        nodes:
          input: {{position: [0, 0, 0]}}
          middle: {{position: [0, 0, 0]}}
          end: {{position: [{c}, 0, {s}]}}
          output: {{position: [{c}, 0, {s}]}}
        elements:
          one: {{{body}, node: input}}
          two: {{{body}, node: middle, attached: [end]}}
          three: {{{body}, node: output}}
        joints:
          bearing: {{type: hinge, nodes: [ground, input], axis: [1, 0, 0]}}
          out: {{type: hinge, nodes: [ground, output], axis: [1, 0, 0]}}
          motor: {{type: prescribed_angle, nodes: [ground, input], axis: [1, 0, 0], value: {{linear: {{slope: 10}}}}}}
          cross_1: {{type: universal, nodes: [input, middle], axis_a: [0, 1, 0], axis_b: [{-s}, 0, {c}]}}
          cross_2: {{type: universal, nodes: [end, output], axis_a: [0, 1, 0], axis_b: [0, 0, 1]}}
        initial: {{velocities: [{{nodes: [input, output], angular_velocity: [10, 0, 0], about: own}}]}}
        time: {{end: 0.4, step: 1.0e-4}}
        """)
    )
    angle = 10 * run.time
    answer = np.unwrap(np.arctan2(c * c * np.sin(angle), np.cos(angle)))
    np.testing.assert_allclose(run["joints/out/angle"], answer, rtol=0, atol=1e-9)


HELD = f"""nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [0, 0, 0]}}}}
elements:
  body_a: {{{BODY}, node: a}}
  body_b: {{{BODY}, node: b}}
joints:
  pin_a: {{type: hinge, nodes: [ground, a], axis: [0, 1, 0]}}
  pin_b: {{type: hinge, nodes: [ground, b], axis: [0, 1, 0]}}
  hold_a: {{type: fixed, nodes: [ground, a], release: {{time: 0.5}}}}
  hold_b: {{type: fixed, nodes: [ground, b], release: {{time: 0.5}}}}
"""


def test_redundancies_of_two_pairs_of_joints_are_reported_apart():
    """A body on a hinge that is held until its release: all five constraints of the hinge are there twice."""
    prepared = prepare(deck(HEAD + HELD))
    assert [group.count for group in prepared.redundant] == [5, 5]
    first, second = (text for text in startup_warnings(prepared) if "redundant" in text)
    assert "pin_a" in first and "hold_a" in first and "pin_b" not in first and "pin_b" in second
    assert "redundant        10 constraint(s)" in summary(deck(HEAD + HELD))


def test_constraints_of_the_same_name_are_counted_one_by_one():
    """In a plane, a hinge along y holds y and both tilts in vain, a rigid offset y and the rotations about x and z."""
    text = " ".join(summary(input_deck("n_four_bar")).split())
    bodies, hinges = 5, 7
    assert f"6 redundant among these {3 * bodies + 3 * hinges}," in text
    assert "force y of the rigid offset; moment about initial x, z (3 of 6 constraints each)" in text
    assert "moment that keeps two axes perpendicular; force y (3 of 5 constraints each)" in text


def test_signals_that_are_not_known_yet_do_not_make_compliances_infinite():
    """Two hinges on one axis are redundant; acos(1.5) is not a number until the signal ``one`` has its value."""
    text = f"""
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [0, 1, 0]}}}}
    elements: {{bar: {{{BODY}, node: a, attached: [b]}}}}
    joints:
      left: {{type: hinge, nodes: [ground, a], axis: [0, 1, 0]}}
      right: {{type: hinge, nodes: [ground, b], axis: [0, 1, 0]}}
    signals: {{one: 1 + time, angle: acos(1.5 - one)}}
    time: {{end: 0.1, step: 0.01}}
    """
    recorded = RecordedRun(deck(text))
    assert recorded.prepared.compliance is not None
    assert recorded["signals/angle/value"] == pytest.approx(np.arccos(0.5 - recorded.time), rel=1e-9)


SLIDE = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [0, 0, 0.5]}}
    elements:
      one: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}
      two: {type: rigid_body, node: b, mass: 1, inertia: [1, 1, 1]}
    joints:
      slide: {type: prismatic, nodes: [a, b], axis: [0, 1, 0]}
      drive: {type: DRIVE}
    time: {end: 1, step: 0.1}
    """


@pytest.mark.parametrize(
    ("drive", "warned"),
    [
        ("prescribed_length, nodes: [a, b], value: 0.1*time*time", True),  # across the slide; at rest at the start
        ("prescribed_length, nodes: [a, b], value: 0", False),  # a rigid rod
        ("prescribed_position, node: a, direction: [1, 0, 0], value: 0.1*time", False),
    ],
)
def test_a_drive_across_its_motion_is_warned_of(drive, warned):
    said = summary(deck(SLIDE.replace("DRIVE", drive)))
    assert ("prescribed_length 'drive' repeats other constraints" in " ".join(said.split())) == warned
