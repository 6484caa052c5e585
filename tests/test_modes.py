"""Modes of small motions against closed forms; linearization of moving states against differences."""

import re

import numpy as np
import pytest
import scipy.sparse as sp
from equilibria import G, arm
from scipy.linalg import block_diag, matrix_balance
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from time_runs import INPUTS, deck, input_deck

import mecano
from mecano.analyses.input_channels import place_of
from mecano.analyses.modal import modes
from mecano.analyses.operating_point import operating_point
from mecano.errors import ResultsError, UsageError
from mecano.post.info import info
from mecano.post.pictures import post
from mecano.results.modes_file import read_modes
from mecano.solve.modal.linearize import Linearization, linearize
from mecano.solve.modal.modes import solve
from mecano.solve.modal.modes_dense import EXACT_ZERO, _all, _without_zeros

TIME = "time: {end: 1, step: 1.0e-3}"


def linearized(text, frame=(0.0, 0.0, 0.0)):
    base = operating_point(deck(text))
    prepared = base.prepared
    return linearize(prepared.system, base.state, prepared.length, frame, base.assemble, prepared.compliance)


def values_of(text, frame=(0.0, 0.0, 0.0), number=30, method="dense"):
    found = solve(linearized(text, frame), number, method)
    assert found.residuals.max(initial=0.0) < 1e-9
    return found.values


def row_of_masses(count, damping=0.0, ends=True):
    """Masses of 2 kg between springs of 100 N/m, moving along x only."""
    lines = ["mecano: 1", "gravity: [0, 0, 0]", "nodes:"]
    fixed = (0, count + 1) if ends else ()
    numbers = range(count + 2) if ends else range(1, count + 1)
    for i in numbers:
        lines.append(f"  p{i}: {{position: [{i}, 0, 0]{', fixed: true' if i in fixed else ''}}}")
    lines += ["elements:", *(f"  m{i}: {{type: point_mass, node: p{i}, mass: 2}}" for i in range(1, count + 1))]
    law = f"{{spring: {{stiffness: 100.0}}, damper: {{coefficient: {damping}}}}}"
    lines += [f"  s{i}: {{type: spring_damper, nodes: [p{i}, p{i + 1}], law: {law}}}" for i in numbers[:-1]]
    held = [(i, j) for i in range(1, count + 1) for j in (0, 1)]
    direction = ("[0, 1, 0]", "[0, 0, 1]")
    lines += ["joints:"]
    lines += [
        f"  h{i}_{j}: {{type: prescribed_position, node: p{i}, direction: {direction[j]}, value: 0}}" for i, j in held
    ]
    return "\n".join([*lines, TIME])


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_row_of_masses_dense_and_sparse(damping):
    """omega_j = 2 sqrt(k/m) sin(j pi/(2 n + 2)); damping in proportion to the stiffness, zeta = c omega/(2 k)."""
    count = 60
    lin = linearized(row_of_masses(count, damping))
    omega = 2.0 * np.sqrt(50.0) * np.sin(np.arange(1, 9) * np.pi / (2 * count + 2))
    zeta = damping / 100.0 * omega / 2.0
    expected = omega * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    for method in ("dense", "sparse"):
        found = solve(lin, 8, method)
        assert method in found.method
        np.testing.assert_allclose(found.values, expected, rtol=1e-11)
        np.testing.assert_allclose(found.damping_ratio, zeta, atol=1e-11)
        np.testing.assert_allclose(found.natural_frequency, omega / (2.0 * np.pi), rtol=1e-11)
        assert found.residuals.max() < 1e-11 and set(found.kinds) == {"oscillation"}
        assert np.abs(found.shapes).max(axis=1) == pytest.approx(1.0)


def test_damping_in_proportion_to_the_stiffness_makes_eigenvalues_accumulate():
    """At -1/T, T = 1 ms, where Arnoldi's method does not separate them: the three modes nearer to zero are found.

    Their eigenvalues follow from the undamped frequencies, w (-w T/2 + i sqrt(1 - (w T/2)^2)).
    """
    beam = """
        mecano: 1
        gravity: none
        nodes: {root: {position: [0, 0, 0], fixed: true}, tip: {position: [1, 0, 0]}}
        sections:
          steel: {type: rectangle, width: 4 cm, height: 2 cm, E: 210 GPa, nu: 0.3, density: 7850, damping: DAMPING}
        elements: {beam: {type: beam, nodes: [root, tip], section: steel, up: [0, 0, 1], mesh: 70}}
        time: {end: 1, step: 1 ms}
        """
    w = values_of(beam.replace("DAMPING", "0"), number=3, method="sparse").imag
    found = solve(linearized(beam.replace("DAMPING", "1 ms")), 10, "sparse")
    expected = w * (-0.5e-3 * w + 1j * np.sqrt(1.0 - (0.5e-3 * w) ** 2))
    np.testing.assert_allclose(found.values[:3], expected, rtol=1e-8)
    assert "of 32 eigenvalues: damping makes the others accumulate" in found.method


@pytest.mark.parametrize("method", ["dense", "sparse"])
def test_free_row_has_a_rigid_motion(method):
    """omega_j = 2 sqrt(k/m) sin(j pi/(2 n)), j = 0: all masses move alike."""
    found = solve(linearized(row_of_masses(40, ends=False)), 4, method)
    np.testing.assert_allclose(np.abs(found.values), 2.0 * np.sqrt(50.0) * np.sin(np.arange(4) * np.pi / 80), rtol=1e-9)
    assert found.values[0] == 0.0 and found.kinds[0] == "free" and np.isnan(found.damping_ratio[0])
    np.testing.assert_allclose(found.shapes[0][::3], 1.0, atol=1e-9)


@pytest.mark.parametrize("stiffness, kind", [(4e-18, "free"), (-4e-18, "free"), (1e-12, "oscillation")])
def test_stiffness_that_is_rounding(stiffness, kind):
    """A mass of 200 kg beside a damped oscillator with 1 N/m: 4e-18 N/m is rounding, 1e-12 N/m is not."""
    M, C, K = (sp.csr_matrix(np.diag(d)) for d in ([200.0, 1.0], [0.0, 0.1], [stiffness, 1.0]))
    found = solve(Linearization(M, C, K, 2, np.arange(2), np.ones(2), np.zeros(2, bool)))
    assert found.kinds == [kind, "oscillation"]
    slow = 0.0 if kind == "free" else 1j * np.sqrt(stiffness / 200.0)
    np.testing.assert_allclose(found.values, [slow, -0.05 + 1j * np.sqrt(1.0 - 0.05**2)], rtol=1e-9, atol=1e-15)


def test_damped_oscillator():
    """k = 200 N/m, c = 4 N s/m, m = 2 kg; across the slack spring the mass is free (twice)."""
    found = values_of(input_deck("oscillator").text)
    np.testing.assert_allclose(found, [0, 0, -1 + 1j * np.sqrt(99.0)], atol=1e-9)


@pytest.mark.parametrize("damping", [30.0, 4.0])
def test_overdamped_oscillator_decays_with_two_rates(damping):
    text = arm(TIME, gravity=0.0).replace("{stiffness: 6.0}", f"{{stiffness: 6.0}}, damper: {{coefficient: {damping}}}")
    inertia = 0.1 + 2.0 * 0.25
    roots = np.roots([inertia, damping, 6.0])
    np.testing.assert_allclose(values_of(text), sorted(roots, key=abs), rtol=1e-9)


@pytest.mark.parametrize("more", [0.0, 1e-9, -1e-9])
def test_the_pair_of_an_unstable_equilibrium_is_not_separated(more):
    """Masses of 1 kg pushed by 4 N/m away from equilibrium: 2 and -2 1/s; an oscillator with 25 N/m, 5 rad/s.

    Which of equal moduli is the lowest is decided by rounding, here by a ``more`` of the stiffness of one of them.
    """
    text = f"""
        mecano: 1
        gravity: none
        nodes:
          $x: {{repeat: {{x: [a, b, c]}}, position: [0, 0, 0]}}
        elements:
          mass_$x: {{repeat: {{x: [a, b, c]}}, type: rigid_body, node: $x, mass: 1, inertia: [1, 1, 1]}}
        joints:
          a: {{type: prismatic, nodes: [ground, a], axis: [1, 0, 0], sliding_law: {{linear: {{slope: -4}}}}}}
          b: {{type: prismatic, nodes: [ground, b], axis: [1, 0, 0], sliding_law: {{linear: {{slope: {-4.0 - more}}}}}}}
          c: {{type: prismatic, nodes: [ground, c], axis: [1, 0, 0], sliding_law: {{linear: {{slope: 25}}}}}}
        {TIME}
    """
    for number, wanted in ((1, [2, 2, -2, -2]), (3, [2, 2, -2, -2]), (4, [2, 2, -2, -2]), (5, [2, 2, -2, -2, 5j])):
        np.testing.assert_allclose(values_of(text, number=number), wanted, rtol=1e-8)


def test_double_pendulum():
    """Equal masses on equal massless rods: omega^2 = (2 -+ sqrt 2) g/L, in each of two planes; no spurious modes."""
    text = f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          top: {{position: [0, 0, 0], fixed: true}}
          a: {{position: [0, 0, -0.7]}}
          b: {{position: [0, 0, -1.4]}}
        elements:
          m: {{type: point_mass, node: a, mass: 3}}
          n: {{type: point_mass, node: b, mass: 3}}
        joints:
          r: {{type: rigid_rod, nodes: [top, a]}}
          s: {{type: rigid_rod, nodes: [a, b]}}
        initial: static
        {TIME}
        """
    expected = 1j * np.sqrt(np.array([2 - np.sqrt(2), 2 - np.sqrt(2), 2 + np.sqrt(2), 2 + np.sqrt(2)]) * G / 0.7)
    np.testing.assert_allclose(values_of(text), expected, rtol=1e-9)


def test_redundant_hinges():
    """A flap of 20 kg on two hinges about x: a physical pendulum, m g c/(J + m c^2); dense and sparse agree."""
    text = """
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {low: {position: [0, 0, 0]}, high: {position: [1, 0, 0]}, rim: {position: [0.5, 0, -0.8]}}
        elements:
          flap: {type: rigid_body, node: low, mass: 20, center_of_mass: [0.5, 0, -0.4], inertia: [1, 1, 1],
                 attached: [high, rim]}
        joints:
          a: {type: hinge, nodes: [ground, low], axis: [1, 0, 0]}
          b: {type: hinge, nodes: [ground, high], axis: [1, 0, 0]}
        static: {}
        """
    expected = 1j * np.sqrt(20 * G * 0.4 / (1 + 20 * 0.16))
    for method in ("dense", "sparse"):
        found = values_of(text, number=1, method=method)
        np.testing.assert_allclose(found, [expected], rtol=1e-6 if method == "sparse" else 1e-10)


def massless(between):
    return f"""
        mecano: 1
        gravity: [0, 0, 0]
        nodes:
          wall: {{position: [0, 0, 0], fixed: true}}
          joint: {{position: [1, 0, 0]}}
          end: {{position: [2, 0, 0]}}
        elements:
          m: {{type: point_mass, node: end, mass: 2}}
          a: {{type: spring_damper, nodes: [wall, joint], law: {between}}}
          b: {{type: spring_damper, nodes: [joint, end], law: {{spring: {{stiffness: 100.0}}}}}}
        joints:
          {"".join(f'''
          {n}_{a}: {{type: prescribed_position, node: {n}, direction: {d}, value: 0}}'''
          for n in ("joint", "end") for a, d in (("y", "[0, 1, 0]"), ("z", "[0, 0, 1]"))).strip()}
        {TIME}
        """  # fmt: skip


def test_nodes_without_mass():
    """Springs in series; then a spring and a damper in series (Maxwell): m c s^3 + m k s^2 + k c s = 0."""
    series = values_of(massless("{spring: {stiffness: 300.0}}"))
    np.testing.assert_allclose(series, [1j * np.sqrt(75.0 / 2.0)], rtol=1e-12)
    maxwell = values_of(massless("{damper: {coefficient: 20.0}}"))
    roots = [root for root in np.roots([2.0 * 20.0, 2.0 * 100.0, 100.0 * 20.0, 0.0]) if root.imag >= 0]
    np.testing.assert_allclose(maxwell, sorted(roots, key=abs), atol=1e-9)


def column(load, links_damping=0.0):
    """Ziegler's column: two massless links of 1 m, 2 kg at the knee and 1 kg at the tip, springs of 1 N m/rad."""
    law = f"{{spring: {{stiffness: 1.0}}, damper: {{coefficient: {links_damping}}}}}"
    return f"""
        mecano: 1
        gravity: [0, 0, 0]
        nodes:
          base: {{position: [0, 0, 0]}}
          knee: {{position: [1, 0, 0]}}
          upper: {{position: [1, 0, 0]}}
          tip: {{position: [2, 0, 0]}}
        elements:
          lower_link: {{type: rigid_link, nodes: [base, knee]}}
          upper_link: {{type: rigid_link, nodes: [upper, tip]}}
          m: {{type: point_mass, node: knee, mass: 2}}
          n: {{type: point_mass, node: tip, mass: 1}}
          s: {{type: torsion_spring_damper, nodes: [ground, base], axis: [0, 1, 0], law: {law}}}
          t: {{type: torsion_spring_damper, nodes: [knee, upper], axis: [0, 1, 0], law: {law}}}
        joints:
          h: {{type: hinge, nodes: [ground, base], axis: [0, 1, 0]}}
          i: {{type: hinge, nodes: [knee, upper], axis: [0, 1, 0]}}
        loads:
          p: {{type: follower_force, node: tip, direction: [-1, 0, 0], value: {load!r}}}
        {TIME}
        """


def test_follower_load_leads_to_flutter():
    """Ziegler 1952: without damping the column flutters from P L/c = 7/2 - sqrt 2 on."""
    critical = 3.5 - np.sqrt(2.0)
    for load in (critical - 1e-6, critical + 1e-6):
        found = solve(linearized(column(float(load))))
        K = np.array([[2.0 - load, load - 1.0], [-1.0, 1.0]])
        squares = np.linalg.eigvals(-np.linalg.solve([[3.0, 1.0], [1.0, 1.0]], K)).astype(complex)
        expected = np.sqrt(squares) * np.where(np.sqrt(squares).imag < 0, -1, 1)
        assert len(found.values) == 2 and np.abs(found.values[:, None] - expected).min(axis=0).max() < 1e-8
        assert ("flutter" in found.kinds) == (load > critical)


def top(spin, process=TIME):
    return f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {{pivot: {{position: [0, 0, 0]}}}}
        elements:
          top: {{type: rigid_body, node: pivot, mass: 15, center_of_mass: [0, 0, 1], inertia: [0.3, 0.3, 0.5]}}
        joints: {{ball: {{type: spherical, nodes: [ground, pivot]}}}}
        initial: {{velocities: [{{nodes: [pivot], angular_velocity: {spin}}}]}}
        {process}
        """


def test_a_free_body_that_is_pushed_does_not_flutter():
    """m y'' = F phi, J phi'' = 0: a chain of four zeros, which rounding alone would spread to a circle of 1e-4."""
    found = solve(linearized(f"""
    mecano: 1
    gravity: [0, 0, 0]
    nodes: {{hull: {{position: [0, 0, 0]}}}}
    elements: {{body: {{type: rigid_body, node: hull, mass: 2, inertia: [1, 2, 2.5]}}}}
    loads: {{push: {{type: follower_force, node: hull, direction: [1, 0.5, 0.2], value: 5}}}}
    {TIME}
    """))  # fmt: skip
    assert found.kinds == ["free"] * 4  # three displacements, and the rotation about the push


def test_sleeping_top():
    """Upright top: A s^2 - i C n s - m g l = 0, s = i w; stable from C n = 2 sqrt(A m g l); seen from it, less n."""
    A, C, mgl = 15.3, 0.5, 15 * G
    for n in (150.0, 90.0):
        roots = 1j * np.roots([A, -C * n, mgl])
        found = values_of(top([0, 0, n]))
        assert found[0] == 0.0
        np.testing.assert_allclose(np.sort_complex(found[1:]), np.sort_complex(roots), atol=1e-10)
        turning = values_of(top([0, 0, n]), (0, 0, n))
        np.testing.assert_allclose(sorted(turning[1:].imag), np.sort(n - roots.imag), rtol=1e-12)
    assert 0.5 * 150 < 2 * np.sqrt(A * mgl) < 0.5 * 190 and np.all(np.abs(values_of(top([0, 0, 190.0])).real) < 1e-9)


def test_top_in_steady_precession():
    """Nutation: A w^2 = d^2/dtheta^2 of (p_phi - p_psi cos)^2/(2 A sin^2) + m g l cos, in axes that precess."""
    A, C, mgl, theta, precession = 15.3, 0.5, 15 * G, 0.7, 3.0
    n = (mgl + A * precession**2 * np.cos(theta)) / (C * precession)  # spin about the axis, in full
    axis = np.array([np.sin(theta), 0.0, np.cos(theta)])
    spin = np.array([0, 0, precession]) + (n - precession * np.cos(theta)) * axis
    text = top(spin.tolist()).replace("[0, 0, 0]}", f"[0, 0, 0], orientation: [0, {theta}, 0]}}")
    p_psi, p_phi = C * n, A * precession * np.sin(theta) ** 2 + C * n * np.cos(theta)

    def slope(t):
        b = p_phi - p_psi * np.cos(t)
        return b * p_psi / (A * np.sin(t)) - b * b * np.cos(t) / (A * np.sin(t) ** 3) - mgl * np.sin(t)

    nutation = np.sqrt((slope(theta + 1e-5) - slope(theta - 1e-5)) / 2e-5 / A)
    assert abs(slope(theta)) < 1e-9
    lin = linearized(text, (0, 0, precession))
    assert lin.variation < 1e-5 < 1e-3 < linearized(text).variation
    found = solve(lin)
    assert found.values[-1] == pytest.approx(1j * nutation, rel=1e-8)
    assert np.abs(found.values[:-1]).max() < 1e-4 and found.kinds[-1] == "oscillation"


@pytest.mark.parametrize("w", [250.0, 300.0, 350.0])
def test_rotor_with_internal_damping(w):
    """m z'' + (c_i + c_e) z' + (k - i w c_i) z = 0, stable below sqrt(k/m)(1 + c_e/c_i) = 300 rad/s.

    The axes of the constraints turn with the shaft, the equations do not change.
    """
    text = f"""
        mecano: 1
        gravity: none
        nodes: {{shaft: {{position: [0, 0, 0]}}, disc: {{position: [0, 0, 0]}}}}
        elements:
          hub: {{type: rigid_body, node: shaft, mass: 1, inertia: [0.1, 0.1, 0.1]}}
          disc: {{type: rigid_body, node: disc, mass: 10, inertia: [0.1, 0.1, 0.2]}}
        laws: {{inner: {{spring: 4.0e5, damper: 200}}, outer: {{damper: 100}}}}
        joints:
          bearing: {{type: hinge, nodes: [ground, shaft], axis: [0, 0, 1]}}
          shaft:
            {{type: generic, nodes: [shaft, disc], axis: [0, 0, 1], compliance: {{along_1: inner, along_2: inner}}}}
          air:
            {{type: generic, nodes: [ground, disc], axis: [0, 0, 1], compliance: {{along_1: outer, along_2: outer}},
             free: [along_axis, about_1, about_2, about_axis]}}
        initial: {{velocities: [{{nodes: all, angular_velocity: [0, 0, {w}], about: [0, 0, 0]}}]}}
        {TIME}
        """
    lin = linearized(text)
    assert lin.variation < 1e-8
    roots = np.roots([10.0, 300.0, 4e5 - 200.0j * w])
    found = [value for value in solve(lin, 20).values if value.imag > 100.0]
    answer = np.sort_complex(roots.real + 1j * np.abs(roots.imag))
    np.testing.assert_allclose(np.sort_complex(found), answer, rtol=0, atol=1e-8)


def test_free_body_about_its_middle_axis():
    """Euler: s = n sqrt((I2 - I1)(I3 - I2)/(I1 I3)) for the spin n about the axis of I2, seen from the body."""
    text = f"""
        mecano: 1
        gravity: [0, 0, 0]
        nodes: {{a: {{position: [0, 0, 0]}}}}
        elements: {{body: {{type: rigid_body, node: a, mass: 1, inertia: [1, 2, 3]}}}}
        initial: {{velocities: [{{nodes: [a], angular_velocity: [0, 5, 0]}}]}}
        {TIME}
        """
    found = solve(linearized(text, (0, 5, 0)), 20)
    growth = [value for value, kind in zip(found.values, found.kinds, strict=True) if kind == "divergence"]
    np.testing.assert_allclose(growth, [5.0 * np.sqrt(1.0 / 3.0)], rtol=1e-10)


def perturbed_rates(R, omega, alpha, phi, w, epsilon, t0=1e-3):
    """Rotation, material angular velocity and acceleration of exp(epsilon hat(Q phi)) R, by differences in time."""

    def rotation(t):
        Q = Rotation.from_rotvec(np.array(w) * t)
        turned = Q.apply(phi[0] + t * phi[1] + 0.5 * t * t * phi[2])
        own = Rotation.from_matrix(R) * Rotation.from_rotvec(t * omega + 0.5 * t * t * alpha)
        return Rotation.from_rotvec(epsilon * turned) * own

    def rate(t):
        step = 1e-4
        return sum(c * (rotation(t - k * step).inv() * rotation(t + k * step)).as_rotvec()
                   for k, c in ((1, 8.0), (2, -1.0))) / (12.0 * step)  # fmt: skip

    return rotation(0.0).as_matrix(), rate(0.0), (rate(t0) - rate(-t0)) / (2.0 * t0)


def test_linearization_of_a_moving_state_is_that_of_the_motion():
    """M y'' + C y' + K y is the change of the residual when the whole motion is varied, in axes that turn."""
    text = f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [0.3, 1, 0.2]}}}}
        elements:
          body: {{type: rigid_body, node: a, mass: 2, center_of_mass: [0.2, 0.1, 0.4], inertia: [0.3, 0.5, 0.4]}}
          other: {{type: rigid_body, node: b, mass: 1, inertia: [0.1, 0.2, 0.15]}}
          spring: {{type: spring_damper, nodes: [a, b], law: {{spring: {{stiffness: 40}}, damper: {{coefficient: 3}}}}}}
          wire: {{type: torsion_spring_damper, nodes: [a, b], axis: [1, 2, 0], law: {{spring: {{stiffness: 5.0}}}}}}
        loads: {{push: {{type: follower_force, node: b, direction: [1, 0, 1], value: 3}}}}
        initial:
          velocities:
            - {{nodes: [a], velocity: [1, 2, 3], angular_velocity: [2, -1, 0.7]}}
            - {{nodes: [b], velocity: [-1, 0, 2], angular_velocity: [0.4, 3, -2]}}
        {TIME}
        """
    base = operating_point(deck(text))
    system, s, w = base.prepared.system, base.state, np.array([0.5, -0.8, 1.1])
    of, rng = system.numbering, np.random.default_rng(4)
    lin = linearize(system, s, 1.0, w)
    y = rng.normal(size=(3, system.n))
    expected = lin.K @ y[0] + lin.C @ y[1] + lin.M @ y[2]

    def residual(epsilon):
        new = s.copy()
        f = np.zeros(system.n)
        for x in of.x:
            xi, xi1, xi2 = y[:, x : x + 3]
            new.z[x : x + 3] += epsilon * xi
            new.v[x : x + 3] += epsilon * (xi1 + np.cross(w, xi))
            new.a[x : x + 3] += epsilon * (xi2 + 2 * np.cross(w, xi1) + np.cross(w, np.cross(w, xi)))
        for r, d in zip(of.rotation, of.r, strict=True):
            state = s.R[r], s.v[d : d + 3], s.a[d : d + 3]
            new.R[r], new.v[d : d + 3], new.a[d : d + 3] = perturbed_rates(*state, y[:, d : d + 3], w, epsilon)
        f[:] = system.assemble(new).residual[: system.n]
        for r, d in zip(of.rotation, of.r, strict=True):
            f[d : d + 3] = s.R[r] @ f[d : d + 3]
        return f

    found = (residual(1e-3) - residual(-1e-3)) / 2e-3
    np.testing.assert_allclose(found, expected, rtol=2e-5, atol=2e-5 * np.abs(expected).max())


FLAPPING = {0.0: 3.51602, 1.0: 3.68165, 2.0: 4.13732, 5.0: 6.44954}
"""Lowest flapping frequency of a cantilever that turns about its root, over sqrt(EI/(m L^4)), by its turning over it:
Wright, Smith, Thresher & Wang, J. Appl. Mech. 49 (1982) 197-202."""


@pytest.mark.parametrize("speed", FLAPPING)
def test_beam_that_turns_is_stiffened(speed):
    """Flapping out of the plane as published; in the plane the square is less by that of the turning."""
    text = f"""
        mecano: 1
        gravity: [0, 0, 0]
        sections:
          s: {{type: stiffness, EA: 1.0e5, GA2: 1.0e6, GA3: 1.0e6, EI2: 1, EI3: 1, GJ: 1, mass_per_length: 1,
               rotary_inertia: [1.0e-6, 5.0e-7, 5.0e-7]}}
        nodes: {{root: {{position: [0, 0, 0]}}, tip: {{position: [1, 0, 0]}}}}
        elements:
          hub: {{type: rigid_body, node: root, mass: 1, inertia: [1, 1, 1]}}
          beam: {{type: beam, nodes: [root, tip], section: s, mesh: 16, up: [0, 0, 1]}}
        joints:
          axle: {{type: hinge, nodes: [ground, root], axis: [0, 0, 1]}}
          motor: {{type: prescribed_angle, nodes: [ground, root], axis: [0, 0, 1],
                   value: {{linear: {{slope: {speed}}}}}}}
        initial: {{steady: {{angular_velocity: [0, 0, {speed}], about: [0, 0, 0]}}}}
        {TIME}
        """
    text, found, _ = modes(deck(text), None, number=2, frame="root")
    assert "not constant" not in text and "not an equilibrium" not in text
    flapping = FLAPPING[speed]
    expected = sorted([flapping, np.sqrt(flapping**2 - speed**2)])
    np.testing.assert_allclose(found.values.imag, expected, rtol=5e-4)
    assert np.abs(found.values.real).max() < 1e-6


WIRE = """
    mecano: 1
    gravity: none
    sections: {wire: {type: circle, diameter: 1 mm, E: 200 GPa, nu: 0.3, density: 7800}}
    nodes: {a: {position: [0, 0, 0], fixed: true}, b: {position: [1, 0, 0]}}
    elements: {wire: {type: beam, nodes: [a, b], section: wire, mesh: MESH}}
    joints: {b: {type: prismatic, nodes: [ground, b], axis: [1, 0, 0]}}
    loads: {pull: {type: force, node: b, direction: [1, 0, 0], value: 100}}
    static: {}
    """


def wire_frequencies():
    """First four [1/s] of a clamped Euler-Bernoulli beam, EI k^4 + T k^2 = m omega^2 for its wave numbers k."""
    area, EI, T = np.pi * 2.5e-7, 200e9 * np.pi * 0.5e-3**4 / 4, 100.0
    m = 7800 * area

    def determinant(omega):
        half, square = T / (2 * EI), np.sqrt((T / (2 * EI)) ** 2 + m * omega**2 / EI)
        waves, fades = np.sqrt(square - half), np.sqrt(square + half)
        edges = 2.0 * waves * fades * (1.0 / np.cosh(fades) - np.cos(waves))
        return edges + (fades**2 - waves**2) * np.sin(waves) * np.tanh(fades)

    grid = np.arange(10.0, 2000.0, 10.0)
    changes = [(a, b) for a, b in zip(grid, grid[1:], strict=False) if determinant(a) * determinant(b) < 0.0]
    return np.array([brentq(determinant, a, b) for a, b in changes[:4]])


@pytest.mark.parametrize(("mesh", "tolerance"), [(10, 0.015), (40, 2e-5)])
def test_stretched_wire_of_beams(mesh, tolerance):
    """The tension of 100 N is 8.5 times 12 EI/L^2 of the ten elements, more than their sections stand up to alone."""
    found = values_of(WIRE.replace("MESH", str(mesh)), number=8)
    np.testing.assert_allclose(found.imag, np.repeat(wire_frequencies(), 2), rtol=tolerance)
    np.testing.assert_allclose(found.real, 0.0, atol=1e-6)


def with_velocity_constraint(stiffness, a=0.7, b=0.9):
    """x'' + k x + b y = 0 with y' + a x = 0, whose multiplier acts on y: s^3 + k s - a b = 0."""
    M, C, K = np.diag([1.0, 1.0, 0.0]), np.zeros((3, 3)), np.zeros((3, 3))
    K[0, :2], K[1, 2], K[2, 0], C[2, 1] = (stiffness, b), -1.0, -a, -1.0
    return M, C, K


@pytest.mark.parametrize("method", ["dense", "sparse"])
def test_constraints_on_velocities(method):
    stiffness = np.linspace(1.0, 9.0, 12)
    parts = [with_velocity_constraint(k) for k in stiffness]
    order = np.concatenate([np.delete(np.arange(36), np.arange(2, 36, 3)), np.arange(2, 36, 3)])
    M, C, K = (sp.csr_matrix(block_diag(*(part[i] for part in parts))[np.ix_(order, order)]) for i in range(3))
    lin = Linearization(M, C, K, 24, np.arange(24) // 2, np.ones(24), np.zeros(24, bool))
    expected = np.concatenate([np.roots([1.0, 0.0, k, -0.63]) for k in stiffness])
    expected = np.array(sorted(expected[expected.imag >= 0.0], key=abs))
    count = 24 if method == "dense" else 5
    found = solve(lin, count, method)
    np.testing.assert_allclose(np.sort_complex(found.values[:count]), np.sort_complex(expected[:count]), rtol=1e-8)
    assert found.residuals.max() < 1e-9


def test_buckling_by_modes():
    """The frequency of the inverted pendulum: (k - mu m g c)/(J + m c^2); beyond buckling it diverges."""
    inertia = 0.1 + 2.0 * 0.25
    for factor in (0.3, 0.6, 0.7):
        found = values_of(arm(f"static: {{end: {factor}}}", centre="[0, 0, 0.5]"))
        square = (6.0 - factor * 2.0 * G * 0.5) / inertia
        expected = [1j * np.sqrt(square)] if square > 0 else [-np.sqrt(-square), np.sqrt(-square)]
        np.testing.assert_allclose(np.sort_complex(found), expected, rtol=1e-8)


def test_about_a_saved_time(tmp_path):
    """A pendulum that passes the angle theta from the vertical: s^2 = -(g/L) cos(theta), at any speed."""
    from mecano.analyses.dynamic import run

    pendulum = input_deck("pendulum", "time.end=0.4")
    run(pendulum, tmp_path / "p.h5")
    base = operating_point(pendulum, f"{tmp_path / 'p.h5'}:0.25")
    R = base.state.R[base.prepared.system.numbering.rotation[0]]
    assert base.words.endswith("at time 0.25 s") and np.abs(base.state.v).max() > 1.0
    lin = linearize(base.prepared.system, base.state, 1.0)
    np.testing.assert_allclose(solve(lin).values, [1j * np.sqrt(-G * R[2, 0])], rtol=1e-9)
    for text, error in (("p.h5:x", UsageError), ("q.h5:1", ResultsError)):
        with pytest.raises(error):
            operating_point(pendulum, str(tmp_path / text))
    with pytest.raises(ResultsError, match="has no node 'hook'"):
        operating_point(input_deck("oscillator"), str(tmp_path / "p.h5"))


def test_held_values_at_a_saved_time(tmp_path):
    """A delay and a sampled value read their inputs between the saved times; the motor accelerates the cart by them."""
    changes = {"output.every": 0.13, "time.end": 0.8}
    checked = input_deck("digital_control", *(f"{name}={value}" for name, value in changes.items()))
    with mecano.run(INPUTS / "digital_control.yaml", tmp_path / "d.h5", set=changes, quiet=True) as r:
        for row in (3, 6):
            base = operating_point(checked, f"{tmp_path / 'd.h5'}:{r.time[row]}")
            system, s = base.prepared.system, base.state
            for name in ("position", "command"):
                assert s.z[place_of(system, name)[0]] == r[f"signals.{name}.value"].values[row]
            cart = system.numbering.x[[node.name for node in system.nodes].index("cart")]
            assert s.a[cart] == pytest.approx(r["command.value"].values[row] / 2.0, rel=1e-9)


def test_about_a_saved_equilibrium(tmp_path):
    from mecano.analyses.static import run

    text = arm("static: {steps: 5}")
    run(deck(text), tmp_path / "a.h5")
    base = operating_point(deck(text), f"{tmp_path / 'a.h5'}:0.6")
    lin = linearize(base.prepared.system, base.state, 1.0, assemble=base.assemble)
    angle = np.arctan2(*base.state.R[base.prepared.system.numbering.rotation[0]][0, [2, 0]])
    expected = np.sqrt((6.0 + 0.6 * 2.0 * G * 0.5 * np.sin(angle)) / 0.6)
    np.testing.assert_allclose(solve(lin).values, [1j * expected], rtol=1e-8)


def test_modes_of_a_string_are_named_by_the_displacements_of_its_antinodes():
    """Rotations of the shape sin(k pi x/L) are k pi/L times the displacement, so L times these is always larger."""
    text = """
        mecano: 1
        gravity: none
        nodes: {left: {position: [0, 0, 0], fixed: true}, right: {position: [10, 0, 0]}}
        sections: {steel: {type: circle, diameter: 2 mm, E: 210 GPa, nu: 0.3, density: 7850 kg/m3}}
        elements: {wire: {type: beam, nodes: [left, right], section: steel, mesh: 20}}
        joints: {rail: {type: prismatic, nodes: [ground, right], axis: [1, 0, 0]}}
        loads: {pull: {type: force, node: right, direction: [1, 0, 0], value: 500 N}}
        initial: static
        time: {end: 1, step: 0.01}
        """
    lines = modes(deck(text), None, number=6)[0].splitlines()[2:8]
    for k, line in zip((1, 1, 2, 2, 3, 3), lines, strict=True):
        named = re.findall(r"node 'wire\.(\d+)' moves along \[0, ", line)
        assert len(named) == 2
        assert all(abs(np.sin(k * np.pi * int(i) / 20)) > 0.95 for i in named)


def test_signals_in_small_units_do_not_hide_the_motion_of_a_mode():
    """A mass on a spring of 100 N/m made of a signal in pm, which a filter reads: one mode each of mass and filter."""
    text = f"""
        mecano: 1
        gravity: none
        nodes: {{cart: {{position: [0, 0, 0]}}}}
        elements: {{mass: {{type: rigid_body, node: cart, mass: 1, inertia: [1, 1, 1]}}}}
        joints: {{rail: {{type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}}}
        signals:
          picometres: 1.0e12*rail.displacement
          seen: {{type: lag, input: picometres, time_constant: 0.5}}
        loads: {{pull: {{type: joint_force, joint: rail, value: -1.0e-10*picometres}}}}
        {TIME}
        """
    text, found, _ = modes(deck(text), None, number=5)
    np.testing.assert_allclose(found.values, [-2.0, 10.0j], rtol=1e-9)
    decay, oscillation = text.splitlines()[2:4]
    assert "lag 'seen'" in decay and oscillation.endswith("node 'cart' moves along [1, 0, 0]")


@pytest.mark.parametrize("volume", [1e-4, 1e-7])
@pytest.mark.parametrize("order", [1, -1])
def test_a_hydraulic_cylinder(volume, order):
    """The cylinder of inputs/servo_valve.yaml, also with small chambers, and with its signals in the other order.

    Pressures grow at p_a' = B (w_a - A v)/(V + A x) and p_b' = B (A v - w_b)/(V - A x), with flows w = q u sqrt(p), at
    p = 10.5 MPa of each, and an opening u = g (0.05 - x); m v' = A (p_a - p_b).
    """
    bulk, area, mass, flow, pressure, gain = 1.4e9, 1e-3, 100.0, 1.5e-7, 1.05e7, 19.0
    through = 0.05 * gain * flow * np.sqrt(pressure)
    by_opening, by_volume, by_v, by_p = (
        bulk / volume * np.array([through / 0.05, through * area / volume, area, through / (2.0 * pressure)])
    )
    exact = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, area / mass, -area / mass],
            [-by_opening - by_volume, -by_v, -by_p, 0.0],
            [by_opening - by_volume, by_v, 0.0, -by_p],
        ]
    )
    exact = np.linalg.eigvals(matrix_balance(exact)[0])
    cylinder = input_deck("servo_valve", f"parameters.volume={volume}", f"parameters.gain={gain}")
    cylinder.values["signals"] = dict(list(cylinder.values["signals"].items())[::order])
    _, found, _ = modes(cylinder, None)
    assert found.residuals.max() < 1e-9
    exact = exact[exact.imag >= 0.0]
    np.testing.assert_allclose(found.values, exact[np.argsort(np.abs(exact))], rtol=1e-8)


def test_table_and_file(tmp_path, monkeypatch):
    path = tmp_path / "m.h5"
    text, found, _ = modes(deck(row_of_masses(4)), path, number=3)
    lines = text.splitlines()
    assert lines[0] == (
        "modes about: initial state; dense, undamped; 4 computed, 3 of them shown (--number, in Python number=)"
    )
    assert len(lines) == 5
    assert "node 'p2' moves along [1, 0, 0]" in lines[2] and lines[2].split()[0] == "1"
    assert float(lines[2].split()[1]) == pytest.approx(found.frequency[0], rel=1e-5)
    file = read_modes(path)
    np.testing.assert_array_equal(file.values, found.values)
    np.testing.assert_allclose(file.nodes["p1"]["translation"][:, 0], found.shapes[:, 0])
    np.testing.assert_array_equal(file.nodes["p0"]["translation"], 0.0)
    assert file.kinds == ["oscillation"] * 3 and file.resolved["gravity"] == [0, 0, 0]
    with monkeypatch.context() as patched, pytest.raises(ResultsError, match="already exists"):
        computed = pytest.fail
        patched.setattr("mecano.analyses.modal.operating_point", lambda *_: computed("before it was refused"))
        modes(deck(row_of_masses(4)), path)
    with pytest.raises(UsageError, match="there is no node 'q'"):
        modes(deck(row_of_masses(4)), None, frame="q")
    for frame in ("1,2,nan", "inf,0,0", "1e300,0,0"):
        with pytest.raises(UsageError, match="out of range"):
            modes(deck(row_of_masses(4)), None, frame=frame)
    for time in ("nan", "inf", "-inf", "soon"):
        with pytest.raises(UsageError, match="cannot be understood; write results.h5:time"):
            modes(deck(row_of_masses(4)), None, at=f"results.h5:{time}")


def test_info_of_a_file_of_modes(tmp_path):
    modes(deck(row_of_masses(4)), tmp_path / "m.h5", number=3)
    text = info(tmp_path / "m.h5")
    frequency = read_modes(tmp_path / "m.h5").numbers["frequency"][1]
    assert "about       initial state" in text and "dense, undamped; 4 computed" in text
    assert text.splitlines()[-4].split()[:2] == ["2", f"{frequency:.6g}"] and "shapes of 6 nodes" in text


def test_pictures(tmp_path):
    from mecano.post.pictures import draw_alone

    modes(deck(column(1.0)), tmp_path / "c.h5")
    picture = draw_alone(tmp_path / "c.h5")
    assert picture == tmp_path / "c.png" and picture.stat().st_size > 10_000
    with pytest.raises(ResultsError, match="is not a file of modes|is not a results file"):
        read_modes(picture)


@pytest.mark.parametrize(("slowest", "zeros"), [(-1.0, 1), (-3e-9, 0)])
def test_a_chain_of_zeros_that_rounding_perturbs(slowest, zeros):
    """It has the eigenvalue zero if a gap separates it from all others; else it may be a slow motion beside them."""
    values = [slowest, -2.0, -3.0, -4.0, -5.0, -6.0]
    Q = np.linalg.qr(np.random.default_rng(1).normal(size=(8, 8)))[0]
    A = Q @ block_diag([[0.0, 1.0], [5e-13, 0.0]], np.diag(values)) @ Q.T
    found, _ = _without_zeros(A, np.eye(8), EXACT_ZERO * np.linalg.norm(A, 2), _all)
    assert np.count_nonzero(found == 0.0) == zeros
    np.testing.assert_allclose(np.sort(found.real)[:5], np.sort(values)[:5], rtol=1e-12)
    assert len(found) == (7 if zeros else 8)  # generalized eigenvectors are not returned


def test_the_title_of_a_picture_names_what_turns_only(tmp_path):
    """A twisting shaft of two discs, and a row of masses that moves along itself."""
    from mecano.post.mode_shapes import _title

    shaft = f"""
        mecano: 1
        gravity: none
        nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [1, 0, 0]}}}}
        sections: {{rod: {{type: circle, diameter: 10 mm, E: 210 GPa, nu: 0.3, density: 7850}}}}
        elements:
          one: {{type: rigid_body, node: a, mass: 1, inertia: [0.2, 90, 90]}}
          two: {{type: rigid_body, node: b, mass: 1, inertia: [0.1, 90, 90]}}
          rod: {{type: beam, nodes: [a, b], section: rod, up: [0, 0, 1]}}
        joints: {{bearing: {{type: hinge, nodes: [ground, a], axis: [1, 0, 0]}}}}
        {TIME}
        """
    modes(deck(shaft), tmp_path / "s.h5")
    file = read_modes(tmp_path / "s.h5")
    titles = [_title(file, i) for i in range(len(file.values))]
    twist = np.sqrt(80.8e9 * np.pi * 0.01**4 / 32 * (1 / 0.2 + 1 / 0.1)) / (2 * np.pi)
    assert titles[0] == "mode 1: free"
    [turning] = [i for i, title in enumerate(titles) if title.endswith(", b turns")]
    assert file.numbers["frequency"][turning] == pytest.approx(twist, rel=1e-3)
    modes(deck(row_of_masses(4)), tmp_path / "r.h5")
    assert not any("turns" in _title(read_modes(tmp_path / "r.h5"), i) for i in range(4))


@pytest.mark.parametrize(
    ("options", "named"), [({"at": "1"}, "--at"), ({"columns": True, "title": "t"}, "--csv, --title")]
)
def test_options_of_runs_are_refused(tmp_path, options, named):
    modes(deck(column(1.0)), tmp_path / "c.h5")
    with pytest.raises(
        UsageError,
        match=f"c.h5 is a file of modes, of a response, of margins, of a sweep or of a study: {named} for results",
    ):
        list(post([tmp_path / "c.h5"], **options))
    assert [path.name for path in tmp_path.iterdir()] == ["c.h5"]


def test_released_joints_are_not_drawn(tmp_path):
    """The clamp of the deck is released at 0.3 s, the hinge at about 0.375 s."""
    from mecano.analyses.dynamic import run
    from mecano.post.mode_shapes import mode_sketches
    from mecano.post.runs import open_runs
    from mecano.post.sketch import sketch

    falling = input_deck("release", "time.end=0.36")
    run(falling, tmp_path / "r.h5")
    (opened,) = open_runs([tmp_path / "r.h5"])
    found = sketch(opened)
    shown = {shape.name: [shape.is_shown(i) for i in range(len(found.times))] for shape in found.shapes}
    assert shown["clamp"] == list(found.times <= 0.3) and not all(shown["clamp"]) and all(shown["hinge"])
    for time, released in ((0.2, set()), (0.36, {"fixed 'clamp'"})):
        modes(falling, tmp_path / "m.h5", at=f"{tmp_path / 'r.h5'}:{time}", force=True)
        file = read_modes(tmp_path / "m.h5")
        hidden = {shape.name for shape in mode_sketches(file)[0].shapes if not shape.is_shown(0)}
        assert file.released == released and hidden == ({"clamp"} if released else set())


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3, 1e5])
def test_poles_of_a_control_loop_do_not_depend_on_the_units_of_its_signals(scale, tmp_path):
    """The servo of inputs/position_servo.yaml with mass, gains and limits multiplied by a factor has the same poles.

    That is m s^2 (T s + 1) = -(K_P + K_I/s + K_D s/(T_D s + 1)), in ascending powers.
    """
    text = f"""
    mecano: 1
    gravity: none
    nodes: {{cart: {{position: [0, 0, 0]}}}}
    elements: {{body: {{type: rigid_body, node: cart, mass: {2 * scale}, inertia: [0.1, 0.1, 0.1]}}}}
    joints: {{rail: {{type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}}}
    signals:
      command: {{type: pid, input: 0 - rail.displacement, proportional: {80 * scale}, integral: {60 * scale},
        derivative: {20 * scale}, derivative_time: 0.02}}
      thrust: {{type: lag, input: command, time_constant: 0.01}}
    loads: {{motor: {{type: joint_force, joint: rail, value: thrust}}}}
    time: {{end: 1, step: 1 ms}}
    """
    found = modes(deck(text), None)[1]
    filtered = np.polynomial.Polynomial([1, 0.02])
    controller = np.polynomial.Polynomial([60, 80]) * filtered + np.polynomial.Polynomial([0, 0, 20])
    loop = np.polynomial.Polynomial([0, 0, 0, 2]) * np.polynomial.Polynomial([1, 0.01]) * filtered + controller
    expected = sorted(loop.roots(), key=abs)
    np.testing.assert_allclose(np.sort_complex(found.values), np.sort_complex(np.array(expected)), rtol=1e-7)
    assert found.converged.all()


def test_filters_of_a_mechanism_that_is_driven_have_poles():
    """Nothing has inertia but what is held or driven: poles of lags are -1/T, of an integrator 0."""
    found = values_of("""
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {crank: {position: [0, 0, 0]}}
    elements: {body: {type: rigid_body, node: crank, mass: 1, center_of_mass: [1, 0, 0], inertia: [1, 1, 1]}}
    joints:
      pin: {type: hinge, nodes: [ground, crank], axis: [0, 1, 0]}
      motor: {type: prescribed_angle, nodes: [ground, crank], axis: [0, 1, 0], value: 2*time}
    signals:
      measured: {type: lag, input: motor.moment, time_constant: 0.1}
      smooth: {type: lag, input: measured, time_constant: 0.2}
      sum: {type: integrator, input: measured}
    time: {end: 1, step: 0.01}
    """)
    np.testing.assert_allclose(np.sort(found.real), [-10, -5, 0], atol=1e-12)
    assert not found.imag.any()


ROTOR = """
    mecano: 1
    gravity: none
    parameters: {omega: 30, e: 0.3, l: 4.7}
    nodes:
      hub: {position: [0, 0, 0]}
      arm: {position: [$e, 0, 0]}
      root: {position: [$e, 0, 0]}
    elements:
      hub: {type: rigid_body, node: hub, attached: [arm], mass: 20, inertia: [1, 1, 1]}
      blade: {type: rigid_body, node: root, mass: 30, center_of_mass: [$l/2, 0, 0],
              inertia: [1.0e-3, 2.5*$l**2, 2.5*$l**2]}
    joints:
      shaft: {type: hinge, nodes: [ground, hub], axis: [0, 0, 1]}
      drive: {type: prescribed_angle, nodes: [ground, hub], axis: [0, 0, 1], value: {linear: {slope: $omega}}}
      flap: {type: hinge, nodes: [arm, root], axis: [0, 1, 0]}
    initial: {velocities: [{nodes: all, angular_velocity: [0, 0, $omega], about: [0, 0, 0]}]}
    time: {end: 1, step: 0.001}
"""


def test_a_flapping_blade_in_the_axes_of_its_hub(verify):
    """The axes turn with the reactions, some of which have inertial components: the equations are constant there."""
    text, found, _ = modes(deck(ROTOR), None, frame="hub")
    known = 30.0 * np.sqrt(1.0 + 1.5 * 0.3 / 4.7 - 1e-3 / (10.0 * 4.7**2))
    verify("Modes", "flapping blade [rad/s]", found.values.imag, [known], "uniform blade on a hinge", relative=1e-9)
    assert "not constant" not in text
    assert "not constant" in modes(deck(ROTOR), None)[0]


HANGING = """
mecano: 1
gravity: [0, 0, -9.81]
nodes: {mass: {position: [0, 0, 0]}}
elements: {mass: {type: point_mass, node: mass, mass: 1}}
joints: {rail: {type: prismatic, nodes: [ground, mass], axis: [0, 0, 1], sliding_law: {spring: 4}}}
time: {end: 1, step: 1.0e-3}
"""
LATE = "signals: {late: {type: delay, input: rail.displacement, time: 0.5}}"
BACK = "loads: {back: {type: joint_force, joint: rail, value: -1.5*late}}"


def test_a_start_out_of_balance_is_reported_and_an_equilibrium_is_not():
    out_of_balance = "not an equilibrium"
    assert out_of_balance in modes(deck(HANGING), None)[0]
    assert out_of_balance not in modes(deck(f"{HANGING}initial: static"), None)[0]
    filtered = "signals: {slow: {type: lag, input: 1, time_constant: 1}}"  # which moves, but no body does
    assert out_of_balance in modes(deck(f"{HANGING}{filtered}"), None)[0]


def test_the_rounding_of_members_without_loads_is_in_balance():
    """An oblique beam, whose axial strain is known to 1e-16."""
    text = f"""
        mecano: 1
        gravity: none
        sections:
          s: {{type: stiffness, EA: 1.0e9, GA2: 4.0e8, GA3: 4.0e8, GJ: 1.0e6, EI2: 1.0e6, EI3: 1.3e6,
            mass_per_length: 10, rotary_inertia: [0.01, 0.005, 0.005]}}
        nodes: {{root: {{position: [1.37, 2.13, 0.71], fixed: true}}, tip: {{position: [4.771, 3.317, 2.177]}}}}
        elements: {{beam: {{type: beam, nodes: [root, tip], section: s, up: [0.3, -1, 0.2], mesh: 8}}}}
        {TIME}
        """
    assert "not an equilibrium" not in modes(deck(text), None)[0]


SPINNING = f"""
    mecano: 1
    gravity: none
    nodes: {{hub: {{position: [1, 0, 2]}}, tip: {{position: [OFFSET, 0, 2]}}, ball: {{position: [OFFSET, 0, 2]}}}}
    elements:
      hub: {{type: rigid_body, node: hub, mass: 1, inertia: [1, 1, 1]}}
      tip: {{type: point_mass, node: tip, mass: 1}}
      ball: {{type: rigid_body, node: ball, mass: 1.0e-9, inertia: [1.0e-9, 1.0e-9, 1.0e-9]}}
      spring: {{type: spring_damper, nodes: [hub, tip], law: {{spring: 1000}}}}
    joints:
      axle: {{type: hinge, nodes: [ground, hub], axis: [0, 0, 1]}}
      guide: {{type: prismatic, nodes: [hub, tip], axis: [1, 0, 0]}}
      joint: {{type: spherical, nodes: [tip, ball]}}
    initial: {{velocities: [{{nodes: all, angular_velocity: [0, 0, 10], about: [1, 0, 2]}}]}}
    {TIME}
    """


NOT_STEADY = "the start is not steady: the nodes 'hub', 'tip', 'ball' turn as one body, which begins to deform"


@pytest.mark.parametrize(
    ("frame", "reported"), [("hub", "not an equilibrium"), ("0,0,10", "not an equilibrium"), ("inertial", NOT_STEADY)]
)
def test_a_turning_start_without_its_centrifugal_forces_is_reported(frame, reported):
    """The spring is not stretched at first; in axes in which the state moves, what it should be is not known."""
    text = modes(deck(SPINNING.replace("OFFSET", "2")), None, frame=frame)[0]
    assert reported in text and "write 'initial: {steady: {angular_velocity: " in text


@pytest.mark.parametrize(("spring", "pull", "reported"), [(1000, 5, True), (1000, 0, False), (0, 5, False)])
def test_bodies_that_move_together_are_reported_if_they_strain_what_connects_them(spring, pull, reported):
    """Two masses on a spring, or apart, of which one is pulled."""
    text = f"""
        mecano: 1
        gravity: none
        nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [1, 0, 0]}}}}
        elements:
          a: {{type: point_mass, node: a, mass: 1}}
          b: {{type: point_mass, node: b, mass: 2}}
          spring: {{type: spring_damper, nodes: [a, b], law: {{spring: {spring or "0.0"}}}}}
        loads: {{pull: {{type: force, node: b, value: {pull}, direction: [1, 0, 0]}}}}
        initial: {{velocities: [{{nodes: all, velocity: [0, 3, 0]}}]}}
        {TIME}
        """
    found = modes(deck(text), None)[0]
    assert ("the start is not steady: the nodes 'a', 'b' move as one body" in found) == reported


@pytest.mark.parametrize("reported", [True, False])
def test_a_turning_start_on_a_pylon_that_does_not_turn_is_reported(reported):
    """At the offset 1.5 m with a natural length of 0.45 m the spring bears the centrifugal force m r w^2 = 50 N."""
    text = SPINNING.replace("[ground, hub]", "[pylon, hub]").replace(
        "nodes: {", "nodes: {pylon: {position: [1, 0, 2]}, "
    )
    text = text.replace("joints:", "joints:\n      pylon: {type: generic, nodes: [ground, pylon], axis: [0, 0, 1], "
                        "compliance: {about_axis: {spring: 1.0e4}}}")  # fmt: skip
    text = text.replace("velocities: [", "velocities: [{nodes: [pylon], angular_velocity: [0, 0, -10]}, ")
    if not reported:
        text = text.replace("OFFSET", "1.5").replace("spring: 1000}", "spring: 1000}, natural_length: 0.45")
    found = modes(deck(text.replace("OFFSET", "2")), None, frame="hub")[0]
    assert ("the start is not an equilibrium" in found and "write 'initial: {steady: {" in found) == reported


def test_a_turning_start_that_is_steady_is_not_reported():
    """The mass at the end of the guide, stretched by m w^2 (L + u) = k u: u = L/9."""
    stretched = SPINNING.replace("OFFSET", f"{1 + 10 / 9:.16g}").replace(
        "{spring: 1000}}", "{spring: 1000}, natural_length: 1}"
    )
    assert "not an equilibrium" not in modes(deck(stretched), None, frame="hub")[0]
    assert "not steady" not in modes(deck(stretched), None)[0]


def test_feedback_through_a_delay_is_reported_as_missing():
    """With it the motion x'' + 4 x + 1.5 x(t - 0.5) = 0 grows; the modes are those of x'' + 4 x = 0."""
    text, found, _ = modes(deck(f"{HANGING}{LATE}\n{BACK}"), None)
    assert "delay 'late': modes take these values as constant" in text
    assert found.values[-1] == pytest.approx(2.0j, rel=1e-9)


@pytest.mark.parametrize("method", ["dense", "sparse"])
def test_a_slender_boom_that_is_not_parallel_to_an_axis_bends(method):
    """First mode of a cantilever of slenderness 5000, 3.51602 r c/(2 L^2) of a round rod; it was called free."""
    rod = "{type: circle, diameter: 4 mm, E: 70 GPa, nu: 0.3, density: 2700}"
    found = values_of(
        f"""
        mecano: 1
        gravity: none
        sections: {{rod: {rod}}}
        nodes: {{root: {{position: [0, 0, 0], fixed: true}}, tip: {{position: [3, 4, 5]}}}}
        elements: {{boom: {{type: beam, nodes: [root, tip], section: rod, mesh: 20}}}}
        {TIME}
        """,
        number=2,
        method=method,
    )
    expected = 3.51602 * 2e-3 * np.sqrt(70e9 / 2700) / (2 * 50.0)
    np.testing.assert_allclose(found, 1j * expected, rtol=1e-5)


def test_a_buckled_blade_diverges_in_any_direction():
    """Beyond its critical load, turned about the vertical; the rate of growth is that along x."""
    tips = [1, 0, 0], [0.6, 0.8, 0]
    along, turned = (modes(input_deck("lateral_buckling", f"nodes.tip.position={tip}"), None)[1] for tip in tips)
    assert along.kinds.count("divergence") == turned.kinds.count("divergence") == 1
    assert max(turned.values.real) == pytest.approx(max(along.values.real), rel=1e-5)


FLOATING = """
    mecano: 1
    gravity: none
    sections:
      mast: {type: tube, diameter: 60 mm, thickness: 1 mm, E: 70 GPa, nu: 0.3, density: 2700, damping: DAMPING}
    nodes: {bus: {position: [0, 0, 0]}, tip: {position: [10, 0, 0]}}
    elements:
      bus: {type: rigid_body, node: bus, mass: 400, inertia: [100, 120, 140]}
      tip: {type: rigid_body, node: tip, mass: 5, inertia: [0.1, 0.2, 0.3]}
      mast: {type: beam, nodes: [bus, tip], section: mast, up: [0, 0, 1], mesh: MESH}
    time: {end: 1, step: 1 ms}
"""


@pytest.mark.parametrize("mesh", [8, 20])
def test_modes_of_a_free_satellite_by_sparse_matrices_are_those_of_dense_ones(mesh):
    """The inverses of the eigenvalues, which ARPACK finds, differ by 1e5 between free motions and vibrations."""
    lin = linearized(FLOATING.replace("MESH", str(mesh)).replace("DAMPING", "0.1 ms"))
    found, exact = (solve(lin, 14, method) for method in ("sparse", "dense"))
    assert found.method.startswith("sparse") and found.kinds == ["free"] * 6 + ["oscillation"] * 8
    assert found.residuals.max() < 1e-6
    np.testing.assert_allclose(found.values[6:], exact.values[6:], rtol=1e-6)


def test_free_motions_of_a_large_satellite_are_converged():
    """With 600 motions the rotation about the mast, which is soft in torsion, was mixed with strains."""
    found = solve(linearized(FLOATING.replace("MESH", "100").replace("DAMPING", "1 us")), 8)
    assert found.method.startswith("sparse") and found.kinds == ["free"] * 6 + ["oscillation"] * 2
    assert found.converged.all()


@pytest.mark.parametrize(
    ("set_point", "polynomial"),
    [
        ("2 + 0.1*time", (2.0, 6.0, 400.0)),  # m s² + c s + k
        ("2 - 0.5*rail.displacement", (2.0, 9.0, 600.0)),  # m s² + (1 + g)(c s + k)
        ("2 - 0.05*rail.velocity", (2.3, 26.0, 400.0)),  # m s² + (1 + g s)(c s + k)
    ],
)
def test_a_damper_with_a_set_point_that_moves(set_point, polynomial):
    """Rates of set points act on dampers. The body that is free beside it keeps its eigenvalues, which are zero."""
    text = f"""
        mecano: 1
        gravity: none
        nodes: {{wall: {{position: [-2, 0, 0], fixed: true}}, a: {{position: [0, 0, 0]}}, b: {{position: [0, 1, 0]}}}}
        elements:
          body: {{type: point_mass, node: a, mass: 2}}
          free: {{type: rigid_body, node: b, mass: 3, inertia: [1, 2, 2]}}
          spring: {{type: spring_damper, nodes: [wall, a], law: {{spring: 400, damper: 6}}, natural_length: wanted}}
        joints:
          rail: {{type: prismatic, nodes: [ground, a], axis: [1, 0, 0]}}
        signals: {{wanted: {set_point}}}
        {TIME}
        """
    found = values_of(text)
    assert np.all(found[:-1] == 0.0)
    assert len(found) == 7
    assert found[-1] == pytest.approx(max(np.roots(polynomial), key=lambda s: s.imag), rel=1e-12)
