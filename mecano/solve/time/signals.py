"""Consistent signals: values of algebraic signals, rates of those with a state of their own."""

import math
from functools import lru_cache

import numpy as np

from mecano.errors import AssemblyError, Failure, NonFiniteError
from mecano.model.assembly import Assembly
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.diagnostics.scales import SMALL
from mecano.solve.time.increments import displaced, moved

ITERATIONS = 30
TOLERANCE = 1e-13  # of the signals
SINGULAR = 1e-13  # of the largest singular value
SWEEPS = 20  # of the balancing, which takes 2 or 3
NONE, ABSENT = -1_000_000, -500_000  # exponent of zero, and a bound on it when it is shifted
MOST_PATTERNS = 64  # of Jacobians whose order and scales are kept
WORTH = 0.95  # of the sum of the norms of a row and a column: balancing must reduce it below
PART = 1e-6  # of the largest entry of a singular vector: signals that take part in it
ELSEWHERE = 1e-2  # m, rad, m/s, rad/s: distance of another state, in which a circle is tried again


def settle_signals(system: System, s: State, dt: float) -> None:
    """Set the signals of ``s`` in place so that their equations hold at its positions and velocities.

    Newton's method finds the values of signals without a state, and the rates of those with one. Rates of the former
    and second rates of the latter are forward differences over ``dt`` [s] of second order; they are found twice if
    signals depend on rates of the former, such as those of set points. Raises NonFiniteError where signals are not
    finite, AssemblyError where they form a loop without a unique solution.
    """
    from mecano.solve.time.compiled_signals import CompiledSignals  # few runs have signals

    if system.kept(CompiledSignals).settle(s, dt):
        return
    equations = system.kept(_Equations)
    _solve(equations, s)
    reads_rates = _refuse_undetermined(equations, s)
    _solve(equations, s)  # the last correction may be the rounding that carries the time over a jump of a law
    s.a[equations.own] = 0.0
    _find_rates(equations, s, dt)
    if reads_rates:
        _solve(equations, s)
        _find_rates(equations, s, dt)


def refuse_undetermined(system: "System", s: "State") -> None:
    """Solve the equations of the signals of ``s`` in place, if it has any; raise the errors of ``settle_signals``."""
    if system.signals.any():
        equations = system.kept(_Equations)
        _refuse_undetermined(equations, _solve(equations, s))


def rates_along(system: System, s: State, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return rates and second rates (n,) of signals without a state along the accelerated motion of ``s``.

    By forward differences over ``dt`` [s].
    """
    now, next_, after = (_solve(system.kept(_Equations), moved(s, i * dt, system.numbering)).z for i in range(3))
    return (4.0 * next_ - 3.0 * now - after) / (2.0 * dt), (now - 2.0 * next_ + after) / (dt * dt)


def _find_rates(equations, s, dt):
    """Set rates and second rates of the signals of ``s`` in place, as ``settle_signals`` describes."""
    system, along = equations.system, s.unaccelerated()
    first, second = (_solve(equations, moved(along, i * dt, system.numbering)) for i in (1, 2))
    at_once, states = np.flatnonzero(system.signals & ~system.states), np.flatnonzero(system.states)
    s.v[at_once] = (4.0 * first.z - 3.0 * s.z - second.z)[at_once] / (2.0 * dt)
    s.a[states] = (4.0 * first.v - 3.0 * s.v - second.v)[states] / (2.0 * dt)


def solve_signals(system: System, s: State) -> State:
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
        found = equations.decomposed(J)
        if not len(own) or found.singular:
            break
        if _correct(equations, s, own, found.solve(r)) <= TOLERANCE and all_known:
            break
    return s


def _correct(equations, s, own, change):
    """Subtract the ``change`` of the signals ``own`` in ``s`` in place; return the largest one, over the signal."""
    is_state = equations.system.states[own]
    s.z[own] -= np.where(is_state, 0.0, change)
    s.v[own] -= np.where(is_state, change, 0.0)
    return float(np.max(np.abs(change) / np.maximum(np.abs(np.where(is_state, s.v[own], s.z[own])), SMALL)))


def _finite(J, r):
    return np.isfinite(r) & np.isfinite(J).all(axis=1)


class _Equations:
    """The equations of the signals of a system, whose indices are ``own`` (n,).

    The assembly is overwritten at every state.
    """

    def __init__(self, system: System):
        self.system, self.own = system, np.flatnonzero(system.signals)
        place = np.full(system.n, -1)
        place[self.own] = np.arange(len(self.own))
        rows, columns = place[system.rows], place[system.cols]
        self._entries = np.flatnonzero((rows >= 0) & (columns >= 0))
        self._places = rows[self._entries], columns[self._entries]
        self._assembly = Assembly(system)
        self._decomposed: _Decomposition | None = None

    def at(self, s: State) -> tuple[np.ndarray, np.ndarray, bool]:
        """Return derivatives (n, n) by values of the signals, or rates of those with a state, and the residual (n,).

        The third value is True if the residual depends on rates of signals without a state.
        """
        n, is_state, found = len(self.own), self.system.states[self.own], self._assembly
        J = np.zeros((2, n, n))
        for i, (cK, cC) in enumerate(((1.0, 0.0), (0.0, 1.0))):
            self.system.assemble(s, cK=cK, cC=cC, into=found)
            J[i][self._places] = found.data[self._entries]
        return np.where(is_state, J[1], J[0]), found.residual[self.own], bool(J[1][:, ~is_state].any())

    def decomposed(self, J: np.ndarray) -> "_Decomposition":
        """Return the _Decomposition of a Jacobian ``J`` (n, n) of the signals."""
        if self._decomposed is None or not np.array_equal(J, self._decomposed.J):
            self._decomposed = _Decomposition(J)
        return self._decomposed


class _Decomposition:
    """A Jacobian ``J`` (n, n) of signals: ``core`` are those of loops and between loops, solved simultaneously.

    Those that read ``first`` ones only, and those that only ``last`` ones read, follow one after another. So a quotient
    that is huge before its denominator is known disturbs no signal but those that read it.
    """

    def __init__(self, J: np.ndarray):
        self.J = J
        reads = J != 0.0
        np.fill_diagonal(reads, np.diag(J) != 1.0)
        self.first, self.core, self.last = _order(reads.tobytes(), len(J))
        within = J[np.ix_(self.core, self.core)]
        self.scales = _scales(within)
        self.U, self.sigma, self.Vt = np.linalg.svd(within / self.scales[:, None] * self.scales)
        self.singular = len(self.core) > 0 and self.sigma[-1] <= SINGULAR * self.sigma[0]

    def solve(self, r: np.ndarray) -> np.ndarray:
        """Return x (n,) with J x = ``r``."""
        x = np.zeros(len(r))
        for i in self.first:
            x[i] = r[i] - self.J[i] @ x
        if len(self.core):
            beyond = (r - self.J @ x)[self.core]
            x[self.core] = self.scales * (self.Vt.T @ ((self.U.T @ (beyond / self.scales)) / self.sigma))
        for i in self.last:
            x[i] = r[i] - self.J[i] @ x
        return x


@lru_cache(maxsize=MOST_PATTERNS)
def _order(pattern: bytes, n: int) -> tuple[list[int], np.ndarray, list[int]]:
    """Return ``first``, ``core`` and ``last`` of a _Decomposition; ``pattern``: reads (n, n) bool."""
    reads, remaining = np.frombuffer(pattern, bool).reshape(n, n), np.ones(n, bool)
    first = _peeled(reads, remaining)
    last = _peeled(reads.T, remaining)[::-1]
    return first, np.flatnonzero(remaining), last


def _peeled(reads, remaining):
    """Return the signals that read no remaining one, in order, and take them out of ``remaining`` in place."""
    order = []
    while len(found := np.flatnonzero(remaining & ~np.any(reads & remaining, axis=1))):
        order += found.tolist()
        remaining[found] = False
    return order


def _scales(J: np.ndarray) -> np.ndarray:
    """Return powers of 2, d (n,), with which the largest entries of rows and columns of D^-1 J D are similar.

    They follow from the exponents of the entries, which rarely change.
    """
    exponents = np.where(J == 0.0, NONE, np.frexp(J)[1]).astype(np.int64)
    return 2.0 ** _balancing(exponents.tobytes(), len(J))


@lru_cache(maxsize=MOST_PATTERNS)
def _balancing(exponents: bytes, n: int) -> np.ndarray:
    """Return the exponents of ``_scales`` for those of J.

    Parlett and Reinsch 1969, "Balancing a matrix for calculation of eigenvalues and eigenvectors", as LAPACK's gebal;
    scipy.linalg takes as long to import as a short run.
    """
    size, d = np.frombuffer(exponents, np.int64).reshape(n, n).copy(), np.zeros(n, int)
    for _ in range(SWEEPS):
        settled = True
        for i in range(n):
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
        remedy = "what to try: keep divisors away from zero, as in y/max(x, 1e-3); are velocities missing in 'initial'?"
        raise NonFiniteError(f"at t = {s.t:.9g} s {name} is not finite\n{remedy}").about([name.place])
    return reads_rates


def refuse_circles(system: System, s: State) -> None:
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
    found = equations.decomposed(J)
    if not found.singular:
        return []
    taking_part = [np.abs(vector) > PART * np.abs(vector).max() for vector in (found.U[:, -1], found.Vt[-1])]
    members = found.core[taking_part[0] & taking_part[1]]
    circle = [int(members[0] if len(members) else found.core[np.argmax(np.abs(found.Vt[-1]))])]
    while len(circle) < len(members):
        following = [int(i) for i in members if i not in circle and J[circle[-1], i]]
        if not following:
            break
        circle.append(following[0])
    return circle


def _error(titles, when=""):
    circle = " -> ".join([*titles, titles[0]])
    text = f"{when}signals form a loop without a unique solution: {circle}"
    return AssemblyError(text, Failure.SINGULAR, timed=True).about(titles)
