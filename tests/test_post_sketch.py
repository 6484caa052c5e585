"""Side views of mechanisms: shapes, plane, instants, ground."""

import every_kind
import numpy as np
import pytest

from mecano.post.draw_sketch import hull, zigzag
from mecano.post.runs import open_runs
from mecano.post.shapes import BODY, JOINT, SPRING, SUPPORT, WHEEL, Shape
from mecano.post.sketch import _axes, _instants, _shift, sketch


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return every_kind.write(tmp_path_factory.mktemp("sketch") / "each.h5")


@pytest.fixture(scope="module")
def runs(path):
    return open_runs([path])


def test_shapes_of_the_mechanism(runs):
    found = sketch(runs[0])
    assert found.axes == (0, 2) and found.in_place
    styles = {shape.name: shape.style for shape in found.shapes if shape.style != SUPPORT}
    assert styles["one_rigid_body"] == BODY and styles["one_spring_damper"] == SPRING
    assert styles["one_wheel"] == WHEEL and styles["one_hinge"] == JOINT
    assert not {"one_force", "one_torsion_spring_damper", "one_held_rotation"} & set(styles)
    assert [shape.name for shape in found.shapes if shape.style == SUPPORT] == ["base"]


def test_the_rim_turns_with_its_node(runs):
    found = sketch(runs[0])
    wheel = next(shape for shape in found.shapes if shape.style == WHEEL)
    spokes = (wheel.points[:, 0] - wheel.points[:, -1]) / 0.3
    assert np.allclose(np.linalg.norm(spokes, axis=1), 1.0, atol=1e-12)
    angle = found.times  # the node turns by t about y: x -> (cos t, 0, -sin t), z -> (sin t, 0, cos t)
    x, z = spokes[0, 0], spokes[0, 2]
    turned = np.stack([x * np.cos(angle) + z * np.sin(angle), 0 * angle, z * np.cos(angle) - x * np.sin(angle)], -1)
    assert np.allclose(spokes, turned, atol=1e-12)


def test_the_ground_is_its_profile(runs):
    (line,) = sketch(runs[0]).grounds
    assert np.allclose(line[:, 1], every_kind.WAVE * np.sin(np.pi * line[:, 0]), atol=1e-12)
    assert len(line) > 20


def test_a_tyre_is_flat_on_flat_ground(path):
    (run,) = open_runs([path])
    run.deck["grounds"]["runway"]["profile"] = None
    wheel = next(shape for shape in sketch(run).shapes if shape.style == WHEEL)
    assert wheel.points[..., 2].min() == 0.0  # the centre is at 0.2 m at times, the radius is 0.3 m


def test_plane_of_the_largest_extents_with_the_vertical_up():
    box = np.array([[0.0, 0.0, 0.0], [3.0, 2.0, 1.0]])
    assert _axes(box, [0, 0, -9.81]) == (0, 1)
    assert _axes(box * (1, 0.1, 1), [0, 0, -9.81]) == (0, 2)
    assert _axes(box, [-9.81, 0, 0]) == (1, 0)
    assert _axes(box * (1, 1, 3), None) == (0, 2)


def test_what_travels_far_is_shown_side_by_side():
    points = np.zeros((3, 2, 3))
    points[:, 1, 0] = 2.0  # 2 m wide
    points[:, :, 0] += np.array([[0.0], [50.0], [100.0]])
    shape = Shape(BODY, "body", points)
    left = points[:, 0, 0] + _shift([shape], 0)
    assert np.allclose(np.diff(left), 1.25 * 2.0)
    points[:, :, 0] = [[0.0, 2.0], [5.0, 7.0], [11.0, 13.0]]
    assert not _shift([shape], 0).any()


def test_instants_follow_the_motion():
    times = np.linspace(0.0, 10.0, 101)
    cloud = np.zeros((101, 2, 3))
    cloud[:, 1, 0] = 1.0 + np.clip(times - 8.0, 0.0, 1.0)  # moves from 8 to 9 s only
    chosen = times[_instants(times, cloud)]
    assert chosen[0] == 0.0 and chosen[-1] == 10.0 and np.sum((chosen >= 8.0) & (chosen <= 9.0)) >= 3


def test_outlines():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5], [0.5, 0.0]])
    assert {tuple(p) for p in hull(square)} == {(0, 0), (1, 0), (1, 1), (0, 1)}
    spring = zigzag(np.array([[0.0, 0.0], [2.0, 0.0]]))
    assert np.array_equal(spring[[0, -1]], [[0, 0], [2, 0]]) and spring[:, 1].max() == pytest.approx(0.2)
