"""Whether the tangent of an earlier step will do for the next one.

An iteration with a tangent of ``age`` steps leaves about the share drift * age of the residual. Two such iterations
cost less than a factorization, so a tangent is kept as long as two are expected to do.
"""

from mecano.jit.kernel import kernel
from mecano.solve.linear.newton import FIRST, ITERATIONS, SECOND, SHARE

TRUST = 0.5  # of the residual norm may be left where two iterations are expected to do
FORGET = 0.9  # the experience with old tangents, at every step that does without


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
    if renewed:  # is the new one worth keeping?
        has = report[ITERATIONS] <= (2.0 if has else 1.0)
        age = 1 if has else 0
    share = drift * age
    if not first * (share * share) <= TRUST:
        has = False
    return has, age, drift
