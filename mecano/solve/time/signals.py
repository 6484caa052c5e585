"""Consistent signals: values of algebraic signals, rates of those with a state of their own."""

import numpy as np

from mecano.errors import AssemblyError, Failure, NonFiniteError
from mecano.process.memory import reserve_blas_buffer
from mecano.solve.diagnostics.scales import SMALL
from mecano.solve.time.increments import displaced, moved

ITERATIONS = 30
TOLERANCE = 1e-13  # of the signals
SINGULAR = 1e-13  # of the largest singular value
PART = 1e-6  # of the largest entry of a singular vector: signals that take part in it
ELSEWHERE = 1e-2  # m, rad, m/s, rad/s: distance of another state, in which a circle is tried again


def settle_signals(system, s, dt):
    """Set the signals of ``s`` in place so that their equations hold at its positions and velocities.

    The values of signals without a state follow by Newton's method, as do the rates of those with one. Rates of the
    former and second rates of the latter are forward differences over ``dt`` [s] of second order; they are found twice
    if signals depend on rates of the former, such as those of set points. Raises NonFiniteError where signals are not
    finite, AssemblyError where they form a loop without a unique solution.
    """
    solve_signals(system, s)
    reads_rates = _refuse_undetermined(system, s)
    s.a[: system.n_q][system.signals] = 0.0
    _find_rates(system, s, dt)
    if reads_rates:
        solve_signals(system, s)
        _find_rates(system, s, dt)


def _find_rates(system, s, dt):
    """Set rates and second rates of the signals of ``s`` in place, as ``settle_signals`` describes."""
    along = s.copy()
    along.a[:] = 0.0
    first, second = (solve_signals(system, moved(along, i * dt, system.numbering)) for i in (1, 2))
    at_once, states = np.flatnonzero(system.signals & ~system.states), np.flatnonzero(system.states)
    s.v[at_once] = (4.0 * first.z - 3.0 * s.z - second.z)[at_once] / (2.0 * dt)
    s.a[states] = (4.0 * first.v - 3.0 * s.v - second.v)[states] / (2.0 * dt)


def solve_signals(system, s):
    """Solve the equations of the signals of ``s`` in place, if it has any that can be solved; return ``s``.

    A signal whose value is not finite waits until the signals that it reads are known: all are zero at first, and may
    be denominators. It may remain so before the velocities of a start are known.
    """
    signals = np.flatnonzero(system.signals)
    for _ in range(ITERATIONS if len(signals) else 0):
        J, r, _ = _equations(system, s, signals)
        known = _finite(J, r)
        own, is_state = signals[known], system.states[signals[known]]
        scales, (U, sigma, Vt) = _decomposed(J[np.ix_(known, known)])
        if not len(own) or sigma[-1] <= SINGULAR * sigma[0]:
            break
        change = scales * (Vt.T @ ((U.T @ (r[known] / scales)) / sigma))
        s.z[own] -= np.where(is_state, 0.0, change)
        s.v[own] -= np.where(is_state, change, 0.0)
        size = np.maximum(np.abs(np.where(is_state, s.v[own], s.z[own])), SMALL)
        if known.all() and np.all(np.abs(change) <= TOLERANCE * size):
            break
    return s


def _finite(J, r):
    return np.isfinite(r) & np.all(np.isfinite(J), axis=1)


def _equations(system, s, own):
    """Return derivatives (n, n) by values of the signals, or rates of those with a state, and the residual (n,).

    The third value is True if the residual depends on rates of signals without a state.
    """
    place = np.full(system.n, -1)
    place[own] = np.arange(len(own))
    rows, columns = place[system.rows], place[system.cols]
    entries = np.flatnonzero((rows >= 0) & (columns >= 0))
    J = np.zeros((2, len(own), len(own)))
    for i, weights in enumerate(((1.0, 0.0), (0.0, 1.0))):
        assembly = system.assemble(s, 1.0, 0.0, *weights, 0.0)
        J[i, rows[entries], columns[entries]] = assembly.data[:-1][entries]
    is_state = system.states[own]
    return np.where(is_state, J[1], J[0]), assembly.residual[own], bool(J[1][:, ~is_state].any())


def _decomposed(J):
    """Return scales of the signals, which have any units, and the singular values and vectors of J in these scales."""
    if not len(J):
        return np.ones(0), np.linalg.svd(J)
    import scipy.linalg as la  # not imported for decks without signals

    reserve_blas_buffer(la.lapack.dgesv)
    with np.errstate(invalid="ignore"):  # large scales are not numbers of a permutation, which is not asked for
        balanced, (scales, _) = la.matrix_balance(J, permute=False, separate=True)
    return scales, np.linalg.svd(balanced)


def _refuse_undetermined(system, s):
    """Raise an error for signals that are not determined; return True if signals depend on rates of those at once."""
    own = np.flatnonzero(system.signals)
    J, r, reads_rates = _equations(system, s, own)
    if not np.all(known := _finite(J, r)):
        name = system.numbering.name[own[np.argmin(known)]]
        error = NonFiniteError(f"at t = {s.t:.9g} s {name} is not finite")
        error.elements = (name.place,)
        raise error
    if circle := _undetermined(J):
        raise _error([system.numbering.name[own[i]].place for i in circle], f"at t = {s.t:.9g} s ")
    return reads_rates


def refuse_circles(system, s):
    """Raise AssemblyError, with the titles of the signals in ``elements``, if signals form a loop without a solution.

    ``s`` is a state before its velocities are known. A loop with a unique solution at other positions and
    velocities is left to ``settle_signals``.
    """
    if not (own := np.flatnonzero(system.signals)).size:
        return
    elsewhere = displaced(s, ELSEWHERE * np.cos(np.arange(system.n_q)), system.numbering)
    elsewhere.v[: system.n_q] += ELSEWHERE * np.sin(1.0 + np.arange(system.n_q))
    circles = []
    for state in (s.copy(), elsewhere):
        J, r, _ = _equations(system, solve_signals(system, state), own)
        circles.append(_undetermined(J) if np.all(_finite(J, r)) else [])
    if all(circles):
        raise _error([system.numbering.name[own[i]].place for i in circles[0]])


def _undetermined(J):
    """Return the signals (list of int) of a loop without a unique solution, in the order in which they read."""
    _, (U, sigma, Vt) = _decomposed(J)
    if sigma[-1] > SINGULAR * sigma[0]:
        return []
    taking_part = [np.abs(vector) > PART * np.abs(vector).max() for vector in (U[:, -1], Vt[-1])]
    members = np.flatnonzero(taking_part[0] & taking_part[1])
    circle = [int(members[0] if len(members) else np.argmax(np.abs(Vt[-1])))]
    while len(circle) < len(members):
        following = [int(i) for i in members if i not in circle and J[circle[-1], i]]
        if not following:
            break
        circle.append(following[0])
    return circle


def _error(titles, when=""):
    circle = " -> ".join([*titles, titles[0]])
    text = f"{when}signals form a loop without a unique solution: {circle}"
    error = AssemblyError(text, Failure.SINGULAR, timed=True)
    error.elements = tuple(titles)
    return error
