"""Joints: signs of reactions, reactions of single bodies known by hand, angles over many turns, refusals."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mecano.constraints.triads import triad
from mecano.element_interface import Place
from mecano.elements import KINDS
from mecano.laws.law_table import LawTable
from mecano.model.model import Element, Model, Node
from mecano.model.system import System

M, G, D, L = 2.0, 9.81, 0.3, 0.8  # mass [kg], gravity [m/s2], arm of the centre of mass, length [m]
J = (0.05, 0.06, 0.07)  # principal moments [kg m2]
X, Y, Z = np.eye(3)
SINE = (("sine", {"amplitude": 0.2, "frequency": 1.5, "phase": 0.3, "offset": 0.0}),)
TIME = 0.1
SINE_RATE = 0.2 * 3.0 * math.pi * math.cos(0.3 * math.pi + 0.3)
SINE_SECOND = -0.2 * (3.0 * math.pi) ** 2 * math.sin(0.3 * math.pi + 0.3)


def filled(kind, values):
    """Deck values with the defaults of the kind."""
    return {**{field.name: field.default for field in KINDS[kind].fields if not field.required}, **values}


def element(name, kind, nodes, **values):
    return Element(name, KINDS[kind], nodes, filled(kind, values))


def body(node, c=(0.0, 0.0, 0.0), inertia=J):
    return element("body", "rigid_body", (node,), mass=M, inertia=inertia, center_of_mass=c)


def reactions(nodes, elements, gravity, spin=(0.0, 0.0, 0.0)):
    """(outputs {element name: {output name: value}}, state, system) at the start, with consistent accelerations.

    ``spin`` is the angular velocity of node b.
    """
    system = System(Model(nodes, elements, LawTable(), np.asarray(gravity, float)))
    s = system.initial_state(TIME)
    if np.any(spin):
        r = system.numbering.r[[node.name for node in system.nodes].index("b")]
        s.v[r : r + 3] = spin
    masses = system.assemble(s, cM=1.0)
    matrix = np.zeros((system.n, system.n))
    matrix[system.rows, system.cols] = masses.data[: system.nnz]
    gradient = np.zeros(system.n_data)
    system.add_constraints(s, 1.0, 0.0, gradient)
    matrix[system.rows, system.cols] += gradient[: system.nnz]
    right = np.concatenate([-masses.residual[: system.n_q], system.constraint_derivatives(s)[:, 2]])
    used = np.abs(matrix).max(axis=1, initial=0.0) > 0.0
    solution = np.zeros(system.n)
    solution[used] = np.linalg.solve(matrix[np.ix_(used, used)], right[used])
    s.a[: system.n_q] = solution[: system.n_q]
    s.z[system.n_q : system.n] = solution[system.n_q :]
    residual = system.assemble(s).residual
    np.testing.assert_allclose(residual[: system.n_q], 0.0, rtol=0, atol=1e-11)
    np.testing.assert_allclose(system.constraint_derivatives(s)[:, 2], 0.0, rtol=0, atol=1e-11)
    return outputs(system, s), s, system


def outputs(system, s):
    found, observed = {}, system.observe(s).outputs
    for batch in system.batches:
        for name, y in zip(batch.names, batch.outputs(observed), strict=True):
            start = 0
            for output in batch.kind.outputs:
                size = int(np.prod(output.shape, dtype=int))
                value = y[start : start + size] if output.shape else y[start]
                found.setdefault(name, {})[output.name] = np.array(value)
                start += size
    return found


def at(x=(0.0, 0.0, 0.0), R=None, name="b", **more):
    return Node(name, np.asarray(x, float), np.eye(3) if R is None else R, **more)


def on_ground(kind, node, c=(0.0, 0.0, 0.0), gravity=(0.0, 0.0, -G), spin=(0.0, 0.0, 0.0), inertia=J, **values):
    """Outputs of one joint between ground and one body."""
    joint = element("joint", kind, ("ground", "b"), **values)
    return reactions([node], [body("b", c, inertia), joint], gravity, spin)[0][f"{kind} 'joint'"]


def close(value, expected):
    np.testing.assert_allclose(value, expected, rtol=1e-9, atol=1e-9)


BAR = (1e-9, M * L**2 / 12.0, M * L**2 / 12.0)


def test_released_bar_weighs_a_quarter_on_its_hinge():
    """Uniform bar, horizontal, hinged at its end, released from rest: F = m g/4, its angle gains 3 g/(2 L)."""
    joint = element("joint", "hinge", ("ground", "b"), axis=Y)
    found, s, system = reactions([at()], [body("b", (L / 2, 0, 0), BAR), joint], (0, 0, -G))
    close(found["hinge 'joint'"]["force"], (0.0, -M * G / 4, 0.0))  # mu_1 = x, mu_2 = y x x = -z
    close(found["hinge 'joint'"]["moment"], (0.0, 0.0, 0.0))
    r = system.numbering.r[0]
    close(s.a[r : r + 3], (0.0, 1.5 * G / L, 0.0))


@pytest.mark.parametrize(("kind", "values"), [("fixed", {}), ("prismatic", {"axis": Y})])
def test_nodes_with_different_orientations_keep_them(kind, values):
    """The same bar from another node at its end, whose axes are those of a permuted; the joint carries the bar."""
    permuted = np.eye(3)[[2, 0, 1]]
    elements = [
        body("b", permuted.T @ (L / 2, 0, 0), np.roll(BAR, -1)),
        element("pivot", "hinge", ("ground", "a"), axis=Y),
        element("joint", kind, ("a", "b"), **values),
    ]
    found, s, system = reactions([at(name="a"), at(R=permuted)], elements, (0, 0, -G))
    close(found["hinge 'pivot'"]["force"], (0.0, -M * G / 4, 0.0))
    close(permuted @ s.a[system.numbering.r[1] + np.arange(3)], (0.0, 1.5 * G / L, 0.0))
    axes = np.eye(3) if kind == "fixed" else triad(Y)
    close(found[f"{kind} 'joint'"]["force"], axes @ (0.0, 0.0, M * G / 4))
    close(found[f"{kind} 'joint'"]["moment"], 0.0)


def test_hinge_carries_the_moment_of_a_body_beside_it():
    """At rest below its axis but D along it: force m g up; the moment -D y x (-m g z) = m g D x along mu_1 = x."""
    found = on_ground("hinge", at(), (0.0, D, -L), axis=Y)
    close(found["force"], (0.0, -M * G, 0.0))
    close(found["moment"], (M * G * D, 0.0, 0.0))


def test_hinge_of_a_spinning_body_out_of_balance():
    """Rate w about z, centre of mass at D x: the hinge pulls with m D w2; with height h it gives the moment too."""
    w, h = 3.0, 0.2
    found = on_ground("hinge", at(), (D, 0.0, h), gravity=(0, 0, 0), spin=(0, 0, w), axis=Z)
    close(found["rate"], w)
    close(found["force"], (-M * D * w**2, 0.0, 0.0))  # mu_1 = x
    close(found["moment"], (0.0, -M * D * h * w**2, 0.0))


def test_order_of_the_nodes_reverses_the_reaction():
    R = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
    for kind, values in (("hinge", {"axis": Y}), ("fixed", {}), ("prismatic", {"axis": X})):
        found = []
        for nodes in (("ground", "b"), ("b", "ground")):
            joint = element("joint", kind, nodes, **values)
            found.append(reactions([at(R=R)], [body("b", (0.1, D, -L)), joint], (0, 0, -G))[0][f"{kind} 'joint'"])
        for name in ("force", "moment"):
            close(found[1][name], -found[0][name])
            assert np.abs(found[0][name]).max() > 0.1


@pytest.mark.parametrize("first", ["ground", "a", "b"])
def test_joints_at_one_place_share_the_load_as_a_chain(first):
    """ground - a - b - c, one mass each, all at one place: the joints carry 3, 2 and 1 of them, in any order."""
    elements = [element(name, "point_mass", (name,), mass=M) for name in "abc"]
    expected = {}
    for load, pair in zip((3, 2, 1), (("ground", "a"), ("a", "b"), ("b", "c")), strict=True):
        reverse = pair[0] == first
        elements.append(element("".join(pair), "spherical", pair[::-1] if reverse else pair))
        expected[f"spherical '{''.join(pair)}'"] = (0, 0, load * M * G * (-1 if reverse else 1))
    found = reactions([at(name=name) for name in "abc"], elements, (0, 0, -G))[0]
    for name, force in expected.items():
        close(found[name]["force"], force)


def test_clamped_body():
    found = on_ground("fixed", at(), (D, 0.0, 0.0))
    close(found["force"], (0, 0, M * G))
    close(found["moment"], (0, -M * G * D, 0))


def test_body_hanging_on_a_ball():
    close(on_ground("spherical", at((1, 2, 3)), (0, 0, -L))["force"], (0, 0, M * G))


def test_universal_joint_transmits_the_moment_about_both_pins():
    """Weight along -y at D x turns about -z = axis_b x axis_a; the joint holds against it."""
    found = on_ground("universal", at(), (D, 0, 0), gravity=(0, -G, 0), axis_a=X, axis_b=Y)
    close(found["force"], (0, M * G, 0))
    close(found["moment"], -M * G * D)


def test_slider_beside_its_rail():
    """On a rail along x the weight gives force and moment; a tilted frame of the node must not matter."""
    R = Rotation.from_rotvec([0.4, 0.7, -0.3]).as_matrix()
    found = on_ground("prismatic", at((1, 2, 3), R), R.T @ (D, 0, 0), axis=X)
    close(found["force"], triad(X) @ (0, 0, M * G))
    close(found["moment"], triad(X) @ (0, -M * G * D, 0))


def test_body_on_a_round_rail():
    found = on_ground("cylindrical", at((1, 2, 3)), (D, 0, -L), axis=X)
    close(found["force"], triad(X) @ (0, 0, M * G))
    close(found["moment"], triad(X) @ (0, -M * G * D, 0))


def test_rod_of_a_conical_pendulum():
    """A mass on a rod, at an angle phi, circling with w2 = g/(l cos phi): tension m g/cos phi."""
    phi = 0.4
    node, w = at((L * math.sin(phi), 0, -L * math.cos(phi))), math.sqrt(G / (L * math.cos(phi)))
    mass = element("mass", "point_mass", ("b",), mass=M)
    rod = element("joint", "rigid_rod", ("o", "b"))
    nodes = [at(name="o", fixed=True), node]
    system = System(Model(nodes, [mass, rod], LawTable(), np.array([0, 0, -G])))
    s = system.initial_state()
    x = system.numbering.x[1]
    s.v[x + 1], s.a[x] = w * L * math.sin(phi), -(w**2) * L * math.sin(phi)
    s.z[system.n_q] = -M * G / math.cos(phi)
    close(system.assemble(s).residual[: system.n], 0.0)
    close(system.constraint_derivatives(s), 0.0)
    close(outputs(system, s)["rigid_rod 'joint'"]["tension"], M * G / math.cos(phi))


def test_rigid_link_to_a_loaded_follower():
    elements = [body("b", (D, 0, 0)), element("link", "rigid_link", ("m", "b"))]
    elements.append(element("clamp", "fixed", ("ground", "m")))
    found, _, _ = reactions([at((0, 0, 0), name="m"), at((L, 0, 0))], elements, (0, 0, -G))
    close(found["rigid_link 'link'"]["force"], (0, 0, M * G))
    close(found["rigid_link 'link'"]["moment"], (0, -M * G * D, 0))
    close(found["fixed 'clamp'"]["force"], (0, 0, M * G))
    close(found["fixed 'clamp'"]["moment"], (0, -M * G * (D + L), 0))


def test_held_rotation_of_a_lifted_body():
    elements = [
        body("b", (D, 0, 0)),
        element("hold", "held_rotation", ("ground", "b")),
        element("lift", "prescribed_position", ("b",), direction=2 * Z, value=SINE),
    ]
    nodes = [at((0, 0, 1))]
    found, s, system = reactions(nodes, elements, (0, 0, -G))
    force = M * (G + SINE_SECOND)
    close(found["prescribed_position 'lift'"]["force"], force)
    close(found["held_rotation 'hold'"]["moment"], (0, -force * D, 0))
    close(system.observe(s).energy[3], force * SINE_RATE)


def test_motor_gives_the_moment_of_inertia_times_acceleration():
    elements = [
        body("b"),
        element("pin", "hinge", ("ground", "b"), axis=Z),
        element("motor", "prescribed_angle", ("ground", "b"), axis=3 * Z, value=SINE),
    ]
    found, s, system = reactions([at()], elements, (0, 0, 0))
    close(found["prescribed_angle 'motor'"]["moment"], J[2] * SINE_SECOND)
    close(system.observe(s).energy[3], J[2] * SINE_SECOND * SINE_RATE)


@pytest.mark.parametrize("row, axis", [(0, 1), (1, 0)], ids=["first multiplier", "second multiplier"])
def test_multipliers_of_a_hinge_are_moments(row, axis):
    """(16)-(17): k lambda_1 is the moment on b about +mu_2, k lambda_2 about -mu_1; opposite on a."""
    hinge = KINDS["hinge"]
    R = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
    nodes = [(np.zeros(3), np.eye(3)), (np.zeros(3), R)]
    part = hinge.parts(filled("hinge", {"axis": np.array([1.0, 2.0, 3.0])}), nodes, None)[row]
    p = np.zeros(1, part.kind.dtype)
    p["mu"], p["xi"] = part.parameters["mu"], part.parameters["xi"]
    q, f = np.zeros(7), np.zeros(7)
    q[6] = 5.0
    matrices = [np.zeros((7, 7)) for _ in range(3)]
    rotations = np.array([node[1] for node in nodes])
    record = p.view(np.recarray)[0]
    part.kind.force(record, Place(0.0, 0, 1.0, 0.0, np.zeros(1), np.zeros(0), q, 0 * q, 0 * q, rotations), f, *matrices)
    expected = (5.0, -5.0)[row] * triad((1, 2, 3))[axis]
    close(R @ -f[3:6], expected)
    close(-f[0:3], -expected)


ANGLED = [
    ("hinge", {"axis": (1.0, 2.0, 3.0)}, "angle", (1.0, 2.0, 3.0)),
    ("cylindrical", {"axis": (0.0, 2.0, 3.0)}, "angle", (0.0, 2.0, 3.0)),
    ("universal", {"axis_a": X, "axis_b": Y}, "angle_a", X),
    ("universal", {"axis_a": X, "axis_b": Y}, "angle_b", Y),
]


@pytest.mark.parametrize("kind, values, name, axis", ANGLED)
def test_angle_continues_over_many_turns(kind, values, name, axis):
    """Large steps of either sense; only ``commit`` moves the memory."""
    start = Rotation.from_rotvec([0.3, -0.2, 0.5]).as_matrix()
    joint = element("joint", kind, ("o", "b"), **values)
    nodes = [at(name="o", fixed=True), at(R=start)]
    system = System(Model(nodes, [body("b"), joint], LawTable()))
    s, title = system.initial_state(), f"{kind} 'joint'"
    direction = np.asarray(axis) / np.linalg.norm(axis)
    b = system.numbering.rotation[1]
    r = system.numbering.r[1]
    angle = 0.0
    for step in [2.9] * 15 + [-3.1] * 30:
        angle += step
        s.R[b] = Rotation.from_rotvec(angle * direction).as_matrix() @ start
        s.v[r : r + 3] = s.R[b].T @ direction * 7.0
        for _ in range(2):
            found = outputs(system, s)[title]
            close(found[name], angle)
            close(found[name.replace("angle", "rate")], 7.0)
        s.memory = system.commit(s)
    assert abs(angle) > 6 * math.pi


def test_prescribed_angle_holds_over_many_turns():
    """Phi sees the difference to f(t) only, so that f may be many turns: 50.3 rad is held like 50.3 - 16 pi."""
    far = (("constant", {"value": 50.3}),)
    motor = element("motor", "prescribed_angle", ("o", "b"), axis=Z, value=far)
    system = System(Model([at(name="o", fixed=True), at()], [body("b"), motor], LawTable()))
    s = system.initial_state()
    for error in (0.0, 0.2, -0.2, 3.0, -3.0):
        s.R[system.numbering.rotation[1]] = Rotation.from_rotvec([0, 0, 50.3 + error]).as_matrix()
        close(system.constraint_derivatives(s)[0, 0], error)
        close(outputs(system, s)["prescribed_angle 'motor'"]["angle"], 50.3 + error)


def test_a_prescribed_angle_of_many_turns_is_held_to_the_rounding_of_one():
    """An error of 2e-13 rad is seen beside 44,000 rad, of which the last digit is 7e-12 rad."""
    motor = element("motor", "prescribed_angle", ("o", "b"), axis=Z, value=(("constant", {"value": 44000.0}),))
    system = System(Model([at(name="o", fixed=True), at()], [body("b"), motor], LawTable()))
    s, held = system.initial_state(), []
    for error in (0.0, 2e-13):
        s.R[system.numbering.rotation[1]] = Rotation.from_rotvec([0, 0, 0.3 + error]).as_matrix()
        held.append(system.constraint_derivatives(s)[0, 0])
    assert held[1] - held[0] == pytest.approx(2e-13, abs=2e-15)


def test_sliding_is_counted_from_the_start():
    """Displacement along the carried axis, and its rate in a turning frame."""
    joint = element("joint", "prismatic", ("a", "b"), axis=Z)
    nodes = [at((0, 0, 1), name="a"), at((0.3, 0, 2))]
    system = System(Model(nodes, [body("a"), body("b"), joint], LawTable()))
    s = system.initial_state()
    of = system.numbering
    s.v[of.r[0] : of.r[0] + 3] = (0.0, 2.0, 0.0)
    s.v[of.x[1] : of.x[1] + 3] = (2.0, 0.0, 0.7 - 0.6)
    s.z[of.x[1] + 2] += 0.25
    found = outputs(system, s)["prismatic 'joint'"]
    close(found["displacement"], 0.25)
    close(found["velocity"], 0.1 + 2.0 * 0.3)


@pytest.mark.parametrize("kind", ["hinge", "cylindrical"])
def test_flipped_axis_is_not_admissible(kind):
    nodes = [(np.zeros(3), np.eye(3))] * 2
    values = filled(kind, {"axis": np.array([1.0, 2.0, 3.0])})
    p = np.zeros(1, KINDS[kind].dtype)
    for key, value in KINDS[kind].prepare(values, nodes, None).items():
        p[key][0] = value
    flip = Rotation.from_rotvec(math.pi * triad(values["axis"])[0]).as_matrix()
    assert KINDS[kind].admissible(p[0], None, np.array([np.eye(3), np.eye(3)])) == ""
    assert "flipped" in KINDS[kind].admissible(p[0], None, np.array([np.eye(3), flip]))


HERE, THERE, TURNED = (np.zeros(3), np.eye(3)), (0.5 * X, np.eye(3)), (np.zeros(3), np.diag([1.0, -1.0, -1.0]))
REFUSED = [
    ("hinge", {}, THERE, "at the same place; they are 0.5 m apart"),
    ("spherical", {}, THERE, "at the same place"),
    ("universal", {"axis_a": X, "axis_b": Y}, THERE, "at the same place"),
    ("universal", {"axis_a": X, "axis_b": X + Y}, HERE, "perpendicular; they are 45 degrees apart"),
    ("fixed", {}, THERE, "at the same place"),
    ("held_rotation", {}, TURNED, "the same rotation; they differ by 180 degrees"),
    ("rigid_rod", {}, HERE, "must not be at the same place ('ground' is at the place of the other node; "),
]


@pytest.mark.parametrize("kind, values, second, text", REFUSED)
def test_nodes_that_do_not_fit_are_refused(kind, values, second, text):
    (found,) = KINDS[kind].check(filled(kind, {"axis": Z, **values}), [HERE, second])
    assert text in found


@pytest.mark.parametrize("axis", [X, Y, Z, (1.0, 2.0, 3.0), (-1.0, 1.0, 1e-9)])
def test_triad_is_right_handed_along_the_axis(axis):
    mu = triad(axis)
    close(mu @ mu.T, np.eye(3))
    close(np.linalg.det(mu), 1.0)
    close(mu[2], np.asarray(axis) / np.linalg.norm(axis))


def test_axis_carried_by_the_second_node_may_differ():
    """The start angle is zero, and turning the axis of b onto that of a satisfies the hinge."""
    hinge = KINDS["hinge"]
    axis, axis_b = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.3, 1.0])
    nodes = [(np.zeros(3), np.eye(3)), (np.zeros(3), Rotation.from_rotvec([0.1, 0.2, 0.3]).as_matrix())]
    p = hinge.prepare(filled("hinge", {"axis": axis, "axis_b": axis_b}), nodes, None)
    close(nodes[1][1] @ p["xi"][2], axis_b / np.linalg.norm(axis_b))
    back = Rotation.from_rotvec([math.atan(0.3), 0, 0]).as_matrix()
    close(p["xi"] @ nodes[1][1].T @ back.T, p["mu"])
