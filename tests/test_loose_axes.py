"""Prescribed angles of bodies that no bearing holds are warned of; those in hinges or on two points are not."""

import pytest
from time_runs import deck

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
        "the angle is that about 'axis' alone: is a hinge missing?"
    ]
