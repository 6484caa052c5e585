"""Angles of bodies that no bearing holds are warned of, and moments about an axis about which nothing can turn."""

import pytest
from time_runs import deck, input_deck

DECK = """
    mecano: 1
    gravity: [0, 0, -9.81]
    time: {end: 1, step: 0.01}
    nodes: {pin: {position: [0, 0, 0]}, end: {position: [0, 1, 0]}}
    elements:
      bar: {type: rigid_body, node: pin, mass: 1, inertia: [1, 1, 1], attached: [end]}
    joints:
      drive: {type: prescribed_angle, nodes: [ground, pin], axis: [0, 1, 0], value: {polynomial: [0, 2]}}
"""


@pytest.mark.parametrize(
    ("joints", "reason"),
    [
        ("", "no joint or member holds it"),
        ("ball: {type: spherical, nodes: [ground, pin]}", "only 'ball' holds it, at a point"),
        ("bearing: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0]}", ""),
        ("frame: {type: held_rotation, nodes: [ground, pin]}", ""),
        ("cross: {type: universal, nodes: [ground, pin], axis_a: [1, 0, 0], axis_b: [0, 1, 0]}", ""),
        (
            "ball: {type: spherical, nodes: [ground, pin]}\n      ball_2: {type: spherical, nodes: [ground, end]}",
            "",
        ),
    ],
)
def test_an_axis_that_nothing_holds_is_warned_of(joints, reason):
    """A single ball joint lets the body turn about any axis; two are a bearing."""
    found = [w.message for w in deck(DECK + f"      {joints}\n").warnings if "can turn about any axis" in w.message]
    if not reason:
        assert found == []
        return
    assert found == [
        f"prescribed_angle 'drive': node 'pin' can turn about any axis, as {reason}; "
        "the joint holds the angle about its axis alone: is a hinge missing?"
    ]


RELEASED = "bearing: {type: hinge, nodes: [ground, pin], axis: [0, 1, 0], release: {time: 0.5}}"


def test_an_angle_that_outlasts_its_bearing_is_warned_of():
    found = [w for w in deck(DECK + f"      {RELEASED}\n").warnings if "can turn about any axis" in w.message]
    assert [f"{w.mark}: {w.message}" for w in found] == [
        "test.yaml:9:3: prescribed_angle 'drive': node 'pin' can turn about any axis, once 'bearing' is released; "
        "the joint holds the angle about its axis alone: is a hinge missing?"
    ]


@pytest.mark.parametrize(
    ("acting", "end"),
    [
        ("loads: {motor: {type: joint_moment, joint: bearing, value: 3}}", "let its value become zero then"),
        ("loads: {motor: {type: joint_moment, joint: bearing, value: '3 - bearing.angle'}}", ""),
    ],
)
def test_a_motor_of_a_released_joint_is_warned_of(acting, end):
    text = DECK.replace("      drive", "      # drive") + f"      {RELEASED}\n    {acting}\n"
    found = [w.message for w in deck(text).warnings]
    assert found == ([f"joint_moment 'motor': it acts on after the release of hinge 'bearing'; {end}"] if end else [])


def test_a_gear_without_a_bearing_is_warned_of():
    (said,) = (w.message for w in input_deck("gears", "joints.bearing_c=null").warnings)
    assert said.startswith(
        "gear_pair 'bevel': node 'c' can turn about any axis, as no joint or member holds it; the joint"
    )
    assert input_deck("gears").warnings == ()


SHAFTS = """
    mecano: 1
    gravity: none
    time: {end: 1, step: 0.01}
    nodes: {one: {position: [0, 0, 0]}, two: {position: [0, 0, 0]}}
    elements:
      one: {type: rigid_body, node: one, mass: 1, inertia: [1, 1, 1]}
      two: {type: rigid_body, node: two, mass: 1, inertia: [1, 1, 1]}
      spring: {type: torsion_spring_damper, nodes: [one, two], axis: AXIS, law: {spring: 1}}
    joints:
      bearing_1: {type: hinge, nodes: [ground, one], axis: [0, 1, 0]}
      bearing_2: {type: hinge, nodes: OTHER, axis: [0, -1, 0]}
"""


@pytest.mark.parametrize("nodes", ["[ground, two]", "[one, two]"])
@pytest.mark.parametrize(("axis", "warned"), [("[1, 0.05, 0]", True), ("[1, 0.2, 0]", False), ("[0, -1, 0]", False)])
def test_a_spring_about_an_axis_across_that_of_its_bearings_is_warned_of(axis, warned, nodes):
    """Between bodies on one hinge, or on two parallel ones of a third body."""
    found = [w.message for w in deck(SHAFTS.replace("AXIS", axis).replace("OTHER", nodes)).warnings]
    assert len(found) == warned
    for said in found:
        assert said.startswith(f"torsion_spring_damper 'spring': 'axis' {axis} is across [0, ")
        assert said.endswith("turn: no effect")


def test_a_brake_about_another_axis_than_its_wheel_is_warned_of():
    (said,) = (w.message for w in input_deck("braked_wheel", "loads.brake.axis=[1, 0, 0]").warnings)
    assert said == (
        "brake 'brake': 'axis' [1, 0, 0] is across [0, 1, 0], the only axis about which hinge 'bearing' lets 'leg', "
        "'hub' turn: no effect"
    )


def test_a_rack_across_its_guide_is_warned_of():
    (said,) = (w.message for w in input_deck("rack", "joints.guide.axis=[0, 0, 1]").warnings)
    assert said == (
        "rack_and_pinion 'teeth': 'direction' [1, 0, 0] is across [0, 0, 1], along which prismatic 'guide' lets 'rack' "
        "slide: it cannot roll"
    )
    assert input_deck("rack").warnings == ()


def test_a_follower_that_only_its_cam_holds_is_warned_of():
    (said,) = input_deck("cam", "joints.guide=null").warnings
    assert said.message == (
        "point_on_curve 'profile': nothing but 'profile' holds node 'roller', which may leave the plane of the curve; "
        "is a guide missing, or 'across: held'?"
    )
    assert str(said.mark).endswith("cam.yaml:28:13") and input_deck("cam").warnings == ()
    assert input_deck("cam", "joints.guide=null", "joints.profile.across=held").warnings == ()
