"""One beam element: strains under rigid motions, tangents far from the start, inertia, sections, members of decks."""

import json
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck

from mecano.analyses.differences import difference, simple_difference
from mecano.analyses.equilibria import follow
from mecano.analyses.kind_samples import Motion, expand, samples, seed_of
from mecano.analyses.prepare import prepare, warnings_of
from mecano.analyses.static import run
from mecano.analyses.tangent_tests import close, slope
from mecano.deck.build import build
from mecano.elements.members.beam import BEAM
from mecano.elements.members.beam_flexibility import element_stiffness
from mecano.elements.members.beam_line import stations
from mecano.elements.members.cross_section import SHAPES, constants
from mecano.errors import DeckError
from mecano.maths.rotation_vector import inverse_coefficients
from mecano.model.system import System
from mecano.post.members import member_sheets
from mecano.post.runs import open_runs
from mecano.post.shapes import Motion as Shown
from mecano.post.shapes import shapes

STEEL = {"E": 2.1e11, "nu": 0.3, "G": None, "density": 7800.0, "damping": 0.0}
CURVED = "sections: {rod: {type: rectangle, width: 0.02, height: 0.05, E: 2.1e11, nu: 0.3, density: 7800}}"


def at_rest(sample):
    """The element of a sample, and the motion of its nodes at their start."""
    n = len(sample.nodes)
    x, turn = np.zeros((2, n, 3, 3))
    x[:, 0] = [node[0] for node in sample.nodes]
    return sample.instances[0], Motion(0.3, x, np.array([node[1] for node in sample.nodes]), turn)


def test_a_thousand_turns_leave_no_strain():
    """Turned step by step about changing axes, 1000 turns in all; and carried away."""
    rng = np.random.default_rng(1)
    for sample in samples(BEAM)[:3]:  # the last one is heated
        instance, start = at_rest(sample)
        R, Q = start.R, np.eye(3)
        for axis in rng.normal(size=(50, 3)):
            step = Rotation.from_rotvec(axis / np.linalg.norm(axis) * 2.0 * np.pi * 20.0 / 55.0).as_matrix()
            for _ in range(55):
                R, Q = step @ R, step @ Q
        motion = Motion(0.3, start.x.copy(), R, start.turn)
        motion.x[:, 0] = start.x[:, 0] @ Q.T + [3.0, -2.0, 1.0]
        y, e = instance.observe(0.3, instance.local(motion), np.zeros(12))
        assert np.abs(y[12:18]).max() < 1e-10 and y[21] < 1e-18


def test_strains_do_not_depend_on_the_path():
    """The same place reached by two sequences of rotations has the same forces."""
    instance, start = at_rest(samples(BEAM)[2])
    turns = Rotation.from_rotvec([[0.3, 0.2, -0.5], [-0.7, 0.4, 0.6]])
    there = [start.R[1] @ (turns[0] * turns[1]).as_matrix()]
    half = Rotation.from_rotvec(0.5 * (turns[0] * turns[1]).as_rotvec()).as_matrix()
    there.append(start.R[1] @ half @ half)
    forces = []
    for R in there:
        motion = Motion(0.3, start.x, np.array([start.R[0], R]), start.turn)
        forces.append(instance.force(0.3, instance.local(motion))[0])
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-12, atol=1e-12 * np.abs(forces[0]).max())


@pytest.mark.parametrize("angle", [1.1, 2.9])
def test_tangents_at_large_relative_rotations(angle):
    """Second node turned by ``angle`` and displaced by half a length against the first."""
    rng = seed_of("large")
    for sample in samples(BEAM):
        instance, motion = sample.instances[0], sample.motion
        axis = rng.normal(size=3)
        motion.R[1] = motion.R[1] @ Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
        motion.x[1, 0] += 0.4 * rng.normal(size=3)
        state = instance.local(motion)
        for array, tangent in enumerate(instance.force(motion.t, state)[1:]):
            by = simple_difference if array else difference  # forces are quadratic in the velocities
            columns = [slope(instance, motion.t, state, array, column, by) for column in range(len(state[0]))]
            expected = np.stack(columns, axis=1)
            close(tangent, expected, 3e-7, angle=angle, tangent="KCM"[array])


def test_series_and_closed_form_meet():
    below, above = (np.array(inverse_coefficients(1.0 + d)) for d in (-1e-12, 1e-12))
    np.testing.assert_allclose(below, above, rtol=1e-11)
    np.testing.assert_allclose(inverse_coefficients(1e-30)[:1], 1 / 12)
    np.testing.assert_allclose(inverse_coefficients(np.pi**2)[0], 1 / np.pi**2, rtol=1e-14)


def test_stiffness_of_a_slender_element_is_that_of_the_cubic_beam():
    C = np.diag([3e9, 1e9, 2e9, 7.0, 5.0, 4.0])
    L = 0.8
    K = element_stiffness(C, np.array([L, 0, 0, 0, 0, 0]))
    np.testing.assert_allclose(np.diag(K), [3e9 / L, 48 / L**3, 60 / L**3, 7 / L, 5 / L, 4 / L], rtol=1e-6)


@pytest.mark.parametrize(("diameter", "warned"), [("20 mm", False), ("1.5", False), ("20", True)])
def test_a_section_in_millimetres_is_reported(diameter, warned):
    """A rod of 1 m, of radii of gyration of 5 mm, 0.375 m and 5 m."""
    text = f"""
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [0, 0, 0], fixed: true}}, b: {{position: [1, 0, 0]}}}}
    sections: {{rod: {{type: circle, diameter: {diameter}, E: 210 GPa, nu: 0.3, density: 7850}}}}
    elements: {{beam: {{type: beam, nodes: [a, b], section: rod, mesh: 4}}}}
    static: {{}}
    """
    said = [one for one in warnings_of(prepare(deck(text))) if "'beam': it is 0.2 radii of gyration" in one]
    assert len(said) == warned


@pytest.mark.parametrize(("slenderness", "mesh", "digits"), [(1e5, 1, None), (3e5, 1, 5), (3e4, 100, 5), (1e6, 10, 3)])
def test_slender_beams_keep_the_digits_that_are_stated(slenderness, mesh, digits):
    """Deflection of a cantilever, F L^3/(3 EI); up to a factor of 30, as rounding is random."""
    bar = math.pi * (4.0 / slenderness) ** 4 / 64.0 * 210e9  # its EI [N m2], at a length of 1 m
    text = f"""
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [0.3, 0.2, 0.1], fixed: true}}, b: {{position: [1.1, 0.2, 0.7]}}}}
    sections: {{wire: {{type: circle, diameter: {4.0 / slenderness}, E: 210 GPa, nu: 0.3, density: 7850}}}}
    elements: {{beam: {{type: beam, nodes: [a, b], section: wire, mesh: {mesh}}}}}
    loads: {{F: {{type: force, node: b, direction: [-0.6, 0, 0.8], value: {3e-3 * bar}}}}}
    static: {{}}
    """
    prepared = prepare(deck(text))
    texts = [one for one in warnings_of(prepared) if "digits" in one]
    assert len(texts) == bool(digits) and all(f"beam 'beam': it is {slenderness:.2g}" in one for one in texts)
    assert all(f"about {digits} digits" in one for one in texts)
    state = follow(prepared).point.state
    x = state.z[prepared.system.numbering.x[1] :][:3] - [1.1, 0.2, 0.7]
    assert abs(x @ [-0.6, 0, 0.8] / 1e-3 - 1.0) < 30 * 10.0 ** -(digits or 6)


def inertia(instance, motion):
    """Mass matrix (12, 12) and forces at rest (12,)."""
    f, _, _, M = instance.force(motion.t, instance.local(motion))
    return M, f


def test_inertia_of_rigid_motions():
    """Mass, first moment and inertia of a straight rod with a heavy side, from its mass matrix and rigid motions."""
    c = np.array([0.0, 0.1, -0.2])
    first = -3.0 * np.cross(np.eye(3), c)
    J = np.diag([0.5, 0.3, 0.2]) + 3.0 * (c @ c * np.eye(3) - np.outer(c, c))
    mass = np.block([[3.0 * np.eye(3), first], [first.T, J]])
    section = {"type": "matrix", "stiffness": np.eye(6) * 9.0, "mass": mass, "E": 0.0, "G": 0.0,
               "torsion_radius": 0.0, "points": [], "damping": 0.0}  # fmt: skip
    values = {"section": section, "up": [0, 0, 1], "mesh": 1, "via": None, "twist": 0.0, "thermal": None}
    nodes = [(np.zeros(3), np.eye(3)), (np.array([2.0, 0, 0]), np.eye(3))]
    instance = expand(BEAM, values, nodes, "", np.zeros(3), np.random.default_rng())[0]
    x, turn = np.zeros((2, 2, 3, 3))
    x[1, 0] = [2.0, 0, 0]
    M, _ = inertia(instance, Motion(0.0, x, np.array([np.eye(3)] * 2), turn))
    hat = np.cross(np.eye(3), [-2.0, 0, 0])  # velocity of the second node for a spin about the first
    rigid = np.block([[np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), np.eye(3)],
                      [np.eye(3), hat], [np.zeros((3, 3)), np.eye(3)]])  # fmt: skip
    found = rigid.T @ M @ rigid
    centre, total = np.array([1.0, 0.1, -0.2]), 6.0
    moment = -total * np.cross(np.eye(3), centre)
    about = 2.0 * J + 3.0 * np.diag([0, 8 / 3, 8 / 3])
    about -= 3.0 * 2.0 * np.array([[0, 0.1, -0.2], [0.1, 0, 0], [-0.2, 0, 0]])
    np.testing.assert_allclose(found, np.block([[total * np.eye(3), moment], [moment.T, about]]), atol=1e-12)
    assert np.linalg.eigvalsh(M)[0] > 0


SECTIONS = {
    "circle": {"diameter": 0.02},
    "tube": {"diameter": 0.02, "thickness": 0.003},
    "rectangle": {"width": 0.03, "height": 0.01},
}


@pytest.mark.parametrize("shape", SECTIONS)
def test_section_constants(shape):
    """Areas and moments by quadrature over the section."""
    d = {"type": shape, **SECTIONS[shape], **STEEL}
    found = constants(d)
    y, z = np.meshgrid(*2 * [(np.arange(2000) + 0.5) / 2000 * 0.04 - 0.02], indexing="ij")
    radius = np.hypot(y, z)
    inside = {"circle": radius < 0.01, "tube": (radius < 0.01) & (radius > 0.007),
              "rectangle": (abs(y) < 0.015) & (abs(z) < 0.005)}[shape]  # fmt: skip
    cell = (0.04 / 2000) ** 2
    area, I2, I3 = inside.sum() * cell, (z**2 * inside).sum() * cell, (y**2 * inside).sum() * cell
    np.testing.assert_allclose(np.diag(found.C)[[0, 4, 5]], 2.1e11 * np.array([area, I2, I3]), rtol=2e-3)
    np.testing.assert_allclose(np.diag(found.J), 7800 * np.array([I2 + I3, I2, I3]), rtol=2e-3)
    assert found.mass == pytest.approx(7800 * area, rel=2e-3)


def test_shear_and_torsion_factors():
    """Cowper 1966: 0.886 (circle), 0.531 (thin tube), 0.850 (rectangle), nu = 0.3; Timoshenko & Goodier, table of
    section 109, a/b = 2: torsion constant 0.229 a b^3, largest stress T/(0.246 a b^2)."""
    G, area = 2.1e11 / 2.6, np.pi * 0.01**2
    circle = constants({"type": "circle", "diameter": 0.02, **STEEL})
    assert circle.C[1, 1] / (G * area) == pytest.approx(0.886, abs=5e-4)
    tube = constants({"type": "tube", "diameter": 0.02, "thickness": 1e-5, **STEEL})
    assert tube.C[1, 1] / (G * tube.C[0, 0] / 2.1e11) == pytest.approx(0.531, abs=2e-3)
    board = constants({"type": "rectangle", "width": 0.02, "height": 0.01, **STEEL})
    assert board.C[2, 2] / (G * 2e-4) == pytest.approx(0.850, abs=5e-4)
    assert board.C[3, 3] / (G * 0.02 * 0.01**3) == pytest.approx(0.229, abs=5e-4)
    twist = 1.0 / board.C[3, 3]
    assert G * twist * board.torsion_radius * 0.02 * 0.01**2 == pytest.approx(1 / 0.246, rel=2e-3)


def test_every_shape_is_explained():
    for shape in SHAPES.values():
        assert shape.doc and shape.section == "sections" and all(field.doc for field in shape.fields)


def test_stations_of_an_arc():
    """A quarter circle with twist: equal steps on the circle, axis 1 tangent, axis 3 turned by the twist."""
    d = {"mesh": 4, "via": np.array([np.sqrt(0.5), 1 - np.sqrt(0.5), 0]), "up": [0, 0, 1], "twist": 0.4}
    nodes = [(np.zeros(3), np.eye(3)), (np.array([1.0, 1.0, 0.0]), np.eye(3))]
    for i, (x, A) in enumerate(stations(d, nodes)):
        angle = i * np.pi / 8
        np.testing.assert_allclose(x, [np.sin(angle), 1 - np.cos(angle), 0], atol=1e-14)
        np.testing.assert_allclose(A[:, 0], [np.cos(angle), np.sin(angle), 0], atol=1e-14)
        np.testing.assert_allclose(A[2], [0, np.sin(0.1 * i), np.cos(0.1 * i)], atol=1e-14)


def member(more="", beams="leg: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1], mesh: 4}"):
    """A deck with a member of four elements."""
    return f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        {CURVED}
        nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [2, 0, 0]}}}}
        elements: {{{beams}}}
        {more}
        time: {{end: 0.01, step: 1.0e-3}}
    """


def test_members_are_divided():
    """Elements and nodes of a member by name; other parts of the deck may use the nodes, and 'all' holds them."""
    more = """initial: {velocities: [{nodes: all, velocity: [0, 0, 1]}, {nodes: [leg.2], velocity: [0, 2, 0]}]}
        joints: {clamp: {type: fixed, nodes: [ground, leg.3]}}
        loads: {push: {type: force, node: leg.1, direction: [0, 1, 0], value: 0.0}}"""
    leg = "leg: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1], mesh: 4}"
    side = "side: {type: beam, nodes: [leg.2, leg.1], section: rod, up: [0, 0, 1], mesh: 2}"
    checked = deck(member(more, f"{leg}, {side}"))
    system = System(build(checked))
    names = [node.name for node in system.nodes]
    assert names[:6] == ["a", "b", "leg.1", "leg.2", "leg.3", "side.1"]
    np.testing.assert_allclose([node.x[0] for node in system.nodes[:6]], [0, 2, 0.5, 1, 1.5, 0.75])
    assert [name for b in system.batches if b.kind is BEAM for name in b.names] == [
        "beam 'leg.1'", "beam 'leg.2'", "beam 'leg.3'", "beam 'leg.4'", "beam 'side.1'", "beam 'side.2'"]  # fmt: skip


def test_a_member_runs():
    """'all' moves every node of the member: thrown freely, it flies without strain."""
    recorded = RecordedRun(deck(member("initial: {velocities: [{nodes: all, velocity: [1, 0, 5]}]}")))
    np.testing.assert_allclose(recorded["nodes/leg.2/position"][-1], [1.01, 0, 0.05 - 0.5 * 9.81 * 1e-4], atol=1e-9)
    assert np.abs(recorded["elements/leg.3/strain_energy"]).max() < 1e-9


@pytest.mark.parametrize(
    ("more", "beams", "text"),
    [
        ("joints: {clamp: {type: fixed, nodes: [ground, leg.4]}}", None, "unknown node 'leg.4'"),
        ("", "leg: {type: beam, nodes: [a, b], section: rood, mesh: 4}", "unknown section 'rood'"),
        ("", "leg: {type: beam, nodes: [a, b], section: rod, mesh: 4}", "missing 'up'"),
        ("", "leg: {type: beam, nodes: [a, b], section: rod, up: [1, 0, 0]}", "'up' must not be parallel"),
        ("", "leg: {type: beam, nodes: [a, ground], section: rod, up: [1, 0, 0], mesh: 3}", "at the same place"),
        ("", "leg: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1], via: [0, 0, 0]}", "'via' must lie"),
        ("", "leg: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1], via: [3, 0, 0]}", "'via' lies on"),
        ("", "leg: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1], twist: 7}", "'mesh' is too small"),
        ("", "leg: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1], mesh: 0}", "must be 1 to 10000"),
        ("", "leg: {type: beam, nodes: [a, leg.1], section: rod, up: [0, 0, 1], mesh: 2}", "depends on itself"),
        ("", "leg.1: {type: beam, nodes: [a, b], section: rod, up: [0, 0, 1]}", "a name begins with a letter"),
    ],
)
def test_what_is_refused(more, beams, text):
    with pytest.raises(DeckError) as caught:
        deck(member(more, beams) if beams else member(more))
    assert text in "\n".join(problem.message for problem in caught.value.problems)


def test_a_beam_whose_stiffness_is_lost_in_rounding_is_refused():
    with pytest.raises(DeckError, match="radii of gyration"):
        deck(member().replace("[2, 0, 0]", "[1e9, 0, 0]"))


@pytest.mark.parametrize(
    ("section", "text"),
    [
        ("{type: tube, diameter: 0.1, thickness: 0.05, E: 1, nu: 0.3, density: 1}", "'thickness' must be less"),
        ("{type: circle, diameter: 0.1, E: 1, density: 1}", "give either 'G' or 'nu'"),
        ("{type: circle, diameter: 0.1, E: 1, nu: 0.6, density: 1}", "'nu' must lie between"),
        ("{type: cirle, diameter: 0.1, E: 1, nu: 0.6, density: 1}", "unknown type 'cirle'"),
        (f"{{type: matrix, stiffness: {np.eye(6).tolist()}, mass: {(-np.eye(6)).tolist()}}}", "positive definite"),
        (
            f"{{type: matrix, stiffness: {np.tri(6).tolist()}, mass: {np.eye(6).tolist()}}}",
            "entries (1, 2) and (2, 1) are 0 and 1",
        ),
        (f"{{type: matrix, stiffness: [[1]], mass: {np.eye(6).tolist()}}}", "6 rows of 6 numbers"),
        (f"{{type: matrix, stiffness: {np.eye(6).tolist()}, mass: {np.diag(range(1, 7)).tolist()}}}", "the form"),
    ],
)
def test_sections_that_are_refused(section, text):
    with pytest.raises(DeckError) as caught:
        deck(member().replace(CURVED, f"sections: {{rod: {section}}}"))
    assert text in "\n".join(problem.message for problem in caught.value.problems)


def test_a_matrix_symmetric_to_rounding_is_accepted():
    """Products of matrices, as of a rotated section, differ from their transposes in the last digits."""
    stiffness = np.diag([1e6, 3e5, 3e5, 50.0, 80.0, 90.0])
    stiffness[0, 3], stiffness[3, 0] = 20.0, 20.0 * (1.0 + 4e-16)
    section = f"{{type: matrix, stiffness: {stiffness.tolist()}, mass: {np.eye(6).tolist()}}}"
    read = np.array(
        deck(member().replace(CURVED, f"sections: {{rod: {section}}}")).values["sections"]["rod"]["stiffness"]
    )
    assert np.array_equal(read, read.T)
    np.testing.assert_allclose(read, stiffness, rtol=1e-15)


def test_resolved_deck_is_the_same_deck():
    """Sections and members survive being written out and read again."""
    checked = deck(member())
    again = deck(json.dumps(checked.resolved()))
    assert again.resolved() == checked.resolved()
    assert checked.resolved()["elements"]["leg"]["section"] == "rod"


def test_pictures_of_a_member(tmp_path):
    """Section forces along the member as in statics; one line for the whole member in the side view."""
    static = member("loads: {pull: {type: force, node: b, direction: [0, 0, -1], value: 10}}").replace(
        "time: {end: 0.01, step: 1.0e-3}", "static: {steps: 1}"
    )
    static = static.replace("a: {position: [0, 0, 0]}", "a: {position: [0, 0, 0], fixed: true}")
    static = static.replace("gravity: [0, 0, -9.81]", "gravity: none")
    run(deck(static), tmp_path / "member.h5")
    runs = open_runs([tmp_path / "member.h5"])
    (sheet,) = member_sheets(runs)
    bending = next(panel for panel in sheet.panels if panel.label == "bending moment").curves[0]
    np.testing.assert_allclose(bending.y.values, 10.0 * (2.0 - bending.x.values), atol=1e-2)
    (line,) = [shape for shape in shapes(Shown(runs[0], np.array([-1]))) if shape.name == "leg"]
    assert line.points.shape == (1, 5, 3)
