"""Signals that fit a motion: the values of those that follow at once, the rates of those with a value of their own."""

import numpy as np

from mecano.errors import AssemblyError, Failure
from mecano.solve.time.increments import SMALL, moved

ITERATIONS = 30
TOLERANCE = 1e-13  # of the signals
SINGULAR = 1e-13  # of the largest singular value


def settle_signals(system, s, dt):
    """Set the signals of ``s`` in place so that their equations hold at its positions and velocities.

    The values of signals without a state follow by Newton's method, as do the rates of those with one. Rates of the
    former and second rates of the latter are forward differences over ``dt`` [s] of second order. Raises AssemblyError
    where signals that need one another do not determine one another.
    """
    solve_signals(system, s)
    s.a[: system.n_q][system.signals] = 0.0
    along = s.copy()
    along.a[:] = 0.0
    first, second = (solve_signals(system, moved(along, i * dt, system.numbering)) for i in (1, 2))
    at_once, states = np.flatnonzero(system.signals & ~system.states), np.flatnonzero(system.states)
    s.v[at_once] = (4.0 * first.z - 3.0 * s.z - second.z)[at_once] / (2.0 * dt)
    s.a[states] = (4.0 * first.v - 3.0 * s.v - second.v)[states] / (2.0 * dt)


def solve_signals(system, s):
    """Solve the equations of the signals of ``s`` in place, as far as it has some; the same state."""
    own = np.flatnonzero(system.signals)
    is_state = system.states[own]
    for _ in range(ITERATIONS if len(own) else 0):
        J = _tangent(system, s, own, is_state)
        change = _solution(system, J, system.residual[own], own, s.t)
        s.z[own] -= np.where(is_state, 0.0, change)
        s.v[own] -= np.where(is_state, change, 0.0)
        size = np.maximum(np.abs(np.where(is_state, s.v[own], s.z[own])), SMALL)
        if np.all(np.abs(change) <= TOLERANCE * size):
            break
    return s


def _tangent(system, s, own, is_state):
    """Residual, and its derivatives (n, n) by the values of the signals, or by the rates of those with a state."""
    place = np.full(system.n, -1)
    place[own] = np.arange(len(own))
    rows, columns = place[system.rows], place[system.cols]
    entries = np.flatnonzero((rows >= 0) & (columns >= 0))
    J = np.zeros((2, len(own), len(own)))
    for i, weights in enumerate(((1.0, 0.0), (0.0, 1.0))):
        system.assemble(s, 1.0, 0.0, *weights, 0.0)
        J[i, rows[entries], columns[entries]] = system.data[:-1][entries]
    return np.where(is_state, J[1], J[0])


def _solution(system, J, r, own, t):
    U, sigma, Vt = np.linalg.svd(J)
    if not np.all(np.isfinite(r)) or sigma[-1] <= SINGULAR * sigma[0]:
        worst = own[int(np.argmax(np.abs(Vt[-1]) if np.all(np.isfinite(r)) else ~np.isfinite(r)))]
        what = "is not determined: signals need one another in a circle" if np.all(np.isfinite(r)) else "is not finite"
        raise AssemblyError(f"at t = {t:.9g} s the signal {system.numbering.name[worst]} {what}", Failure.SINGULAR)
    return Vt.T @ ((U.T @ r) / sigma)
