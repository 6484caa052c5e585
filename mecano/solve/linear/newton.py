"""Newton iterations with a factor that is kept, in one compiled call.

They go on while the residual falls quickly enough. Otherwise they ask for a new tangent (STALE), which the caller
evaluates and factors before it calls again: the choice of the linear solver is none of theirs.
"""

import numpy as np

from mecano.compiled.entry import Indices, Matrices, Matrix, Records, Short, Table, Vector, entry
from mecano.compiled.kernel import kernel
from mecano.errors import Failure
from mecano.model.conduct import aim, residual
from mecano.model.loops import BATCH, SYSTEM
from mecano.solve.diagnostics.scales import norms
from mecano.solve.events.compliance import soften
from mecano.solve.linear.multifrontal import substitute
from mecano.solve.time.increments import correct

SLOW = 0.1  # a kept factor is used again as long as the residual falls by more than this

CONVERGED, STALE, NOT_FINITE, TOO_MANY, SINGULAR, DIVERGES = range(6)
MESSAGES = {
    NOT_FINITE: "a residual is not finite",
    TOO_MANY: "no convergence in {} iterations",
    SINGULAR: "the tangent is singular",
    DIVERGES: "no convergence: corrections grow beyond the size of the mechanism",
}
FAILURES = dict.fromkeys(MESSAGES, Failure.NOT_CONVERGED) | {
    NOT_FINITE: Failure.NOT_FINITE,
    SINGULAR: Failure.SINGULAR,
}

# What is known of the iterations, a vector: their number; forces, constraints and increment now, over their tolerances;
# the largest residual before the last iteration, now, before the first one and after it.
REPORT = ITERATIONS, FORCES, CONSTRAINTS, INCREMENT, LAST, WORST, FIRST, SECOND = range(8)


@entry
def iterate(
    # equations
    loops: Indices, batches: Records(BATCH), system: Records(SYSTEM), r: Vector, size: Vector,
    starts: Indices, columns: Indices, compliances: Vector,
    # factor
    order: Indices, fronts: Table, links: Short, factors: Vector, exchanges: Indices, vectors: Matrix,
    # model
    kind: Indices, rotation_dof: Indices, n_q: int, n: int,
    # limits
    length: float, force_tolerance: float, constraint_tolerance: float, increment_tolerance: float, most: int,
    # increment, in and out
    x: Vector,
    # step
    k: float, penalty: float, cC: float, cM: float, stiffness: float, reach: float, share: float,
    kept: bool, usable: bool, pending: bool,
    # state, moved
    t: float, R0: Matrices, z: Vector, v: Vector, a: Vector, R: Matrices, modes: Indices, memory: Vector,
    # out
    report: Vector,
) -> int:  # fmt: skip
    """Iterate from the present state: one of the codes above.

    ``pending``: x solves for the present residual, whose largest norm is report[WORST]. ``kept``: the factor belongs to
    an earlier solution and is expected to do for two iterations. ``usable``: the factor may be used at all.
    """
    aim(system, t, z, v, a, R, modes, memory)
    system[0].lag = 1.0 / cC
    while True:
        if pending:
            report[LAST] = report[WORST]
            moved = correct(length, kind, rotation_dof, n_q, n, x, k, cC, cM, R0, z, v, a, R)
            report[INCREMENT] = moved / increment_tolerance
            report[ITERATIONS] += 1
        residual(loops, batches, system, k, penalty)
        soften(k, starts, columns, compliances, z[n_q:n], r[n_q:n])
        forces, constraints = norms(
            r, size, kind, n, length, force_tolerance, constraint_tolerance, share, k, stiffness, reach
        )
        code = judge(report, forces, constraints, most, kept, usable)
        if code >= 0:
            return code
        substitute(r[:n], order, fronts, links, factors, exchanges, vectors, x)
        pending = True


@kernel
def judge(report, forces, constraints, most, kept, usable):
    """Enter the present norms; one of the codes, or -1 to go on with the factor at hand."""
    worst = max(forces, constraints)
    report[WORST], report[FORCES], report[CONSTRAINTS] = worst, forces, constraints
    iteration = report[ITERATIONS]
    if iteration == 0:
        report[FIRST] = worst
    elif iteration == 1:
        report[SECOND] = worst
    if not np.isfinite(worst):
        return NOT_FINITE
    if iteration and worst <= 1.0 and report[INCREMENT] <= 1.0:
        return CONVERGED
    if iteration == most:
        return TOO_MANY
    if not usable:
        return STALE
    if iteration == 0:
        return -1
    slow = worst * worst > report[LAST] if kept and iteration == 1 else worst > SLOW * report[LAST]
    return STALE if slow else -1
