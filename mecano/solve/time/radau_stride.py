"""Ordinary steps of Radau IIA, many in one compiled call, as stride.py for generalized-alpha."""

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats
from mecano.model.assembly_driver import assemble_residual, residual_loops
from mecano.solve.linear.newton import CONVERGED, PAUSE
from mecano.solve.time.output import DONE, FULL, OUTPUT
from mecano.solve.time.radau_workspace import RADAU, copy_numbers, stage_of
from mecano.solve.time.step import exceeds_gap, gap_of, give_way
from mecano.solve.time.step_control import STRETCH, allowed, factor_of_order, retried
from mecano.solve.time.step_info import MOST_TURN
from mecano.solve.time.stride import (
    ADVANCED,
    AGAIN,
    DECIDE,
    ENOUGH,
    READY,
    RECORDED,
    RECORDING,
    REPEAT,
    STEPPING,
    STRIDE,
    WAIT,
    count,
    departs,
    happens,
    passes,
    plan,
    take,
)
from mecano.solve.time.workspace import BEGIN, STEP, TRIAL, copy_state, is_due, state_of, system_of, time_of

ORDER = 5


@entry
def stride(
    integrator: Records(STRIDE), work: Records(STEP), radau: Records(RADAU), output: Records(OUTPUT)
) -> int:  # fmt: skip
    """Make steps from BEGIN; return why the call ends, as the function of the same name in stride.py."""
    m, w, r, o = integrator[0], work[0], radau[0], output[0]
    while True:
        if m.phase == READY:
            found = prepared(m, w)
            if found != ADVANCED:
                return found
        if m.phase == STEPPING:
            found = tried(m, w, r, o)
            if found == AGAIN:
                continue
            if found != ADVANCED:
                return found
        if m.phase == RECORDING:
            call(m.record, m.record_words, 0)
            if o.code == FULL:
                return RECORDED
            move_on(m, w, r)
            if o.code != DONE:
                return RECORDED
        if is_due(w):
            return WAIT


@kernel
def prepared(m, w):
    """Begin the next step; return ADVANCED, or why the call ends."""
    if m.done == m.most or m.until - time_of(w, BEGIN)[0] < STRETCH * m.planned:
        return ENOUGH
    if departs(m, w):
        return REPEAT
    w.h, m.rejections, m.of_rejected = m.planned, 0, 0
    begin(m, w)
    return ADVANCED


@kernel
def begin(m, w):
    """Begin the step of size h."""
    m.phase, w.begun = STEPPING, 0


@kernel
def tried(m, w, r, o):
    """Make a trial of the step and accept or reject it; return ADVANCED, AGAIN, or why the call ends."""
    call(m.attempt, m.attempt_words, 0)
    if w.code == PAUSE:
        return WAIT
    if w.code != CONVERGED:
        return REPEAT if m.rejections else DECIDE
    if not r.projected or w.turn > MOST_TURN or contradict(m, w):
        return REPEAT
    share = allowed(m.tolerance, m.duration, w.h)
    change = factor_of_order(r.error, share, ORDER)
    if not (r.error <= share or w.h < m.minimum):
        if w.h <= m.minimum:
            return REPEAT if m.rejections else DECIDE
        m.rejections, m.of_rejected = m.rejections + 1, m.of_rejected + r.iterations
        w.h = retried(change, w.h, m.minimum)
        begin(m, w)
        return AGAIN
    within = happens(m, w, stage_of(w, r, 0)) or happens(m, w, stage_of(w, r, 1))
    if within or happens(m, w, state_of(w, TRIAL)) or passes(m, w):
        return REPEAT if m.rejections else DECIDE
    accept(m, w, r, o, change, share)
    return ADVANCED


@kernel
def contradict(m, w):
    """Return whether redundant constraints give way, or are violated, at TRIAL by more than compiled code admits."""
    return give_way(m, w) or m.checks_gaps != 0 and exceeds_gap(m, gap_of(w, state_of(w, TRIAL), 0))


@kernel
def accept(m, w, r, o, change, share):
    """Commit memories, observe the outputs, add the work of the stages, plan the next step."""
    assemble_residual(residual_loops(w), system_of(w), state_of(w, TRIAL), 1.0, 0.0)
    take(m, w)
    work = floats(r.work, (3, 2))
    m.dissipated += work[2, 0]
    m.given += work[2, 1]
    o.forces, o.constraints, o.increment = 0.0, r.drift, r.size / r.goal
    count(m, w, o, r.iterations, r.error, share)
    plan(m, w, change, share, r.iterations)
    m.phase = RECORDING
    if not m.records:
        move_on(m, w, r)


@kernel
def move_on(m, w, r):
    """Make TRIAL the beginning of the next step, and the stages its history."""
    copy_state(w, TRIAL, BEGIN)
    copy_numbers(r.velocities, r.last_velocities, 4 * w.n_q)
    copy_numbers(r.reactions, r.last_reactions, 3 * w.n_l)
    r.last_h, r.known, r.last_amplified = w.h, 1, r.amplified
    r.least_amplified = min(r.least_amplified, r.amplified)
    m.phase = READY
