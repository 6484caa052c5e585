"""Steps made many at a time in compiled code are those that Python makes one at a time, bit for bit."""

import numpy as np
import pytest
import surviving
from surviving import check_same, contents
from time_runs import deck, input_deck

from mecano.analyses.dynamic import run
from mecano.solve.time.time_integration import TimeIntegrator

TWO_BARS = """
    mecano: 1
    gravity: [0, 0, -9.81]
    nodes: {a: {position: [0, 0, 0]}}
    elements: {bar: {type: rigid_body, node: a, mass: 1, center_of_mass: [0.5, 0, 0], inertia: [0.01, 0.1, 0.1]}}
    joints:
      one: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}
      two: {type: hinge, nodes: [ground, a], axis: [0, 1, 0]}
    time: {end: 0.5, step: 2.0e-3}
    output: {every: 0.0033}
"""


RADAU = "time.method=radau", "output.every=0.00123"
BY_RADAU = (  # deck and overrides
    ("four_bar", "time.end=0.5", "time.adaptive={tolerance: 1.0e-6}"), ("wheel_drop", "time.end=0.8"),
    ("bicycle", "time.end=0.3"), ("position_servo", "time.end=0.3"), ("controlled_double_pendulum", "time.end=0.3"),
)  # fmt: skip


def decks():
    """Events, shocks, memory, adaptive steps, tangents that are kept, constraints that repeat one another."""
    return surviving.decks() | {
        "pendulum": input_deck("pendulum", "time.end=0.5", "output.every=0.00123"),
        "rolling_disc": input_deck("rolling_disc", "time.end=0.3"),
        "axle_on_slope": input_deck("axle_on_slope", "time.end=0.5"),
        "axle_on_slope, adaptive": input_deck("axle_on_slope", "time.end=1", "time.adaptive={tolerance: 1.0e-4}"),
        "two_hinges": deck(TWO_BARS),
        "two_hinges, radau": deck(TWO_BARS.replace("time: {", "time: {method: radau, ")),
    } | {f"{name}, radau": input_deck(name, *RADAU, *more) for name, *more in BY_RADAU}  # fmt: skip


@pytest.mark.parametrize("name", decks())
def test_many_steps_in_one_call_are_those_of_python(name, tmp_path, monkeypatch):
    checked = decks()[name]
    fast, steps = run(checked, tmp_path / "fast.h5"), []
    run(checked, tmp_path / "observed.h5", observers=(lambda accepted: steps.append(accepted.h),))
    monkeypatch.setattr(TimeIntegrator, "ordinary", lambda integrator, run, stop: (run, None, True))
    slow = run(checked, tmp_path / "slow.h5")
    assert (fast.steps, fast.rejected, fast.iterations) == (slow.steps, slow.rejected, slow.iterations)
    assert len([h for h in steps if h]) == fast.steps
    assert np.array_equal(fast.motion.z, slow.motion.z) and fast.dissipated == slow.dissipated
    for other in ("observed.h5", "slow.h5"):
        check_same(contents(tmp_path / other), contents(tmp_path / "fast.h5"))
