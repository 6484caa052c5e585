"""Whether the tangent of an earlier step will do for the next one.

An iteration with a tangent of ``age`` steps leaves about the share drift * age of the residual. Two such iterations
cost less than a factorization, so a tangent is kept as long as two are expected to do.
"""

from mecano.solve.linear.newton import FIRST, ITERATIONS, SECOND

SHARE = 0.001  # of the tolerances is met with an old tangent: what it leaves is not squared by the last iteration
TRUST = 0.5  # of the residual norm may be left where two iterations are expected to do
FORGET = 0.9  # the experience with old tangents, at every step that does without


def keep(history, used, report):
    """(tangent, age, drift) for the next step, after one that ended with the tangent of the state ``used``."""
    tangent, age, drift, first = history.tangent, history.age + 1, history.drift * FORGET, report[FIRST]
    if tangent is None:
        first /= SHARE
    elif first > 0.0:
        drift = report[SECOND] / first / history.age
    if tangent is not used:  # a new one was evaluated in this step; is it worth keeping?
        tangent, age = (used, 1) if report[ITERATIONS] <= (1 if tangent is None else 2) else (None, 0)
    if not first * (drift * age) ** 2 <= TRUST:
        tangent = None
    return tangent, age, float(drift)
