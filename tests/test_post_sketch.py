"""Views of mechanisms: shapes, plane or eye, instants, ground."""

from dataclasses import replace
from types import SimpleNamespace

import every_kind
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from time_runs import deck

from mecano.analyses.dynamic import run
from mecano.elements import KINDS
from mecano.post.draw_sketch import MOST_PARTS, colours_of, draw_sketch, hull, zigzag
from mecano.post.ground import ground_patch, grounds_near
from mecano.post.mode_shapes import MOST_TURN, _title, mode_sketches
from mecano.post.runs import open_runs
from mecano.post.shapes import BODY, JOINT, MASS, ROD, SPRING, SUPPORT, WHEEL, Shape
from mecano.post.sketch import _instants, _shift, plane_axes, sketch
from mecano.post.view_direction import direction, projection


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return every_kind.write(tmp_path_factory.mktemp("sketch") / "each.h5")


@pytest.fixture(scope="module")
def runs(path):
    return open_runs([path])


@pytest.fixture(scope="module")
def flat_run(tmp_path_factory):
    """A mechanism in the plane of x and z."""
    kinds = {name: KINDS[name] for name in ("wheel", "spring_damper", "hinge")}
    return open_runs([every_kind.write(tmp_path_factory.mktemp("flat") / "flat.h5", kinds=kinds)])[0]


def test_planar_mechanisms_are_seen_from_the_side_others_in_space(runs, flat_run):
    assert sketch(flat_run).axes == (0, 2) and sketch(flat_run).in_place
    found = sketch(runs[0])
    assert found.axes == () and found.in_place
    np.testing.assert_allclose(found.projection @ found.projection.T, np.eye(2), atol=1e-12)
    assert found.projection[0, 2] == pytest.approx(0.0, abs=1e-12) and found.projection[1, 2] > 0.8  # z is up


def test_shapes_of_the_mechanism(runs):
    found = sketch(runs[0])
    styles = {shape.name: shape.style for shape in found.shapes if shape.style != SUPPORT}
    assert styles["one_rigid_body"] == BODY and styles["one_spring_damper"] == SPRING
    assert styles["one_wheel"] == WHEEL and styles["one_hinge"] == JOINT
    assert not {"one_force", "one_torsion_spring_damper", "one_held_rotation"} & set(styles)
    assert [shape.name for shape in found.shapes if shape.style == SUPPORT] == ["base"]


def test_a_joint_that_slides_is_no_support(tmp_path):
    axes = {"slides": "free: [along_axis]", "driven": "driven: {along_1: time}", "turns": "free: [about_axis, about_1]"}
    joints = "\n".join(f"  {n}: {{type: generic, nodes: [ground, {n}], axis: [0, 0, 1], {a}}}" for n, a in axes.items())
    names = f"{{repeat: {{n: [{', '.join(axes)}]}}"
    given = deck(
        "mecano: 1\ngravity: none\ntime: {end: 0.1, step: 0.05}\n"
        f"nodes:\n  $n: {names}, position: [0, 0, 0]}}\n"
        f"elements:\n  body_$n: {names}, type: rigid_body, node: $n, mass: 1, inertia: [1, 1, 1]}}\n"
        f"joints:\n{joints}"
    )
    run(given, tmp_path / "r.h5")
    found = sketch(open_runs([tmp_path / "r.h5"])[0])
    assert [shape.name for shape in found.shapes if shape.style == SUPPORT] == ["turns"]


def test_the_rim_turns_with_its_node(runs):
    found = sketch(runs[0])
    wheel = next(shape for shape in found.shapes if shape.style == WHEEL)
    spokes = (wheel.points[:, 0] - wheel.points[:, -1]) / 0.3
    assert np.allclose(np.linalg.norm(spokes, axis=1), 1.0, atol=1e-12)
    angle = found.times  # the node turns by t about y: x -> (cos t, 0, -sin t), z -> (sin t, 0, cos t)
    x, z = spokes[0, 0], spokes[0, 2]
    turned = np.stack([x * np.cos(angle) + z * np.sin(angle), 0 * angle, z * np.cos(angle) - x * np.sin(angle)], -1)
    assert np.allclose(spokes, turned, atol=1e-12)


def test_the_ground_is_its_profile(runs, flat_run):
    (line,) = sketch(flat_run).grounds
    assert np.allclose(line[:, 1], every_kind.WAVE * np.sin(np.pi * line[:, 0]), atol=1e-12)
    assert len(line) > 20
    points = np.array([[0.0, -1.0, 2.0], [3.0, 1.0, 2.0]])
    outline = ground_patch(runs[0].deck, runs[0].deck["grounds"]["runway"], points)
    assert np.allclose(outline[:, 2], every_kind.WAVE * np.sin(np.pi * outline[:, 0]), atol=1e-12)
    assert np.all(outline.min(axis=0)[:2] < (0.0, -1.0)) and np.all(outline.max(axis=0)[:2] > (3.0, 1.0))


def test_a_ground_far_below_is_not_near():
    """A mechanism of 3 m is never nearer than 4.5 m to its ground, or once."""
    deck = {"grounds": {"sea": {"plane": {"point": [0, 0, -4.6], "normal": [0, 0, 1]}}}, "elements": {}}
    deck["elements"]["wheel"] = {"ground": "sea"}
    points = np.array([[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]], [[0.0, 0.0, 1.0], [3.0, 0.0, 1.0]]])
    assert grounds_near(deck, points) == []
    assert grounds_near(deck, points - [0.0, 0.0, 0.2]) == [deck["grounds"]["sea"]]


def test_a_tyre_is_flat_on_flat_ground(path):
    (run,) = open_runs([path])
    run.deck["grounds"]["runway"]["profile"] = None
    wheel = next(shape for shape in sketch(run).shapes if shape.style == WHEEL)
    assert wheel.points[..., 2].min() == 0.0  # the centre is at 0.2 m at times, the radius is 0.3 m


def test_plane_of_the_largest_extents_with_the_vertical_up():
    box = np.array([[0.0, 0.0, 0.0], [3.0, 2.0, 1.0]])
    assert plane_axes(box, [0, 0, -9.81]) == (0, 1)
    assert plane_axes(box * (1, 0.1, 1), [0, 0, -9.81]) == (0, 2)
    assert plane_axes(box, [-9.81, 0, 0]) == (1, 0)
    assert plane_axes(box * (1, 1, 3), None) == (0, 2)


def test_instants_of_a_travelling_mechanism_are_shown_side_by_side():
    points = np.zeros((3, 2, 3))
    points[:, 1, 0] = 2.0  # 2 m wide
    points[:, :, 0] += np.array([[0.0], [50.0], [100.0]])
    shape = Shape(BODY, "body", points)
    side = np.eye(3)[[0, 2]]
    left = points[:, 0, 0] + _shift([shape], side, None)[:, 0]
    assert np.allclose(np.diff(left), 1.25 * 2.0)
    up, view = np.array([0.0, 0.0, 1.0]), projection(direction(-1.0, 0.4))
    points[:, :, 2] += np.array([[0.0], [0.5], [0.0]])
    placed = points[:, 0] @ view.T + _shift([shape], view, up)
    np.testing.assert_allclose(placed[:, 1] - placed[0, 1], [0.0, 0.5 * np.cos(0.4), 0.0], atol=1e-12)  # it rises
    points[:, :, 2] = 0.0
    points[:, :, 0] = [[0.0, 2.0], [5.0, 7.0], [11.0, 13.0]]
    assert not _shift([shape], side, None).any()


def test_a_narrow_mechanism_that_moves_is_shown_side_by_side():
    """In place the coils of a strut that strokes would be drawn over one another."""
    heights, side = np.array([1.0, 0.7, 0.9]), np.eye(3)[[0, 2]]
    points = np.zeros((3, 2, 3))
    points[:, 1, 2] = heights
    strut = Shape(SPRING, "strut", points)
    shift = _shift([strut], side, None)
    assert np.all(np.diff(shift[:, 0]) > 0.25) and not shift[:, 1].any()  # a zigzag is 0.2 of its length wide
    still = Shape(SPRING, "strut", np.repeat(points[:1], 3, axis=0))
    assert not _shift([still], side, None).any()
    ball = Shape(MASS, "ball", points[:, 1:])
    assert not _shift([ball], side, None).any()  # of which the path is shown
    wide = Shape(BODY, "table", points + np.array([[0.0, 0, 0], [0.5, 0, 0]]))
    assert not _shift([wide], side, None).any()


def test_instants_follow_the_motion():
    times = np.linspace(0.0, 10.0, 101)
    cloud = np.zeros((101, 2, 3))
    cloud[:, 1, 0] = 1.0 + np.clip(times - 8.0, 0.0, 1.0)  # moves from 8 to 9 s only
    chosen = times[_instants(times, cloud)]
    assert chosen[0] == 0.0 and chosen[-1] == 10.0 and np.sum((chosen >= 8.0) & (chosen <= 9.0)) >= 3


def test_many_shapes_have_colours_of_their_styles():
    points = np.zeros((1, 2, 3))
    rods = [Shape(ROD, f"rod {i}", points) for i in range(MOST_PARTS - 1)]
    masses = [Shape(MASS, f"mass {i}", points[:, :1]) for i in range(2)]
    few, many = colours_of([*rods, masses[0]]), colours_of([*rods, *masses])
    assert few["rod 0"] != few["rod 1"]
    assert len({many[rod.name] for rod in rods}) == 1
    assert many["mass 0"] == many["mass 1"] != many["rod 0"]


def test_outlines():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5], [0.5, 0.0]])
    assert {tuple(p) for p in hull(square)} == {(0, 0), (1, 0), (1, 1), (0, 1)}
    spring = zigzag(np.array([[0.0, 0.0], [2.0, 0.0]]))
    assert np.array_equal(spring[[0, -1]], [[0, 0], [2, 0]]) and spring[:, 1].max() == pytest.approx(0.2)


@pytest.mark.parametrize(("rise", "labels"), [(0.0, 7), (4.0, 1)])
def test_the_times_below_a_view_do_not_overlap(flat_run, rise, labels):
    """A mechanism that rises high beside its width is drawn narrow, with fewer times."""
    found = sketch(flat_run)
    shift = np.outer(np.arange(7.0), (2.0, rise))
    shapes = tuple(replace(s, points=np.repeat(s.points[:1], 7, axis=0)) for s in found.shapes if s.style == WHEEL)
    figure = Figure(figsize=(9.0, 2.0))
    ax = figure.add_subplot()
    draw_sketch(ax, replace(found, times=np.linspace(0.0, 0.6, 7), shapes=shapes, shift=shift, grounds=(), paths=()))
    FigureCanvasAgg(figure).draw()
    boxes = [text.get_window_extent() for text in ax.texts if text.get_text().endswith(" s")]
    assert all(left.x1 < right.x0 for left, right in zip(boxes, boxes[1:], strict=False))
    assert len(boxes) >= labels


@pytest.mark.parametrize("width", [2.5, 9.0])
def test_the_compass_is_beside_the_mechanism(runs, width):
    """In a narrow view, too, where the first instant begins in the corner."""
    found = sketch(runs[0])
    wheels = tuple(shape for shape in found.shapes if shape.style == WHEEL)
    beside = np.outer(np.arange(len(found.times)), (2.0, 0.0))
    figure = Figure(figsize=(width, 2.0), layout="constrained")
    ax = figure.add_subplot()
    draw_sketch(ax, replace(found, shapes=wheels, shift=beside, grounds=(), paths=()), named=False)
    FigureCanvasAgg(figure).draw()
    letters = [text.get_window_extent() for text in ax.texts if text.get_text() in ("x", "y", "z")]
    left = min(line.get_window_extent().x0 for line in ax.lines)
    assert len(letters) == 3 and all(0.0 < box.x0 and box.x1 < left for box in letters)


def test_a_mode_in_which_a_wheel_spins_shows_it_round_and_from_the_side():
    """A hub that hardly moves: the largest displacement does not give the amplitude, and the rim turns exactly."""
    still, spin = np.array([[0.0, 0.0, 1e-3]], complex), np.array([[0.0, 1.0, 0.0]], complex)
    nodes = {
        "hub": {"position": np.array([0.0, 0.4, 0.3]), "translation": still, "rotation": spin},
        "frame": {"position": np.array([1.0, 0.0, 0.3]), "translation": 0.0 * still, "rotation": 0.0 * spin},
    }
    wheel = {"type": "wheel", "node": "hub", "axis": [0.0, 1.0, 0.0], "radius": 0.3, "ground": "road"}
    road = {"plane": {"point": [0.0, 0.0, -1.0], "normal": [0.0, 0.0, 1.0]}}
    file = SimpleNamespace(
        nodes=nodes, inner={}, released=(), values=np.zeros(1), displays={"wheel": SimpleNamespace(shape="wheel")},
        resolved={"elements": {"wheel": wheel}, "nodes": {name: {} for name in nodes}, "grounds": {"road": road}},
    )  # fmt: skip
    [drawn] = mode_sketches(file)
    [shape] = drawn.shapes
    np.testing.assert_allclose(np.linalg.norm(shape.points[:, :-1] - shape.points[:, -1:], axis=2), 0.3, rtol=1e-12)
    first, last = shape.points[0, 0] - shape.points[0, -1], shape.points[-1, 0] - shape.points[-1, -1]
    assert first @ last / 0.09 == pytest.approx(np.cos(2.0 * MOST_TURN), abs=1e-12)
    assert drawn.axes == (0, 2)


@pytest.mark.parametrize(("direction", "in_space"), [((0.0, 0.0, 1.0), True), ((0.6, 0.8, 0.0), False)])
def test_a_mode_across_the_plane_of_a_frame_is_seen_in_space(direction, in_space):
    """A triangle of bars in the plane x, y, one corner of which moves."""
    places = {"a": (0.0, 0.0, 0.0), "b": (1.0, 0.0, 0.0), "c": (0.4, 0.9, 0.0)}
    nodes = {
        name: {"position": np.array(x), "translation": np.zeros((1, 3), complex), "rotation": np.zeros((1, 3), complex)}
        for name, x in places.items()
    }
    nodes["c"]["translation"] = np.array([direction], complex)
    bars = {"".join(pair): {"type": "bar", "nodes": list(pair)} for pair in ("ab", "bc", "ca")}
    file = SimpleNamespace(
        nodes=nodes, inner={}, released=(), values=np.zeros(1), displays={"bar": SimpleNamespace(shape="line")},
        resolved={"elements": bars, "nodes": {name: {} for name in nodes}},
    )  # fmt: skip
    [drawn] = mode_sketches(file)
    assert drawn.axes == (() if in_space else (0, 1)) and (drawn.view is not None) == in_space
    seen = np.array(direction) @ drawn.projection.T
    assert np.linalg.norm(seen) > 0.8


def test_the_node_that_turns_is_in_a_second_line_of_a_long_title():
    nodes = {name: {"translation": np.zeros((1, 3)), "rotation": np.ones((1, 3))} for name in ("front_right_hub",)}
    numbers = {"frequency": [27.364], "damping_ratio": [0.452]}
    file = SimpleNamespace(nodes=nodes, kinds=["oscillation"], converged=[True], numbers=numbers)
    assert _title(file, 0) == "mode 1: 27.364 Hz, damping 0.452,\nfront_right_hub turns"
    file.nodes = {"hub": nodes["front_right_hub"]}
    assert _title(file, 0) == "mode 1: 27.364 Hz, damping 0.452, hub turns"
