"""The linkage of Bennett: a loop of four hinges in space, three of whose constraints are redundant in every position.

Its hinges are skew, so that the redundant directions turn with it. Opposite links are alike, and
sin(alpha)/a = sin(beta)/b; the angles of adjacent hinges satisfy
tan(t1/2) tan(t2/2) = sin((beta + alpha)/2)/sin((beta - alpha)/2)
(Bennett, Engineering 76 (1903) 777-778; Hunt, Kinematic Geometry of Mechanisms, 1978).
"""

import math

import numpy as np
from time_runs import RecordedRun, deck

ALPHA, BETA, FIRST = math.radians(40.0), math.radians(70.0), 1.0
RATIO = math.sin((BETA + ALPHA) / 2) / math.sin((BETA - ALPHA) / 2)
HINGE = "type: hinge"
TWO_AXES = "type: generic, free: [along_axis, about_1, about_2, about_axis]"  # what the motion leaves to be held


def second(first):
    """Return the angle of the second hinge for that of the first one."""
    return 2.0 * np.arctan2(RATIO * np.cos(first / 2), np.sin(first / 2))


def corners():
    """Return points and axes (4, 3) of the hinges, by the transformations of Denavit and Hartenberg."""
    a, b = 1.0, math.sin(BETA) / math.sin(ALPHA)
    points, axes, place = [], [], np.eye(4)
    links = (FIRST, a, ALPHA), (second(FIRST), b, BETA), (-FIRST, a, ALPHA), (-second(FIRST), b, BETA)
    for angle, length, twist in links:
        points.append(place[:3, 3])
        axes.append(place[:3, 2])
        c, s, ct, st = math.cos(angle), math.sin(angle), math.cos(twist), math.sin(twist)
        step = [[c, -s * ct, s * st, length * c], [s, c * ct, -c * st, length * s], [0, st, ct, 0], [0, 0, 0, 1]]
        place = place @ np.array(step)
    assert np.abs(place - np.eye(4)).max() < 1e-14
    return np.array(points).tolist(), np.array(axes).tolist()


def linkage(last):
    """Return the deck of the linkage, which falls from rest; ``last`` is its fourth joint."""
    points, axes = corners()
    middles = [((np.array(points[i + 1]) - points[i]) / 2).tolist() for i in range(3)]
    nodes = "".join(f"  n{i}: {{position: {points[i]}}}\n  m{i}: {{position: {points[i + 1]}}}\n" for i in range(3))
    links = "".join(
        f"  link{i}: {{type: rigid_body, node: n{i}, mass: 1, center_of_mass: {middles[i]}, "
        f"inertia: [0.1, 0.1, 0.1], attached: [m{i}]}}\n"
        for i in range(3)
    )
    before, behind = ("ground", "m0", "m1", "ground"), ("n0", "n1", "n2", "m2")
    joints = "".join(
        f"  h{i}: {{{HINGE if i < 3 else last}, nodes: [{before[i]}, {behind[i]}], axis: {axes[i]}}}\n"
        for i in range(4)
    )
    times = "time: {end: 2, step: 2 ms, adaptive: {tolerance: 1.0e-5}}\n"
    return deck(f"mecano: 1\ngravity: [0, 0, -9.81]\nnodes:\n{nodes}elements:\n{links}joints:\n{joints}{times}")


def test_redundant_hinges_in_space_cost_no_steps(verify):
    """Steps and motion are those of the loop that is closed by the two constraints that it needs."""
    redundant, isostatic = RecordedRun(linkage(HINGE)), RecordedRun(linkage(TWO_AXES))
    assert [group.count for group in redundant.prepared.analysis.redundant] == [3]
    assert not isostatic.prepared.analysis.redundant
    first, found = redundant["joints/h0/angle"], redundant["joints/h1/angle"]
    exact = np.unwrap(second(FIRST + first)) - second(FIRST)
    source = "closed form of Bennett 1903"
    verify(
        "Mechanisms", "Bennett's linkage falls: angle of its second hinge [rad]", found, exact, source, absolute=1e-9
    )
    end = isostatic["joints/h0/angle"][-1]
    assert abs(first[-1] - end) < 1e-7
    assert len(redundant.time) < 1.02 * len(isostatic.time)
    assert np.diff(redundant.time).min() > 0.5 * np.diff(isostatic.time).min()
