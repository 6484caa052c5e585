"""One step of generalized-alpha in one compiled call: prediction, Newton's iterations, error estimate.

Functions at the end judge redundant and deactivated constraints at its end (contradictions.py).
"""

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers
from mecano.model.assembly_driver import constraint_derivatives, constraint_loops
from mecano.model.numbering import ROTATION, SIGNAL, TRANSLATION
from mecano.solve.diagnostics.scales import state_size
from mecano.solve.events.compliance import soften
from mecano.solve.linear.newton import CONVERGED, newton
from mecano.solve.linear.refactorization import choose_tangent, most_kept
from mecano.solve.time.contradictions import CREEPING, NOTICED, SLIPS
from mecano.solve.time.increments import carried_history, finish, predict
from mecano.solve.time.step_control import SUDDEN, counted
from mecano.solve.time.workspace import (
    BEGIN,
    STEP,
    TRIAL,
    copy_state,
    history_of,
    put_start_spins,
    state_of,
    system_of,
    time_of,
    unknowns_of,
)


@entry
def attempt(work: Records(STEP)):
    """Step from BEGIN to TRIAL, or continue the iterations if ``begun``; ``code`` reports the outcome."""
    w = work[0]
    if not w.begun:
        w.begun = 1
        begin(w)
    w.code = newton(w)
    if w.code == CONVERGED:
        complete(w)


@kernel
def begin(w):
    """Predict the state TRIAL, from the history or ``by_velocity`` alone, and begin the report on the iterations."""
    copy_state(w, BEGIN, TRIAL)
    time_of(w, TRIAL)[0] = time_of(w, BEGIN)[0] + w.h
    start = state_of(w, BEGIN)
    put_start_spins(w)
    before, slope, bend = history_of(w, BEGIN)
    if w.by_velocity:
        # after a sudden load on stiff and light members the accelerations say little of displacements in a long step
        known, known_bend, kind = slope, bend, integers(w.kind, w.n_all)
        slope, bend = floats(w.guess, w.n), floats(w.guess + 8 * w.n, w.n)
        for i in range(w.n_q):
            a1 = (1.0 - 0.5 / w.beta) * before[i]
            slope[i] = ((1.0 - w.am) * a1 + w.am * before[i] - w.af * start.a[i]) / (1.0 - w.af) - start.a[i]
            if kind[i] == SIGNAL:
                slope[i], bend[i] = known[i], known_bend[i]
    history = before, slope, bend, floats(w.v_shift, w.n_all)
    farthest, w.loudest = predict(w, unknowns_of(w), start, history, state_of(w, TRIAL))
    w.farthest = max(farthest / w.length, w.farthest_fixed)
    w.reach = max(w.farthest, 1.0)
    floats(w.report, 8)[:] = 0.0
    w.pending = 0
    w.most_kept = most_kept(w.spent, w.age, w.most)
    w.kept = 1 if w.has and not w.renewed and w.most_kept > 0 else 0
    w.stale = 0 if w.kept and w.usable else 1


@kernel
def complete(w):
    """Compute the history at TRIAL, the error measures, and whether the next step may keep the tangent."""
    start, s, before, after = state_of(w, BEGIN), state_of(w, TRIAL), carried_history(w), history_of(w, TRIAL)
    w.change, w.turn = finish(w, unknowns_of(w), start, s, before, after)
    system, sizes, signal = system_of(w)[0], start.memory, 0.0
    _, began, slope, _ = before
    ended, new_slope, _ = after
    states, first = integers(system.states, system.n_states), w.n_memory - system.n_states
    for i in range(system.n_states):
        d = states[i]
        size = max(sizes[first + i], state_size(w.duration, s.z[d], s.v[d]))
        # the mean of two changes: a jump of the rate makes them alternate for some steps
        change = 0.5 * (slope[d] + new_slope[d]) if w.known else ended[d] - began[d]
        signal = max(signal, abs(change) / size)
    share = counted(1.0, SUDDEN, w.duration, w.h)  # squared, as the rounding of reactions grows as 1/h^2
    w.signalled = w.error * w.h * w.h * signal * share * share
    largest, massless = 0.0, integers(w.massless, w.n_massless)
    for i in range(w.n_massless):
        largest = max(largest, abs(ended[massless[i]] - began[massless[i]]))
    w.lag = w.error * w.h * w.h * largest / w.length
    if w.relax and w.usable:
        call(w.relax, w.relax_words, 0)
    w.next_known = min(w.known + 1, 2)
    w.next_has, w.next_age, w.next_drift, w.next_spent = choose_tangent(
        w.has, w.age, w.drift, w.spent, w.renewed, floats(w.report, 8), w.most, w.n
    )


@kernel
def give_way(m, w):
    """Return whether reactions at TRIAL displace redundant constraints by more than compiled code admits."""
    if not m.checks_gaps:
        return False
    gap = floats(w.gap, w.n_l)
    deflections(w, 1.0, gap)
    return exceeds_gap(m, gap)


@kernel
def exceeds_gap(m, violations):
    """Return whether the ``violations`` (n_l,) of redundant constraints exceed what compiled code admits."""
    weight, largest = floats(m.share_of_gap, violations.size), 0.0
    for i in range(violations.size):
        largest += (violations[i] * weight[i]) * (violations[i] * weight[i])
    return largest > NOTICED * NOTICED


@kernel
def deflections(w, factor, out):
    """Write -c Lambda (n_l,) times a ``factor`` at TRIAL, with the compliances c of redundant constraints."""
    out[:] = 0.0
    starts, columns = integers(w.soft_starts, w.n_l + 1), integers(w.soft_columns, w.n_entries)
    multipliers = state_of(w, TRIAL).z[w.n_q : w.n]
    soften(factor, starts, columns, floats(w.soft_values, w.n_entries), multipliers, out)


@kernel
def slips(m, w):
    """Return whether a deactivated constraint slips at TRIAL, by more than half of what is allowed of the speeds."""
    if m.n_released == 0:
        return False
    rates = floats(w.gap, w.n_l)
    linear, angular = largest_speeds(w, state_of(w, TRIAL), w.h)
    deflections(w, w.cC, rates)
    released, along = integers(m.released, m.n_released), integers(m.along, m.n_released)
    for i in range(m.n_released):
        if abs(rates[released[i]]) > 0.5 * SLIPS * (linear if along[i] else angular):
            return True
    return False


@kernel
def largest_speeds(w, s, h):
    """Return the largest speeds [m/s, rad/s] that count in a step of size h, at least CREEPING (contradictions.py)."""
    kind, linear, angular = integers(w.kind, w.n_all), CREEPING * w.length, CREEPING
    for i in range(w.n_q):
        speed = abs(s.v[i]) + h * abs(s.a[i])
        if kind[i] == TRANSLATION:
            linear = max(linear, speed)
        elif kind[i] == ROTATION:
            angular = max(angular, speed)
    return linear, angular


@kernel
def gap_of(w, s, order):
    """Return by how much a state violates the constraints (n_l,), those on positions alone, or their rates."""
    g, gap, of_rates = floats(w.derivatives, (w.n_l, 3)), floats(w.gap, w.n_l), integers(w.exact_rates, w.n_l)
    constraint_derivatives(constraint_loops(w), system_of(w), s, g)
    for i in range(w.n_l):
        gap[i] = 0.0 if order == 0 and of_rates[i] else g[i, order]
    return gap
