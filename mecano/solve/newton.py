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
    first: float  # largest residual norm before the first iteration
    second: float  # and after it
    message: str = ""


def newton(evaluate, solve, correct, *, kept, max_iterations):
    """Solve r(z) = 0 at least once, until residual and increment meet their tolerances.

    evaluate(tangent) -> tuple of residual norms over their tolerances, at the current z, with its tangent if asked for;
    solve(fresh) -> increment, with the last tangent evaluated or, not fresh, with the factor kept from before, None if
    singular; correct(dz) -> norm of the increment over its tolerance; moves z. ``kept``: there is a factor, of an
    earlier solution, that is expected to do for two iterations. Never raises for non-convergence.
    """
    increment = last = first = second = np.inf
    fresh = not kept
    norms = evaluate(fresh)
    for iteration in range(max_iterations + 1):
        worst = max(norms)
        if iteration < 2:
            first, second = (first, worst) if iteration else (worst, np.inf)
        if not np.isfinite(worst):
            return NewtonResult(False, iteration, (*norms, increment), first, second, "a residual is not finite")
        if iteration and worst <= 1.0 and increment <= 1.0:
            return NewtonResult(True, iteration, (*norms, increment), first, second)
        if iteration == max_iterations:
            break
        if iteration:
            fresh = worst * worst > last if kept and iteration == 1 else worst > SLOW * last
            if fresh:
                worst = max(evaluate(True))
        dz = solve(fresh)
        if dz is None:
            return NewtonResult(False, iteration, (*norms, increment), first, second, "the tangent is singular")
        increment, last = correct(dz), worst
        norms = evaluate(False)
    message = f"no convergence in {max_iterations} iterations"
    return NewtonResult(False, max_iterations, (*norms, increment), first, second, message)
