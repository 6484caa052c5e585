r"""One step of generalized-alpha in one compiled call: prediction, Newton's iterations, error estimate.

The local error of a massless unknown, of an element or of a node, :math:`\delta = C_e h^2 \Delta a`, is that of its
value as the integral of its rate. Its equation corrects it within the step: with the tangent S of the step and the part
:math:`c_C C` of the rates,

.. math::  S\, x = c_C C\, \delta

leaves x at the end of the step, which is :math:`\delta` as long as the step is short beside the time constant
:math:`K^{-1} C`, and nothing where the equation does not contain the rate. A patch of a tyre that begins to slide is
such a case, or a node between a spring and dry friction: friction depends on the rate no more, which jumps, while the
displacement is that at which friction is in balance. The product is a difference of two residuals: friction has no
derivative that holds over such a jump.

If each step leaves the share :math:`\rho = x/\delta`, the errors add up to :math:`x/(1 - \rho)`.
"""

from mecano.jit.entry import Records, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers
from mecano.model.assembly_driver import bind_state, residual, residual_loops
from mecano.model.numbering import ROTATION, SIGNAL
from mecano.solve.diagnostics.scales import state_size
from mecano.solve.linear.newton import CONVERGED, newton
from mecano.solve.linear.refactorization import choose_tangent, most_kept
from mecano.solve.time.increments import carried_history, finish, largest_change, predict
from mecano.solve.time.step_control import FORGOTTEN, SUDDEN, allowed, counted
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

IN_ALL = 0.1  # of the tolerance: the sum of the errors of steps that soon forget them


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
    error = counted(w.lag, FORGOTTEN, w.duration, w.h)
    if w.n_light > w.n_massless:
        error = max(error, w.error * w.h * w.h * w.change)
    if error > allowed(w.tolerance, w.duration, w.h) and w.usable:
        relax_errors(w, began, ended)
    w.next_known = min(w.known + 1, 2)
    w.next_has, w.next_age, w.next_drift, w.next_spent = choose_tangent(
        w.has, w.age, w.drift, w.spent, w.renewed, floats(w.report, 8), w.most, w.n
    )


@kernel
def relax_errors(w, began, ended_out):
    """Count the error of unknowns without mass as that which is left at the end of the step in the workspace, at TRIAL.

    Their accelerations (n_all,) ``began`` and ``ended_out`` differ by the change from which the local error follows;
    ``ended_out`` is changed on the way only.
    """
    light, errors, largest = integers(w.light, w.n_light), floats(w.guess, w.n), 0.0
    for i in range(w.n_light):
        errors[i] = w.error * w.h * w.h * (ended_out[light[i]] - began[light[i]])
        largest = max(largest, abs(errors[i]) / length_of(w, light[i]))
    if w.n_light > w.n_massless:
        w.change = change_of_others(w, light, began, ended_out)
    if largest > 0.0:
        w.lag = remembered(largest, left_by_equations(w, light, errors))


@kernel
def length_of(w, i):
    """Return the length [m] over which the error of an unknown counts; 1 for a rotation."""
    return 1.0 if integers(w.kind, w.n_all)[i] == ROTATION else w.length


@kernel
def change_of_others(w, light, began, ended_out):
    """Return the largest change from ``began`` to ``ended_out`` (n_all,) but for the unknowns ``light``."""
    kept = floats(w.guess + 8 * w.n, w.n)
    for i in range(light.size):
        kept[i], ended_out[light[i]] = ended_out[light[i]], began[light[i]]
    change = largest_change(began, ended_out, integers(w.kind, w.n_all), w.n_q, w.length)
    for i in range(light.size):
        ended_out[light[i]] = kept[i]
    return change


@kernel
def left_by_equations(w, light, errors_out):
    """Return the largest of the ``errors_out`` of the unknowns ``light`` that is left, over its length.

    They are overwritten. The residual is last that of the state itself, whose forces are observed.
    """
    s, system, rates = state_of(w, TRIAL), system_of(w), floats(w.guess + 8 * w.n, w.n)
    r, x, loops = floats(w.residual, w.n_all), floats(w.increment, w.n), residual_loops(w)
    bind_state(system, s)
    system[0].lag = 1.0 / w.cC
    for i in range(light.size):
        rates[i] = s.v[light[i]]
        s.v[light[i]] -= w.cC * errors_out[i]
    residual(loops, system, w.k, w.penalty)
    for i in range(light.size):
        errors_out[i], s.v[light[i]] = r[light[i]], rates[i]
    residual(loops, system, w.k, w.penalty)
    for i in range(light.size):
        errors_out[i] = r[light[i]] - errors_out[i]
    r[: w.n] = 0.0
    for i in range(light.size):
        r[light[i]] = errors_out[i]
    call(w.substitute, w.substitute_words, 0)
    largest = 0.0
    for i in range(light.size):
        largest = max(largest, abs(x[light[i]]) / length_of(w, light[i]))
    return largest


@kernel
def remembered(error, left):
    """Return the error that counts of a local ``error`` > 0 of which the equations leave ``left``.

    The sum of errors that steps reduce may be IN_ALL of the tolerance, each of the others FORGOTTEN of it.
    """
    if not left < error:
        return error
    return min(left, FORGOTTEN / IN_ALL * left / (1.0 - left / error))
