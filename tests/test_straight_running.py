"""Straight steady running: what it leaves as the deck says."""

import numpy as np
from time_runs import INPUTS, deck

from mecano.analyses.initial_state import set_initial_state
from mecano.analyses.prepare import prepare


def test_an_integrator_that_nothing_reads_keeps_its_initial_value():
    """The yaw rate of a carriage in straight running is zero but for rounding, which must not move the integrator."""
    text = (INPUTS / "caster_shimmy.yaml").read_text(encoding="utf-8")
    yaw = "{type: integrator, input: carriage.angular_velocity.z, initial: 0.3}"
    prepared = prepare(deck(f"{text}\nsignals: {{yaw: {yaw}}}\n"))
    set_initial_state(prepared)
    signals = prepared.state.z[: prepared.system.n_q][prepared.system.signals]
    np.testing.assert_allclose(signals[0], 0.3, rtol=1e-12)


SPRUNG = """
mecano: 1
gravity: [0, 0, -9.81]
nodes:
  body: {position: [0, 0, 0.8]}
  axle: {position: [0, 0, 0.3]}
  hub: {position: [0, 0, 0.3]}
elements:
  load: {type: rigid_body, node: body, mass: 300, inertia: [20, 20, 20]}
  carrier: {type: rigid_body, node: axle, mass: 20, inertia: [0.5, 0.5, 0.5]}
  rim: {type: rigid_body, node: hub, mass: 15, inertia: [0.4, 0.7, 0.4]}
  wheel: {type: wheel, node: hub, axis: [0, 1, 0], tire_law: tyre, ground: road}
joints:
  upright: {type: held_rotation, nodes: [ground, body]}
  guide: {type: prismatic, nodes: [body, axle], axis: [0, 0, 1], stops: {lower: 0}, sliding_law: {preload: %s}}
  bearing: {type: hinge, nodes: [axle, hub], axis: [0, 1, 0]}
tire_laws:
  tyre: {radius: 0.3, radial: {linear: {slope: 2.0e5}}, friction: 0.9, slip_regularization: 0.1}
grounds:
  road: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
initial: {steady: {velocity: [10, 0, 0]}}
time: {end: 1, step: 1 ms}
"""


def test_a_stop_that_a_preload_presses_holds_in_steady_running():
    """A gas spring extends its strut against a stop with 5 kN, more than the weight of 300 kg: the strut stays there.

    The tyre is pressed in by the whole weight over its stiffness.
    """
    prepared = prepare(deck(SPRUNG % "5000"))
    set_initial_state(prepared)
    z = prepared.state.z[prepared.system.numbering.x + 2]
    body, axle = (z[[node.name for node in prepared.system.nodes].index(name)] for name in ("body", "axle"))
    assert abs(body - axle - 0.5) < 1e-9
    assert abs(axle - (0.3 - 335.0 * 9.81 / 2e5)) < 1e-8
