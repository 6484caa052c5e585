"""Joints between the same two bodies that bind are named; those that leave a motion, and frames, are not."""

import numpy as np
import pytest
from time_runs import deck

from mecano.analyses.prepare import prepare
from mecano.maths.vector import skew

TWO_SUPPORTS = """
    mecano: 1
    gravity: [0, 0, -9.81]
    time: {{end: 1, step: 0.01}}
    sections: {{tube: {{type: circle, E: 2e11, nu: 0.3, density: 7800, diameter: 0.02}}}}
    nodes:
      a: {{position: [0.2, 0.1, -0.3]}}
      b: {{position: [1, 0.4, 0]}}
      c: {{position: [1, 0.4, 0], fixed: true}}
      d: {{position: [0.2, 0.1, -0.3], fixed: true}}
    elements:
      {part}
    joints:
      first: {{type: {first}}}
      second: {{type: {second}}}
"""
RIGID = "door: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1], attached: [b]}"
BEAM = "blade: {type: beam, nodes: [a, b], section: tube}"
LINE = "axis: [0.8, 0.3, 0.3]"  # from a to b
BESIDE = "axis: [0.8, 0.3, 0.31]"
BETWEEN_A, BETWEEN_B = "nodes: [d, a]", "nodes: [c, b]"
ANGLE = np.arctan2(np.linalg.norm(np.cross([0.8, 0.3, 0.3], [0.8, 0.3, 0.31])), 0.8 * 0.8 + 0.09 + 0.3 * 0.31)


def supported(first, second, part=RIGID):
    """A deck with a part on two supports, each (type, fields)."""
    return deck(TWO_SUPPORTS.format(part=part, first=f"{first}, {BETWEEN_A}", second=f"{second}, {BETWEEN_B}"))


def bound(found):
    """The texts on joints that bind."""
    return [problem.message for problem in found.warnings if "bind" in problem.message]


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (f"hinge, {LINE}", f"hinge, {LINE}"),
        (f"hinge, {LINE}", f"hinge, {BESIDE}"),
        (f"hinge, {LINE}", f"cylindrical, {BESIDE}"),
        ("hinge, axis: [0, 1, 0]", "hinge, axis: [0, 1, 0]"),
        (f"hinge, {LINE}", f"planar, {LINE}"),
        (f"hinge, {LINE}", "planar, axis: [0, 0, 1]"),
        ("spherical", "spherical"),
        (f"hinge, {BESIDE}", "spherical"),
        (f"prismatic, {BESIDE}", f"prismatic, {BESIDE}"),
        (f"prismatic, {LINE}", f"prismatic, {BESIDE}"),
        (f"prismatic, {LINE}", f"cylindrical, {LINE}"),
        (f"prismatic, {LINE}", f"hinge, {LINE}"),
        (f"generic, {LINE}, free: [along_axis]", f"generic, {LINE}, free: [along_axis, about_axis]"),
        (f"generic, {LINE}, free: [along_1]", f"generic, {LINE}, free: [along_2]"),
    ],
)  # fmt: skip
def test_bound_where_the_assembled_constraints_leave_no_motion(first, second):
    """The rows of two joints agree with the rank of the constraints of the assembled model, which are others."""
    found = supported(first, second)
    assert bool(bound(found)) == (prepare(found).analysis.mobility == 0)


def test_angle_and_distance():
    """Those of the second axis from the line of the first: atan2 of cross and dot product, |mu x r|."""
    (text,) = bound(supported(f"hinge, {BESIDE}", f"hinge, {LINE}"))
    beside = np.linalg.norm(np.array(skew(np.array([0.8, 0.3, 0.31]))) @ [0.8, 0.3, 0.3]) / np.linalg.norm(
        [0.8, 0.3, 0.31]
    )
    assert text.startswith("hinge 'first', hinge 'second' join the same two bodies and bind: ")
    assert f"others are {ANGLE:.3g} rad from its direction and {beside:.3g} m beside it" in text


def test_flexible_parts_are_bound_by_nearly_agreeing_axes_only():
    """A beam on two hinges turns by its deformation if their axes differ a little; on parallel axes it is a frame."""
    (text,) = bound(supported(f"hinge, {LINE}", f"hinge, {BESIDE}", BEAM))
    assert "let them move only by deformation" in text
    for axis in (LINE, "axis: [0, 1, 0]"):
        assert not bound(supported(f"hinge, {axis}", f"hinge, {axis}", BEAM))


@pytest.mark.parametrize(
    "freed",
    ["release: {time: 0.5}", "compliance: {about_1: {spring: {stiffness: 9}}, about_2: {spring: {stiffness: 9}}}"],
)
def test_released_and_elastic_joints_bind_nothing(freed):
    """A joint that is released, or elastic about the axes that disagree, is not counted."""
    second = f"cylindrical, {BESIDE}, {freed}"
    assert not bound(supported("spherical", second))
    assert bound(supported("spherical", f"cylindrical, {BESIDE}"))
