"""Times at which signals are sampled, and what a sample is where its input jumps at that instant."""

import numpy as np
import pytest
from time_runs import RecordedRun, deck

CART = """
    mecano: 1
    gravity: none
    nodes: {cart: {position: [0, 0, 0]}}
    elements: {cart: {type: point_mass, node: cart, mass: 2}}
    joints: {rail: {type: prismatic, nodes: [ground, cart], axis: [1, 0, 0]}}
"""


def last_before(t, start, period):
    """Return the last sampling times before t; a row at a sampling time has the value before."""
    return start + period * np.maximum(np.ceil((t - start) / period - 1e-6) - 1.0, 0.0)


@pytest.mark.parametrize("method", ["generalized_alpha", "radau"])
@pytest.mark.parametrize("start", [100.0, 1000.0])
def test_samples_keep_their_times(start, method):
    """The sampled time itself, at 1/ms and 1/(0.7 ms): sums of periods would miss samples after a few hundred."""
    m = RecordedRun(
        deck(f"""{CART}
    signals:
      slow: {{type: sample_and_hold, input: time, period: 1 ms}}
      fast: {{type: sample_and_hold, input: time, period: 0.7 ms}}
    loads: {{push: {{type: joint_force, joint: rail, value: slow - fast}}}}
    time: {{start: {start}, end: {start + 0.25}, step: 10 ms, method: {method}}}
    """)
    )
    for name, period in (("slow", 1e-3), ("fast", 0.7e-3)):
        np.testing.assert_allclose(m[f"signals/{name}/value"], last_before(m.time, start, period), rtol=0.0, atol=1e-9)
    assert len(m.time) > 500
