"""Decide when to refactor the Newton tangent.

An iteration with a tangent that is ``age`` steps old reduces the residual to about drift * age of its norm. A few such
iterations, more in larger models, cost less than a new tangent with its factorization; a tangent is kept as long as
that number is expected to converge.
"""

import math

from mecano.jit.kernel import kernel
from mecano.solve.linear.newton import FIRST, ITERATIONS, SECOND, SHARE

FEW = 2  # iterations with a kept tangent in small models
LARGER = 90  # unknowns from which a model is not small
TRUST = 0.5  # of the residual norm: expected residual after the iterations up to which a tangent is kept
FORGET = 0.9  # factor of the drift in every step without an old tangent
IN_VAIN = 0.3  # least drift after a step in which the tangent of the last one did not suffice


def most_kept(n):
    """Return how many iterations with a kept tangent cost less than a new one of n unknowns.

    Fitted to the fastest choice among 2 to 12 for ten four-bars and for chains of 10 to 1000 bars (104 to 11,000
    unknowns), which is 4 to 8. In small models more than two gain 4 % at most, and leave larger residuals.
    """
    return FEW if n < LARGER else round(0.6 * math.log2(n))


@kernel
def choose_tangent(has, age, drift, renewed, report, most_kept):
    """Decide whether the next step uses the tangent of this one; return (decision, age in steps, drift).

    ``has``, ``age`` and ``drift`` are those with which this step began; ``renewed``: it evaluated a tangent;
    ``most_kept``: iterations that may be made with an old one.
    """
    first, before = report[FIRST], age
    age, drift = age + 1, drift * FORGET
    if not has:
        first /= SHARE
    elif first > 0.0:
        drift = report[SECOND] / first / before
    if renewed:  # keep it if it converges quickly, unless that of the step before did not suffice in this one
        if has and before == 1:
            has, drift = False, max(drift, IN_VAIN)
        else:
            has = report[ITERATIONS] <= (most_kept if has else 1.0)
        age = 1 if has else 0
    share = drift * age
    if not first * share**most_kept <= TRUST:
        has = False
    return has, age, drift
