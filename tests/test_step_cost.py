"""What a step costs in Python, counted in calls, which do not depend on the machine; docs/benchmarks.md has times."""

import sys
from collections import Counter

from marching import input_deck

from mecano.analyses.dynamic import run
from mecano.solve.time.march import March

MOST = 160  # calls of Python's functions and of built-in ones for each step; 157 in Python 3.11


def test_a_step_of_a_pendulum_makes_no_more_calls(tmp_path, monkeypatch):
    counted, to = Counter(), March.to

    def count(frame, event, argument):
        counted[event] += 1

    def counting(march, end, start):
        sys.setprofile(count)
        try:
            return to(march, end, start)
        finally:
            sys.setprofile(None)

    monkeypatch.setattr(March, "to", counting)
    final = run(input_deck("pendulum"), tmp_path / "r.h5")
    assert final.steps == 2000 and not final.rejected
    assert 0.8 * MOST < (counted["call"] + counted["c_call"]) / final.steps <= MOST
