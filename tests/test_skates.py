"""Vehicles on skates, which do not slip: a skateboard that steers by leaning, a caster on a spring, a snakeboard."""

import numpy as np
import pytest
from convergence import pair
from scipy.integrate import solve_ivp
from small_motions import eigenvalues
from time_runs import RecordedRun, deck

from mecano.analyses.sweep import sweep

FRONT, REAR, LEADS, FOLLOWS = 0.4, 0.35, 0.55, 0.3  # m from the middle to the axles; angles of the axles over the lean
MASS, HEIGHT, INERTIA = 70.0, 0.9, np.array([6.0, 5.0, 1.5])
STIFFNESS, DAMPING, G = 500.0, 8.0, 9.81
BOARD = f"""
    mecano: 1
    gravity: [0, 0, {-G}]
    parameters: {{speed: SPEED}}
    nodes:
      board: {{position: [0, 0, 0]}}
      fore: {{position: [{FRONT}, 0, 0]}}
      aft: {{position: [{-REAR}, 0, 0]}}
      rider: {{position: [0, 0, 0]}}
      front: {{position: [{FRONT}, 0, 0]}}
      rear: {{position: [{-REAR}, 0, 0]}}
    elements:
      fore: {{type: rigid_link, nodes: [board, fore]}}
      aft: {{type: rigid_link, nodes: [board, aft]}}
      rider: {{type: rigid_body, node: rider, mass: {MASS}, center_of_mass: [0, 0, {HEIGHT}], inertia: [6, 5, 1.5]}}
      front: {{type: skate, node: front, axis: [0, 1, 0], ground: road}}
      rear: {{type: skate, node: rear, axis: [0, 1, 0], ground: road}}
    grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    laws: {{bushes: {{spring: {{stiffness: {STIFFNESS}}}, damper: {{coefficient: {DAMPING}}}}}}}
    joints:
      floor: {{type: planar, nodes: [ground, board], axis: [0, 0, 1]}}
      lean: {{type: hinge, nodes: [board, rider], axis: [1, 0, 0], turning_law: bushes}}
      front_pin: {{type: hinge, nodes: [fore, front], axis: [0, 0, 1]}}
      rear_pin: {{type: hinge, nodes: [aft, rear], axis: [0, 0, 1]}}
      steers: {{type: coupler, angles: [lean, front_pin], factors: [{LEADS}, 1]}}
      follows: {{type: coupler, angles: [lean, rear_pin], factors: [{FOLLOWS}, -1]}}
"""


def partial_velocities(lean):
    """Yaw rate over speed, and velocity of the mass centre and angular velocity by the speed u and by the lean rate w.

    The velocities are in the axes of the board, the angular velocities in those of the rider. The axles do not slip
    sideways: the middle moves sideways at u Y, the board turns at u T.
    """
    fore, aft = np.tan(-LEADS * lean), np.tan(FOLLOWS * lean)
    T, Y = (fore - aft) / (FRONT + REAR), (REAR * fore + FRONT * aft) / (FRONT + REAR)
    s, c = np.sin(lean), np.cos(lean)
    by_u = np.array([1.0 + T * HEIGHT * s, Y, 0.0 * s]), T * np.array([0.0 * s, s, c])
    by_w = np.array([0.0 * s, -HEIGHT * c, -HEIGHT * s]), np.array([1.0 + 0.0 * s, 0.0 * s, 0.0 * s])
    return T, by_u, by_w


def board_rates(t, y):
    """Rates of x, y, heading, lean, speed u, lean rate w by Jourdain's principle; the axles have no mass."""
    _, _, heading, lean, u, w = y
    T, (P_u, W_u), (P_w, W_w) = partial_velocities(lean)
    _, *varied = partial_velocities(lean + 1e-30j)  # complex step
    (dP_u, dW_u), (dP_w, dW_w) = ((P.imag / 1e-30, W.imag / 1e-30) for P, W in varied)
    v, omega = P_u * u + P_w * w, W_u * u + W_w * w
    acceleration = (dP_u * u + dP_w * w) * w + np.cross([0.0, 0.0, T * u], v)
    force = MASS * (np.array([0.0, 0.0, -G]) - acceleration)
    moment = -INERTIA * (dW_u * u + dW_w * w) * w - np.cross(omega, INERTIA * omega)
    both = (P_u, W_u), (P_w, W_w)
    M = [[MASS * P @ Q + W @ (INERTIA * X) for Q, X in both] for P, W in both]
    f = [P @ force + W @ moment for P, W in both]
    rates = np.linalg.solve(M, f - np.array([0.0, STIFFNESS * lean + DAMPING * w]))
    c, s, aside = np.cos(heading), np.sin(heading), P_u[1]
    return [u * (c - s * aside), u * (s + c * aside), T * u, w, *rates]


def test_a_skateboard_steers_by_leaning(verify):
    """The rider begins to fall aside at 0.2 rad/s; the board steers under him."""
    more = """
    initial:
      velocities:
        - {nodes: all, velocity: [$speed, 0, 0]}
        - {nodes: [rider], angular_velocity: [0.2, 0, 0], about: [0, 0, 0]}
    time: {end: 2, step: 1 ms, method: radau, adaptive: {tolerance: 1.0e-8}}
    """
    recorded = RecordedRun(deck(BOARD.replace("SPEED", "3") + more))
    start = [0.0, 0.0, 0.0, 0.0, 3.0, 0.2]
    exact = solve_ivp(board_rates, (0.0, 2.0), start, "DOP853", rtol=1e-11, atol=1e-13, t_eval=recorded.time).y
    found = np.column_stack([recorded["nodes/board/position"][:, :2], recorded["joints/lean/angle"]])
    assert np.ptp(exact[1]) > 0.4 and np.ptp(exact[3]) > 0.06
    verify(
        "Mechanisms", "skateboard: path and lean [m, rad]", found, exact[[0, 1, 3]].T, "Jourdain's principle",
        absolute=1e-9,
    )  # fmt: skip


@pytest.mark.parametrize("speed", [1.0, 3.0])
def test_a_skateboard_is_stable_at_speed(speed, verify):
    """Slow, it falls to a side; fast, it sways and recovers: the eigenvalues of the lean."""
    steady = "    initial: {steady: {velocity: [$speed, 0, 0]}}\n    time: {end: 1, step: 1 ms}\n"
    found = eigenvalues(deck(BOARD.replace("SPEED", str(speed)) + steady))[-2:]
    at, d = np.array([0.0, 0.0, 0.0, 0.0, speed, 0.0]), 1e-6 * np.eye(6)
    rows = [(np.subtract(board_rates(0.0, at + d[i]), board_rates(0.0, at - d[i])) / 2e-6)[[3, 5]] for i in (3, 5)]
    expected = np.linalg.eigvals(np.transpose(rows))
    assert (expected.real.max() > 0.0) == (speed == 1.0)
    what = f"skateboard at {speed:g} m/s: eigenvalues of the lean [1/s]"
    verify("Modes", what, np.sort_complex(found), np.sort_complex(expected), "Jourdain's principle", relative=1e-7)


CASTER = """
mecano: 1
gravity: none
parameters: {speed: 1}
nodes:
  cart: {position: [0, 0, 0]}
  king: {position: [0, 0, 0]}
  arm: {position: [0, 0, 0]}
  edge: {position: [-0.3, 0, 0]}
elements:
  cart: {type: point_mass, node: cart, mass: 1000}
  arm:
    {type: rigid_body, node: arm, mass: 10, center_of_mass: [-0.12, 0, 0], inertia: [0.4, 0.4, 0.6], attached: [edge]}
  blade: {type: skate, node: edge, axis: [0, 1, 0], ground: road}
grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
laws: {bushes: {spring: {stiffness: 2.0e4}, damper: {coefficient: 15}}}
joints:
  track: {type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}
  side: {type: prismatic, nodes: [cart, king], axis: [0, 1, 0], sliding_law: bushes}
  pivot: {type: hinge, nodes: [king, arm], axis: [0, 0, 1]}
initial: {steady: {velocity: [$speed, 0, 0]}}
time: {end: 1, step: 1 ms}
"""


def test_a_caster_on_a_spring_shimmies_between_two_speeds(tmp_path, verify):
    """J s^3 + (e V + c a^2) s^2 + (k a^2 + c a V) s + k a V = 0 with e = m (a - b), J about the point of contact.

    a and b are the distances of contact and mass centre from the king pin, whose side motion y = (a s + V)/s times the
    angle is on the spring k and the damper c. Routh: stable where (e V + c a^2)(k a + c V) > J k V.
    """
    m, a, b, k, c = 10.0, 0.3, 0.12, 2e4, 15.0
    J, e = 0.6 + m * (a - b) ** 2, m * (a - b)
    expected = np.sort(np.roots([e * c, e * k * a + c**2 * a**2 - J * k, c * a**3 * k]))
    (tmp_path / "caster.yaml").write_text(CASTER)
    (locus,) = sweep(tmp_path / "caster.yaml", (), ["speed=0.5,1,2,250,280,300"]).loci
    begins, ends = locus.critical
    assert begins.destabilizes and not ends.destabilizes
    found = [begins.place, ends.place]
    verify("Shimmy", "caster on a spring: critical speeds [m/s]", found, expected, "criterion of Routh", relative=1e-9)


def snakeboard_rates(t, y):
    """Rates of x, y, heading, speed u of inputs/snakeboard.yaml: d'Alembert's principle for the motion at u alone."""
    mass, inertia, rotor = 5.002, 0.3 + 0.2 + 2 * 0.01 + 0.002 * 0.25**2, 0.2
    phi, phi_rate, rotor_acceleration = 0.4 * np.sin(4 * t), 1.6 * np.cos(4 * t), -11.2 * np.sin(4 * t)
    T, T_rate = np.tan(phi) / 0.25, phi_rate / np.cos(phi) ** 2 / 0.25
    _, _, heading, u = y
    u_rate = -T * (inertia * u * T_rate + rotor * rotor_acceleration) / (mass + inertia * T**2)
    return [u * np.cos(heading), u * np.sin(heading), u * T, u_rate]


def test_a_snakeboard_starts_by_itself(verify):
    """Its rider turns and steers both axles in time with it (Ostrowski, Lewis, Murray & Burdick 1994)."""
    at = np.arange(1.0, 6.5)
    found = solve_ivp(snakeboard_rates, (0, 6), np.zeros(4), rtol=1e-11, atol=1e-13, t_eval=at)
    np.testing.assert_allclose(found.y[:, -1], [5.298760, 0.299627, -0.342250, 1.853450], atol=1e-6)  # of the deck

    def motion(run):
        velocity = run["nodes/board/velocity"]
        return np.column_stack([run["nodes/board/position"][:, :2], np.hypot(*velocity[:, :2].T)])

    coarse, fine = pair("snakeboard", motion, at, 8e-3)
    exact = np.array([found.y[0], found.y[1], np.abs(found.y[3])]).T
    verify.second_order("Rolling", "snakeboard: path [m] and speed [m/s]", coarse, fine, exact, 2e-6, "SciPy")
