"""Newton iteration on any residual, driven from Python; independent of time and mechanics."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from mecano.errors import Failure
from mecano.solve.linear import newton
from mecano.solve.linear.newton import FAILURES, MESSAGES, NOT_FINITE, SLOW, TOO_MANY

SINGULAR = MESSAGES[newton.SINGULAR]
Exhausted: TypeAlias = Callable[[float, float, bool], bool]  # see ``iterate``


@dataclass(slots=True)
class Iterated:
    """Outcome of an iteration; ``norms`` are residuals and increments over their tolerances, <= 1 if converged."""

    ok: bool
    iterations: int
    norms: tuple[float, ...]
    message: str = ""
    failure: Failure = Failure.NOT_CONVERGED  # if not ok


def iterate(
    evaluate: Callable[[bool], tuple[float, ...]],
    solve: Callable[[bool], np.ndarray | None],
    move: Callable[[np.ndarray], float],
    *,
    most: int,
    exhausted: Exhausted,
) -> Iterated:
    """Solve r(z) = 0 by at least one iteration until residual and increment meet their tolerances; never raise.

    evaluate(tangent) returns a tuple of residual norms over their tolerances at the current z and, if ``tangent``,
    evaluates the tangent; solve(fresh) returns the increment, from the last tangent or, if not fresh, from the factor
    kept, None if singular; move(dz) moves z and returns the norm of dz over its tolerance; exhausted(this norm, the
    residual over that before dz, fresh) returns whether the remaining residual is rounding error. At most ``most``
    iterations.
    """
    increment, last, fresh = np.inf, np.inf, False
    for iteration in range(most + 1):
        norms = evaluate(iteration == 0)
        worst = max(norms)
        if not np.isfinite(worst):
            return Iterated(False, iteration, (*norms, increment), MESSAGES[NOT_FINITE], FAILURES[NOT_FINITE])
        if iteration and increment <= 1.0 and (worst <= 1.0 or exhausted(increment, worst / last, fresh)):
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
