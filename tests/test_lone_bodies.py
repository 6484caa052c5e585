"""Bodies that fly freely are drawn as cuboids of their mass and inertia."""

import textwrap

import numpy as np
import pytest

import mecano
from mecano.post.runs import opened_runs
from mecano.post.shapes import Motion, shapes

DECK = """
mecano: 1
gravity: none
nodes: {a: {position: [0, 0, 0], orientation: [0, 0, 0.3]}, b: {position: [DISTANCE, 0, 0]}, c: {position: [0, 2, 0]}}
elements:
  free: {type: rigid_body, node: a, mass: 12, inertia: [5, 10, 13]} # sides of 3, 2 and 1 m
  disc: {type: rigid_body, node: b, mass: 12, inertia: [1, 2, 3]}
  swung: {type: rigid_body, node: c, mass: 12, inertia: [5, 10, 13]}
joints: {pin: {type: hinge, nodes: [ground, c], axis: [0, 0, 1]}}
initial: {velocities: [{nodes: [a], velocity: [1, 0, 0], angular_velocity: [0, 0, 2]}]}
time: {end: 0.5, step: 0.01}
"""


@pytest.fixture
def bodies(tmp_path):
    def drawn(distance):
        (tmp_path / "deck.yaml").write_text(DECK.replace("DISTANCE", str(distance)))
        mecano.run(tmp_path / "deck.yaml", tmp_path / "deck.h5", quiet=True, force=True).close()
        with opened_runs([tmp_path / "deck.h5"]) as [run]:
            return {one.name: one.points for one in shapes(Motion(run, slice(None))) if one.style in ("body", "mass")}

    return drawn


def sides(corners):
    """Lengths of the sides of a cuboid with corners (8, 3) in the order of signs."""
    return np.sort(np.linalg.norm(corners[[4, 2, 1]] - corners[0], axis=1))


def test_sides_follow_from_the_inertia_and_turn_with_the_node(bodies):
    found = bodies(60.0)
    free = found["free"]
    assert free.shape[1] == 9 and found["swung"].shape[1] == 1, "a body on a joint is a dot"
    for corners in free[:, 1:]:
        np.testing.assert_allclose(sides(corners), [1.0, 2.0, 3.0], rtol=1e-12)
    np.testing.assert_allclose(free[:, 1:].mean(axis=1), free[:, 0], atol=1e-12)
    along = free[-1, 5] - free[-1, 1]  # the longest side, which begins along x of the node
    angle = np.arctan2(along[1], along[0])
    assert np.angle(np.exp(2j * (angle - 0.3 - 2.0 * 0.5))) == pytest.approx(0.0, abs=1e-9), "free of other axes"


def test_a_plane_body_is_a_plate_and_none_is_larger_than_a_quarter_of_the_mechanism(bodies):
    found = bodies(1.0)
    thin, _, long = sides(found["disc"][0, 1:])
    assert thin == pytest.approx(0.05 * long)
    assert sides(bodies(0.1)["free"][0, 1:])[-1] == pytest.approx(0.5 * np.hypot(2.0, 0.1))


@pytest.mark.parametrize("held", [False, True])
def test_the_main_body_of_a_satellite_is_a_cuboid_about_its_centre_of_mass(tmp_path, held):
    """A boom is hinged to a bus of 12 kg and 3 x 2 x 1 m; one that stands on the ground is drawn by its points."""
    text = """
        mecano: 1
        gravity: none
        nodes: {bus: {position: [0, 0, 0]}, root: {position: [1.5, 0, 0]}, boom: {position: [1.5, 0, 0]}}
        elements:
          bus: {type: rigid_body, node: bus, mass: 12, inertia: [5, 10, 13], center_of_mass: [0.2, 0, 0],
                attached: [root]}
          boom: {type: rigid_body, node: boom, mass: 1, center_of_mass: [6, 0, 0], inertia: [1, 1, 1]}
        joints:
          hinge: {type: hinge, nodes: [root, boom], axis: [0, 0, 1]}
        HELD
        time: {end: 0.1, step: 0.01}
        """.replace("HELD", "  stand: {type: spherical, nodes: [ground, bus]}" if held else "")
    (tmp_path / "satellite.yaml").write_text(textwrap.dedent(text))
    mecano.run(tmp_path / "satellite.yaml", tmp_path / "satellite.h5", quiet=True).close()
    with opened_runs([tmp_path / "satellite.h5"]) as [run]:
        [bus] = [one.points for one in shapes(Motion(run, slice(None))) if one.name == "bus"]
    assert bus.shape[1] == (2 if held else 10)
    if not held:
        np.testing.assert_allclose(bus[0, 2:].mean(axis=0), [0.2, 0.0, 0.0], atol=1e-12)
        ratio = sides(bus[0, 2:])
        np.testing.assert_allclose(ratio / ratio[0], [1.0, 2.0, 3.0], rtol=1e-12)
