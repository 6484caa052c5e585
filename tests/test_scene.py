"""What pages and pictures in space show: forces, rigid motions of flexible parts, the direction of the eye."""

import every_kind
import numpy as np
import pytest
from process import mecano_process, settings
from time_runs import INPUTS

from mecano.elements import KINDS
from mecano.post import scene
from mecano.post.animation import FILES, page_text
from mecano.post.deformation import flexible_parts, quaternions, rigid_fit
from mecano.post.forces import arrows
from mecano.post.runs import open_runs
from mecano.post.scene import scene_of
from mecano.post.shapes import ROD, WHEEL, Motion, Shape, shapes, vertical
from mecano.post.view_direction import direction, eye, projection


def run(folder, name, *overrides):
    path = folder / f"{name}.h5"
    assert mecano_process("run", INPUTS / f"{name}.yaml", "-q", "-o", path, *settings(*overrides))[0] == 0
    [found] = open_runs([path])
    return found


def rotations(rng, n):
    """Random rotation matrices (n, 3, 3), of QR decompositions."""
    q, r = np.linalg.qr(rng.normal(size=(n, 3, 3)))
    q = q * np.sign(np.einsum("nii->ni", r))[:, None]
    return q * np.linalg.det(q)[:, None, None]


def test_the_force_of_a_hinge_moves_what_hangs_on_it(tmp_path):
    """Newton's law of the lower bar of a double pendulum: F + m g = m a, its axes carried by the upper one.

    a by central differences of the saved velocities: off by h^2/6 of their third rate, 1e-3 of the largest here.
    """
    double = run(tmp_path, "double_pendulum", "time.end=1.0", "output.every=0.002")
    found = {arrow.name: arrow for arrow in arrows(Motion(double, slice(None)))}
    results = double.results
    velocity = results["lower.velocity"].values
    acceleration = (velocity[2:] - velocity[:-2]) / 0.004
    expected = acceleration - (0.0, 0.0, -9.81)
    error = np.abs(found["elbow_hinge"].values[1:-1] - expected).max()
    assert error < 3e-3 * np.abs(expected).max()
    np.testing.assert_array_equal(found["elbow_hinge"].places, results["lower_end.position"].values)


def test_a_model_of_many_nodes_is_shown_at_fewer_times(tmp_path, monkeypatch):
    """Ten of 21 saved times, if these are as many points as a page can hold, but no fewer than four."""
    drop = run(tmp_path, "wheel_drop", "time.end=0.02", "output.every=1e-3")
    nodes = len(Motion(drop, slice(None)).nodes)
    assert len(scene_of(drop, 600).times) == 21
    monkeypatch.setattr(scene, "FEWEST", 4)
    for limit, shown in ((10 * nodes, 10), (nodes, 4)):
        monkeypatch.setattr(scene, "MOST_POINTS", limit)
        times = scene_of(drop, 600).times
        assert len(times) == shown and times[0] == 0.0 and times[-1] == drop.results.time[-1]


def test_the_force_on_a_wheel_acts_where_it_touches_the_ground(tmp_path):
    drop = run(tmp_path, "wheel_drop", "time.end=0.2")
    (arrow,) = arrows(Motion(drop, slice(None)))
    np.testing.assert_array_equal(arrow.values, drop.results["tire.contact_force"].values)
    np.testing.assert_array_equal(arrow.places, drop.results["tire.contact_point"].values)


def test_a_rigid_motion_is_found_as_it_is():
    """Points in space, in a plane and on a line; the turns of the last only as far as they move the line."""
    rng = np.random.default_rng(1)
    for shape in (np.ones(3), (1, 1, 0), (1, 0, 0)):
        reference = rng.normal(size=(6, 3)) * shape
        turns, shifts = rotations(rng, 8), rng.normal(size=(8, 3))
        points = np.einsum("nij,kj->nki", turns, reference) + shifts[:, None]
        start, places, found = rigid_fit(reference, points, rng.uniform(1.0, 2.0, 6))
        again = np.einsum("nij,kj->nki", found, reference - start) + places[:, None]
        np.testing.assert_allclose(again, points, rtol=0, atol=1e-12)
        np.testing.assert_allclose(np.linalg.det(found), 1.0, rtol=1e-12)


def test_held_parts_do_not_move():
    """The rigid motion of a bent rod that is held at its first node passes through that node."""
    x = np.linspace(0.0, 1.0, 9)
    bent = np.stack([[x, 0 * x, 0 * x], [x, 0.1 * x**2, 0 * x]]).swapaxes(1, 2)
    rod = Shape(ROD, "rod", bent, tuple(f"n{i}" for i in range(9)))
    (part,) = flexible_parts([rod], {"rod"}, {"n0"})
    held = part.turns[1] @ (bent[0, 0] - part.start) + part.places[1]
    assert np.abs(held).max() < 1e-3 * 0.1


def test_parts_are_what_shares_nodes():
    def rod(name, *nodes):
        return Shape(ROD, name, np.random.default_rng(2).normal(size=(1, len(nodes), 3)), nodes)

    shapes = [rod("a", "1", "2"), rod("b", "3", "4"), rod("c", "2", "3"), rod("d", "5", "6"), rod("e", "1", "9")]
    parts = flexible_parts(shapes, {"a", "b", "c", "d"}, set())
    assert sorted(part.shapes for part in parts) == [(0, 1, 2), (3,)]


def test_quaternions_turn_as_the_matrices():
    turns = np.concatenate([rotations(np.random.default_rng(3), 50), [np.diag(d) for d in (
        (1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))]])  # fmt: skip
    w, x, y, z = quaternions(turns).T
    again = np.array([
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ])  # fmt: skip
    np.testing.assert_allclose(again.transpose(2, 0, 1), turns, rtol=0, atol=1e-12)


def test_of_two_wheels_on_one_axle_both_are_seen():
    """The centres are farther apart in the picture than a wheel is wide there; from the side they would be one."""
    wheels = [(np.array([0.0, y, 0.0]), np.array([0.0, 1.0, 0.0]), 0.3) for y in (-0.25, 0.25)]
    angle = np.linspace(0.0, 2.0 * np.pi, 30)
    rim = 0.3 * np.stack([np.cos(angle), 0.0 * angle, np.sin(angle)], axis=1)
    cloud = np.concatenate([rim + centre for centre, *_ in wheels] + [[[0.0, 0.0, 1.5]]])[None]
    seen = eye(cloud, wheels)
    right, above = np.abs(projection(seen) @ (wheels[1][0] - wheels[0][0]))
    width = 2 * 0.3 * abs(wheels[0][1] @ seen)
    assert right > 0.5 * width and seen[2] > 0.0
    assert abs(projection(direction(-0.5 * np.pi, 0.0)) @ (wheels[1][0] - wheels[0][0])).max() < 1e-12


def test_a_projection_is_right_handed_and_up_is_up():
    for up in np.concatenate([np.eye(3), -np.eye(3)]):
        for azimuth in (-2.0, 0.3, 1.4):
            seen = direction(azimuth, 0.4, up)
            right, above = projection(seen, up)
            np.testing.assert_allclose(np.cross(right, above), seen, atol=1e-12)
            assert above @ up == pytest.approx(np.cos(0.4)) and right @ up == pytest.approx(0.0, abs=1e-12)


def test_up_is_against_gravity():
    assert vertical([0.0, -9.81, 0.1]).tolist() == [0, 1, 0] and vertical([0, 0, 1.6]).tolist() == [0, 0, -1]
    assert vertical(None).tolist() == [0, 0, 1]


def test_a_beam_is_a_smooth_line_through_its_nodes(tmp_path):
    """Its line leaves a node along the direction that the node carries; the difference is exact for cubics."""
    rod = run(tmp_path, "flexible_pendulum", "time.end=0.3", "elements.rod.mesh=2")
    scene = scene_of(rod, 50)
    (shape,) = (s for s in scene.shapes if s.style == ROD)
    start = shape.points[0]
    straight = start[:1] + np.linspace(0.0, 1.0, len(start))[:, None] * (start[-1:] - start[:1])
    np.testing.assert_allclose(start, straight, atol=1e-12)
    motion = Motion(rod, scene.rows)
    carried = motion.turned(shape.nodes[0], start[-1] - start[0])
    p = np.moveaxis(shape.points[:, :4], 1, 0)
    leaving = -11 * p[0] + 18 * p[1] - 9 * p[2] + 2 * p[3]
    across = np.linalg.norm(np.cross(carried, leaving), axis=1)
    assert np.all(across < 1e-9 * np.linalg.norm(carried, axis=1) * np.linalg.norm(leaving, axis=1))


def test_a_page_has_everything_in_it():
    text = page_text({"title": "</script><b>"})
    assert "{{" not in text.split("<style>")[0] and "</script><b>" not in text
    assert "MIT" in text and "three.js authors" in text and "Leon Sorokin" in text
    assert not [address for address in ('src="http', 'href="http', "import(") if address in text]
    assert {"three/three.min.js", "uplot/uPlot.iife.min.js"} == set(FILES["libraries"])


def test_pitch_circles_touch_and_roll_on_one_another(tmp_path):
    """Both circles of each pair pass through one point of the carrier, and travel alike there (inputs/gears.yaml)."""
    motion = Motion(run(tmp_path, "gears", "time.end=0.5"), slice(None))
    for name, pitch, radii in (("spur", (0.1, 0.0, 0.0), (0.1, 0.2)), ("bevel", (0.4, 0.0, 0.3), (0.1, 0.05))):
        travels = []
        for shape, radius in zip([shape for shape in shapes(motion) if shape.name == name], radii, strict=True):
            spokes = shape.points[:, :-1] - shape.points[:, -1:]
            np.testing.assert_allclose(np.linalg.norm(spokes, axis=2), radius, rtol=1e-12)
            arm = np.array(pitch) - shape.points[0, -1]
            normal = np.cross(spokes[0, 0], spokes[0, 1])
            assert np.linalg.norm(arm) == pytest.approx(radius) and abs(arm @ normal) < 1e-12
            across = np.linalg.norm(np.cross(spokes[0, 0], spokes[:20, 0]), axis=1)
            travels.append(radius * np.arctan2(across, spokes[:20, 0] @ spokes[0, 0]))
        np.testing.assert_allclose(*travels, atol=1e-12)


def test_every_kind_is_in_the_scene(tmp_path):
    """A wheel on a body names its hub as the second of two nodes."""
    [run] = open_runs([every_kind.write(tmp_path / "all.h5", kinds=KINDS)])
    scene = scene_of(run, 3)
    wheels = {shape.name for shape in scene.shapes if shape.style == WHEEL}
    assert {f"one_{name}" for name, kind in KINDS.items() if kind.display.shape in ("wheel", "wheel_on_body")} <= wheels
    assert all(orientation.radius > 0.0 for shape, orientation in zip(scene.shapes, scene.orientations, strict=True)
               if shape.style == WHEEL)  # fmt: skip
