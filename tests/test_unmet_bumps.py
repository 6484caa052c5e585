"""A run warns if no wheel meets a bump of its ground."""

import pytest
from time_runs import input_deck

from mecano.analyses.dynamic import run
from mecano.results.reader import open_results

BUMP = "{bump: {start: 1.0, length: 1.0, height: 0.02}}"


@pytest.mark.parametrize(
    ("end", "direction", "height", "warned"),
    [
        (0.32, 1, BUMP, False),  # the wheel rolls from -0.4 m on at 5 m/s, and meets the bump at 0.28 s
        (0.24, 1, BUMP, True),
        (0.32, -1, BUMP, True),
        (0.24, 1, "{sine: {amplitude: 1.0e-3, frequency: 0.1}}", False),
    ],
)
def test_a_bump_that_is_not_met(end, direction, height, warned, tmp_path):
    profile = f"{{direction: [{direction}, 0, 0], height: {height}}}"
    overrides = f"time.end={end}", "time.step=1.0e-3", f"grounds.track.profile={profile}"
    run(input_deck("trailing_wheel_bump", *overrides), tmp_path / "r.h5")
    with open_results(tmp_path / "r.h5") as results:
        found = [text for text in results.warnings if "no wheel met a bump of ground 'track'" in text]
    assert len(found) == warned
