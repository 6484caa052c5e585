"""A wobble plate that drives five pistons against springs: one degree of freedom, a loop in space for each piston."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from time_runs import RecordedRun, deck

TILT, RADIUS, ROD, STIFFNESS, TORQUE = np.radians(18.0), 0.05, 0.08, 8e3, 0.3
SHAFT, PISTON, PLATE, BEGINS = 2e-3, 0.15, np.array([3e-4, 3e-4, 5e-4]), 40.0  # kg m2, kg, kg m2, rad/s
AROUND = 2.0 * np.pi * np.arange(5) / 5 + 0.3
BORES = RADIUS * np.column_stack([np.cos(AROUND), np.sin(AROUND)])
BALLS = np.column_stack([BORES, np.zeros(5)])  # in the axes of the plate
END = 0.05


def plate(angle):
    """Rotation of the plate for an angle of the shaft: inclined, and turned back so that its pin stays at y = 0."""
    back = -np.arctan2(np.sin(angle) * np.cos(TILT), np.cos(angle))
    return Rotation.from_euler("ZYZ", [angle, TILT, back]).as_matrix()


def pistons(angle):
    """Heights (5,) of the pistons."""
    balls = BALLS @ plate(angle).T
    return balls[:, 2] + np.sqrt(ROD**2 - np.sum((balls[:, :2] - BORES) ** 2, axis=1))


def derivative(function, x, h):
    """Derivative by differences of order four."""
    return (8.0 * (function(x + h) - function(x - h)) - function(x + 2.0 * h) + function(x - 2.0 * h)) / (12.0 * h)


def inertia(angle):
    """Inertia [kg m2] of the mechanism, reduced to the shaft."""
    S = plate(angle).T @ derivative(plate, angle, 1e-3)
    omega, heights = np.array([S[2, 1], S[0, 2], S[1, 0]]), derivative(pistons, angle, 1e-3)
    return SHAFT + omega @ (PLATE * omega) + PISTON * heights @ heights


def rates(t, y):
    """Rates of angle and angular velocity of the shaft, by Lagrange's equation."""
    springs = STIFFNESS * (pistons(y[0]) - pistons(0.0)) @ derivative(pistons, y[0], 1e-3)
    return [y[1], (TORQUE - springs - 0.5 * derivative(inertia, y[0], 3e-3) * y[1] ** 2) / inertia(y[0])]


def wobble_plate():
    nodes, elements, joints = "", "", ""
    for i, ((x, y), ball, z) in enumerate(zip(BORES, BALLS @ plate(0.0).T, pistons(0.0), strict=True)):
        nodes += f"      ball{i}: {{position: {ball.tolist()}}}\n      piston{i}: {{position: [{x}, {y}, {z}]}}\n"
        nodes += f"      head{i}: {{position: [{x}, {y}, {z + 0.2}], fixed: true}}\n"
        elements += f"      piston{i}: {{type: point_mass, node: piston{i}, mass: {PISTON}}}\n"
        elements += f"      spring{i}: {{type: spring_damper, nodes: [piston{i}, head{i}], "
        elements += f"law: {{spring: {{stiffness: {STIFFNESS}}}}}}}\n"
        joints += f"      rod{i}: {{type: rigid_rod, nodes: [ball{i}, piston{i}]}}\n"
        joints += f"      bore{i}: {{type: prismatic, nodes: [ground, piston{i}], axis: [0, 0, 1]}}\n"
    axis, pin = plate(0.0)[:, 2].tolist(), (RADIUS * plate(0.0)[:, 0]).tolist()
    return deck(f"""
    mecano: 1
    gravity: none
    nodes:
      shaft: {{position: [0, 0, 0]}}
      plate: {{position: [0, 0, 0], orientation: [0, {TILT}, 0]}}
      pin: {{position: {pin}}}
{nodes}
    elements:
      shaft: {{type: rigid_body, node: shaft, mass: 1, inertia: [{SHAFT}, {SHAFT}, {SHAFT}]}}
      plate:
        {{type: rigid_body, node: plate, mass: 0.4, inertia: {PLATE.tolist()},
         attached: [pin, ball0, ball1, ball2, ball3, ball4]}}
{elements}
    joints:
      bearing: {{type: hinge, nodes: [ground, shaft], axis: [0, 0, 1]}}
      inclined: {{type: hinge, nodes: [shaft, plate], axis: {axis}}}
      guide: {{type: prescribed_position, node: pin, direction: [0, 1, 0], value: 0}}
{joints}
    loads: {{motor: {{type: joint_moment, joint: bearing, value: {TORQUE}}}}}
    initial: {{velocities: [{{nodes: [shaft], angular_velocity: [0, 0, {BEGINS}]}}]}}
    time: {{end: {END}, step: 0.5 ms, method: radau, adaptive: {{tolerance: 1.0e-7}}}}
    """)


def test_a_wobble_plate_drives_its_pistons(verify):
    """The shaft alone turns at first: its momentum is shared with plate and pistons."""
    recorded = RecordedRun(wobble_plate())
    turning = SHAFT * BEGINS / inertia(0.0)
    found, source = recorded["joints/bearing/rate"], "Lagrange's equation, one angle"
    verify("Mechanisms", "wobble plate: rate at the start [rad/s]", found[0], turning, source, relative=1e-9)
    exact = solve_ivp(rates, (0.0, END), [0.0, turning], "DOP853", rtol=1e-10, atol=1e-12, t_eval=recorded.time).y
    assert np.ptp(exact[0]) > 0.5 and np.ptp(exact[1]) > 50.0
    verify("Mechanisms", "wobble plate: rate [rad/s]", found, exact[1], source, absolute=1e-6)
    heights = np.column_stack([recorded[f"nodes/piston{i}/position"][:, 2] for i in range(5)])
    expected = np.array([pistons(angle) for angle in exact[0]])
    verify("Mechanisms", "wobble plate: heights of the pistons [m]", heights, expected, source, absolute=1e-9)
