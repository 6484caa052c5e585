r"""Error of massless unknowns that is left at the end of a step in which they relax.

The local error of a massless unknown, :math:`\delta = C_e h^2 \Delta a`, is that of its value as the integral of its
rate. Its equation corrects it within the step: with the tangent S of the step and the part :math:`c_C C` of the rates,

.. math::  S\, x = c_C C\, \delta

leaves x, which is :math:`\delta` as long as the step is short beside the time constant :math:`K^{-1} C`, and nothing
where the equation does not contain the rate. A patch of a tyre that begins to slide is such a case: its friction
depends on its rate no more, which jumps, while its displacement is that at which its friction is in balance. The
product is a difference of two residuals: friction has no derivative that holds over such a jump.

If each step leaves the share :math:`\rho = x/\delta`, the errors add up to :math:`x/(1 - \rho)`.
"""

from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers
from mecano.model.assembly_driver import bind_state, loops_at, residual
from mecano.solve.time.step_control import FORGOTTEN
from mecano.solve.time.workspace import TRIAL, state_of, system_of

IN_ALL = 0.1  # of the tolerance: the sum of the errors of steps that soon forget them


@kernel
def relaxed(w, began, ended):
    """Return the largest error of massless unknowns that is left at the end of the step in the workspace, at TRIAL.

    Their accelerations (n_all,) ``began`` and ``ended`` differ by the change from which the local error follows.
    """
    s, system, massless = state_of(w, TRIAL), system_of(w), integers(w.massless, w.n_massless)
    r, x, loops = floats(w.residual, w.n_all), floats(w.increment, w.n), loops_at(w.n_loops, w.loops, w.batches)
    rates, changes = floats(w.guess, w.n), floats(w.guess + 8 * w.n, w.n)
    bind_state(system, s)
    system[0].lag = 1.0 / w.cC
    for i in range(w.n_massless):
        d = massless[i]
        rates[i] = s.v[d]
        s.v[d] -= w.cC * w.error * w.h * w.h * (ended[d] - began[d])
    residual(loops, system, w.k, w.penalty)
    for i in range(w.n_massless):
        changes[i], s.v[massless[i]] = r[massless[i]], rates[i]
    residual(loops, system, w.k, w.penalty)  # last at the state itself, whose forces are observed
    for i in range(w.n_massless):
        changes[i] = r[massless[i]] - changes[i]
    r[: w.n] = 0.0
    for i in range(w.n_massless):
        r[massless[i]] = changes[i]
    call(w.substitute, w.substitute_words, 0)
    largest = 0.0
    for i in range(w.n_massless):
        largest = max(largest, abs(x[massless[i]]))
    return largest


@kernel
def remembered(error, left):
    """Return the error that counts of a local ``error`` > 0 of which the equations leave ``left``.

    The sum of errors that steps reduce may be IN_ALL of the tolerance, each of the others FORGOTTEN of it.
    """
    if not left < error:
        return error
    return min(left, FORGOTTEN / IN_ALL * left / (1.0 - left / error))
