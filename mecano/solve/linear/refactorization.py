"""Decide when to refactor the Newton tangent.

An iteration with a tangent that is ``age`` steps old reduces the residual to about drift * age of its norm. The tangent
is kept as long as the iterations expected in the next step are fewer than a step has cost on average since it was
factored, the factorization included: this average is then least.
"""

import math

from mecano.jit.kernel import kernel
from mecano.solve.linear.newton import FIRST, ITERATIONS, SECOND, SHARE
from mecano.solve.linear.rounding import TINY

PRICE = 6.0  # iterations that cost as much as a new tangent and its factorization, in small models
SMALL = 450  # unknowns up to which a model is small
TRUST = 0.5  # of the residual norm: expected residual after the iterations up to which a tangent is kept
FORGET = 0.9  # factor of the drift in every step without an old tangent
IN_VAIN = 0.3  # least drift after a step in which the tangent of the last one did not suffice


@kernel
def price(n):
    """Return how many iterations cost as much as a new tangent of n unknowns and its factorization.

    Fitted to the fastest choice among 3 to 20 for linkages, chains, wheels, a car and masts of 5 to 11,000 unknowns.
    """
    return PRICE if n < SMALL else PRICE * math.sqrt(math.sqrt(n / SMALL))


@kernel
def most_kept(spent, age, most):
    """Return the most iterations of a step with an old tangent: what a step has cost on average, rounded up.

    Of ``most`` iterations of a step, half are left for a new tangent.
    """
    return min(math.ceil(spent / max(age, 1)), (most - 1) // 2)


@kernel
def choose_tangent(has, age, drift, spent, renewed, report, most, n):
    """Decide whether the next step uses the tangent of this one; return (decision, age in steps, drift, spent).

    ``has``, ``age``, ``drift`` and ``spent`` are those with which this step began; ``renewed``: it evaluated a tangent;
    ``spent``: iterations since the factorization, which counts as ``price(n)`` of them; ``most``: those that a step may
    make; ``n``: unknowns.
    """
    first, before, ratio = report[FIRST], age, report[SECOND] / max(report[FIRST], TINY)
    age, spent, drift = age + 1, spent + report[ITERATIONS], ratio / before if has else drift * FORGET
    keeps = True
    if renewed:
        age, spent = 1, price(n) + 1.0
        if has and before == 1:  # the tangent of the step before did not suffice
            keeps, drift = False, max(drift, IN_VAIN)
        elif not has:
            first, drift = first / SHARE, max(drift, ratio)
    fewer = most_kept(spent, age, most) - 1
    keeps = keeps and fewer > 0 and first * (drift * age) ** fewer <= TRUST
    return keeps, age if keeps else 0, drift, spent
