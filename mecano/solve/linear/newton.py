"""Newton's iterations of a step, in one compiled call.

The factor of an earlier tangent is used as long as the residual falls quickly enough; otherwise the tangent is
evaluated and factored again. With a factor of an earlier step the residual must fall below SHARE of its tolerance; if
one correction from a residual within the tolerance is expected to reach that, it is the last, and the residual after it
is not evaluated. The call returns to Python, which then calls again, to look at signals of the process
before a factorization (PAUSE), or if the fixed order of elimination cannot factor the matrix (OTHERWISE).

Iterations also end where a new tangent reduces the residual no more, within ten times its tolerance, after corrections
far below theirs: the rounding of a position, which the next one cannot mend, goes through damping into the force on a
massless unknown and moves it by more than rounding.

Some corrections that overshoot are shortened by a line search (Matthies and Strang, Int. J. Numer. Methods Eng. 14
(1979) 1613-1626): those of unknowns on which a force with corners acts, such as that of a damped line, and, in a step
that is cut because a longer one failed, those of massless unknowns. Where a tyre, or a node without mass between a
spring and dry friction, begins to stick, the latter would alternate between sliding in both directions, however short
the step: friction that slides does not depend on the velocity, so the shorter the step, the longer they are. In the
same way a line that is slack and stiff in turn would throw its node to and fro.
"""

import numpy as np

from mecano.errors import Failure
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers
from mecano.model.assembly_driver import assemble, bind_state, residual, residual_loops, tangent_loops
from mecano.model.numbering import ROTATION, SIGNAL, STATE, TRANSLATION
from mecano.solve.diagnostics.scales import Limits, Scales, norms
from mecano.solve.events.compliance import soften
from mecano.solve.linear.rounding import ROUNDING, STALLS, TINY, at_rounding
from mecano.solve.linear.sparse import ACCEPT_BELOW
from mecano.solve.time.increments import Weights, correct, motion_tangents
from mecano.solve.time.workspace import (
    BEGIN,
    RENEWED,
    TRIAL,
    copy_state,
    is_due,
    start_spins,
    state_of,
    system_of,
    unknowns_of,
)

SLOW = 0.1  # a kept factor is used again as long as the residual falls by more than this
SHARE = 0.001  # of the tolerances, to be met with a kept tangent: its last iteration does not square the error
MOST_STALLED = 10.0  # largest residual, over its tolerance, at which iterations may end that reduce it no more
MOST_ROUNDING = 10.0  # largest residual, over its estimated rounding error, if the corrections are rounding errors
USUAL = 3  # corrections of most steps, after which those that overshoot are shortened
OVERSHOT = 0.5  # share of the work of the residual that may remain with the opposite sign
MOST_HALVINGS = 40  # of one correction: at the start of sticking it may be 1e10 times too long
MOST_MOVED = 3.0  # length scales, or rad, in one correction: iterations that move farther diverge

CONVERGED, STALE, NOT_FINITE, TOO_MANY, SINGULAR, DIVERGES, PAUSE, OTHERWISE = range(8)
CONTINUE, FINISH = -1, -2  # with the current factor; FINISH by one correction whose residual is not evaluated
MESSAGES = {
    NOT_FINITE: "a residual is not finite",
    TOO_MANY: "no convergence in {} iterations",
    SINGULAR: "the tangent is singular",
    DIVERGES: "no convergence: corrections grow beyond the size of the mechanism",
}
FAILURES = dict.fromkeys(MESSAGES, Failure.NOT_CONVERGED) | {NOT_FINITE: Failure.NOT_FINITE, SINGULAR: Failure.SINGULAR}

# Report of the iterations, a vector: their number; current forces, constraints and increment over their tolerances;
# the largest residual before the last iteration, after it, before the first one and after that.
ITERATIONS, FORCES, CONSTRAINTS, INCREMENT, LAST, WORST, FIRST, SECOND = range(8)


@kernel
def newton(w):
    """Iterate from the state TRIAL of the workspace, changed in place; return one of the codes above.

    ``stale``: the tangent must be renewed. ``pending``: the increment solves for the current residual, whose largest
    norm is report[WORST]. ``kept``: the factor belongs to an earlier solution, and ``most_kept`` iterations with it are
    expected to converge. ``usable``: the factor may be used at all.
    """
    while True:
        if w.stale:
            if is_due(w) and not w.paused:
                w.paused = 1
                return PAUSE
            w.paused = 0
            code = renew(w)
            if code != STALE:
                return code
        code = iterate(w)
        if code != STALE:
            return code
        w.stale = 1


@kernel
def iterate(w):
    """Iterate with the current factor; return STALE if a new one is needed, or another of the codes."""
    s, start, of, by = state_of(w, TRIAL), state_of(w, BEGIN), unknowns_of(w), Weights(w.k, w.cC, w.cM, w.h)
    r, x = floats(w.residual, w.n_all), floats(w.increment, w.n)
    report, system = floats(w.report, 8), system_of(w)
    loops = residual_loops(w)
    share = SHARE if w.kept and not w.renewed else 1.0
    bind_state(system, s)
    system[0].lag, code = 1.0 / w.cC, CONTINUE
    while True:
        work = searched_work(w, r, x) if w.pending else 0.0
        if w.pending:
            report[LAST], w.last_motion = report[WORST], w.motion
            report[INCREMENT] = correct(of, w.length, x, by, start, s) / w.increment_tolerance
            report[ITERATIONS] += 1
        if code == FINISH:
            return CONVERGED
        residual(loops, system, w.k, w.penalty)
        soften_rows(w, s.z, r)
        judged = w.strict or report[ITERATIONS] > USUAL and report[LAST] > 1.0  # not rounding
        if work and judged and searched_work(w, r, x) * work < -OVERSHOT * work * work:
            report[INCREMENT] *= shorten(w, work)
        before = report[FORCES], report[CONSTRAINTS]
        code = judge(w, report, before, measure(w, report, share))
        if code == CONVERGED or code == FINISH:  # the report is in whole tolerances
            report[FORCES], report[CONSTRAINTS] = share * report[FORCES], share * report[CONSTRAINTS]
        if code >= 0:
            return code
        call(w.substitute, w.substitute_words, 0)
        w.pending = 1


@kernel
def searched_work(w, r, x):
    """Return the work of the residual of the ``searched`` unknowns in their correction."""
    total = 0.0
    for i in integers(w.searched, w.n_searched):
        total += r[i] * x[i]
    return total


@kernel
def scale_searched(w, x_out, share):
    """Scale the correction of the ``searched`` unknowns, and drop that of all others."""
    searched, j = integers(w.searched, w.n_searched), 0
    for i in range(x_out.size):
        if j < w.n_searched and searched[j] == i:
            x_out[i] *= share
            j += 1
        else:
            x_out[i] = 0.0


@kernel
def shorten(w, work):
    """Shorten the last correction of the ``searched`` unknowns, whose residual did ``work`` in it and now opposes it.

    A bisection ends where the work of the residual is less than half of what it was. Returns the remaining share.
    """
    s, start, of, by = state_of(w, TRIAL), state_of(w, BEGIN), unknowns_of(w), Weights(w.k, w.cC, w.cM, w.h)
    r, x, system = floats(w.residual, w.n_all), floats(w.increment, w.n), system_of(w)
    loops = residual_loops(w)
    low, high, share, scale = 0.0, 1.0, 1.0, 1.0
    for _ in range(MOST_HALVINGS):
        change = 0.5 * (low + high) - share
        scale_searched(w, x, change / scale)
        share, scale = share + change, change
        correct(of, w.length, x, by, start, s)
        residual(loops, system, w.k, w.penalty)
        soften_rows(w, s.z, r)
        left = searched_work(w, r, x) / (scale * work)
        if abs(left) <= OVERSHOT:
            break
        low, high = (share, high) if left > 0.0 else (low, share)
    return share


@kernel
def measure(w, report, share):
    """Enter the norms of the current residual, for a ``share`` of the tolerances; return that of signals."""
    forces, constraints, signals = present_norms(w, share, 1.0, w.reach)
    w.motion = max(forces, constraints)
    report[FORCES], report[CONSTRAINTS] = max(forces, signals), constraints
    report[WORST] = max(report[FORCES], report[CONSTRAINTS])
    return signals


@kernel
def present_norms(w, share, most, reach):
    """Return the norms of the current residual, for a ``share``, ``most`` and ``reach`` of the Limits."""
    r, size = floats(w.residual, w.n_all), floats(w.size, w.n_all)
    scales = Scales(w.length, w.k, w.stiffness, w.duration, w.loudest)
    limits = Limits(w.force_tolerance, w.constraint_tolerance, share, most, reach)
    return norms(r, size, unknowns_of(w), state_of(w, TRIAL), scales, limits)


@kernel
def judge(w, report, before, signals):
    """Return one of the codes for the current norms; those of forces and constraints ``before`` the correction."""
    worst, iteration = report[WORST], report[ITERATIONS]
    if iteration == 0:
        report[FIRST] = worst
    elif iteration == 1:
        report[SECOND] = worst
    if not np.isfinite(worst):
        return NOT_FINITE
    rate = worst / max(report[LAST], TINY)
    reduction = w.motion / max(w.last_motion, TINY)  # the correction is of the motion alone
    if iteration and report[INCREMENT] * min(reduction, 1.0) <= 1.0:  # the next correction would be within tolerance
        rounded = at_rounding(report[INCREMENT] * w.increment_tolerance, reduction, w.renewed, w.reach, ROUNDING)
        rounded = rounded and (w.renewed or reduction > SLOW)  # reactions converge with the residual of an old tangent
        if rounded and signals > 1.0 and w.renewed and signals_at_rounding(w):
            signals = 1.0
        stalls = w.renewed and reduction > STALLS and worst <= MOST_STALLED and report[INCREMENT] <= SHARE
        if worst <= 1.0 or stalls or (signals <= 1.0 and rounded and not w.strict):
            return CONVERGED
        if signals <= 1.0 and rounded:  # the residual may be the rounding error of positions
            forces, constraints, _ = present_norms(w, 1.0, np.inf, w.farthest)
            if max(forces, constraints) <= MOST_ROUNDING:
                return CONVERGED
    if iteration == w.most:
        return TOO_MANY
    if not w.usable:
        return STALE
    if iteration == 0:
        return CONTINUE
    with_old = w.kept and not w.renewed and iteration < w.most_kept
    if with_old and not w.strict and worst * SHARE <= 1.0:  # within the tolerance already
        forces, constraints = after_next(report[FORCES], before[0]), after_next(report[CONSTRAINTS], before[1])
        if max(forces, constraints) <= 1.0:
            return FINISH
    return STALE if (worst * rate ** (w.most_kept - iteration) > 1.0 if with_old else rate > SLOW) else CONTINUE


@kernel
def signals_at_rounding(w):
    """Return whether residuals of signals are no larger than the rounding of what they read makes them.

    A signal that is a small difference of large quantities, or a multiple of one, is known no better.
    """
    s, of, data = state_of(w, TRIAL), unknowns_of(w), floats(system_of(w)[0].data, w.nnz)
    r, rows, columns = floats(w.residual, w.n_all), integers(w.rows, w.nnz), integers(w.columns, w.nnz)
    for i in range(w.n_q):
        if of.kind[i] == SIGNAL or of.kind[i] == STATE:
            terms = 0.0
            for j in range(w.nnz):
                if rows[j] == i:
                    terms += abs(data[j]) * known_as(w, of.kind[columns[j]], s.z[columns[j]])
            if abs(r[i]) > ROUNDING * terms:
                return False
    return True


@kernel
def known_as(w, kind, x):
    """Return the magnitude of an unknown x that determines its rounding."""
    if kind == TRANSLATION or kind == ROTATION:
        return w.reach * (w.length if kind == TRANSLATION else 1.0)
    return abs(x)


@kernel
def after_next(norm, before):
    """Return the norm that the next correction is expected to leave, as the one from the norm ``before`` did."""
    return norm * min(norm / max(before, TINY), 1.0)


@kernel
def renew(w):
    """Factor the tangent at TRIAL and solve for the residual there; return STALE to continue, or another code."""
    evaluate(w, TRIAL)
    report = floats(w.report, 8)
    measure(w, report, 1.0)
    if report[ITERATIONS] == 0.0:
        report[FIRST] = report[WORST]
    if not np.isfinite(report[WORST]):
        return NOT_FINITE
    if report[INCREMENT] * w.increment_tolerance > MOST_MOVED:
        return DIVERGES
    copy_state(w, TRIAL, RENEWED)
    results = floats(w.solve_results, 3)
    w.renewed = 1
    w.factorizations += 1
    call(w.solve, w.solve_words, w.solve_results)
    if not results[2] <= ACCEPT_BELOW:
        return OTHERWISE
    w.usable, w.pending, w.stale = 1, 1, 0
    return STALE


@kernel
def evaluate(w, which):
    """Evaluate residual and tangent at one of the four states, with the compliance."""
    s, T, system = state_of(w, which), floats(w.T, (3 * w.n_rotations, 3, 3)), system_of(w)
    by = Weights(w.k, w.cC, w.cM, w.h)
    motion_tangents(integers(w.rotation_dof, w.n_rotations), w.n_q, start_spins(w, which), s, by, T)
    assemble(tangent_loops(w), system, s, T, w.k, w.penalty, 1.0, w.cC, w.cM)
    soften_rows(w, s.z, floats(w.residual, w.n_all))
    soften_tangent(w, system[0], 1.0)


@kernel
def soften_tangent(w, s, share):
    """Add a ``share`` of the compliances of redundant constraints to the tangent."""
    places, values, data = (
        integers(w.entry_places, w.n_entries),
        floats(w.entry_values, w.n_entries),
        floats(s.data, s.n_data),
    )
    for i in range(w.n_entries):
        data[places[i]] += share * values[i]


@kernel
def soften_rows(w, z, r_out):
    """Add the compliance of redundant constraints to their rows (compliance.py)."""
    if w.n_entries:
        starts, columns = integers(w.soft_starts, w.n - w.n_q + 1), integers(w.soft_columns, w.n_entries)
        soften(w.k, starts, columns, floats(w.soft_values, w.n_entries), z[w.n_q : w.n], r_out[w.n_q : w.n])
