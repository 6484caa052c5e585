"""A platform on eight cables, whose lengths are driven, against its own equations: pose and tensions."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck

CORNERS = np.array([[x, y, z] for x in (-2.0, 2.0) for y in (-1.5, 1.5) for z in (0.0, 3.0)])
LUGS = np.array([[0.3 * x, 0.2 * y, -0.15 * z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
MASS, INERTIA, WEIGHT, EA, TAU = 12.0, np.array([0.4, 0.5, 0.6]), 12.0 * 9.81, 4e4, 2e-3
BEGIN, PRETENSION, RATE = np.array([0.1, -0.05, 1.4]), 150.0, 3.0
HAULED = 0.3 * np.array([0.05, -0.03, 0.02, 0.04, -0.05, 0.01, 0.03, -0.02])  # m
NATURAL = np.linalg.norm(BEGIN + LUGS - CORNERS, axis=1) / (1.0 + PRETENSION / EA)
SOURCE = "Newton and Euler, one platform"


def robot():
    """The deck: natural lengths L - h (1 - cos(RATE t))."""
    nodes = "".join(
        f"      corner{i}: {{position: {corner.tolist()}, fixed: true}}\n      lug{i}: {{position: {lug.tolist()}}}\n"
        for i, (corner, lug) in enumerate(zip(CORNERS, BEGIN + LUGS, strict=True))
    )
    cables = "".join(
        f"      rope{i}: {{type: cable, nodes: [corner{i}, lug{i}], axial_stiffness: {EA}, damping: {TAU}, "
        f'natural_length: "{length} - {hauled}*(1 - cos({RATE}*time))"}}\n'
        for i, (length, hauled) in enumerate(zip(NATURAL.tolist(), HAULED.tolist(), strict=True))
    )
    lugs = ", ".join(f"lug{i}" for i in range(8))
    return deck(f"""
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes:
      platform: {{position: {BEGIN.tolist()}}}
{nodes}
    elements:
      platform: {{type: rigid_body, node: platform, mass: {MASS}, inertia: {INERTIA.tolist()}, attached: [{lugs}]}}
{cables}
    initial: static
    time: {{end: 1, step: 1 ms, method: radau, adaptive: {{tolerance: 1.0e-6}}}}
    """)


def tensions(t, x, R, v, omega):
    """Tensions (8,), force and moment on the platform, inertial; a cable never pushes."""
    L, L_rate = NATURAL - HAULED * (1.0 - np.cos(RATE * t)), -HAULED * RATE * np.sin(RATE * t)
    arms = LUGS @ R.T
    d = x + arms - CORNERS
    length = np.linalg.norm(d, axis=1)
    u = d / length[:, None]
    rate = np.sum(u * (v + np.cross(omega, arms)), axis=1)
    strain, strain_rate = length / L - 1.0, rate / L - length * L_rate / L**2
    N = np.where(strain > 0.0, np.maximum(EA * (strain + TAU * strain_rate), 0.0), 0.0)
    forces = -N[:, None] * u
    return N, forces.sum(axis=0) - [0.0, 0.0, WEIGHT], np.cross(arms, forces).sum(axis=0)


def rates(t, y):
    """Rates of position, quaternion (x, y, z, w), velocity and material angular velocity."""
    q, v, W = y[3:7], y[7:10], y[10:]
    R = Rotation.from_quat(q).as_matrix()
    _, force, moment = tensions(t, y[:3], R, v, R @ W)
    turning = 0.5 * np.concatenate([q[3] * W + np.cross(q[:3], W), [-q[:3] @ W]])
    return np.concatenate([v, turning, force / MASS, (R.T @ moment - np.cross(W, INERTIA * W)) / INERTIA])


def out_of_balance(pose):
    _, force, moment = tensions(0.0, pose[:3], Rotation.from_rotvec(pose[3:]).as_matrix(), np.zeros(3), np.zeros(3))
    return np.concatenate([force, moment])


def test_a_platform_on_eight_cables(verify):
    """It begins in equilibrium; some cables become slack on the way."""
    recorded = RecordedRun(robot())
    pose = root(out_of_balance, np.concatenate([BEGIN, np.zeros(3)]), tol=1e-13).x
    turned = Rotation.from_rotvec(pose[3:])
    found = np.array([recorded[f"elements/rope{i}/tension"] for i in range(8)])
    at_rest, _, _ = tensions(0.0, pose[:3], turned.as_matrix(), np.zeros(3), np.zeros(3))
    verify("Cables", "platform on eight cables: tensions at rest [N]", found[:, 0], at_rest, SOURCE, relative=1e-9)

    start = np.concatenate([pose[:3], turned.as_quat(), np.zeros(6)])
    y = solve_ivp(rates, (0.0, 1.0), start, "DOP853", rtol=1e-9, atol=1e-11, t_eval=recorded.time, max_step=2e-3).y
    exact = np.empty_like(found)
    for k, t in enumerate(recorded.time):
        R = Rotation.from_quat(y[3:7, k]).as_matrix()
        exact[:, k] = tensions(t, y[:3, k], R, y[7:10, k], R @ y[10:, k])[0]
    assert exact.min() == 0.0 and exact.max() > 400.0 and np.ptp(y[:3], axis=1).min() > 5e-3
    position = recorded["nodes/platform/position"]
    verify("Cables", "platform on eight cables: position [m]", position, y[:3].T, SOURCE, absolute=1e-7)
    verify("Cables", "platform on eight cables: tensions [N]", found, exact, SOURCE, absolute=2e-3)
