"""Newton iteration on any residual; knows nothing of time or mechanics."""

from dataclasses import dataclass

import numpy as np

SLOW = 0.1  # the factor of the last iteration is used again as long as the residual falls by more than this


@dataclass(slots=True)
class NewtonResult:
    """How the iteration ended; ``norms`` are residuals and increments over their tolerances, each <= 1 when met."""

    ok: bool
    iterations: int
    norms: tuple
    message: str = ""


def newton(evaluate, solve, correct, *, max_iterations):
    """Solve r(z) = 0 at least once, until residual and increment meet their tolerances.

    evaluate(tangent) -> tuple of residual norms over their tolerances, at the current z, with its tangent if asked for;
    solve(fresh) -> increment, with the last tangent evaluated or, not fresh, with the factor kept from before, None if
    singular; correct(dz) -> norm of the increment over its tolerance; moves z. Never raises for non-convergence.
    """
    increment, last = np.inf, np.inf
    for iteration in range(max_iterations + 1):
        norms = evaluate(iteration == 0)
        worst = max(norms)
        if not np.isfinite(worst):
            return NewtonResult(False, iteration, (*norms, increment), "a residual is not finite")
        if iteration and worst <= 1.0 and increment <= 1.0:
            return NewtonResult(True, iteration, (*norms, increment))
        if iteration == max_iterations:
            break
        fresh = not iteration or worst > SLOW * last
        if fresh and iteration:
            evaluate(True)
        dz = solve(fresh)
        if dz is None:
            return NewtonResult(False, iteration, (*norms, increment), "the tangent is singular")
        increment, last = correct(dz), worst
    return NewtonResult(False, max_iterations, (*norms, increment), f"no convergence in {max_iterations} iterations")
