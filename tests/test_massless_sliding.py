"""Unknowns without mass that begin to slide, of a tyre and of a node: rates that jump, displacements that do not."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

RISE, START, RADIUS, HEIGHT = 0.02, 0.1, 0.3, 0.28  # m, s, m, m: the wheel is lifted by RISE, as far as the ground
STIFFNESS, FRICTION, LATERAL = 3e5, 0.5, 2e5  # N/m radial; -; N/m
DECK = """
    mecano: 1
    gravity: none
    nodes:
      cart: {{position: [0, 0, 0.28]}}
      hub: {{position: [0, 0, 0.28]}}
    elements:
      cart: {{type: rigid_body, node: cart, mass: 1, inertia: [1, 1, 1]}}
      rim: {{type: rigid_body, node: hub, mass: 10, inertia: [0.4, 0.7, 0.4]}}
      wheel:
        {{type: flexible_wheel, node: hub, axis: ['-sin({angle})', 'cos({angle})', 0], tire_law: tyre, ground: road}}
    joints:
      level: {{type: held_rotation, nodes: [ground, cart]}}
      tow: {{type: prescribed_position, node: cart, direction: [1, 0, 0], value: {{linear: {{slope: 15}}}}}}
      track: {{type: prescribed_position, node: cart, direction: [0, 1, 0], value: 0}}
      height:
        type: prescribed_position
        node: cart
        direction: [0, 0, 1]
        value: {{bump: {{start: 0.1, length: {length}, height: 0.02}}}}
      bearing: {{type: hinge, nodes: [cart, hub], axis: ['-sin({angle})', 'cos({angle})', 0]}}
    tire_laws:
      tyre:
        radius: 0.3
        radial: {{linear: {{slope: 3.0e5}}}}
        radial_damping: {damping}
        friction: 0.5
        slip_regularization: 0.01
        lateral: {{relaxation: {{cornering_stiffness: 6.0e4, relaxation_length: 0.3}}}}
    grounds: {{road: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}}}
    initial:
      velocities:
        - {{nodes: all, velocity: [15, 0, 0]}}
        - {{nodes: [hub], angular_velocity: ['-sin({angle})*50', 'cos({angle})*50', 0], about: own}}
    time: {{end: {end}, step: 0.1 ms, adaptive: {{tolerance: {tolerance}}}}}
"""


@pytest.mark.parametrize(
    ("angle", "length", "damping", "share", "tolerance"),
    [
        (0.04, 0.05, 0.5, 0.3, 1e-4),
        (0.02, 0.05, 0.5, 0.3, 1e-4),
        (0.02, 0.01, 0.1, 0.3, 1e-4),
        (0.01, 0.02, 0.5, 0.2, 1e-5),
    ],
)
def test_a_patch_slides_where_the_friction_balances_the_tyre(angle, length, damping, share, tolerance):
    """mu N of N = k w (1 + c dw/dt), a ``share`` of the way up; the tyre has the part along the axle, turned by psi."""
    end, given = START + share * 0.5 * length, {"angle": angle, "length": length, "damping": damping}
    run = RecordedRun(deck(DECK.format(**given, end=end, tolerance=tolerance)))
    names = "longitudinal_force", "lateral_force", "y", "psi"
    along, across, y, psi = (float(run[f"elements/wheel/{name}"][-1]) for name in names)
    phase = 2.0 * np.pi * (end - START) / length
    depth = RADIUS - HEIGHT - 0.5 * RISE * (1.0 - np.cos(phase))
    rate = -0.5 * RISE * np.sin(phase) * 2.0 * np.pi / length
    friction = FRICTION * STIFFNESS * depth * (1.0 + damping * rate)
    assert np.hypot(along, across) == pytest.approx(friction, rel=1e-3)  # the rate of the height is of second order
    assert -LATERAL * y == pytest.approx(across - psi * along, rel=1e-6)


JENKINS = """
    mecano: 1
    gravity: none
    nodes: {{a: {{position: [0, 0, 0]}}, s: {{position: [1, 0, 0]}}}}
    elements:
      mass: {{type: point_mass, node: a, mass: 1}}
      spring: {{type: spring_damper, nodes: [a, s], law: {{spring: 1000}}}}
    joints:
      guide: {{type: prismatic, nodes: [ground, a], axis: [1, 0, 0]}}
      slider:
        {{type: prismatic, nodes: [ground, s], axis: [1, 0, 0],
         sliding_law: {{dry_friction: {{force: 10, regularization: {regularization}}}}}}}
    initial: {{velocities: [{{nodes: [a], velocity: [1, 0, 0]}}]}}
    time: {{end: 0.2, step: 1 ms, adaptive: {{tolerance: {tolerance}}}}}
"""


@pytest.mark.parametrize(("regularization", "tolerance"), [(1e-3, 1e-4), (1e-3, 1e-5), (1e-3, 1e-6), (1e-5, 1e-4)])
def test_a_node_without_mass_between_a_spring_and_dry_friction(regularization, tolerance):
    """The mass m = 1 slides by d = (m v^2/2 - F^2/(2 k))/F, with F/k of the spring; then the spring swings to -F/k.

    The slider creeps by less than the regularization times the duration.
    """
    run = RecordedRun(deck(JENKINS.format(tolerance=tolerance, regularization=regularization)))
    slid, given = run["nodes/s/position"][:, 0] - 1.0, run["nodes/a/position"][:, 0]
    creep = 2.0 * tolerance + 0.2 * regularization
    assert slid.max() == pytest.approx((0.5 - 0.05) / 10.0, abs=creep)
    assert given.max() == pytest.approx(0.045 + 0.01, abs=creep)


TOUCH_DOWN = """
mecano: 1
gravity: [0, 0, -9.81]
parameters: {damping: 0, drift: 0.2}
nodes: {strut: {position: [0, 0, 0.3]}, hub: {position: [0, 0, 0.3]}}
elements:
  mass: {type: rigid_body, node: strut, mass: 130, inertia: [1, 1, 1]}
  rim: {type: rigid_body, node: hub, mass: 15, inertia: [0.5, 0.9, 0.5]}
  tyre: {type: flexible_wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: runway}
joints:
  upright: {type: held_rotation, nodes: [ground, strut]}
  bearing: {type: hinge, nodes: [strut, hub], axis: [0, 1, 0]}
tire_laws:
  rubber:
    radius: 0.3
    radial: {linear: {slope: 2.0e5}}
    radial_damping: $damping
    friction: 0.7
    slip_regularization: 0.02
    lateral: {relaxation: {cornering_stiffness: 6.0e4, relaxation_length: 0.3}}
grounds: {runway: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
initial:
  velocities:
    - {nodes: all, velocity: [6.3, $drift, -0.55]}
    - {nodes: [hub], angular_velocity: [0, 20.9, 0]}
time: {end: 20 ms, step: 0.1 ms, adaptive: {tolerance: 1.0e-7}}
"""


@pytest.mark.parametrize("damping", [0.0, 1.7])
@pytest.mark.parametrize("drift", [0.1, 0.2, 0.3, 0.5])
def test_a_drifting_tyre_touches_down_between_grip_and_slip(damping, drift):
    """Load and lateral force grow together from zero; the rates of the tyre at the start satisfy both."""
    text = TOUCH_DOWN.replace("damping: 0,", f"damping: {damping},").replace("drift: 0.2", f"drift: {drift}")
    smooth, radau = (
        RecordedRun(deck(text.replace("step:", f"method: {m}, step:"))) for m in ("generalized_alpha", "radau")
    )
    assert radau.run.motion.z[1] == pytest.approx(smooth.run.motion.z[1], abs=1e-7 * smooth.prepared.length)
    assert radau["elements/tyre/y"][-1] == pytest.approx(smooth["elements/tyre/y"][-1], rel=1e-5)
    assert len(smooth.time) < 265 and len(radau.time) < 50
