"""Modes of models beyond the size of dense matrices with wheels that spin freely, whose stiffness is singular."""

import numpy as np
from time_runs import deck

from mecano.analyses.modal import modes

LEG = """
    mecano: 1
    gravity: [0, 0, -9.81]
    parameters: {speed: 10}
    sections:
      leg: {type: stiffness, EA: 1.0e8, GA2: 5.0e7, GA3: 5.0e7, GJ: 2.0e3, EI2: 1.0e5, EI3: 3.0e3, mass_per_length: 10,
            rotary_inertia: [2.0e-3, 1.0e-3, 1.0e-3]}
    nodes: {car: {position: [0, 0, 1.3]}, foot: {position: [0, 0, 0.3]}, hub: {position: [0, 0, 0.3]}}
    elements:
      body: {type: rigid_body, node: car, mass: 200, inertia: [20, 20, 20]}
      leg: {type: beam, nodes: [car, foot], section: leg, up: [1, 0, 0], mesh: 8}
      rim: {type: rigid_body, node: hub, mass: 10, inertia: [0.2, 0.4, 0.2]}
      tyre: {type: flexible_wheel, node: hub, axis: [0, 1, 0], tire_law: rubber, ground: road}
    joints:
      rail: {type: prismatic, nodes: [ground, car], axis: [1, 0, 0]}
      axle: {type: hinge, nodes: [foot, hub], axis: [0, 1, 0]}
    tire_laws:
      rubber:
        radius: 0.31
        radial: {linear: {slope: 2.0e5}}
        friction: 0.8
        slip_regularization: 0.01
        lateral: {relaxation: {cornering_stiffness: 4.0e4, relaxation_length: 0.3}}
    grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
    initial: {steady: {velocity: [$speed, 0, 0]}}
    time: {end: 1, step: 1 ms}
"""


def test_a_wheel_on_a_leg_of_many_beams():
    """Two free motions, a decay and five oscillations with 8 beams by dense, and with 80 by sparse matrices."""
    _, few, _ = modes(deck(LEG), None, number=8)
    _, many, _ = modes(deck(LEG.replace("mesh: 8", "mesh: 80")), None, number=8)
    assert few.method.startswith("dense") and many.method.startswith("sparse")
    assert many.kinds == ["free"] * 2 + ["decay"] + ["oscillation"] * 5
    np.testing.assert_allclose(np.abs(many.values), np.abs(few.values), rtol=2e-4)  # the error of 8 beams is 1e-4
    np.testing.assert_allclose(many.values.real, few.values.real, rtol=1e-3)
