"""One step of Radau IIA in one compiled call: prediction, Newton's iterations, error estimate, end of the step."""

import numpy as np

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats, integers, items
from mecano.model.assembly_driver import assemble_residual, observe, observe_loops, residual_loops
from mecano.model.loop_records import SYSTEM
from mecano.model.numbering import MASSLESS, ROTATION, STATE, TRANSLATION
from mecano.model.state import Motion
from mecano.solve.diagnostics.scales import SIGNALS, SMALL
from mecano.solve.linear.newton import CONVERGED, DIVERGES, NOT_FINITE, PAUSE, STALE, TOO_MANY
from mecano.solve.linear.rounding import TINY, at_rounding
from mecano.solve.time.constrained_mass import MASS, accelerate, assemble_mass, change, factor_mass
from mecano.solve.time.increments import largest, move
from mecano.solve.time.radau_stages import begin_stages, correct, measure_signals, place, residual
from mecano.solve.time.radau_tangent import renew, solve, solve_real
from mecano.solve.time.radau_workspace import RADAU, copy_numbers, row_of, stage_of
from mecano.solve.time.singular_position import LOST, ROUNDED
from mecano.solve.time.step import gap_of
from mecano.solve.time.step_control import SUDDEN, allowed, counted
from mecano.solve.time.workspace import (
    BEGIN,
    RENEWED,
    STEP,
    TRIAL,
    copy_state,
    copy_to_state,
    is_due,
    state_of,
    system_of,
    unknowns_of,
)

SHARE = 0.01  # of the allowed error of a step: a correction that leaves less ends Newton's iteration
LEAST = 1e-17  # of the length scale, or rad: increments are known to more digits than positions
CAUTION = 8.0  # times the estimate: errors of velocities add up to more than themselves
SLOW = 0.9  # ratio of two corrections above which the last one is not made, and the tangent is renewed
BALANCED = 1e-5  # of the largest force: resultants at the stages below which reactions are accurate enough
FALLING = 0.9  # ratio of two such resultants from which on more iterations do not help
MOST_MOVED = 1e6  # length scales, or rad, in one correction: iterations that go so far do not come back
END = 2  # the last stage


@entry
def attempt(work: Records(STEP), radau: Records(RADAU)):
    """Step from BEGIN to TRIAL, or continue the iterations if ``begun``; ``code`` reports the outcome.

    ``projected``: TRIAL is the end of the step; otherwise it is the last stage.
    """
    w, r = work[0], radau[0]
    if not w.begun:
        w.begun = 1
        begin(w, r)
    w.code = iterate(w, r)
    while w.code == CONVERGED and not complete(w, r):
        w.code = iterate(w, r)


@kernel
def begin(w, r):
    """Predict the stages, and set the corrections at which Newton's iteration ends."""
    r.iterations, r.size, r.unbalanced, w.stale = 0, np.inf, np.inf, 1
    r.goal, accuracy = accuracies(w, r)
    s0, kind, farthest = state_of(w, BEGIN), integers(w.kind, w.n_all), 0.0
    for i in range(w.n_all):
        if kind[i] == TRANSLATION:
            farthest = max(farthest, abs(s0.z[i]))
    r.reach = max(farthest / w.length, 1.0)
    measure_signals(w, r, min(r.goal / accuracy, 1.0))
    begin_stages(w, r)


@kernel
def accuracies(w, r):
    """Return the errors that end Newton's iteration: of increments, and relative ones of signals without a rate.

    Increments are relative to the length scale, or rad; their error over h is that of velocities, which accumulates
    until the end of the run.
    """
    share, accuracy = allowed(r.tolerance, w.duration, w.h), min(SHARE * r.tolerance, SIGNALS)
    if share == np.inf:
        return r.constraint_tolerance, accuracy
    return max(SHARE * share * w.h / w.duration, LEAST), accuracy


@kernel
def iterate(w, r):
    """Iterate on the stages; return CONVERGED, PAUSE or the reason of a failure (newton.py)."""
    while True:
        if is_due(w) and not w.paused:
            w.paused = 1
            return PAUSE
        w.paused = 0
        if r.iterations == w.most:
            return TOO_MANY
        renewed = w.stale
        if renewed:
            code = renew(w, r)
            if code != STALE:
                return code
            w.stale = 0
        place(w, r)
        for i in range(3):
            residual(w, r, stage_of(w, r, i), row_of(r.F, i, w.n))
        solve(w, r)
        copy_numbers(r.increments, r.kept_increments, 3 * w.n_q)
        copy_numbers(r.reactions, r.kept_reactions, 3 * w.n_l)
        last, r.size = r.size, correct(w, r)
        r.iterations += 1
        code = judge(w, r, last, renewed)
        if code >= 0:
            return code


@kernel
def judge(w, r, last, renewed):
    """Return CONVERGED, NOT_FINITE or DIVERGES for the current correction and the ``last`` one, or -1 to continue.

    A correction that grows is undone, and the next tangent evaluated at the stages, unless signals alone grow by one
    with a ``renewed`` tangent: they follow from one another.
    """
    ratio = r.size / last if r.iterations > 1 else 1.0
    if not r.size < np.inf:
        return NOT_FINITE
    if r.size > MOST_MOVED:
        return DIVERGES
    if r.size < r.goal or r.size * ratio < r.goal * (1.0 - ratio):
        return CONVERGED
    if at_rounding(r.size, ratio, ratio != 1.0, r.reach, 0.0):
        return CONVERGED
    if r.iterations > 1 and (ratio > SLOW or r.size * ratio ** (w.most - r.iterations) > r.goal):
        if ratio > SLOW and not (renewed and r.moved <= SLOW * last):
            copy_numbers(r.kept_increments, r.increments, 3 * w.n_q)
            copy_numbers(r.kept_reactions, r.reactions, 3 * w.n_l)
            r.size = last
        w.stale = 1
    return -1


@kernel
def complete(w, r):
    """Compute the stages, the error, the work and the end of the step; return whether no more iterations are due.

    Corrections of the motion do not reveal errors of reactions that the constraints alone balance, and the prediction
    by a parabola amplifies these errors. Reactions that cause friction influence the motion.
    """
    place(w, r)
    last = r.unbalanced
    observe_stages(w, r)
    if r.projects and BALANCED < r.unbalanced < FALLING * last and r.iterations < w.most:
        return False
    v, s0, w.turn = floats(r.velocities, (4, w.n_q)), state_of(w, BEGIN), 0.0
    end, kind = stage_of(w, r, END), integers(w.kind, w.n_all)
    for d in range(w.n_q):
        v[0, d] = s0.v[d]
        if kind[d] == ROTATION:
            w.turn = max(w.turn, abs(end.z[d]))
    for i in range(3):
        s = stage_of(w, r, i)
        for d in range(w.n_q):
            v[1 + i, d] = s.v[d]
    r.error = error_of(w, r)
    add_work(w, r)
    copy_to_state(w, end, TRIAL)
    r.projected = 1 if r.projects and projected(w, r, items(r.mass, 1, MASS)[0]) else 0
    return True


@kernel
def observe_stages(w, r):
    """Write outputs and energies of the stages, and the largest of their ``unbalanced`` forces."""
    r.unbalanced = 0.0
    observation, system = items(r.observation, 1, SYSTEM), system_of(w)
    residuals, observed = (residual_loops(w), observe_loops(r))
    for i in range(3):
        s = stage_of(w, r, i)
        assemble_residual(residuals, system, s, 1.0, 0.0)
        r.unbalanced = max(r.unbalanced, unbalanced(w))
        observation[0].outputs, observation[0].energy = r.outputs + 8 * i * r.n_outputs, r.energies + 32 * i
        observe(observed, observation, s, floats(system[0].force, system[0].n_slots))


@kernel
def unbalanced(w):
    """Return the largest resultant force or moment on a node, over the largest force or moment of the assembly."""
    resultant, size, kind = floats(w.residual, w.n_all), floats(w.size, w.n_all), integers(w.kind, w.n_all)
    force = moment = 0.0
    force_size = moment_size = TINY
    for d in range(w.n_all):
        x = abs(resultant[d]) if d < w.n_q else 0.0
        if kind[d] == TRANSLATION:
            force, force_size = max(force, x), max(force_size, size[d])
        elif kind[d] == ROTATION:
            moment, moment_size = max(moment, x), max(moment_size, size[d])
    return max(force / max(force_size, moment_size / w.length), moment / max(moment_size, force_size * w.length))


@kernel
def add_work(w, r):
    """Write the work (3, 2) from the beginning to the stages, dissipated and given, by the method itself."""
    energies, work, A = floats(r.energies, (3, 4)), floats(r.work, (3, 2)), floats(r.A, (3, 3))
    for i in range(3):
        for j in range(2):
            work[i, j] = 0.0
            for k in range(3):
                work[i, j] += w.h * A[i, k] * energies[k, 2 + j]


@kernel
def error_of(w, r):
    r"""Return the local error of a step.

    Hairer and Wanner's embedded formula (IV.8, 8.19) is of order 3; its error, of order 4 in h, times
    :math:`(\omega h)^2` estimates that of order 6. omega follows from the accelerations in the step.
    """
    v, theta, n_q = floats(r.velocities, (4, w.n_q)), floats(r.increments, (3, w.n_q)), w.n_q
    e_of, c, terms = floats(r.to_error, 3), floats(r.to_cubic, (4, 4)), floats(r.scratch, (3, n_q))
    kind = integers(w.kind, w.n_all)
    copy_state(w, BEGIN, RENEWED)
    s = state_of(w, RENEWED)
    for d in range(n_q):
        back = s.v[d]
        for j in range(3):
            back += e_of[j] * theta[j, d] / w.h
        s.a[d] = -r.real / w.h * back
        for j in range(3):
            s.a[d] -= e_of[j] * (v[1 + j, d] - v[0, d]) / w.h
        s.v[d] -= back
        if kind[d] == ROTATION:
            s.z[d] = 0.0
        for i in range(3):
            terms[i, d] = 0.0
            for j in range(1, 4):
                terms[i, d] += c[1 + i, j] * (v[j, d] - v[0, d])
    F = row_of(r.F, 0, w.n)
    residual(w, r, s, F)
    e = solve_real(w, r, F)
    forgive_massless(w, r, e, terms)
    sizes = largest(e, kind, n_q, w.length), largest(terms[0], kind, n_q, w.length)
    error = of_order_six(*sizes, largest(terms[1], kind, n_q, w.length), largest(terms[2], kind, n_q, w.length))
    return max(error, error_of_signals(w, r, e, terms))


@kernel
def forgive_massless(w, r, e_out, terms_out):
    """Reduce the error estimates of unknowns without mass in a step that is shorter than the one before.

    Their equations hold at its beginning as well as the iteration of that step had to satisfy them; the difference
    does not become smaller with the step.
    """
    if not r.known or w.h >= r.last_h:
        return
    kind, share = integers(w.kind, w.n_all), w.h / r.last_h
    for d in range(w.n_q):
        if kind[d] == MASSLESS:
            e_out[d] *= share
            for i in range(3):
                terms_out[i, d] *= share


@kernel
def error_of_signals(w, r, e, terms):
    """Return the largest error of the signals with a rate, relative to their sizes, reduced in small steps."""
    v, kind, sizes, worst = floats(r.velocities, (4, w.n_q)), integers(w.kind, w.n_all), floats(r.sizes, w.n_q), 0.0
    for d in range(w.n_q):
        if kind[d] == STATE:
            size, fastest = sizes[d], 0.0
            for j in range(1, 4):
                fastest = max(fastest, abs(v[j, d] - v[0, d]))
            if size <= SMALL:
                size = max(w.duration * fastest, SMALL)  # at rest before
            x, y, z = abs(terms[0, d]) / size, abs(terms[1, d]) / size, abs(terms[2, d]) / size
            worst = max(worst, of_order_six(abs(e[d]) / size, x, y, z))
    share = counted(1.0, SUDDEN, w.duration, w.h)
    return worst * share * share


@kernel
def of_order_six(e, first, second, third):
    """Return the error estimate from that of order 3 and the coefficients of the velocities in the step."""
    fast = 6.0 * third / (first + 2.0 * second) if third > 0.0 else 0.0
    return CAUTION * e * min(fast, 1.0)


@kernel
def projected(w, r, m):
    """Project TRIAL on the constraints, with its accelerations and multipliers; return whether that was possible.

    Near a singular position TRIAL remains the last stage (singular_position.py), as rounding errors would dominate the
    projection.
    """
    stage, s, of = stage_of(w, r, END), state_of(w, TRIAL), unknowns_of(w)
    m.length = w.length
    assemble_mass(items(r.mass, 1, MASS), stage)
    w.factorizations += 1
    if not factor_mass(m):
        return False
    r.amplified = max(largest(change(m, floats(r.violation, w.n_l), 1.0), of.kind, of.n_q, w.length), 1.0)
    before, now = r.last_amplified / r.least_amplified, r.amplified / r.least_amplified
    r.drift = 0.0
    if min(before, now) > LOST:
        return False
    none = floats(m.a, w.n_all)
    if now > max(before, ROUNDED):
        move(of, 1.0, Motion(stage.z, none, none, stage.R), s)
        return True
    x = change(m, gap_of(w, stage, 0), -1.0)
    r.drift = largest(x, of.kind, of.n_q, w.length)
    move(of, 1.0, Motion(stage.z, x, none, stage.R), s)
    x = change(m, gap_of(w, s, 1), -1.0)
    for i in range(w.n_q):
        s.v[i] += x[i]
    accelerate(m, stage, s.v, s.z, s.a)
    return True
