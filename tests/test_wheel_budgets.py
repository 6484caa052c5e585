"""Energy of the examples with wheels: rolling conserves it, friction only removes it, and the budget closes."""

import numpy as np
import pytest
from time_runs import RecordedRun, input_deck

EXAMPLES = (
    "axle_on_slope",
    "bicycle",
    "braked_wheel",
    "caster_shimmy",
    "nose_gear_rigid",
    "nose_landing_gear",
    "paper_disc",
    "rolling_disc",
    "shimmy_freeplay",
    "sleigh",
    "step_steer",
    "trailing_wheel_bump",
    "wheel_drop",
    "wheel_spin_up",
)
ROLLING = ("bicycle", "paper_disc", "rolling_disc", "sleigh")  # nothing drives, brakes or slips


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_budget_closes(name):
    """To two millionths of the energy at the start, over all accepted steps."""
    recorded = RecordedRun(input_deck(name))
    total = recorded["energy/total"].ravel()
    balance = recorded["energy/balance"].ravel()
    assert np.abs(balance - balance[0]).max() < 2e-6 * total[0]
    dissipated = np.diff(recorded["energy/dissipated"].ravel())
    assert dissipated.min() > -1e-12 * total[0]
    if name in ROLLING:
        assert np.ptp(total) < 1e-6 * total[0]
