"""Modes of a body that rubs on a moving belt: friction follows the reaction, and makes it flutter, as a brake squeals.

The body, of the mass m and the moment of inertia J, is held by springs and touches the belt at the point (r_x, r_z)
from its centre of mass. With the reaction N = N_0 + n of the belt, friction mu N along it, and small displacements x
and rotations t about y, by which the centre rises by r_x t,

    n = m r_x t'' + k_z r_x t
    m x'' + k_x x + k_xt t - mu n = 0
    J t'' + k_xt x + k_t t + (r_x - mu r_z) n + (mu r_x + r_z) N_0 t = 0

as in the minimal model of mode coupling of N. Hoffmann et al., Int. J. Mech. Sci. 44 (2002), whose matrices are
not symmetric either.
"""

import numpy as np
import pytest
from time_runs import deck

from mecano.analyses.modal import modes

MASS, INERTIA, R_X, R_Z, FRICTION = 2.0, 0.03, 0.08, -0.1, 0.6  # kg, kg m2, m, m
K_X, K_Z, K_T, LOAD = 9e3, 2e4, 20.0, 2.0 * 9.81  # N/m, N/m, N m/rad, N


def rubbing(coupling):
    """The deck; dead loads balance the weight's moment and the friction, so the body is at rest."""
    springs = np.diag([K_X, 1e4, K_Z, 100.0, K_T, 100.0])
    springs[0, 4] = springs[4, 0] = coupling
    return deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          belt: {{position: [0, 0, 0]}}
          body: {{position: [0, 0, {-R_Z}]}}
          pad: {{position: [{R_X}, 0, 0]}}
        elements:
          belt: {{type: rigid_body, node: belt, mass: 1, inertia: [1, 1, 1]}}
          body: {{type: rigid_body, node: body, mass: {MASS}, inertia: {[INERTIA] * 3}, attached: [pad]}}
          springs: {{type: bushing, nodes: [ground, body], stiffness: {springs.tolist()}}}
          pad:
            type: contact
            nodes: [belt, pad]
            plane: {{normal: [0, 0, 1], point: [0, 0, 0]}}
            friction: {{coefficient: {FRICTION}, regularization: 1 mm/s}}
        joints:
          guide: {{type: prismatic, nodes: [ground, belt], axis: [1, 0, 0]}}
          drive: {{type: prescribed_position, node: belt, direction: [1, 0, 0], value: 2*time}}
          plane: {{type: planar, nodes: [ground, body], axis: [0, 1, 0]}}
        loads:
          stop: {{type: force, node: body, direction: [-1, 0, 0], value: {FRICTION * LOAD}}}
          turn: {{type: moment, node: body, direction: [0, -1, 0], value: {(FRICTION * R_Z - R_X) * LOAD}}}
        initial: {{velocities: [{{nodes: [belt], velocity: [2, 0, 0]}}]}}
        time: {{end: 1, step: 1 ms}}
        """)


def closed_form(coupling):
    """The eigenvalues of the equations above with positive imaginary parts, in the order of ``ordered``."""
    arm = R_X - FRICTION * R_Z
    M = np.array([[MASS, -FRICTION * MASS * R_X], [0.0, INERTIA + arm * MASS * R_X]])
    K = np.array([[K_X, coupling - FRICTION * K_Z * R_X], [coupling, K_T + (FRICTION * R_X + R_Z) * LOAD]])
    K[1, 1] += arm * K_Z * R_X
    values = np.sqrt(-np.linalg.eigvals(np.linalg.solve(M, K)).astype(complex))
    return ordered(np.where(values.imag < 0.0, -values, values))


def ordered(values):
    """The values by the sums of their parts: those that flutter and decay have the same frequency."""
    return values[np.argsort(values.real + values.imag)]


@pytest.mark.parametrize(("coupling", "kinds"), [(0.0, ["oscillation"] * 2), (400.0, ["flutter", "oscillation"])])
def test_friction_that_follows_the_reaction_couples_modes(coupling, kinds, verify):
    _, found, _ = modes(rubbing(coupling), None)
    assert found.converged.all() and sorted(found.kinds) == kinds
    what = f"body that rubs on a belt, coupled by {coupling:g} N: eigenvalues [1/s]"
    verify("Modes", what, ordered(found.values), closed_form(coupling), "closed form", relative=1e-7)


@pytest.mark.slow
def test_the_efficiency_of_gears_divides_what_they_drive(verify):
    """Gears turn between springs, a drives: w^2 = (k_a + k_b i^2/eta)/(J_a + J_b i^2/eta), i = r_a/r_b."""
    (J_a, J_b), (k_a, k_b), (r_a, r_b), eta = (0.02, 0.05), (50.0, 400.0), (0.1, 0.2), 0.8
    _, found, _ = modes(
        deck(f"""
        mecano: 1
        gravity: none
        parameters: {{speed: 10, force: 100, ratio: {r_a / r_b}}}
        nodes: {{a: {{position: [0, 0, 0]}}, b: {{position: [{r_a + r_b}, 0, 0]}}}}
        elements:
          a: {{type: rigid_body, node: a, mass: 1, inertia: [0.1, 0.1, {J_a}]}}
          b: {{type: rigid_body, node: b, mass: 1, inertia: [0.1, 0.1, {J_b}]}}
          spring_a:
            {{type: torsion_spring_damper, nodes: [ground, a], axis: [0, 0, 1], law: {{spring: {k_a}}},
             natural_angle: $speed*time}}
          spring_b:
            {{type: torsion_spring_damper, nodes: [ground, b], axis: [0, 0, 1], law: {{spring: {k_b}}},
             natural_angle: -$ratio*$speed*time}}
        joints:
          hinge_a: {{type: hinge, nodes: [ground, a], axis: [0, 0, 1]}}
          hinge_b: {{type: hinge, nodes: [ground, b], axis: [0, 0, 1]}}
          gears:
            type: gear_pair
            nodes: [ground, a, b]
            axis_a: [0, 0, 1]
            radius_a: {r_a}
            radius_b: {r_b}
            friction: {{efficiency: {eta}, regularization: 0.01 mm/s}}
        loads:
          motor: {{type: joint_moment, joint: hinge_a, value: {r_a}*$force}}
          load: {{type: joint_moment, joint: hinge_b, value: {eta * r_b}*$force}}
        initial:
          velocities:
            - {{nodes: [a], angular_velocity: [0, 0, $speed]}}
            - {{nodes: [b], angular_velocity: [0, 0, -$ratio*$speed]}}
        time: {{end: 1, step: 1 ms}}
        """),
        None,
    )
    driven = (r_a / r_b) ** 2 / eta
    frequency = np.sqrt((k_a + k_b * driven) / (J_a + J_b * driven))
    verify(
        "Modes", "gears with an efficiency of 0.8 [rad/s]", found.values.imag, [frequency], "closed form", relative=1e-9
    )


MASS_ON_GUIDES, STIFFNESS, ANGLE = 2.0, 800.0, 0.7


def on_guides(whip=""):
    """The deck of a block on two guides at the same place, of the friction 0.3 and 0.1, with a spring to a pin."""
    guide = "{{type: prismatic, nodes: [sledge, block], axis: [1, 0, 0], friction: {{coefficient: {}, {}}}}}"
    first, second = (guide.format(mu, "regularization: 0.01 mm/s") for mu in (0.3, 0.1))
    return deck(f"""
        mecano: 1
        gravity: [0, 0, -9.81]
        nodes:
          sledge: {{position: [0, 0, 0]}}
          block: {{position: [0, 0, 0]}}
          end: {{position: [0, 0.5, 0]}}
          pin: {{position: [{-np.cos(ANGLE)}, 0, {np.sin(ANGLE)}], fixed: true}}
        sections: {{strip: {{type: rectangle, width: 20 mm, height: 5 mm, E: 70 GPa, nu: 0.3, density: 2700}}}}
        elements:
          sledge: {{type: rigid_body, node: sledge, mass: 1, inertia: [1, 1, 1]}}
          block: {{type: rigid_body, node: block, mass: {MASS_ON_GUIDES}, inertia: [0.01, 0.01, 0.01], attached: [end]}}
          spring: {{type: spring_damper, nodes: [pin, block], law: {{spring: {STIFFNESS}}}}}
          {whip}
        joints:
          track: {{type: prismatic, nodes: [ground, sledge], axis: [1, 0, 0]}}
          drive: {{type: prescribed_position, node: sledge, direction: [1, 0, 0], value: 0.5*time}}
          first: {first}
          second: {second}
        loads:
          stop: {{type: force, node: block, direction: [-1, 0, 0], value: {0.2 * MASS_ON_GUIDES * 9.81}}}
        initial: {{velocities: [{{nodes: [sledge], velocity: [0.5, 0, 0]}}]}}
        time: {{end: 1, step: 1 ms}}
        """)


def test_redundant_guides_share_the_reaction_and_its_friction(verify):
    """Half of the force on each, hence the friction 0.2 on all.

    The spring of the stiffness k, inclined by the angle a, changes the force of the guides by k cos a sin a per
    displacement: w^2 = k cos a (cos a + 0.2 sin a)/m.
    """
    _, found, _ = modes(on_guides(), None)
    frequency = np.sqrt(STIFFNESS * np.cos(ANGLE) * (np.cos(ANGLE) + 0.2 * np.sin(ANGLE)) / MASS_ON_GUIDES)
    what = "block in redundant guides with friction [rad/s]"
    verify("Modes", what, found.values.imag, [frequency], "closed form", relative=1e-9)


def test_both_solvers_find_the_same_modes_with_friction():
    """A beam on the block makes it large enough for the sparse solver; nothing is damped, but D differs from B^T.

    The compliances by which redundant guides share their reactions are small, but not zero for the sparse solver.
    """
    model = on_guides("whip: {type: beam, nodes: [block, end], section: strip, up: [0, 0, 1], mesh: 8}")
    dense, sparse = (modes(model, None, number=4, method=method)[1] for method in ("dense", "sparse"))
    assert "Arnoldi" in sparse.method
    np.testing.assert_allclose(sparse.values.imag, dense.values.imag, rtol=1e-5)
