"""Signs of the outputs of a wheel, as the sketch in docs/tyres.md shows them."""

import pytest
from time_runs import INPUTS, RecordedRun

from mecano.deck.read import deck_of_bytes

TOWED = """
mecano: 1
gravity: [0, 0, -9.81]
nodes:
  carriage: {position: [0, 0, 0.3], orientation: [LEAN, 0, 0]}
  hub: {position: [0, 0, 0.3], orientation: [LEAN, 0, 0]}
elements:
  rim: {type: rigid_body, node: hub, mass: 10, inertia: [0.2, 0.4, 0.2]}
  tyre: {type: wheel, node: hub, axis: [0, cos(LEAN), sin(LEAN)], tire_law: car, ground: road}
joints:
  level: {type: held_rotation, nodes: [ground, carriage]}
  height: {type: prescribed_position, node: carriage, direction: [0, 0, 1], value: 0.0}
  track: {type: prescribed_position, node: carriage, direction: [0, 1, 0], value: DRIFT*time}
  tow: {type: prescribed_position, node: carriage, direction: [1, 0, 0], value: 20*time}
  bearing: {type: hinge, nodes: [carriage, hub], axis: [0, cos(LEAN), sin(LEAN)]}
tire_laws: {car: {magic_formula: {file: passenger_car.tir}}}
grounds: {road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}
initial:
  velocities:
    - {nodes: all, velocity: [20, DRIFT, 0]}
    - {nodes: [hub], angular_velocity: [0, SPIN*cos(LEAN), SPIN*sin(LEAN)]}
time: {end: 5 ms, step: 1 ms}
"""


@pytest.mark.parametrize(
    ("lean", "drift", "spin", "signs"),
    [
        (0.0, 1.0, 64.0, {"slip_angle": 1, "lateral_slip": 1, "lateral_force": -1, "slip_moment": 1}),
        (0.1, 0.0, 64.0, {"lean": 1, "lateral_force": -1}),
        (0.0, 0.0, 40.0, {"slip_ratio": -1, "longitudinal_slip": 1, "longitudinal_force": -1}),
    ],
    ids=["drift to the left", "lean to the right", "braked"],
)
def test_signs(lean, drift, spin, signs):
    text = TOWED.replace("LEAN", str(lean)).replace("DRIFT", str(drift)).replace("SPIN", str(spin))
    run = RecordedRun(deck_of_bytes(text.encode(), str(INPUTS / "towed.yaml")))
    for name, sign in {"normal_force": 1, "spin_rate": 1, **signs}.items():
        value = run[f"elements/tyre/{name}"][-1]
        assert sign * (value[2] if name == "slip_moment" else value) > 1e-3, name
