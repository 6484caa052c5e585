"""The state of a run is one value: saved, loaded and marched on, it gives the same bits."""

import h5py
import numpy as np
import pytest
from marching import deck

from mecano.prepare import march_of, prepare
from mecano.results.state import load_state, save_state
from mecano.solve.run_state import from_plain, to_plain

DECK = """
    mecano: 1
    nodes:
      a: {position: [0, 0, 0]}
      b: {position: [1, 0, 0]}
      c: {position: [1, 0, 0]}
    elements:
      upper: {type: rigid_body, node: a, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1], attached: [b]}
      lower: {type: rigid_body, node: c, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1]}
    joints:
      shoulder: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}
      elbow: {type: hinge, nodes: [b, c], axis: [0, 1, 0.2]}
    time: {end: 1.0, step: 0.005, %s}
"""


@pytest.mark.parametrize("control", ["rho_inf: 0.9", "adaptive: {tolerance: 1.0e-3}"])
def test_a_run_goes_on_from_its_saved_state_with_the_same_bits(control, tmp_path):
    checked = deck(DECK % control)
    prepared = prepare(checked)
    march = march_of(prepared)
    middle = march.to(0.5, march.begin(prepared.state, 0.005))
    end = march.to(1.0, middle)
    with h5py.File(tmp_path / "state.h5", "w") as file:
        save_state(file, "middle", to_plain(middle))
        loaded = from_plain(load_state(file["middle"]))
    again = prepare(checked)
    other = march_of(again).to(1.0, loaded)
    assert other.steps == end.steps > 100
    assert np.array_equal(other.motion.z, end.motion.z) and np.array_equal(other.motion.R, end.motion.R)
    assert other.dissipated == end.dissipated and other.h == end.h


def test_rejected_steps_leave_nothing_behind():
    prepared = prepare(deck(DECK % "rho_inf: 0.9"))
    march = march_of(prepared)
    plain = march.to(1.0, march.begin(prepared.state, 0.005))
    march = march_of(prepare(deck(DECK % "rho_inf: 0.9")))
    step, calls = march.method.step, []

    def every_third_twice(s, history, h):
        calls.append(h)
        if len(calls) % 3 == 0:
            step(s, march.method.restart(s, history, 0.3 * h), 0.3 * h)
        return step(s, history, h)

    march.method.step = every_third_twice
    disturbed = march.to(1.0, march.begin(prepared.state, 0.005))
    assert len(calls) >= 200
    assert np.array_equal(disturbed.motion.z, plain.motion.z)
