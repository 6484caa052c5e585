r"""Error of massless unknowns that is left at the end of a step in which they relax.

The local error of a massless unknown, of an element or of a node, :math:`\delta = C_e h^2 \Delta a`, is that of its
value as the integral of its rate. Its equation corrects it within the step: with the tangent S of the step and the part
:math:`c_C C` of the rates,

.. math::  S\, x = c_C C\, \delta

leaves x, which is :math:`\delta` as long as the step is short beside the time constant
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
from mecano.model.numbering import ROTATION
from mecano.solve.time.increments import carried_history, compared, largest_change
from mecano.solve.time.step_control import FORGOTTEN, allowed, counted
from mecano.solve.time.workspace import STEP, TRIAL, history_of, state_of, system_of

IN_ALL = 0.1  # of the tolerance: the sum of the errors of steps that soon forget them


@entry
def relax_error(work: Records(STEP)):
    """Count the error of unknowns without mass as that which is left at the end of the step in the workspace, at TRIAL.

    If the step would be rejected, ``lag`` becomes their error, ``change`` that of the accelerations of all others.
    """
    w = work[0]
    plain = w.error * w.h * w.h * w.change if w.n_light > w.n_massless else 0.0
    error = max(plain, counted(w.lag, FORGOTTEN, w.duration, w.h))
    if not error > allowed(w.tolerance, w.duration, w.h):
        return
    true, a0, _, _ = carried_history(w)
    began, ended_out = compared(w.am, true, state_of(w, TRIAL).a, a0, history_of(w, TRIAL)[0])
    light, errors, largest = integers(w.light, w.n_light), floats(w.guess, w.n), 0.0
    for i in range(w.n_light):
        errors[i] = w.error * w.h * w.h * (ended_out[light[i]] - began[light[i]])
        largest = max(largest, abs(errors[i]) / length_of(w, light[i]))
    if w.n_light > w.n_massless:
        w.change = change_of_others(w, light, began, ended_out)
    if largest > 0.0:
        w.lag = counted_error(largest, left_by_equations(w, light, errors))


@kernel
def length_of(w, i):
    """Return the length [m] over which the error of an unknown counts; 1 for a rotation."""
    return 1.0 if integers(w.kind, w.n_all)[i] == ROTATION else w.length


@kernel
def change_of_others(w, light, began, ended_out):
    """Return the largest change from ``began`` to ``ended_out`` (n_all,) but for the unknowns ``light``.

    ``ended_out`` is changed on the way only.
    """
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
def counted_error(error, left):
    """Return the error that counts of a local ``error`` > 0 of which the equations leave ``left``.

    The sum of errors that steps reduce may be IN_ALL of the tolerance, each of the others FORGOTTEN of it.
    """
    if not left < error:
        return error
    return min(left, FORGOTTEN / IN_ALL * left / (1.0 - left / error))
