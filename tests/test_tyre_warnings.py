"""Tyre data that do not fit a patch which slides or twists: warnings before a run."""

import numpy as np
import pytest
from marching import input_deck
from towed_wheel import MORELAND, SIGMA, SPEED, SPIN_INERTIA, towed

from mecano.prepare import prepare, warnings_of

KAP, ROLLING = 1e4, float(np.radians(5.0))


def test_a_law_whose_rates_run_away_is_warned_of():
    """A1 of Moreland's law has a negative symmetric part below C1 = kap C^2 D/4: 2e-5 s here."""
    (found,) = towed(MORELAND % (500.0, 1.9e-5, KAP)).warnings
    assert found.message.startswith(
        "tire law 'rubber': 'lateral.moreland.yaw_time' is 1.9e-05 s, less than torsional_stiffness yaw_coefficient^2 "
        "lateral_damping/4 = 2e-05 s: the rates of its patch may run away"
    )
    assert found.mark.text.strip().startswith("lateral: {moreland")
    assert towed(MORELAND % (500.0, 2.1e-5, KAP)).warnings == ()
    full = "{{matrices: {{stiffness: [7e5, 0, 0, 1e4], damping: [9, 0, -{0}, 4]}}}}"
    assert [len(towed(full.format(mixed)).warnings) for mixed in (11.9, 12.1)] == [0, 1]  # 9 x 4 = (12/2)^2


@pytest.mark.parametrize(("share", "warned"), [(0.9, True), (1.1, False)])
def test_a_twist_that_swings_with_the_spin_is_warned_of(share, warned):
    """Routh's bound for the slip angle of the start, with the radius of the tyre without load, leaning or not."""
    y, r = ROLLING * SIGMA, 0.45
    needed = SPEED * SPIN_INERTIA * y * y / (SIGMA * r * r * KAP)
    for lean in (0.0, 10.0):
        said = warnings_of(prepare(towed(MORELAND % (0.0, share * needed, KAP), angle=ROLLING, lean=lean)))
        assert len(said) == warned
        for text in said:
            assert "flexible_wheel 'tire': where it rolls at the slip angle of its start, 5 deg at 60 m/s" in text
            assert f"'tire_law.lateral.moreland.yaw_time' ({share * needed:g} s) is more than {needed:.2g} s" in text


@pytest.mark.parametrize("name", ["nose_landing_gear", "step_steer", "caster_shimmy"])
def test_no_warning_of_good_tyres(name):
    assert warnings_of(prepare(input_deck(name))) == []
