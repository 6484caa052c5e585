"""Ground resonance of a helicopter: lagging blades and a hub on springs (Coleman and Feingold, NACA Report 1351, 1958).

In axes that turn with the rotor at the speed n, with the displacement w (a complex number) of the hub, the lag angles
of the blades at the azimuths p_k, their static moment S and moment of inertia I about their hinges, which lie at the
radius e, the mass m of hub and blades, and the stiffness K and damping C of its support:

    m (w'' + 2 i n w' - n^2 w) + C (w' + i n w) + K w + S sum i exp(i p_k) (z_k'' + 2 i n z_k' - n^2 z_k) = 0
    I z_k'' + c z_k' + e S n^2 z_k + S Re[-i exp(-i p_k) (w'' + 2 i n w' - n^2 w)] = 0
"""

import numpy as np
import pytest
from time_runs import deck

from mecano.analyses.modal import modes

E, MASS, ARM, INERTIA = 0.3, 23.5, 2.35, 43.2  # of a blade: hinge [m], mass [kg], centre of mass [m], about it [kg m2]
HUB, K, C = 600.0, 150e3, 500.0  # kg, N/m, N s/m
S, I = MASS * ARM, INERTIA + MASS * ARM**2
AZIMUTHS = 2.0 * np.pi / 3.0 * np.arange(3)
ROTOR = f"""
    mecano: 1
    gravity: none
    parameters: {{speed: SPEED, damping: DAMPING}}
    templates:
      blade:
        nodes: {{root: {{position: [{E}, 0, 0]}}, cuff: {{position: [{E}, 0, 0]}}}}
        elements:
          blade:
            {{type: rigid_body, node: cuff, mass: {MASS}, center_of_mass: [{ARM}, 0, 0], inertia: [1, 43, {INERTIA}]}}
        joints: {{lag: {{type: hinge, nodes: [root, cuff], axis: [0, 0, 1], turning_law: {{damper: $damping}}}}}}
    place:
      b$k: {{repeat: {{k: 1..3}}, template: blade, orientation: [0, 0, ($k - 1)*2*pi/3]}}
    nodes: {{base: {{position: [0, 0, 0]}}, hub: {{position: [0, 0, 0]}}}}
    elements:
      base: {{type: rigid_body, node: base, mass: {HUB - 20}, inertia: [10, 10, 10]}}
      hub: {{type: rigid_body, node: hub, mass: 20, inertia: [2, 2, 3], attached: [b1_root, b2_root, b3_root]}}
    laws: {{pylon: {{spring: {K}, damper: {C}}}}}
    joints:
      pylon:
        {{type: generic, nodes: [ground, base], axis: [0, 0, 1], compliance: {{along_1: pylon, along_2: pylon}}}}
      shaft: {{type: hinge, nodes: [base, hub], axis: [0, 0, 1]}}
      motor: {{type: prescribed_angle, nodes: [base, hub], axis: [0, 0, 1], value: $speed*time}}
    initial:
      velocities:
        - {{nodes: all, angular_velocity: [0, 0, $speed], about: [0, 0, 0]}}
        - {{nodes: [base], angular_velocity: [0, 0, -$speed]}}
    time: {{end: 1, step: 1 ms}}
    """


def coleman(n, c):
    """Eigenvalues of the equations above for the motions of the hub and of the three blades."""
    m, turn = HUB + 3.0 * MASS, np.array([[0.0, -1.0], [1.0, 0.0]])
    across = np.array([-np.sin(AZIMUTHS), np.cos(AZIMUTHS)])
    M, G, Q = (np.zeros((5, 5)) for _ in range(3))
    M[:2, :2], G[:2, :2] = m * np.eye(2), 2.0 * n * m * turn + C * np.eye(2)
    Q[:2, :2] = (K - n**2 * m) * np.eye(2) + C * n * turn
    M[:2, 2:], G[:2, 2:], Q[:2, 2:] = S * across, 2.0 * n * S * turn @ across, -(n**2) * S * across
    M[2:, :2], G[2:, :2], Q[2:, :2] = S * across.T, 2.0 * n * S * across.T @ turn, -(n**2) * S * across.T
    M[2:, 2:], G[2:, 2:], Q[2:, 2:] = I * np.eye(3), c * np.eye(3), E * S * n**2 * np.eye(3)
    rates = np.hstack([-np.linalg.solve(M, Q), -np.linalg.solve(M, G)])
    return np.linalg.eigvals(np.vstack([np.hstack([np.zeros((5, 5)), np.eye(5)]), rates]))


@pytest.mark.parametrize(
    ("speed", "damping", "grows"), [(22.0, 0.0, True), (22.0, 10000.0, False), (40.0, 100.0, False)]
)
def test_modes_of_a_rotor_on_springs_are_those_of_coleman(speed, damping, grows):
    text, found, _ = modes(deck(ROTOR.replace("SPEED", f"{speed}").replace("DAMPING", f"{damping}")), None, frame="hub")
    expected = coleman(speed, damping)
    assert (expected.real.max() > 0.1) == grows and "mecano: " not in text
    for value in expected[expected.imag >= 0.0]:
        assert np.abs(found.values - value).min() < 1e-8 * np.abs(expected).max()
