"""Consistent signals: values of algebraic signals, rates of those with a state of their own."""

import math
from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import AssemblyError, Failure, NonFiniteError
from mecano.model.assembly import Assembly
from mecano.solve.diagnostics.scales import SMALL
from mecano.solve.time.increments import displaced, moved

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System

ITERATIONS = 30
TOLERANCE = 1e-13  # of the signals
SINGULAR = 1e-13  # of the largest singular value
SWEEPS = 20  # of the balancing, which takes 2 or 3
NONE, ABSENT = -1_000_000, -500_000  # exponent of zero, and a bound on it when it is shifted
WORTH = 0.95  # of the sum of the norms of a row and a column: balancing must reduce it below
PART = 1e-6  # of the largest entry of a singular vector: signals that take part in it
ELSEWHERE = 1e-2  # m, rad, m/s, rad/s: distance of another state, in which a circle is tried again


def settle_signals(system: "System", s: "State", dt: float) -> None:
    """Set the signals of ``s`` in place so that their equations hold at its positions and velocities.

    Newton's method finds the values of signals without a state, and the rates of those with one. Rates of the former
    and second rates of the latter are forward differences over ``dt`` [s] of second order; they are found twice if
    signals depend on rates of the former, such as those of set points. Raises NonFiniteError where signals are not
    finite, AssemblyError where they form a loop without a unique solution.
    """
    equations = system.kept(_Equations)
    _solve(equations, s)
    reads_rates = _refuse_undetermined(equations, s)
    s.a[equations.own] = 0.0
    _find_rates(equations, s, dt)
    if reads_rates:
        _solve(equations, s)
        _find_rates(equations, s, dt)


def _find_rates(equations, s, dt):
    """Set rates and second rates of the signals of ``s`` in place, as ``settle_signals`` describes."""
    system, along = equations.system, s.copy()
    along.a[:] = 0.0
    first, second = (_solve(equations, moved(along, i * dt, system.numbering)) for i in (1, 2))
    at_once, states = np.flatnonzero(system.signals & ~system.states), np.flatnonzero(system.states)
    s.v[at_once] = (4.0 * first.z - 3.0 * s.z - second.z)[at_once] / (2.0 * dt)
    s.a[states] = (4.0 * first.v - 3.0 * s.v - second.v)[states] / (2.0 * dt)


def solve_signals(system: "System", s: "State") -> "State":
    """Solve the equations of the signals of ``s`` in place, if it has any that can be solved; return ``s``.

    A signal whose value is not finite is solved later, when the signals that it reads are known: all are zero at first,
    and may be denominators. It may remain non-finite before the velocities of a start are known.
    """
    return _solve(system.kept(_Equations), s) if system.signals.any() else s


def _solve(equations, s):
    """Do as ``solve_signals`` with the _Equations of a system."""
    for _ in range(ITERATIONS):
        J, r, _ = equations.at(s)
        known = _finite(J, r)
        all_known = known.all()
        own = equations.own if all_known else equations.own[known]
        if not all_known:
            J, r = J[np.ix_(known, known)], r[known]
        is_state = equations.system.states[own]
        scales, (U, sigma, Vt) = equations.decomposed(J)
        if not len(own) or sigma[-1] <= SINGULAR * sigma[0]:
            break
        change = scales * (Vt.T @ ((U.T @ (r / scales)) / sigma))
        s.z[own] -= np.where(is_state, 0.0, change)
        s.v[own] -= np.where(is_state, change, 0.0)
        size = np.maximum(np.abs(np.where(is_state, s.v[own], s.z[own])), SMALL)
        if all_known and np.all(np.abs(change) <= TOLERANCE * size):
            break
    return s


def _finite(J, r):
    return np.isfinite(r) & np.isfinite(J).all(axis=1)


class _Equations:
    """The equations of the signals of a system, whose indices are ``own`` (n,).

    The assembly is overwritten at every state. Most signals are linear: their Jacobian is decomposed once. That of the
    others seldom needs other scales.
    """

    def __init__(self, system: "System"):
        self.system, self.own = system, np.flatnonzero(system.signals)
        place = np.full(system.n, -1)
        place[self.own] = np.arange(len(self.own))
        rows, columns = place[system.rows], place[system.cols]
        self._entries = np.flatnonzero((rows >= 0) & (columns >= 0))
        self._places = rows[self._entries], columns[self._entries]
        self._assembly = Assembly(system)
        self._last: tuple[np.ndarray, tuple] | None = None  # a Jacobian, and what ``decomposed`` returns for it
        self._balanced: tuple[np.ndarray, np.ndarray] | None = None  # exponents, and the scales that follow from them

    def at(self, s: "State") -> tuple[np.ndarray, np.ndarray, bool]:
        """Return derivatives (n, n) by values of the signals, or rates of those with a state, and the residual (n,).

        The third value is True if the residual depends on rates of signals without a state.
        """
        n, is_state, found = len(self.own), self.system.states[self.own], self._assembly
        J = np.zeros((2, n, n))
        for i, (cK, cC) in enumerate(((1.0, 0.0), (0.0, 1.0))):
            self.system.assemble(s, cK=cK, cC=cC, into=found)
            J[i][self._places] = found.data[self._entries]
        return np.where(is_state, J[1], J[0]), found.residual[self.own], bool(J[1][:, ~is_state].any())

    def decomposed(self, J):
        """Return scales of the signals, which may have any units, and the singular values and vectors of J so scaled.

        They follow from J alone, not from Jacobians before it.
        """
        if self._last is None or not np.array_equal(J, self._last[0]):
            scales = self._scales(J)
            self._last = J, (scales, np.linalg.svd(J / scales[:, None] * scales))
        return self._last[1]

    def _scales(self, J):
        """Return the scales by which J is balanced."""
        exponents = _exponents(J)
        if self._balanced is None or not np.array_equal(exponents, self._balanced[0]):
            self._balanced = exponents, 2.0 ** _balancing(exponents)
        return self._balanced[1]


def _exponents(J):
    """Return the exponents of 2 of the entries of J, NONE for zero."""
    return np.where(J == 0.0, NONE, np.frexp(J)[1])


def _balancing(exponents):
    """Return exponents d (n,) of 2 with which the largest entries of rows and columns of D^-1 J D are similar.

    ``exponents`` (n, n) are those of J. Parlett and Reinsch 1969, "Balancing a matrix for calculation of eigenvalues
    and eigenvectors", as LAPACK's gebal; scipy.linalg takes as long to import as a short run.
    """
    size, d = exponents.copy(), np.zeros(len(exponents), int)
    for _ in range(SWEEPS):
        settled = True
        for i in range(len(size)):
            column, row = int(size[:, i].max()), int(size[i].max())
            by = (row - column) // 2
            if min(column, row) > ABSENT and _sum(column + by, row - by) < WORTH * _sum(column, row):
                settled = False
                d[i] += by
                size[:, i] += by
                size[i] -= by
        if settled:
            break
    return d


def _sum(i, j):
    return math.ldexp(0.5, i) + math.ldexp(0.5, j)


def _refuse_undetermined(equations, s):
    """Raise an error for undetermined signals; return True if signals depend on rates of algebraic signals."""
    names, own = equations.system.numbering.name, equations.own
    J, r, reads_rates = equations.at(s)
    if circle := _undetermined(equations, J, known := _finite(J, r)):  # it may be what makes others not finite
        raise _error([names[own[i]].place for i in circle], f"at t = {s.t:.9g} s ")
    if not np.all(known):
        name = names[own[np.argmin(known)]]
        error = NonFiniteError(f"at t = {s.t:.9g} s {name} is not finite")
        error.elements = (name.place,)
        raise error
    return reads_rates


def refuse_circles(system: "System", s: "State") -> None:
    """Raise AssemblyError, with the titles of the signals in ``elements``, if signals form a loop without a solution.

    ``s`` is a state before its velocities are known. A loop with a unique solution at other positions and
    velocities is left to ``settle_signals``.
    """
    if not system.signals.any():
        return
    equations = system.kept(_Equations)
    elsewhere = displaced(s, ELSEWHERE * np.cos(np.arange(system.n_q)), system.numbering)
    elsewhere.v[: system.n_q] += ELSEWHERE * np.sin(1.0 + np.arange(system.n_q))
    circles = []
    for state in (s.copy(), elsewhere):
        J, r, _ = equations.at(_solve(equations, state))
        circles.append(_undetermined(equations, J, _finite(J, r)))
    if all(circles):
        raise _error([system.numbering.name[equations.own[i]].place for i in circles[0]])


def _undetermined(equations, J, known):
    """Return the signals (list of int) of a loop without a unique solution, in the order in which they read.

    ``known`` (n,) are the signals with finite equations; the others are ignored.
    """
    numbers = np.flatnonzero(known)
    return [int(numbers[i]) for i in _circle(equations, J[np.ix_(known, known)])]


def _circle(equations, J):
    """Return the indices (list of int) into J of the equations of such a loop."""
    _, (U, sigma, Vt) = equations.decomposed(J)
    if not len(J) or sigma[-1] > SINGULAR * sigma[0]:
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
