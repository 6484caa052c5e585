"""Contact of capsules with one another: distance, impact, friction, parallel rods, conservation."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck, input_deck

from mecano.constraints.touching import touch_at_start
from mecano.constraints.touching_rods import RODS
from mecano.errors import DeckError

g = 9.81


@pytest.mark.parametrize("seed", range(12))
def test_the_gap_is_the_least_distance_of_both_lines(seed):
    """The quadratic |P(s) - Q(t)|^2 is minimized in the rectangle of s and t, which is convex."""
    rng = np.random.default_rng(seed)
    x, axes, lengths = rng.normal(size=(2, 3)), rng.normal(size=(2, 3)), rng.uniform(0.2, 2.0, 2)
    units = axes / np.linalg.norm(axes, axis=1)[:, None]
    least = minimize(
        lambda p: np.sum((x[1] + p[1] * units[1] - x[0] - p[0] * units[0]) ** 2), 0.5 * lengths,
        bounds=[(0.0, lengths[0]), (0.0, lengths[1])], tol=1e-14,
    ).fun  # fmt: skip
    d = {
        "capsule": {"axis": axes[0], "length": lengths[0], "radius": 0.01, "center": None},
        "rod": {"axis": axes[1], "length": lengths[1], "center": None}, "radius": 0.02,
    }  # fmt: skip
    nodes = [(place, np.eye(3)) for place in x]
    assert touch_at_start(RODS, d, nodes).gap == pytest.approx(np.sqrt(least) - 0.03, abs=1e-6)


def test_a_rod_falls_across_another_and_one_slides_on_rails(verify):
    recorded = RecordedRun(input_deck("rods"))
    (impact,) = [event for event in recorded.event_records if event.element == "contact 'impact'"]
    speed, arm, inertia, rebound = np.sqrt(2.0 * g * 0.2), 0.15, 1.0 / 12.0, 0.5
    impulse = (1.0 + rebound) * speed / (1.0 + arm**2 / inertia)
    after = impulse - speed - g * (0.6 - impact.t)
    found = impact.t, impact.impulse, recorded["nodes/falling/velocity"][-1, 2]
    known = speed / g, impulse, after
    what = "rod falls across a rod: instant [s], impulse [N s], speed in the end [m/s]"
    verify("Contact", what, found, known, "impulse on a free rod", relative=1e-6)
    assert recorded["nodes/falling/angular_velocity"][-1, 1] == pytest.approx(impulse * arm / inertia, rel=1e-6)
    stopped, distance = recorded["nodes/sliding/position"][-1, 0], 0.8**2 / (2.0 * 0.2 * g)
    verify("Contact", "rod on two rails: stops after [m]", stopped, distance, "v^2/(2 mu g)", relative=1e-3)
    np.testing.assert_allclose(recorded["nodes/sliding/position"][:, 2], 0.02, atol=1e-9)


FREE = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}, b: {position: [0.1, 0.05, 0.3]}}
    elements:
      a: {type: rigid_body, node: a, mass: 2, inertia: [0.01, 0.2, 0.2]}
      b: {type: rigid_body, node: b, mass: 1, inertia: [0.1, 0.005, 0.1]}
      hit: {type: contact, nodes: [a, b], capsule: {axis: [1, 0, 0], length: 1, radius: 0.05, center: [-0.5, 0, 0]},
            rod: {axis: AXIS, length: 1, center: CENTER}, radius: 0.05, CONTACT}
    initial: {velocities: [{nodes: [b], velocity: [0, 0, -1], angular_velocity: [0.5, 0.2, 0.3]}]}
    time: {end: 0.6, step: 0.001, adaptive: {tolerance: 1.0e-5}}
    """
CROSSING = {"AXIS": "[0.1, 1, 0]", "CENTER": "[0.05, -0.45, 0.3]"}
ELASTIC = "law: {power: {coefficient: 1.0e6, exponent: 1.5}}"


def _free(contact, axis, center):
    text = FREE.replace("CONTACT", contact).replace("AXIS", axis).replace("CENTER", center)
    return RecordedRun(deck(text))


@pytest.mark.parametrize(
    ("contact", "kept"),
    [
        ("restitution: 1", True),
        (ELASTIC, True),
        (f"{ELASTIC}, friction: {{coefficient: 0.3, regularization: 1 cm/s}}", False),
        ("restitution: 0.4, friction: {coefficient: 0.3, regularization: 1 cm/s}", False),
    ],
)
def test_momenta_and_energy_of_two_free_rods(contact, kept):
    m = _free(contact, *CROSSING.values())
    masses, inertias = {"a": 2.0, "b": 1.0}, {"a": [0.01, 0.2, 0.2], "b": [0.1, 0.005, 0.1]}
    momentum, spin = np.zeros((len(m.time), 3)), np.zeros((len(m.time), 3))
    for node, mass in masses.items():
        v = mass * m[f"nodes/{node}/velocity"]
        momentum += v
        w_x_y_z = m[f"nodes/{node}/rotation"]
        Rs = Rotation.from_quat(np.roll(w_x_y_z, -1, axis=1)).as_matrix()
        omega = m[f"nodes/{node}/angular_velocity"]
        own = np.einsum("tij,j,tkj,tk->ti", Rs, np.array(inertias[node]), Rs, omega)
        spin += np.cross(m[f"nodes/{node}/position"], v) + own
    assert m.event_records
    np.testing.assert_allclose(momentum, momentum[[0]].repeat(len(m.time), 0), atol=1e-9)
    np.testing.assert_allclose(spin, spin[[0]].repeat(len(m.time), 0), atol=1e-4)
    kinetic = m["energy/kinetic"]
    assert kinetic[-1] == pytest.approx(kinetic[0], rel=1e-4) if kept else kinetic[-1] < 0.999 * kinetic[0]


def test_parallel_rods_touch_in_the_middle_of_their_common_part():
    """They overlap from 0.2 to 0.5 m: the force, without turning, acts at 0.35 m."""
    text = FREE.replace("CONTACT", ELASTIC).replace("AXIS", "[1, 0, 0]").replace("CENTER", "[0.2, 0, 0.09]")
    text = text.replace("[0.5, 0.2, 0.3]", "[0, 0, 0]").replace("velocity: [0, 0, -1]", "velocity: [0, 0, 0]")
    m = RecordedRun(deck(text.replace("end: 0.6", "end: 1.0e-4").replace("step: 0.001", "step: 1.0e-5")))
    assert m["elements/hit/point"][0, 0] == pytest.approx(0.35, abs=1e-12)
    assert m["elements/hit/normal_force"][0] == pytest.approx(1e6 * 0.01**1.5, rel=1e-9)


@pytest.mark.parametrize(
    ("surface", "message"),
    [
        ("plane: {normal: [0, 0, 1], point: [0, 0, -1]}", "a 'rod' touches a 'capsule'"),
        ("cylinder: {axis: [1, 0, 0], radius: 0.5, inside: true}", "a ball of this 'radius' at each of its ends"),
        ("cylinder: {axis: [0, 1, 0], radius: 0.05, center: [0.3, 0, 0.31]}", "0.01 m apart: move them apart"),
        ("cylinder: {axis: [0, 1, 0], radius: 0.05, center: [0.3, 0, 0.21]}", "the rod starts 0.01 m within"),
    ],
)
def test_wrong_rods(surface, message):
    text = FREE.replace("capsule: {axis: [1, 0, 0], length: 1, radius: 0.05, center: [-0.5, 0, 0]}", surface)
    text = text.replace("CONTACT", "restitution: 0.1").replace("AXIS", "[1, 0, 0]").replace("CENTER", "[0, 0.05, 0.3]")
    with pytest.raises(DeckError) as error:
        deck(text)
    assert message in error.value.problems[0].message


ON_AN_AXIS = """
    mecano: 1
    gravity: none
    nodes: {a: {position: [0, 0, 0]}}
    elements:
      body: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1]}
      hit: {type: contact, nodes: NODES, cylinder: {axis: [0, 0, 1], radius: 0.5, center: [0, 0, 0]}, radius: 0.1,
            rod: {axis: [0, 0, 1], length: 1CENTER}}
    time: {end: 0.1, step: 0.1}
    """


@pytest.mark.parametrize("nodes", ["[ground, a]", "[a, ground]"])
def test_the_node_of_a_rod_may_lie_within_the_cylinder(nodes):
    m = RecordedRun(deck(ON_AN_AXIS.replace("NODES", nodes).replace("CENTER", ", center: [1, 0, 0]")))
    np.testing.assert_allclose(m["elements/hit/gap"], 1.0 - 0.5 - 0.1, atol=1e-15)


def test_a_rod_in_the_ground_needs_a_place():
    with pytest.raises(DeckError, match="'rod' needs 'center': the ground has no position"):
        deck(ON_AN_AXIS.replace("NODES", "[a, ground]").replace("CENTER", ""))
