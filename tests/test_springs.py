"""Spring-dampers and loads: values by hand, whole turns, action and reaction, stops and their modes."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mecano.analyses.kind_samples import Instance
from mecano.element_interface import Context, Place
from mecano.elements import KINDS
from mecano.laws.law_table import LawTable

LINEAR = (("spring", {"stiffness": 10.0}), ("damper", {"coefficient": 2.0}))
STOP = (("stop", {"stiffness": 100.0, "lower": -0.3, "upper": 0.2, "damping": 0.0}),)
AXIS = np.array([1.0, -2.0, 0.5])


@dataclass
class One:
    """One element with the memory of its start, evaluated in Python."""

    kind: object
    values: dict
    nodes: list

    def __post_init__(self):
        table = LawTable()
        defaults = {field.name: field.default for field in self.kind.fields}
        self.p = np.zeros(1, self.kind.dtype)
        for key, value in self.kind.prepare(
            {**defaults, **self.values}, self.nodes, Context(table, np.zeros(3))
        ).items():
            self.p[key][0] = value
        self.record = self.p.view(np.recarray)[0]
        self.laws, self.memory = table.array(), np.zeros(len(self.kind.memory))

    def force(self, q, v, R, t=0.0):
        one = Instance(self.kind, self.p, (), 0, self.memory, self.laws, np.zeros((3, 0)), np.zeros(0))
        f, K, C, _ = one.force(t, (q, v, np.zeros(len(q)), R))
        return f, K, C

    def observe(self, q, v, R, t=0.0):
        n, y, e = self.kind.n_local, np.zeros(9), np.zeros(4)
        a, F = np.zeros(n), np.zeros(n)
        self.kind.observe(self.record, Place(t, 0, 1.0, 0.0, self.laws, self.memory, q, v, a, R), F, y, e)
        return y, e

    def events(self, q, R):
        g, zero = np.zeros(4), np.zeros(self.kind.n_local)
        self.kind.event_values(self.record, Place(0.0, 0, 1.0, 0.0, self.laws, self.memory, q, zero, zero, R), g)
        return g

    def commit(self, R):
        zero = np.zeros(self.kind.n_local)
        at = Place(0.0, 0, 1.0, 0.0, self.laws, self.memory.copy(), zero, zero, zero, R)
        self.kind.commit(self.record, at, self.memory)


def at(*positions):
    return [(np.array(x, float), np.eye(3)) for x in positions]


def rotations(n, seed):
    return Rotation.random(n, np.random.default_rng(seed)).as_matrix()


def about(axis, angle):
    return Rotation.from_rotvec(angle * np.asarray(axis) / np.linalg.norm(axis)).as_matrix()


NONE = np.zeros((0, 3, 3))


def test_spring_damper_by_hand():
    spring = One(KINDS["spring_damper"], {"law": LINEAR, "natural_length": 4.0}, at([0, 0, 0], [3, 4, 0]))
    q, v = np.array([0, 0, 0, 3.0, 4, 0]), np.array([0, 0, 0, 1.0, 0, 0])
    f, K, C = spring.force(q, v, NONE)
    u = np.array([0.6, 0.8, 0.0])
    np.testing.assert_allclose(f, 11.2 * np.concatenate([-u, u]), rtol=1e-14)  # 10 * 1 m + 2 * 0.6 m/s
    np.testing.assert_allclose(C[3:, 3:], 2.0 * np.outer(u, u), rtol=1e-14, atol=1e-15)
    assert K[5, 5] == pytest.approx(11.2 / 5.0, rel=1e-14)  # N/length across the line
    y, e = spring.observe(q, v, NONE)
    np.testing.assert_allclose(y[:5], [5.0, 1.0, 0.6, 11.2, -1.0], rtol=1e-14)
    np.testing.assert_allclose(e, [0.0, 5.0, 2.0 * 0.36, 0.0], rtol=1e-13)


def test_natural_length_is_the_initial_distance_by_default():
    nodes = at([1, 1, 1], [1, 1, 3])
    kind = KINDS["spring_damper"]
    q = np.array([1.0, 1, 1, 1, 1, 3.5])
    assert One(kind, {"law": LINEAR}, nodes).observe(q, 0 * q, NONE)[0][1] == pytest.approx(0.5, rel=1e-15)
    given = One(kind, {"law": LINEAR, "natural_length": 0.0}, nodes)
    assert given.observe(q, 0 * q, NONE)[0][1] == pytest.approx(2.5, rel=1e-15)


@pytest.mark.parametrize("natural", [-0.1, (("linear", {"slope": 1.0, "offset": -0.1}),)])
def test_a_negative_natural_length_is_refused(natural):
    texts = KINDS["spring_damper"].check(
        {"law": LINEAR, "natural_length": natural, "activate": None, "release": None}, at([0, 0, 0], [1, 0, 0])
    )
    assert texts == ["'natural_length' must not be negative at t = 0"]


def test_a_spring_of_no_length_is_refused_and_survives_a_trial():
    kind, d = KINDS["spring_damper"], {"law": LINEAR, "natural_length": None, "activate": None, "release": None}
    assert "must not be at the same place" in kind.check(d, at([1, 2, 3], [1, 2, 3]))[0]
    assert kind.check(d, at([1, 2, 3], [1, 2, 4])) == []
    spring = One(kind, {"law": LINEAR, "natural_length": 1.0}, at([0, 0, 0], [1, 0, 0]))
    for array in spring.force(np.ones(6), np.ones(6), NONE):
        assert np.all(np.isfinite(array))


@pytest.mark.parametrize(
    ("extension", "phase", "left"),
    [(-0.5, "below", None), (0.0, "between", None), (0.4, "above", None), (-0.29, "below", "between")],
)
def test_events_of_the_stops(extension, phase, left):
    """Only the event that leaves a wrong mode has a positive value: repeated changes end in the right one."""
    kind = KINDS["spring_damper"]
    spring = One(kind, {"law": STOP, "natural_length": 2.0}, at([0, 0, 0], [2, 0, 0]))
    g = spring.events(np.array([0, 0, 0, 2.0 + extension, 0, 0]), NONE)
    after = [event.after for event, value in zip(kind.events, g, strict=True) if event.before == phase and value > 0]
    assert after == ([left] if left else [])
    seen = {event.name: value for event, value in zip(kind.events, g, strict=True)}
    assert seen["lower stop closes"] == pytest.approx(-0.3 - extension, abs=1e-15)
    assert seen["upper stop closes"] == pytest.approx(extension - 0.2, abs=1e-15)


def test_events_without_stops_never_happen_and_are_finite():
    spring = One(KINDS["spring_damper"], {"law": LINEAR}, at([0, 0, 0], [2, 0, 0]))
    g = spring.events(np.array([0, 0, 0, 1e6, 0, 0]), NONE)
    assert np.all(np.isfinite(g)) and g[0] < 0 and g[2] < 0


def test_torsion_angle_over_many_turns_changes_in_commit_only():
    nodes = [(np.zeros(3), R) for R in rotations(2, 1)]
    spring = One(KINDS["torsion_spring_damper"], {"law": LINEAR, "axis": AXIS, "natural_angle": 0.5}, nodes)
    zero = np.zeros(6)
    for i in range(1, 41):
        R = np.array([nodes[0][1], about(AXIS, 0.9 * i) @ nodes[1][1]])
        before = spring.memory.copy()
        f, _, _ = spring.force(zero, zero, R)
        y, e = spring.observe(zero, zero, R)
        assert np.array_equal(spring.memory, before)
        assert y[0] == pytest.approx(0.9 * i, rel=1e-12)
        assert y[2] == pytest.approx(10 * (0.9 * i - 0.5), rel=1e-12)
        assert e[1] == pytest.approx(5 * (0.9 * i - 0.5) ** 2, rel=1e-11)
        np.testing.assert_allclose(R[1] @ f[3:], y[2] * AXIS / np.linalg.norm(AXIS), atol=1e-9)
        spring.commit(R)
    assert spring.memory[0] == pytest.approx(36.0, rel=1e-12)


def test_torsion_angle_turns_back_below_zero():
    nodes = [(np.zeros(3), np.eye(3))] * 2
    spring = One(KINDS["torsion_spring_damper"], {"law": LINEAR, "axis": [0, 0, 1]}, nodes)
    for angle in (2.0, 4.0, 3.0, 1.0, -2.0, -4.0):
        spring.commit(np.array([np.eye(3), about([0, 0, 1], angle)]))
        assert spring.memory[0] == pytest.approx(angle, rel=1e-14)


def test_torsion_angle_of_swapped_nodes_is_opposite_off_alignment():
    nodes = [(np.zeros(3), np.eye(3))] * 2
    kind, zero = KINDS["torsion_spring_damper"], np.zeros(6)
    spring = One(kind, {"law": LINEAR, "axis": AXIS}, nodes)
    R = rotations(2, 5)
    there, back = spring.observe(zero, zero, R)[0][0], spring.observe(zero, zero, R[::-1].copy())[0][0]
    assert abs(there) > 0.1
    assert back == pytest.approx(-there, rel=1e-13)


def test_torsion_events_count_from_the_natural_angle():
    kind = KINDS["torsion_spring_damper"]
    spring = One(kind, {"law": STOP, "axis": [1, 0, 0], "natural_angle": 0.25}, [(np.zeros(3), np.eye(3))] * 2)
    g = spring.events(np.zeros(6), np.array([np.eye(3), about([1, 0, 0], 0.4)]))
    np.testing.assert_allclose(g, [-0.45, 0.45, -0.05, 0.05], rtol=1e-12)


def test_couple_turns_the_second_node_about_the_axis_of_the_first():
    A, B = rotations(2, 4)
    couple = One(KINDS["couple"], {"axis": AXIS, "value": 4.0}, [(np.zeros(3), A), (np.zeros(3), B)])
    turn, omega = rotations(1, 6)[0], np.array([0.3, -1.0, 2.0, 1.5, 0.2, -0.7])
    R = np.array([turn @ A, B])
    axis = turn @ AXIS / np.linalg.norm(AXIS)
    f = couple.force(np.zeros(6), omega, R)[0]
    np.testing.assert_allclose(R[1] @ -f[3:], 4.0 * axis, rtol=1e-13)  # f is minus the load
    y, e = couple.observe(np.zeros(6), omega, R)
    rate = axis @ (R[1] @ omega[3:] - R[0] @ omega[:3])
    np.testing.assert_allclose(y[:3], [4.0, rate, 4.0 * rate], rtol=1e-13)
    assert e[3] == pytest.approx(4.0 * rate, rel=1e-13)


@pytest.mark.parametrize("name", ["force", "follower_force", "moment", "follower_moment"])
def test_direction_of_loads(name):
    """Dead loads keep the direction of the deck, followers turn with the node; 2 + 3 t at t = 1 is 5."""
    kind = KINDS[name]
    value = (("linear", {"slope": 3.0, "offset": 2.0}),)
    start, turn = rotations(2, 8)
    load = One(kind, {"direction": AXIS, "value": value}, [(np.zeros(3), start)])
    R = np.array([turn @ start])
    direction = AXIS / np.linalg.norm(AXIS)
    expected = 5.0 * (turn @ direction if "follower" in name else direction)
    v = np.arange(1.0, 1.0 + kind.n_local)
    f = load.force(np.zeros(kind.n_local), v, R if "R0" in kind.layout else NONE, t=1.0)[0]
    on_node = -(R[0] @ f if "moment" in name else f[:3])
    np.testing.assert_allclose(on_node, expected, rtol=1e-13)
    y, e = load.observe(np.zeros(kind.n_local), v, R if "R0" in kind.layout else NONE, t=1.0)
    np.testing.assert_allclose(y[:3], expected, rtol=1e-13)
    assert e[3] == pytest.approx(-f @ v, rel=1e-13) and y[3] == e[3]
