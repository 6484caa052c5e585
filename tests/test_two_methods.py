"""Generalized-alpha and Radau IIA, which share elements but neither steps nor error estimates, find the same motion."""

import numpy as np
import pytest
from time_runs import INPUTS, RecordedRun, input_deck

TOLERANCE = 1e-6
LONG = {"reflector", "reflector_template"}  # stiff members: both need more than 1e5 steps
DECKS = sorted({path.stem for path in INPUTS.glob("*.yaml")} - LONG)


@pytest.mark.slow
@pytest.mark.parametrize("name", DECKS)
def test_a_quarter_of_a_run(name):
    """All positions and angles at its end, to twenty tolerances: links much shorter than the mechanism turn by more.

    An error of a speed adds up: angles of many turns are compared by the turn.
    """
    deck = input_deck(name)
    if not deck.values["time"]:
        pytest.skip("not integrated")
    start, end = deck.values["time"]["start"], deck.values["time"]["end"]
    control = f"time.end={start + 0.25 * (end - start)!r}", f"time.adaptive={{tolerance: {TOLERANCE}}}"
    one, other = (
        RecordedRun(input_deck(name, *control, f"time.method={method}")) for method in ("generalized_alpha", "radau")
    )
    assert one.run.motion.t == pytest.approx(other.run.motion.t, abs=1e-9 * end)
    assert len(one.event_records) == len(other.event_records)
    for path, column in one.columns.items():
        if column.unit in ("m", "rad"):
            turns = np.abs(other[path][-1]).max() / (2.0 * np.pi)
            scale = one.prepared.length if column.unit == "m" else max(1.0, turns)
            np.testing.assert_allclose(
                one[path][-1] / scale, other[path][-1] / scale, rtol=0, atol=20 * TOLERANCE, err_msg=path
            )
