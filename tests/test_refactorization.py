"""When Newton's tangent is factored again: the mean cost of a step is near the least of all choices."""

import math

import numpy as np
import pytest

from mecano.solve.linear.newton import FIRST, ITERATIONS, SECOND, SHARE
from mecano.solve.linear.refactorization import PRICE, choose_tangent

MOST = 15  # iterations of a step
RESIDUAL = 1e4  # of each step before its first iteration, over the tolerance


def needed(drift, age):
    """Return the iterations that leave SHARE of the tolerance, each a share drift * age of the residual before."""
    return math.ceil(math.log(RESIDUAL / SHARE) / -math.log(drift * age)) if drift * age < 1.0 else math.inf


def mean_cost(drift, steps=2000):
    """Return the mean cost of a step, in iterations, by the choices of ``choose_tangent``."""
    has, age, measured, spent, total = False, 0, 0.0, 0.0, 0.0
    for _ in range(steps):
        report = np.zeros(8)
        iterations = needed(drift, age) if has else 1
        report[ITERATIONS], report[FIRST] = iterations, RESIDUAL / SHARE if has else RESIDUAL
        report[SECOND] = report[FIRST] * (drift * age if has else 1e-6)
        total += iterations + (0.0 if has else PRICE)
        has, age, measured, spent = choose_tangent(has, age, measured, spent, not has, report, MOST, 9)
    return total / steps


def least_cost(drift):
    """Return the least mean cost with tangents that serve any constant number of steps."""
    costs, total = [], PRICE + 1.0
    for age in range(1, 500):
        costs.append(total / age)
        if not drift * age < 1.0:
            break
        total += needed(drift, age)
    return min(costs)


@pytest.mark.parametrize("drift", [1e-5, 1e-3, 1e-2, 0.1, 0.3])
def test_the_mean_cost_of_a_step_is_nearly_the_least(drift):
    """Within 8 %, as the drift of a step is known only after it."""
    assert mean_cost(drift) <= 1.08 * least_cost(drift)


def test_a_tangent_that_serves_no_other_step_is_not_tried_again_and_again():
    """Where one step spoils it, one step in five or fewer begins with the tangent of the step before."""
    has, age, drift, spent, tried = False, 0, 0.0, 0.0, 0
    for _ in range(500):
        report = np.zeros(8)
        report[ITERATIONS], report[FIRST], report[SECOND] = 3.0, RESIDUAL / SHARE, 0.9 * RESIDUAL / SHARE
        if not has:
            report[ITERATIONS], report[FIRST], report[SECOND] = 1.0, RESIDUAL, 1e-6 * RESIDUAL
        tried += has
        has, age, drift, spent = choose_tangent(has, age, drift, spent, True, report, MOST, 9)
    assert 0 < tried <= 100
