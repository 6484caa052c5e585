"""Newton iteration on any residual, conducted from Python; knows nothing of time or mechanics."""

from dataclasses import dataclass

import numpy as np

from mecano.errors import Failure
from mecano.solve.linear import newton
from mecano.solve.linear.newton import FAILURES, MESSAGES, NOT_FINITE, SLOW, TOO_MANY

SINGULAR = MESSAGES[newton.SINGULAR]


@dataclass(slots=True)
class Iterated:
    """How the iteration ended; ``norms`` are residuals and increments over their tolerances, each <= 1 when met."""

    ok: bool
    iterations: int
    norms: tuple
    message: str = ""
    failure: Failure = Failure.NOT_CONVERGED  # where not ok


def iterate(evaluate, solve, move, *, most):
    """Solve r(z) = 0 at least once, until residual and increment meet their tolerances; never raises.

    evaluate(tangent) -> tuple of residual norms over their tolerances, at the current z, with its tangent if asked for;
    solve(fresh) -> increment, with the last tangent evaluated or, not fresh, with the factor kept from before, None if
    singular; move(dz) -> norm of the increment over its tolerance; moves z. ``most`` iterations.
    """
    increment, last = np.inf, np.inf
    for iteration in range(most + 1):
        norms = evaluate(iteration == 0)
        worst = max(norms)
        if not np.isfinite(worst):
            return Iterated(False, iteration, (*norms, increment), MESSAGES[NOT_FINITE], FAILURES[NOT_FINITE])
        if iteration and worst <= 1.0 and increment <= 1.0:
            return Iterated(True, iteration, (*norms, increment))
        if iteration == most:
            break
        fresh = not iteration or worst > SLOW * last
        if fresh and iteration:
            evaluate(True)
        dz = solve(fresh)
        if dz is None:
            return Iterated(False, iteration, (*norms, increment), SINGULAR, Failure.SINGULAR)
        increment, last = move(dz), worst
    return Iterated(False, most, (*norms, increment), MESSAGES[TOO_MANY].format(most))
