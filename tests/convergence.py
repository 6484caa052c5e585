"""Convergence of a run to a known solution: runs with steps h and h/2, the order, the extrapolated value."""

import numpy as np
from time_runs import RecordedRun, input_deck

SECOND_ORDER = 4.0, 0.3  # ratio of the errors with h and h/2, and what may be missing to it


def at_times(recorded, values, times):
    """Return the ``values`` (n, ...) of the accepted steps at ``times`` (m,), which must be ends of steps."""
    index = np.searchsorted(recorded.time, np.asarray(times) - 1e-9)
    np.testing.assert_allclose(recorded.time[index], times, rtol=0, atol=1e-9)
    return np.asarray(values)[index]


def pair(name, observe, times, h, *overrides):
    """Return ``observe(recorded)`` (n, ...) at ``times``, for a deck of inputs/ with steps h and h/2."""
    found = []
    for step in (h, h / 2.0):
        recorded = RecordedRun(input_deck(name, f"time.step={step}", f"time.end={max(times)}", *overrides))
        found.append(at_times(recorded, observe(recorded), times))
    return found


def check_second_order(coarse, fine, reference, extrapolated):
    """Errors against ``reference`` fall fourfold from h to h/2, and Richardson's value lies within ``extrapolated``.

    The extrapolated value is (4 fine - coarse)/3, whose error falls faster than the square of the step.
    """
    reference = np.asarray(reference)
    before, after = (float(np.abs(values - reference).max()) for values in (coarse, fine))
    ratio, (wanted, missing) = before / after, SECOND_ORDER
    assert abs(ratio - wanted) <= missing, f"errors {before:.3g}, {after:.3g}: ratio {ratio:.3f}"
    left = float(np.abs((4.0 * fine - coarse) / 3.0 - reference).max())
    assert left <= extrapolated, f"extrapolated value off by {left:.3g}"
    assert extrapolated <= after / 5.0, "the tolerance does not test more than the finer run alone"
