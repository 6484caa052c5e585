"""Planes of contacts in pictures: as large as the motion near them."""

from types import SimpleNamespace

import numpy as np
from calls import calls

from mecano.post.contact_outlines import LARGE, surface_outlines
from mecano.post.runs import Run
from mecano.post.shapes import Motion


def plane(path, others=(), **plane):
    """Return the outline (n, 3) of the plane below a node that moves on a ``path``, beside nodes that rest."""
    path = np.array(path, float)
    places = {"foot": path[0], **{f"n{i}": np.array(place, float) for i, place in enumerate(others)}}
    deck = {"nodes": {name: {"position": list(place)} for name, place in places.items()}}
    motion = SimpleNamespace(
        nodes=list(places), run=Run(SimpleNamespace(resolved=deck)), path=lambda node: path, position=lambda node: path
    )
    [line] = surface_outlines(motion, {"nodes": ["ground", "foot"], "plane": plane}, 0.0)
    return line[0]


def test_a_plane_is_drawn_where_the_node_comes_near_it():
    """A foot is carried from a table at x = 1 to one at x = -1, 1 m higher; the points of the planes are far away."""
    path = [(1.0, 0.0, 0.0), (0.9, 0.0, 0.05), (0.0, 0.0, 2.0), (-1.0, 0.0, 1.1), (-1.1, 0.0, 1.0)]
    room = LARGE * np.hypot(2.1, 2.0)
    for height, low, high in ((0.0, 0.9, 1.0), (1.0, -1.1, -1.0)):
        line = plane(path, normal=[0.0, 0.0, 1.0], point=[50.0, 0.0, height])
        np.testing.assert_allclose(np.sort(line[:, 0]), (low - room, high + room), atol=1e-12)
        np.testing.assert_allclose(line[:, 1:], [(0.0, height)] * 2, atol=1e-12)


def test_a_plane_below_a_mechanism_in_space_is_a_rectangle():
    """Its four edges; a mechanism without width, as above, has a line, which keeps its side view."""
    path = [(0.0, 0.0, 0.1), (1.0, 0.0, 0.1)]
    outline = plane(path, [(0.5, 0.4, 0.1)], normal=[0.0, 0.0, 1.0], point=[0.0, 0.0, 0.0])
    room = LARGE * np.hypot(1.0, 0.4)
    assert len(outline) == 5 and np.array_equal(outline[0], outline[-1])
    np.testing.assert_allclose(outline.min(axis=0), (-room, -room, 0.0), atol=1e-12)
    np.testing.assert_allclose(outline.max(axis=0), (1.0 + room, room, 0.0), atol=1e-12)


def test_contacts_with_one_plane_share_its_outline():
    """Two feet 1 m apart: the first contact has the outline below both, the second none; another plane is another."""
    places = {"left": np.array([[0.0, 0.0, 0.1]]), "right": np.array([[1.0, 0.0, 0.1]])}
    floor, table = (
        {"normal": [0.0, 0.0, 1.0], "point": [0.0, 0.0, 0.0]},
        {"normal": [0.0, 0.0, 1.0], "point": [0.0, 0.0, 0.5]},
    )
    contacts = {
        "first": {"nodes": ["ground", "left"], "plane": floor},
        "second": {
            "nodes": ["ground", "right"],
            "plane": {**floor, "normal": [0.0, 0.0, 2.0], "point": [7.0, 0.0, 0.0]},
        },
        "other": {"nodes": ["ground", "right"], "plane": table},
    }
    deck = {"nodes": {name: {"position": list(path[0])} for name, path in places.items()}, "joints": contacts}
    motion = SimpleNamespace(
        nodes=list(places),
        run=Run(SimpleNamespace(resolved=deck)),
        path=places.__getitem__,
        position=places.__getitem__,
    )
    [first], second, [other] = (surface_outlines(motion, d, 0.0) for d in contacts.values())
    room = LARGE * 1.0
    np.testing.assert_allclose(np.sort(first[0][:, 0]), (-room, 1.0 + room), atol=1e-12)
    assert not second
    np.testing.assert_allclose(np.sort(other[0][:, 0]), (1.0 - room, 1.0 + room), atol=1e-12)


def calls_for_feet(n):
    """How many calls draw the contacts of ``n`` feet on one floor."""
    places = {f"foot{i}": np.array([[float(i), 0.0, 0.1]]) for i in range(n)}
    floor = {"normal": [0.0, 0.0, 1.0], "point": [0.0, 0.0, 0.0]}
    contacts = {node: {"nodes": ["ground", node], "plane": floor} for node in places}
    deck = {"nodes": {name: {"position": list(path[0])} for name, path in places.items()}, "elements": contacts}
    run = Run(SimpleNamespace(resolved=deck))
    motion = SimpleNamespace(nodes=list(places), run=run, path=places.__getitem__, position=places.__getitem__)
    return calls(lambda: [surface_outlines(motion, d, 0.0) for d in contacts.values()])


def test_the_work_for_contacts_with_one_plane_is_proportional_to_their_number():
    few, some, many = map(calls_for_feet, (50, 100, 200))
    assert many - some == 2 * (some - few)


def test_a_path_on_a_table_that_turns_is_that_seen_from_the_table():
    """A ball that the table carries round stays at its place, and one at rest runs round backwards."""
    angle = np.linspace(0.0, 2.0 * np.pi, 9)
    turned = np.stack([np.cos(angle / 2.0), 0.0 * angle, 0.0 * angle, np.sin(angle / 2.0)], axis=1)
    carried = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    centre = np.array([5.0, 0.0, 0.0])
    values = {
        "nodes/table/rotation": turned,
        "nodes/table/position": np.tile(centre, (9, 1)),
        "nodes/ball/position": centre + carried,
        "nodes/still/position": np.tile(centre + [1.0, 0.0, 0.0], (9, 1)),
    }
    motion = object.__new__(Motion)
    motion.run = SimpleNamespace(results=SimpleNamespace(find=lambda path: SimpleNamespace(values=values[path])))
    np.testing.assert_allclose(motion.path_from("table", "ball"), np.tile([1.0, 0.0, 0.0], (9, 1)), atol=1e-15)
    np.testing.assert_allclose(motion.path_from("table", "still"), carried * (1.0, -1.0, 1.0), atol=1e-15)
