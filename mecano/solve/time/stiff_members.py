r"""Accelerations that stiff members need to follow a slow motion; the modal filter alone would remove them.

A stiff member that turns has centripetal accelerations, which are not vibration: they keep its strain constant. The
forces f(q, v), without inertia, distinguish both. Along a motion with velocities v and accelerations a they change by

.. math:: r = \frac{d}{dt} f_e + c_C f_o, \quad g = \frac{d^2}{dt^2} f_e + c_C \frac{d}{dt} f_o, \qquad
   f_e, f_o = \tfrac12 [f(q, v) \pm f(q, -v)]

of which the first is small for velocities without vibration, and the second for accelerations without it
(modal_filter.py; docs/theory.md, 2.1). Multipliers, signals, massless scalars and the time are held constant.
"""

import numpy as np

from mecano.jit.kernel import kernel
from mecano.jit.memory import call, floats, integers
from mecano.model.assembly_driver import bind_state, residual, residual_loops
from mecano.model.numbering import MASSLESS, SIGNAL
from mecano.model.state import Instant
from mecano.solve.time.increments import move
from mecano.solve.time.workspace import BEGIN, TRIAL, copy_state, state_of, system_of, unknowns_of

DIFFERENCE = 0.02  # of a step, for the first rates; the second ones are those over a step, beside less rounding


@kernel
def follow_stiff_members(w, a):
    """Solve for minus the accelerations that stiff members need in addition to ``a`` (n_all,).

    They are evaluated at the slow velocities of the members. Return whether the forces are finite over the step.
    """
    true, rest = state_of(w, BEGIN).v, floats(w.added + 8 * w.n_all, w.n_all)
    v, x, rates = floats(w.added + 24 * w.n_all, w.n), floats(w.increment, w.n), floats(w.added + 32 * w.n_all, w.n)
    force_rates(w, true, rest, False, rates)
    if not solve_for(w, rates):
        return False
    for i in range(w.n_q):
        v[i] = true[i] - (x[i] if moves(w, i) else 0.0)
    force_rates(w, v, a, True, rates)
    return solve_for(w, rates)


@kernel
def solve_for(w, rates):
    """Solve with the last factor for ``rates`` (n,) of forces; return whether they are finite."""
    b, x = floats(w.residual, w.n_all), floats(w.increment, w.n)
    for i in range(w.n):
        b[i] = rates[i]
    call(w.substitute, w.substitute_words, 0)
    for i in range(w.n_q):
        if not np.isfinite(x[i]):
            return False
    return True


@kernel
def moves(w, i):
    """Return whether an unknown has inertia or constraints that move it; others follow from equations of their own."""
    kind = integers(w.kind, w.n_all)[i]
    return kind != MASSLESS and kind < SIGNAL


@kernel
def force_rates(w, v, a, second, rates_out):
    """Write r (n,) at BEGIN, or g if ``second``, for velocities ``v`` and accelerations ``a`` (>= n_q,).

    Zero for signals and constraints. Overwrites TRIAL.
    """
    f, of, dt = floats(w.residual, w.n_all), unknowns_of(w), w.h if second else DIFFERENCE * w.h
    rates_out[:] = 0.0
    for steps in range(-1, 2):
        for way in range(-1, 2, 2):
            even, odd = 0.25 * steps / dt, 0.0 if steps else 0.5 * w.cC
            if second:
                even, odd = (0.5 if steps else -1.0) / (dt * dt), 0.25 * steps * w.cC / dt
            evaluate_forces(w, of, v, a, steps * dt, way)
            for i in range(w.n_q):
                if of.kind[i] < SIGNAL:
                    rates_out[i] += (even + way * odd) * f[i]


@kernel
def evaluate_forces(w, of, v, a, dt, way):
    """Write the residual a time dt from BEGIN along the motion, without inertia, with ``way`` times its velocities."""
    s, s_moved, system = state_of(w, BEGIN), state_of(w, TRIAL), system_of(w)
    copy_state(w, BEGIN, TRIAL)
    move(of, dt, Instant(s.t, s.z, v, a, s.R, s.phases, s.memory), s_moved)
    for i in range(w.n_q):
        if moves(w, i):
            s_moved.v[i] = way * (v[i] + dt * a[i])
        else:
            s_moved.z[i] = s.z[i]
    s_moved.a[:] = 0.0
    bind_state(system, s_moved)
    system[0].lag = 1.0 / w.cC
    residual(residual_loops(w), system, w.k, 0.0)
