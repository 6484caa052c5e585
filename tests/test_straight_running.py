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
