"""Beams at rest against exact answers: errors with n elements, orders, and the goals of the project."""

import numpy as np
import pytest
from beam_cases import (
    BEND,
    ELASTICA,
    PRINCETON,
    bend,
    dead_force,
    elastica,
    euler_load,
    lateral_buckling,
    princeton,
    roll_up,
    smallest_stiffness,
    stiffness,
    straight,
    torque_buckling,
)
from equilibria import Equilibrium
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.optimize import brentq
from time_runs import deck, input_deck

from mecano.analyses.equilibria import follow
from mecano.analyses.prepare import prepare, startup_warnings

CASES = {
    **{f"elastica_{load:g}": (elastica, load) for load in ELASTICA},
    **{f"bend_{load:g}": (bend, load) for load in BEND},
    **{f"princeton_{angle}": (princeton, angle) for angle in PRINCETON},
}
REST, TRANSCENDENTAL = "Beams at rest", "transcendental equation of the beam of Timoshenko"
TIMOSHENKO = (3.7975628699347963, 23.792645105269827, 66.59173371319504, 130.41213633808454)
"""Bending frequencies [rad/s] of a cantilever, EI = 14000, GA = 1e7, rhoA = 1.2, rhoI = 6e-4, L = 10: transcendental
equation of the beam of Timoshenko."""


def test_roll_up_closes(verify):
    """A circular arc is in the space of the helix: exact with any number of elements that turn by less than pi."""
    for n in (4, 16):
        verify(REST, f"roll-up to a circle, {n} elements: gap over length", roll_up(n), 0.0, "circle", absolute=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_error_with_few_elements(case, verify):
    """0.25 % asked with 16 elements: 25 times better with half as many."""
    error, parameter = CASES[case]
    tolerance = 5e-4 if "princeton" in case else 1e-4
    what = f"{case.replace('_', ' ')}, 8 elements: error of the tip over length"
    verify(REST, what, error(8, parameter), 0.0, "exact rod of Reissner and Simo, by shooting", absolute=tolerance)


@pytest.mark.parametrize(("case", "order"), [("elastica_4", 4.0), ("bend_600", 4.0), ("princeton_90", 4.0)])
def test_order_four_in_bending(case, order):
    error, parameter = CASES[case]
    coarse, fine = error(4, parameter), error(8, parameter)
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.15)


def test_order_two_where_bending_couples_with_torsion():
    coarse, fine = princeton(4, 45), princeton(8, 45)
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.1)


def euler_load_of_cubic_beams(n):
    """Relative error of n elements with cubic deflections and their consistent geometric stiffness (textbooks)."""
    h = 1.0 / n
    bending, geometric = np.zeros((2, 2 * n + 2, 2 * n + 2))
    for first in range(0, 2 * n, 2):
        of = slice(first, first + 4)
        bending[of, of] += np.array(
            [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
             [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]
        ) / h**3  # fmt: skip
        geometric[of, of] += np.array(
            [[36, 3 * h, -36, 3 * h], [3 * h, 4 * h**2, -3 * h, -(h**2)],
             [-36, -3 * h, 36, -3 * h], [3 * h, -(h**2), -3 * h, 4 * h**2]]
        ) / (30 * h)  # fmt: skip
    return 1.0 / eigh(geometric[2:, 2:], bending[2:, 2:], eigvals_only=True)[-1] / (np.pi**2 / 4) - 1.0


@pytest.mark.parametrize("n", [1, 2, 4])
def test_euler_load(verify, n):
    what = f"Euler load of a cantilever, {n} element(s): relative error"
    verify(REST, what, euler_load(n), euler_load_of_cubic_beams(n), "cubic beam elements", absolute=1e-6)


def test_a_cantilever_curls_under_a_follower_force(verify):
    """EI theta'' = -F cos(theta) from the tip, where theta = theta' = 0; the force turns the tip by 171 degrees."""

    def from_tip(s, y):
        return [y[1], -10.0 * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

    theta, _, x, y = solve_ivp(from_tip, (1.0, 0.0), np.zeros(4), rtol=1e-10, atol=1e-12).y[:, -1]
    tip = -np.array([x * np.cos(theta) + y * np.sin(theta), y * np.cos(theta) - x * np.sin(theta)])
    loads = "push: {type: follower_force, node: tip, direction: [0, 1, 0], value: 10}"
    section = stiffness(EA=1e7, GA=1e7, GJ=1.0, EI2=1.0, EI3=1.0)
    found = Equilibrium(straight(section, 1.0, 16, loads).replace("static: {}", "static: {steps: 5}"))
    what = "cantilever under a follower force of 10 EI/L2: tip over length"
    verify(REST, what, found.position("tip")[:2], tip, "elastica", absolute=2e-5)


def test_lateral_buckling_load(verify):
    coarse, fine = lateral_buckling(4), lateral_buckling(8)
    verify(REST, "lateral buckling load, 8 elements: relative error", fine, 0.0, "function of Bessel", absolute=0.01)
    verify(REST, "lateral buckling load: order", np.log2(coarse / fine), 2.0, "order of the method", absolute=0.1)


def test_torque_that_buckles_a_shaft(verify):
    coarse, fine = torque_buckling(8), torque_buckling(16)
    verify(
        REST, "torque that buckles a clamped shaft, 16 elements: relative error", fine, 0.0, "Greenhill", absolute=2e-3
    )
    verify(
        REST,
        "torque that buckles a clamped shaft: order",
        np.log2(coarse / fine),
        2.0,
        "order of the method",
        absolute=0.3,
    )


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_error_with_16_and_64_elements(case):
    error, parameter = CASES[case]
    assert error(16, parameter) <= 2.5e-3 and error(64, parameter) <= 2e-4


@pytest.mark.slow
def test_lateral_buckling_load_with_16_and_64_elements():
    assert lateral_buckling(16) <= 2.5e-3 and lateral_buckling(64) <= 2e-4


def frequencies(n):
    """The lowest frequencies [rad/s] of the cantilever, each twice."""
    section = stiffness(EA=1e9, GA=1e7, GJ=1e5, EI2=14000.0, EI3=14000.0)
    section = section.replace("mass_per_length: 1, rotary_inertia: [2, 1, 1]",
                              "mass_per_length: 1.2, rotary_inertia: [1.2e-3, 6e-4, 6e-4]")  # fmt: skip
    at_rest = Equilibrium(straight(section, 10.0, n, ""))
    K, M = at_rest.tangent().toarray(), at_rest.tangent(0.0, 1.0).toarray()
    np.testing.assert_allclose(K, K.T, atol=1e-9 * K.max())
    np.testing.assert_allclose(M, M.T, atol=1e-12 * M.max())
    return np.sqrt(eigh(K, M, eigvals_only=True, subset_by_index=[0, 7]))


@pytest.mark.parametrize(("n", "tolerance"), [(8, 2e-3), (16, 2e-4), (64, 5e-6)])
def test_frequencies_of_a_cantilever(n, tolerance, verify):
    found = frequencies(n)
    np.testing.assert_allclose(found[::2], found[1::2], rtol=1e-7)
    what = f"cantilever of {n} elements: first four [rad/s]"
    verify("Frequencies", what, found[::2], TIMOSHENKO, TRANSCENDENTAL, relative=tolerance)


def test_linear_statics_of_one_element_are_exact():
    """Tip of a curved, twisted element of full section stiffness: one element and sixteen agree to a small load."""
    rng = np.random.default_rng(3)
    A = rng.normal(size=(6, 6))
    C = (A @ A.T + 6 * np.eye(6)).tolist()
    section = f"{{type: matrix, stiffness: {C}, mass: {np.eye(6).tolist()}}}"
    loads = "pull: {type: force, node: tip, direction: [1, 2, 3], value: 1.0e-7}, " \
            "turn: {type: moment, node: tip, direction: [3, -1, 2], value: 1.0e-7}"  # fmt: skip
    tips = []
    for n in (1, 16):
        text = straight(section, 1.0, n, loads, ", via: [0.5, 0.2, 0.1]")
        found = Equilibrium(text)
        tips.append((found.position("tip") - [1, 0, 0]) / 1e-7)
    np.testing.assert_allclose(tips[0], tips[1], rtol=1e-5)


def test_section_forces_are_those_of_statics():
    """A cantilever under a tip force: moment linear to the root, shear and stress as in the textbook; light load."""
    section = "{type: rectangle, width: 0.02, height: 0.04, E: 2.0e11, nu: 0.3, density: 7800}"
    found = Equilibrium(straight(section, 1.0, 4, dead_small()))
    P = 10.0
    force, strain = found.output("elements/leg.1/force"), found.output("elements/leg.1/strain")
    np.testing.assert_allclose(force, [0, 0, P], atol=1e-4 * P)
    np.testing.assert_allclose(found.output("elements/leg.1/moment_start"), [0, -P, 0], atol=1e-6 * P)
    np.testing.assert_allclose(found.output("elements/leg.1/moment"), [0, -0.875 * P, 0], atol=1e-6 * P)
    np.testing.assert_allclose(found.output("elements/leg.1/moment_end"), [0, -0.75 * P, 0], atol=1e-6 * P)
    shear = P / (10 * 1.3 / (12 + 11 * 0.3) * 2e11 / 2.6 * 0.0008)
    assert strain[2] == pytest.approx(shear, rel=1e-6)
    assert found.output("elements/leg.1/normal_stress")[0] == pytest.approx(6 * P / (0.02 * 0.04**2), rel=1e-6)
    assert found.output("elements/leg.4/moment_end")[1] == pytest.approx(0.0, abs=1e-6)


def stretched_shear(n):
    """Return the shear force in the middle of the first of n elements of a cantilever with k L = 10, and the exact one.

    With the tension k^2 EI and a transverse force Q at the tip it is Q cosh k(L - x)/cosh k L.
    """
    section, k = stiffness(EA=1e8, GA=1e8, GJ=80.0, EI2=100.0, EI3=100.0), 10.0
    stretch = "stretch: {type: force, node: tip, direction: [1, 0, 0], value: 1.0e4}, "
    found = Equilibrium(straight(section, 1.0, n, stretch + dead_force(0, 0, 1.0)))
    return found.output("elements/leg.1/force")[2], np.cosh(k * (1.0 - 0.5 / n)) / np.cosh(k)


@pytest.mark.parametrize(("n", "tolerance"), [(8, 1e-3), (16, 1e-4)])
def test_shear_of_a_stretched_cantilever(verify, n, tolerance):
    """In the axes of the helix between the ends of the element the shear force would be 20 % and 5 % too large."""
    found, exact = stretched_shear(n)
    verify(REST, f"stretched cantilever, {n} elements: shear force [N]", found, exact, "cosh", relative=tolerance)


EDGE, TORQUE = 0.05, 50.0
"""Shear centre of the sections below from their node, along axis 2 [m]; torque of one radian per metre [N m]."""


def aside():
    """Return a section whose shear centre is EDGE from its node: its shear strain there is gamma_3 + EDGE kappa_1."""
    C = np.diag([1e6, 1e6, 1e6, TORQUE + 1e6 * EDGE**2, 100.0, 100.0])
    C[2, 3] = C[3, 2] = 1e6 * EDGE
    return f"{{type: matrix, stiffness: {C.tolist()}, mass: {np.eye(6).tolist()}}}"


@pytest.mark.parametrize("n", [1, 4])
def test_a_section_turns_about_its_shear_centre(verify, n):
    """A torque turns all nodes about the line of shear centres, at rest on it: nothing else deforms the beam."""
    loads = f"turn: {{type: moment, node: tip, direction: [1, 0, 0], value: {TORQUE}}}"
    found = Equilibrium(straight(aside(), 1.0, n, loads))
    tip = [1.0, EDGE * (1.0 - np.cos(1.0)), -EDGE * np.sin(1.0)]
    name = "leg" if n == 1 else "leg.1"
    what = f"shear centre aside, {n} elements: "
    verify(REST, what + "tip under a torque [m]", found.position("tip"), tip, "rotation", absolute=1e-10)
    moment = found.output(f"elements/{name}/moment")
    verify(REST, what + "section moment [N m]", moment, [TORQUE, 0, 0], "rotation", absolute=1e-8)


@pytest.mark.parametrize("n", [8, 16])
def test_a_column_with_its_shear_centre_aside_bends_and_twists(verify, n):
    """Axial load through the nodes of a cantilever: pi^2 EI/(2 L)^2 = P + P^2 c^2/GJ.

    Of the rod of Cosserat without shear: stationary 1/2 int(GJ phi'^2 + EI theta'^2) - P int(c phi' theta + theta^2/2).
    """
    c, GJ, GA = 0.5, 0.5, 1e5
    C = np.diag([1e6, 1e5, GA, GJ + GA * c**2, 1.0, 4.0])
    C[2, 3] = C[3, 2] = GA * c
    section = f"{{type: matrix, stiffness: {C.tolist()}, mass: {np.eye(6).tolist()}}}"
    a = c**2 / GJ
    exact = (np.sqrt(1.0 + np.pi**2 * a) - 1.0) / (2.0 * a)
    smallest = lambda load: smallest_stiffness(straight(section, 1.0, n, dead_force(-load, 0, 0)))  # noqa: E731
    found = brentq(smallest, 0.7 * exact, 1.2 * exact, xtol=1e-7)
    verify(
        REST, f"column that bends and twists, {n} elements: load [N]", found, exact, "rod of Cosserat", relative=5e-3
    )


@pytest.mark.parametrize("n", [1, 2])
def test_the_middle_of_a_section_that_couples_shear_and_bending(verify, n):
    """A small force P: N_1 = -P theta, theta = P (F_35 x - F_55 (L x - x^2/2)), x the middle of the first element."""
    P, C = 1e-3, np.diag([1e6, 1e5, 100.0, 1.0, 1.0, 4.0])
    C[2, 4] = C[4, 2] = 5.0
    F, x = np.linalg.inv(C), 0.5 / n
    section = f"{{type: matrix, stiffness: {C.tolist()}, mass: {np.eye(6).tolist()}}}"
    found = Equilibrium(straight(section, 1.0, n, dead_force(0, 0, P))).output(
        f"elements/{'leg' if n == 1 else 'leg.1'}/force"
    )
    exact = -P * P * (F[2, 4] * x - F[4, 4] * (x - x * x / 2))
    what = f"section that couples shear and bending, {n} elements: axial force in the middle [N]"
    verify(REST, what, found[0], exact, "linear theory", relative=1e-3)


def moments_of_an_arc(n):
    """Return the section moments (n, 3) in the middle of elements and at their first nodes; the section is coupled."""
    C = np.diag([1e5, 4e4, 5e4, 60.0, 80.0, 120.0])
    C[1, 5] = C[5, 1] = 600.0
    C[3, 4] = C[4, 3] = 20.0
    section = f"{{type: matrix, stiffness: {C.tolist()}, mass: {np.eye(6).tolist()}}}"
    found = Equilibrium(straight(section, 2.0, n, dead_force(5, 10, 20), ", via: [1, 0.8, 0.3]"))
    names = [f"elements/leg.{i + 1}/moment" for i in range(n)]
    return tuple(np.array([found.output(name + end) for name in names]) for end in ("", "_start"))


def test_the_moment_in_the_middle_is_as_accurate_as_that_at_the_nodes():
    """Of a curved beam that bends in space: with half the elements, compared with the nodes of all."""
    (middle, start), (_, finer) = moments_of_an_arc(8), moments_of_an_arc(16)
    assert np.abs(middle - finer[1::2]).max() < 2.0 * np.abs(start - finer[::2]).max()  # measured 1.1


def displaced_section(c):
    """Return the section forces about the mass centre, its nodes displaced by -c from there, under 30 N and 20 N m."""
    C, back, offset = np.diag([1e5, 4e4, 5e4, 60.0, 80.0, 120.0]), np.eye(6), np.array([0.0, *c])
    back[:3, 3:] = np.cross(offset, np.eye(3))
    section = f"{{type: matrix, stiffness: {(back.T @ C @ back).tolist()}, mass: {np.eye(6).tolist()}}}"
    found = Equilibrium(f"""
        mecano: 1
        gravity: none
        nodes:
          root: {{position: {(-offset).tolist()}, fixed: true}}
          tip: {{position: {([2, 0, 0] - offset).tolist()}}}
          hook: {{position: [2, 0.1, 0.2]}}
        sections: {{s: {section}}}
        elements:
          leg: {{type: beam, nodes: [root, tip], section: s, mesh: 4, up: [0, 0, 1]}}
          arm: {{type: rigid_link, nodes: [tip, hook]}}
        loads:
          pull: {{type: force, node: hook, direction: [1, 2, -3], value: 30}}
          turn: {{type: follower_moment, node: hook, direction: [1, 0, 0], value: 20}}
        static: {{}}
    """)
    force = found.output("elements/leg.2/force")
    moment = found.output("elements/leg.2/moment") - np.cross(offset, force)
    return np.concatenate([found.position("hook"), force, moment])


def test_the_place_of_the_nodes_in_the_section_does_not_matter():
    """The same beam, its section matrix written about three lines: large bending and twist by an eccentric force."""
    found = [displaced_section(c) for c in ([0.0, 0.0], [0.05, -0.03], [-0.2, 0.1])]
    np.testing.assert_allclose(found[1:], [found[0]] * 2, rtol=1e-8)


def dead_small():
    """A force of 10 N upwards at the tip."""
    return "pull: {type: force, node: tip, direction: [0, 0, 1], value: 10.0}"


@pytest.mark.parametrize(
    ("name", "tip", "tolerance"),
    [
        ("beam_roll_up", (0.0, 0.0, 0.0), 1e-5),  # 1e-6 of its length
        ("beam_45_degrees", BEND[600.0], 1e-4),
        ("princeton_beam", (0.508 - PRINCETON[45][2], PRINCETON[45][0], PRINCETON[45][1]), 1e-5),
    ],
)
def test_input(name, tip, tolerance):
    prepared = prepare(input_deck(name))
    state = follow(prepared).point.state
    first = prepared.system.numbering.x[[node.name for node in prepared.system.nodes].index("tip")]
    np.testing.assert_allclose(state.z[first : first + 3], tip, rtol=0, atol=tolerance)


ROPE = """
    mecano: 1
    gravity: [0, 0, -9.81]
    sections: {rope: {type: circle, diameter: 2 mm, E: 10 GPa, nu: 0.3, density: 7800}}
    nodes: {a: {position: [0, 0, 0]}, b: {position: [10, 0, 0]}}
    elements: {rope: {type: beam, nodes: [a, b], section: rope, via: [5, 0, -2.9], mesh: MESH}}
    joints: {pin_$n: {repeat: {n: [a, b]}, type: hinge, nodes: [ground, $n], axis: [0, 1, 0]}}
    static: {}
    """


@pytest.mark.parametrize(("mesh", "tolerance"), [(80, 1e-4), (40, 3e-4), (20, 4e-3)])
def test_a_rope_of_beams_hangs_as_a_catenary(verify, mesh, tolerance):
    """Its length is that of the arc through the middle; with 20 elements its tension is 10 times 12 EI/L^2."""
    radius = (5.0**2 + 2.9**2) / (2 * 2.9)
    length = 2.0 * radius * np.arcsin(5.0 / radius)
    a = brentq(lambda a: 2.0 * a * np.sinh(5.0 / a) - length, 1.0, 100.0)
    prepared = prepare(deck(ROPE.replace("MESH", str(mesh))))
    state, places = follow(prepared).point.state, {n.name: i for i, n in enumerate(prepared.system.nodes)}
    x = prepared.system.numbering.x[places[f"rope.{mesh // 2}"]]
    sag = a * (np.cosh(5.0 / a) - 1.0)
    name = f"rope of {mesh} beams: sag [m]"
    verify("Equilibria", name, -state.z[x + 2], sag, "catenary", relative=tolerance)


def test_a_rope_of_too_long_arcs_is_warned_of():
    """30 EI/L^2 on the chord of 10 m with 10 elements is 0.236 N."""
    (text,) = startup_warnings(prepare(deck(ROPE.replace("MESH", "10"))))
    assert "its weight of 2.4 N exceeds 30 EI/L^2 = 0.236 N" in text and "write 'mesh: 32' or more" in text
    assert not startup_warnings(prepare(deck(ROPE.replace("MESH", "32"))))
    assert not startup_warnings(prepare(deck(ROPE.replace("MESH", "10").replace("via: [5, 0, -2.9], ", ""))))
