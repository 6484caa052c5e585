"""Decide when to refactor the Newton tangent.

An iteration with a tangent that is ``age`` steps old reduces the residual to about drift * age of its norm. Two such
iterations cost less than a factorization, so a tangent is kept as long as two are expected to converge.
"""

from mecano.jit.kernel import kernel
from mecano.solve.linear.newton import FIRST, ITERATIONS, SECOND, SHARE

TRUST = 0.5  # of the residual norm: expected residual after two iterations up to which a tangent is kept
FORGET = 0.9  # factor of the drift in every step without an old tangent


@kernel
def choose_tangent(has, age, drift, renewed, report):
    """Decide whether the next step uses the tangent of this one: (whether, age in steps, drift).

    ``has``, ``age`` and ``drift`` are those with which this step began; ``renewed``: it evaluated a tangent.
    """
    first, before = report[FIRST], age
    age, drift = age + 1, drift * FORGET
    if not has:
        first /= SHARE
    elif first > 0.0:
        drift = report[SECOND] / first / before
    if renewed:  # keep it if it converges quickly
        has = report[ITERATIONS] <= (2.0 if has else 1.0)
        age = 1 if has else 0
    share = drift * age
    if not first * (share * share) <= TRUST:
        has = False
    return has, age, drift
