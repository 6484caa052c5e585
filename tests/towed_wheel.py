"""A wheel lowered onto the road at a slip angle, which spins up and then rolls; its laws of the patch."""

import numpy as np
from time_runs import deck

SPEED, ANGLE, SINK, DOWN = 60.0, np.radians(6.0), 2.0, 0.04  # m/s, rad, m/s, s
RADIUS, SPIN_INERTIA, CORNERING, SIGMA, DAMPING = 0.45, 4.2, 250e3, 0.35, 0.1
TOWED = """
    mecano: 1
    gravity: [0, 0, 0]
    parameters: {{lean: {lean} deg, vx: {vx!r}, vy: {vy!r}}}
    nodes:
      carriage: {{position: [0, 0, 0.452]}}
      hub: {{position: [0, 0, 0.452]}}
    elements:
      rim: {{type: rigid_body, node: hub, mass: 55, inertia: [2.5, 4.2, 2.5]}}
      tire: {{type: flexible_wheel, node: hub, axis: [0, cos($lean), sin($lean)], tire_law: rubber, ground: road}}
    joints:
      level: {{type: held_rotation, nodes: [ground, carriage]}}
      height: {{type: prescribed_position, node: carriage, direction: [0, 0, 1],
        value: {height}}}
      track: {{type: prescribed_position, node: carriage, direction: [0, 1, 0], value: {{linear: {{slope: $vy}}}}}}
      tow: {{type: prescribed_position, node: carriage, direction: [1, 0, 0], value: {{linear: {{slope: $vx}}}}}}
      bearing: {{type: hinge, nodes: [carriage, hub], axis: [0, cos($lean), sin($lean)]}}
    tire_laws:
      rubber:
        radius: 0.45
        radial: {{polynomial: {{coefficients: [0, 7.0e5, 2.0e6]}}}}
        radial_damping: 0.1
        friction: {{exponential: {{start: 0.8, limit: 0.5, rate: 0.03}}}}
        slip_regularization: 0.1
        lateral: {lateral}
    grounds:
      road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
    initial:
      velocities:
        - {{nodes: all, velocity: [$vx, $vy, {sink}]}}
        - {{nodes: [hub], angular_velocity: [0, {spin!r}, 0], about: own}}
    time: {{end: {end}, step: 1.0e-4, adaptive: {{length_scale: 1 m, tolerance: {tolerance}, maximum_step: 1.0e-3}}}}
"""
RELAXATION = f"{{relaxation: {{cornering_stiffness: {CORNERING}, relaxation_length: {SIGMA}}}}}"
OF_STRING = f"cornering_stiffness: {CORNERING}, relaxation_length: {SIGMA}, contact_length: 0.3"
STRING = f"{{string: {{{OF_STRING}, torsional_stiffness: 1.0e4}}}}"
TANGENT = f"{{straight_tangent: {{{OF_STRING}}}}}"
MORELAND = (
    f"{{moreland: {{lateral_stiffness: {CORNERING / SIGMA!r}, yaw_coefficient: {1 / CORNERING!r}, "
    "lateral_damping: %r, yaw_time: %r, torsional_stiffness: %r}}"
)
LAWS = {
    "relaxation": RELAXATION, "string": STRING, "straight_tangent": TANGENT,
    "moreland": MORELAND % (500.0, 2e-3, 1e4), "moreland without rates": MORELAND % (0.0, 0.0, 1e4),
}  # fmt: skip


LED = {  # down: where the hub is led to, and its velocity at the start [m/s]
    "down": ("{ramp: {start: 0, end: 0.04, from: 0, to: -0.08}}", -SINK),
    "down and up": ("{sine: {amplitude: 0.04, frequency: 5, phase: 1.5707963267948966, offset: -0.04}}", 0.0),
}


def towed(lateral, lean=0.0, end=0.2, tolerance=1e-3, angle=ANGLE, led="down", spin=0.0):
    """The checked deck with a lateral law."""
    vx, vy, (height, sink) = float(SPEED * np.cos(angle)), float(SPEED * np.sin(angle)), LED[led]
    values = {"lateral": lateral, "height": height, "sink": sink, "lean": lean, "end": end, "tolerance": tolerance}
    return deck(TOWED.format(vx=vx, vy=vy, spin=spin, **values))
