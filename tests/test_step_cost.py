"""What a step costs in Python, counted in calls, which do not depend on the machine; docs/benchmarks.md has times."""

import sys
from collections import Counter

from time_runs import input_deck

from mecano.analyses.dynamic import run
from mecano.solve.time.time_integration import TimeIntegrator

MOST = 0.2  # calls of Python's functions and of built-in ones for each step


def test_steps_of_a_pendulum_make_hardly_any_calls(tmp_path, monkeypatch):
    counted, to = Counter(), TimeIntegrator.to

    def count(frame, event, argument):
        counted[event] += 1

    def counting(integrator, end, start):
        sys.setprofile(count)
        try:
            return to(integrator, end, start)
        finally:
            sys.setprofile(None)

    run(input_deck("pendulum", "time.end=0.1"), tmp_path / "first.h5")  # finds the compiled code
    monkeypatch.setattr(TimeIntegrator, "to", counting)
    final = run(input_deck("pendulum", "time.end=10"), tmp_path / "r.h5")
    assert final.steps == 10000 and not final.rejected
    assert (counted["call"] + counted["c_call"]) / final.steps <= MOST
