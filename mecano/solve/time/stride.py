"""Ordinary steps, many in one compiled call: those whose iterations converge and that contain no event.

The call returns if a rare decision is due: an event, a failed iteration, a time at which a step must end, full buffers,
a check for signals of the process. Python takes that decision, and computes the same step to the same bits.
"""

import numpy as np

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers, items
from mecano.maths.neighbours import successor
from mecano.model.assembly_driver import commit, event_values, loops_at, observe, observe_loops
from mecano.model.loop_records import SYSTEM, fields
from mecano.model.numbering import ROTATION
from mecano.model.state import Instant
from mecano.solve.events.events import some_happened
from mecano.solve.events.passing import AFTER_START, BEFORE_END, SHARE, heads_for_zero, may_pass, may_peak
from mecano.solve.linear.newton import CONVERGED, DIVERGES, PAUSE, TOO_MANY
from mecano.solve.time.error_bound import BOUND
from mecano.solve.time.increments import extrapolate
from mecano.solve.time.output import DONE, FULL, OUTPUT
from mecano.solve.time.step import give_way, slips
from mecano.solve.time.step_control import (
    FORGOTTEN,
    HOLD,
    NEGLIGIBLE_TIME,
    SHORT,
    STRETCH,
    allowed,
    clipped,
    counted,
    factor,
    planned,
    retried,
)
from mecano.solve.time.step_info import MOST_TURN
from mecano.solve.time.workspace import (
    BEGIN,
    BETWEEN,
    RENEWED,
    STEP,
    TANGENT,
    TRIAL,
    copy_history,
    copy_state,
    is_due,
    state_of,
    system_of,
    time_of,
)

PROBE = 50  # steps between two computations of the bounded error of steps that their plain error keeps short
WORTH = 3.0  # growth of steps, each of which then computes the bounded error, too, with two factorizations

ENOUGH, DECIDE, REPEAT, WAIT, RECORDED, RESTART = range(6)  # why the call ends
ADVANCED, AGAIN = 6, 7  # it goes on, with the next phase or with another trial
READY, STEPPING, RECORDING, SAMPLING = range(4)  # phases of a step

STRIDE = fields(
    floats="until stop tolerance duration minimum maximum turn planned longest_restart dissipated given "
    "power_dissipated power_given",
    words="phase jumps_at_end n_samples samples next_sample restarts_at_stop restarts_now "
    "at_sample at_sample_words restarted "
    "steps done most rejected iterations in_vain rejections of_rejected renewed_tangents "
    "attempt attempt_words records record record_words bound bound_error bound_error_words "
    "n_events before_values n_departing departing "
    "n_brief brief n_conditions conditions "
    "n_arrivals arrivals "
    "checks_gaps share_of_gap n_released released along change_step change_step_words observation",
    loops="event observe commit",
)


@entry
def stride(integrator: Records(STRIDE), work: Records(STEP), output: Records(OUTPUT)) -> int:
    """Make steps from BEGIN; return why the call ends.

    ENOUGH: the requested number of steps is made, or the next one needs another size. RESTART: Python restarts at
    BEGIN, a sampling time. DECIDE: Python judges TRIAL, the first trial from BEGIN. REPEAT: Python makes the step from
    BEGIN. WAIT: Python checks for signals, and calls again. RECORDED: the buffers are full, or the run must end, as the
    code in ``output`` states.
    """
    m, w, o = integrator[0], work[0], output[0]
    while True:
        if m.phase == READY:
            found = prepared(m, w)
            if found != ADVANCED:
                return found
        if m.phase == STEPPING:
            found = tried(m, w, o)
            if found == AGAIN:
                continue
            if found != ADVANCED:
                return found
        if m.phase == RECORDING:
            call(m.record, m.record_words, 0)
            if o.code == FULL:
                return RECORDED
            move_on(m, w)
            if o.code != DONE:
                return RECORDED
        if m.phase == SAMPLING:
            call(m.at_sample, m.at_sample_words, 0)
            m.phase = READY
            if not m.restarted:
                return RESTART
            if m.records and o.code != DONE:
                return RECORDED
        if is_due(w):
            return WAIT


@kernel
def prepared(m, w):
    """Begin the next step; return ADVANCED, or why the call ends."""
    if m.done == m.most:
        return ENOUGH
    t, size = time_of(w, BEGIN)[0], m.planned
    m.stop, jumps = next_stop(m, w, t)
    if m.stop - t < STRETCH * size:
        if not m.restarts_at_stop:
            return ENOUGH
        size = clipped(t, size, m.stop, jumps)
    if size <= SHORT * m.planned or (size != w.h and not changes(m, w, size)):
        return ENOUGH
    if departs(m, w):
        return REPEAT
    m.rejections, m.of_rejected = 0, 0
    begin(m, w)
    return ADVANCED


@kernel
def next_stop(m, w, t):
    """Return the next time at which a step must end, and whether forces jump there.

    It is that of a sample, or at which a late jump arrives, where compiled code restarts, or the end.
    """
    samples, stop, jumps = floats(m.samples, m.n_samples), m.until, m.jumps_at_end
    m.restarts_at_stop = 0
    while m.next_sample < m.n_samples and samples[m.next_sample] <= t:
        m.next_sample += 1
    if m.next_sample < m.n_samples:
        stop, jumps, m.restarts_at_stop = samples[m.next_sample], 1, 1
    arrivals, memory = integers(m.arrivals, m.n_arrivals), state_of(w, BEGIN).memory
    for i in range(m.n_arrivals):
        if t < memory[arrivals[i]] < stop:
            stop, jumps, m.restarts_at_stop = memory[arrivals[i]], 1, 1
    return stop, jumps


@kernel
def tried(m, w, o):
    """Make a trial of the step and accept or reject it; return ADVANCED, AGAIN, or why the call ends."""
    call(m.attempt, m.attempt_words, 0)
    if w.code == PAUSE:
        return WAIT
    if w.code == TOO_MANY or w.code == DIVERGES:
        if w.by_velocity:
            return REPEAT if m.rejections else DECIDE
        m.in_vain, w.begun, w.by_velocity = int(floats(w.report, 8)[0]), 0, 1  # as GeneralizedAlpha.step
        return AGAIN
    if w.code != CONVERGED or w.turn > MOST_TURN or give_way(m, w) or slips(m, w):
        return REPEAT
    lag = counted(w.lag, FORGOTTEN, m.duration, w.h)
    plain = max(w.error * w.h * w.h * w.change, w.signalled, lag)
    share = allowed(m.tolerance, m.duration, w.h)
    within = plain <= share or w.h < m.minimum
    error = plain if within else bounded(m, w, plain)
    if not (within or error <= share):
        if w.h <= m.minimum or not (w.knows_light and reject(m, w, plain, share)):
            return REPEAT if m.rejections else DECIDE
        return AGAIN
    if happens(m, w, state_of(w, TRIAL)) or passes(m, w):
        return REPEAT if m.rejections else DECIDE
    if is_probe(m, w, error, share):
        found = bounded(m, w, plain)
        error = found if factor(found, share) >= WORTH else error
    accept(m, w, o, error, share)
    return ADVANCED


@kernel
def bounded(m, w, plain):
    """Return the error of a step with oscillations bounded (error_bound.py); ``plain`` is the error without a bound."""
    if not m.bound:
        return plain
    found = items(m.bound, 1, BOUND)[0]
    call(m.bound_error, m.bound_error_words, 0)
    return max(found.bounded, w.signalled, counted(w.lag, FORGOTTEN, m.duration, w.h))


@kernel
def reject(m, w, plain, share):
    """Begin the step again with a smaller size; return whether it was possible in compiled code.

    The size follows from the ``plain`` error: the bounded one falls only once steps resolve oscillations.
    """
    m.rejections, m.of_rejected = m.rejections + 1, m.of_rejected + m.in_vain + int(floats(w.report, 8)[0])
    size = retried(factor(plain, share), w.h, m.minimum)
    if not changes(m, w, size):
        return False
    begin(m, w)
    return True


@kernel
def changes(m, w, size):
    """Change the step size; return whether it was possible in compiled code."""
    if not m.change_step:
        return False
    w.next_h = size
    call(m.change_step, m.change_step_words, 0)
    m.renewed_tangents += 1
    if w.code != CONVERGED:
        w.h = w.last_h
    return w.code == CONVERGED


@kernel
def begin(m, w):
    """Prepare the next step: Newton's method starts from the prediction by the history."""
    w.begun, w.by_velocity, w.renewed = 0, 0, 0
    m.phase, m.in_vain = STEPPING, 0


@kernel
def evaluate_events(m, w, s, out):
    """Write the values of all events at a state."""
    event_values(loops_at(m.n_event_loops, m.event_loops, m.event_batches), system_of(w), s, out)


@kernel
def departs(m, w):
    """Return whether a contact that has opened has no gap yet: its rates decide whether it departs (shocks.py)."""
    if not m.n_events:
        return False
    values, own = floats(m.before_values, m.n_events), integers(m.departing, m.n_departing)
    evaluate_events(m, w, state_of(w, BEGIN), values)
    for i in range(m.n_departing):
        if values[own[i]] >= 0.0:
            return True
    return False


@kernel
def happens(m, w, s):
    """Return whether an event happened from BEGIN to the state ``s``."""
    if not m.n_events:
        return False
    values = floats(m.before_values, 2 * m.n_events)
    evaluate_events(m, w, s, values[m.n_events :])
    return some_happened(values[: m.n_events], values[m.n_events :])


@kernel
def passes(m, w):
    """Return whether an event may happen from BEGIN to TRIAL, and be undone; ``happens`` has shown none at TRIAL."""
    brief, conditions = integers(m.brief, m.n_brief), integers(m.conditions, m.n_conditions)
    values = floats(m.before_values, (4, m.n_events))
    moving = may_pass(brief, values)
    if not (moving or may_pass(conditions, values)):
        return False
    extrapolate(w, BEGIN, SHARE * (time_of(w, TRIAL)[0] - time_of(w, BEGIN)[0]), BETWEEN)
    evaluate_events(m, w, state_of(w, BETWEEN), values[AFTER_START])
    if heads_for_zero(conditions, values):
        return True
    if not (moving and heads_for_zero(brief, values)):
        return False
    extrapolate(w, TRIAL, -SHARE * (time_of(w, TRIAL)[0] - time_of(w, BEGIN)[0]), BETWEEN)
    evaluate_events(m, w, state_of(w, BETWEEN), values[BEFORE_END])
    return may_peak(brief, values)


@kernel
def is_probe(m, w, error, share):
    """Return whether this step computes the bounded error, to find out if only oscillations keep steps short."""
    return m.steps % PROBE == PROBE - 1 and w.h < m.maximum and factor(error, share) < HOLD


@kernel
def accept(m, w, o, error, share):
    """Commit memories, observe the outputs, add the work by the trapezoidal rule, plan the next step."""
    take(m, w)
    energy, report = floats(observation_of(m)[0].energy, 4), floats(w.report, 8)
    m.dissipated += 0.5 * w.h * (m.power_dissipated + energy[2])
    m.given += 0.5 * w.h * (m.power_given + energy[3])
    iterations = m.in_vain + int(report[0])
    o.forces, o.constraints, o.increment = report[1], report[2], report[3]
    count(m, w, o, iterations, error, share)
    plan(m, w, factor(error, share), share, iterations)
    m.restarts_now = 1 if m.restarts_at_stop and meets(w, m.stop) else 0
    if m.restarts_now:
        time_of(w, TRIAL)[0] = m.stop
    m.phase = RECORDING
    if not m.records:
        move_on(m, w)


@kernel
def meets(w, stop):
    """Return whether the step ends at the time ``stop`` [s], but for rounding."""
    return abs(time_of(w, TRIAL)[0] - stop) <= max(NEGLIGIBLE_TIME * w.h, successor(stop) - stop)


@kernel
def count(m, w, o, iterations, error, share):
    """Count an accepted step with its iterations and rejected trials, and enter it into the output."""
    energy = floats(observation_of(m)[0].energy, 4)
    m.power_dissipated, m.power_given = energy[2], energy[3]
    m.steps, m.done, m.iterations = m.steps + 1, m.done + 1, m.iterations + iterations + m.of_rejected
    m.rejected += m.rejections
    o.h, o.iterations, o.error, o.share, o.rejected = w.h, float(iterations), error, error / share, float(m.rejections)
    o.dissipated, o.given = m.dissipated, m.given


@kernel
def observation_of(m):
    """Return the record SYSTEM (1,) of outputs and energies."""
    return items(m.observation, 1, SYSTEM)


@kernel
def take(m, w):
    """Commit the memories at TRIAL, and write outputs and energies there."""
    s, system = state_of(w, TRIAL), system_of(w)
    if w.n_memory:
        before = Instant(s.t, s.z, s.v, s.a, s.R, s.phases, state_of(w, BEGIN).memory)
        commit(loops_at(m.n_commit_loops, m.commit_loops, m.commit_batches), system, before, s.memory)
    forces = floats(system[0].force, system[0].n_slots)
    observe(observe_loops(m), observation_of(m), s, forces)


@kernel
def plan(m, w, change, share, iterations):
    """Plan the size of the next step; it grows only as far as no body turns too far in it.

    A step shortened to end at a given time does not shorten the next one.
    """
    wanted = planned(change, share, w.h, m.minimum, m.maximum, iterations)
    if m.rejections == 0 and w.h < m.planned:
        wanted = max(wanted, m.planned)
    if wanted > w.h:
        longest = longest_step(m, w)
        wanted = min(wanted, longest) if longest >= HOLD * w.h else w.h
    m.planned = wanted


@kernel
def longest_step(m, w):
    """Return the longest step [s] in which no body turns too far at the velocities of TRIAL."""
    v, kind, fastest = state_of(w, TRIAL).v, integers(w.kind, w.n_all), 0.0
    for i in range(w.n_q):
        if kind[i] == ROTATION:
            fastest = max(fastest, abs(v[i]))
    return m.turn / fastest if fastest > 0.0 else np.inf


@kernel
def move_on(m, w):
    """Make TRIAL the beginning of the next step."""
    copy_state(w, TRIAL, BEGIN)
    copy_history(w, TRIAL, BEGIN)
    w.changed, w.taken = 0, w.h
    floats(w.v_shift, w.n_all)[:] = 0.0
    if w.renewed:
        copy_state(w, RENEWED, TANGENT)
        m.renewed_tangents += 1
        w.renewed = 0
    w.known, w.has, w.age, w.drift, w.spent = w.next_known, w.next_has, w.next_age, w.next_drift, w.next_spent
    m.phase = SAMPLING if m.restarts_now else READY
