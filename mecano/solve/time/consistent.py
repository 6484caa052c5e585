r"""Consistent velocities, accelerations and multipliers at given positions.

All three come from one matrix, factored once,

.. math:: \begin{bmatrix} M + p B^T B & -k B^T \\ -k B & -k^2 c \end{bmatrix},

with right-hand sides that set the rate, the second rate, or its derivative, of the constraints. The penalty p, k times
the ``penalty_share`` and the factors of the system, makes it regular for nodes without mass; the compliances c are
zero unless constraints are redundant.
"""

import numpy as np

from mecano.errors import AssemblyError, Failure
from mecano.model.assembly import Assembly
from mecano.model.numbering import SCALAR
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.diagnostics.failure import not_finite
from mecano.solve.events.compliance import Compliance
from mecano.solve.linear.sparse import LinearSolver
from mecano.solve.time.constrained_mass import ConstrainedMass
from mecano.solve.time.contradictions import Contradictions
from mecano.solve.time.increments import displaced
from mecano.solve.time.massless_scalars import DIFFERENCE, MasslessScalars
from mecano.solve.time.signals import settle_signals

RUBBING = 20  # iterations on the friction at most
DEPENDENT = 1e-10  # of a diagonal, after elimination: a constraint that repeats others
ROUNDING = 1e-12  # of the largest multiplier, value or rate: an iteration on them has converged


class Consistent:
    """The factored matrix above at one configuration, and the problems solved with it."""

    def __init__(self, system: System, linear: LinearSolver, s: State, length: float, compliance: Compliance | None):
        """Factor at the positions of ``s`` (its a and multipliers are not used), of a mechanism of the ``length`` [m].

        Raises AssemblyError if the matrix is singular.
        """
        self.system, self.linear, self._assembly = system, linear, system.kept(Assembly)
        data, self.loose, self.k, self.softness = system.kept(ConstrainedMass).at(s, length, compliance)
        scalars = system.numbering.kind[: system.n_q] == SCALAR
        self.massless = MasslessScalars(system, np.flatnonzero(self.loose & scalars))
        self.penalty = self.k * system.penalty_share * system.penalty_factors
        self.data, self.bare, self.compliance = data, system.bare(s), compliance
        self._factor()

    def repeats(self) -> bool:
        """Return whether a constraint without compliance depends on others; call it before any solution.

        Its pivot has been cancelled by elimination, or is small relative to its ``mobility``: where rows are exchanged,
        or one group of pivots adds and cancels, no intermediate value of a diagonal shows it.
        """
        n_q = self.system.n_q
        dependent = np.ones(self.system.n_l, bool)
        if self.linear.kept:
            dependent = self.linear.cancellation()[n_q:] < DEPENDENT
            dependent |= np.abs(self.linear.pivots()[n_q:]) < DEPENDENT * self._mobility()
        if self.compliance is not None:
            dependent &= np.diff(self.compliance.matrix.starts) == 0
        return bool(dependent.any())

    def _mobility(self):
        """Return (n_l,) the sum of (k B)^2/S of each constraint, S the diagonal: its pivot if S were diagonal."""
        system, n_q = self.system, self.system.n_q
        at = np.flatnonzero((system.rows >= n_q) & (system.cols < n_q) & (self.data[: system.nnz] != 0.0))
        diagonal = np.abs(self.data[system.diagonal[system.cols[at]]])
        shares = self.data[at] ** 2 / np.where(diagonal > 0.0, diagonal, np.inf)
        return np.bincount(system.rows[at] - n_q, shares, system.n_l)

    def _factor(self):
        """Factor the matrix, unless it is factored already, as after an event that changes forces only."""
        factored, n = self.linear.label, self.system.nnz
        if isinstance(factored, np.ndarray) and np.array_equal(factored[:n], self.data[:n]):
            return
        self._solve(self.data, np.zeros(self.system.n))
        self.linear.label = self.data

    def _solve(self, data, b):
        x = np.zeros(self.system.n)
        status = self.linear.solve(data, b, x)
        if not status.finite:
            raise not_finite(self.system, data, self.bare.t)
        if not status.ok:
            raise AssemblyError(
                "the constraints and masses of the model leave some accelerations undetermined", Failure.SINGULAR
            )
        return x

    def _solve_again(self, top, bottom):
        n_q, x = self.system.n_q, self._sharing(top, bottom)
        if self.compliance is not None:
            yielding = self.softness * self.compliance.deflection(self.k * x[n_q:])
            x += self._sharing(np.zeros(n_q), -self.k * yielding)
        return x[:n_q], self.k * x[n_q:]

    def _sharing(self, top, bottom):
        x = self._solution(top, bottom)
        if self.compliance is not None and len(self.compliance.released):
            x = self._solution(top, self.compliance.sharing(self.k, bottom, x[self.system.n_q :]))
        return x

    def _solution(self, top, bottom):
        x = np.zeros(self.system.n)
        self.linear.solve_again(np.concatenate([top, bottom]), x)
        return x

    def change(self, rate: np.ndarray) -> np.ndarray:
        """Return the least change dq (n_q,), in the metric of the mass, with B dq = rate (n_l,)."""
        return self.impose(rate)[0]

    def respond(self, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the response to forces (n_q,) under constraints: rates (n_q,), reactions (n_l,) without penalty."""
        return self._solve_again(np.where(self.loose, 0.0, forces), np.zeros(self.system.n_l))

    def impose(self, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the ``change`` dq (n_q,) and k mu (n_l,): its impulses plus p B dq, as the penalty acts on B dq."""
        return self._solve_again(np.zeros(self.system.n_q), -self.k * rate)

    def share(self, reactions: np.ndarray) -> np.ndarray:
        """Return reactions or impulses (n_l,) of the same effect and of least norm.

        The first correction makes their norm the least, but yields to the compliances; the second takes that back.
        """
        if self.compliance is None:
            return reactions
        none, out = np.zeros(self.system.n_q), reactions
        for sign in (1.0, -1.0):
            yielding = self.softness * self.compliance.deflection(out)
            out = out + self.k * self._sharing(none, sign * self.k * yielding)[self.system.n_q :]
        return out

    def project_velocity(self, s: State) -> None:
        """Change v of ``s`` in place so that the rates of the constraints become zero."""
        s.v[: self.system.n_q] += self.change(-self.system.constraint_derivatives(s)[:, 1])

    def settle(self, s: State, h: float) -> None:
        """Set signals, and values and rates of massless unknowns, of ``s`` in place, consistent for steps of size h."""
        if self.system.signals.any():
            settle_signals(self.system, s, DIFFERENCE * h)
            signals = np.flatnonzero(self.system.signals)
            self.bare.z[signals] = s.z[signals]
        self.massless.settle(s, h)

    def accelerate(self, s: State) -> None:
        """Set accelerations and multipliers of ``s`` in place from the equations of motion at its q and v."""
        system = self.system
        bare = _with(self.bare, s.v, np.zeros_like(s.a))
        gamma = system.constraint_derivatives(bare)[:, 2]
        residual = system.assemble(bare, into=self._assembly).residual
        top = np.where(self.loose, 0.0, -residual[: system.n_q])
        a, reaction = self._solve_again(top, self.k * gamma)
        s.a[system.n_q :] = 0.0
        s.a[: system.n_q] = np.where(system.signals, s.a[: system.n_q], a)
        s.z[system.n_q : system.n] = self.share(reaction + self.penalty * gamma)
        if len(system.coupled_multipliers) or len(system.sensed_multipliers):
            self._apply_multipliers(s, np.abs(top).max(initial=0.0))

    def _apply_multipliers(self, s, applied):
        """Solve for accelerations, multipliers and signals of ``s``, where forces or signals depend on multipliers.

        Newton's method; the forces are those of friction, and the accelerations satisfy the constraints throughout. If
        it does not converge, because friction locks, the first step finds the motion. Multipliers that are small
        relative to the largest ``applied`` force, as in free flight, are rounding errors.
        """
        system, n_q, n = self.system, self.system.n_q, self.system.n
        signals = system.signals if len(system.sensed_multipliers) else np.zeros(n_q, bool)
        for _ in range(RUBBING):
            here = _with(self.bare, s.v, s.a)
            here.z[n_q:n] = s.z[n_q:n]
            here.z[:n_q][signals] = s.z[:n_q][signals]
            data = self.data.copy()
            residual = self._couple_signals(here, signals, data)
            unbalanced = np.where(self.loose & ~signals, 0.0, -residual[:n_q])
            system.add_coupled_multipliers(here, self.k, data)
            change = self._solve(data, np.concatenate([unbalanced, np.zeros(system.n_l)]))
            of_motions, of_signals = np.where(signals, 0.0, change[:n_q]), np.where(signals, change[:n_q], 0.0)
            s.a[:n_q] += of_motions
            s.v[:n_q] += np.where(system.states, of_signals, 0.0)
            s.z[:n_q] += np.where(system.states, 0.0, of_signals)
            s.z[n_q:n] += self.k * change[n_q:]
            if np.abs(self.k * change[n_q:]).max() <= ROUNDING * max(applied, np.abs(s.z[n_q:n]).max()):
                break
        self._factor()

    def friction_on_itself(self, s: State) -> np.ndarray:
        """Return W (m, m): changes of the coupled multipliers at ``s`` by the friction that unit multipliers cause.

        The reactions keep the constraints; without friction the change is zero.
        """
        import scipy.sparse as sp  # no ordinary run needs it

        system, n_q, n, data = self.system, self.system.n_q, self.system.n, np.zeros(len(self.data))
        coupled = n_q + system.coupled_multipliers
        here = _with(self.bare, s.v, s.a)
        here.z[n_q:n] = s.z[n_q:n]
        system.add_coupled_multipliers(here, self.k, data)
        of_all = sp.csc_matrix((data[: system.nnz], (system.rows, system.cols)), shape=(n, n))
        columns = of_all[:, coupled].toarray().T
        return np.array([self._solution(column[:n_q], column[n_q:])[coupled] for column in columns]).T

    def _couple_signals(self, s, signals, data):
        """Enter the equations of ``signals`` (n_q,) bool and their columns at ``s`` into data; return the residual.

        The unknown of a signal is its value, or its rate if it has a state.
        """
        system, n_q = self.system, self.system.n_q
        if not signals.any():
            return system.assemble(s, self.k, into=self._assembly).residual
        assembly = system.assemble(s, self.k, cK=1.0, into=self._assembly)
        by_value, residual = assembly.data[: system.nnz].copy(), assembly.residual.copy()
        by_rate = system.assemble(s, self.k, cC=1.0, into=self._assembly).data[: system.nnz]
        row, column = (np.append(signals, np.zeros(system.n_l, bool))[i] for i in (system.rows, system.cols))
        has_state = np.append(system.states, np.zeros(system.n_l, bool))[system.cols]
        values = np.where(has_state, by_rate, by_value)
        data[: system.nnz][row | column] = np.where(column | (system.cols >= n_q), values, 0.0)[row | column]
        return residual

    def apply_compliance(self, s: State, compliance: Compliance) -> State:
        """Return ``s`` with positions moved by the deflection of the compliances under its reactions."""
        n_q, n = self.system.n_q, self.system.n
        gap = self.system.constraint_derivatives(s)[:, 0] + compliance.matrix @ s.z[n_q:n]
        gap[self.system.numbering.of_rates] = 0.0
        return displaced(s, self.change(-gap), self.system.numbering)

    def without_compliance(self, s: State) -> State:
        """Return ``s`` with positions and velocities that satisfy compliant constraints as exactly as all others.

        A joint that locks in this state is free of stress. In the deflected state it would keep the deflection and, in
        series with the compliances, the reactions of this instant.
        """
        gap = self.system.constraint_derivatives(s)[:, 0]
        gap[self.system.numbering.of_rates] = 0.0
        s = displaced(s, self.change(-gap), self.system.numbering)
        self.project_velocity(s)
        return s


def consistent_state(
    system: System,
    linear: LinearSolver,
    s: State,
    h: float,
    contradictions: Contradictions,
    compliance: Compliance | None,
    consistent: Consistent | None,
) -> tuple[State, Consistent]:
    """Return ``s`` with consistent velocities, accelerations and multipliers for steps of size h, and its Consistent.

    ``consistent``, if given, is factored for ``s``. Raises AssemblyError where constraints contradict one another.
    """
    s = s.copy()
    consistent = consistent or Consistent(system, linear, s, contradictions.length, compliance)
    consistent.project_velocity(s)
    contradictions.refuse(s, h)
    consistent.settle(s, h)
    consistent.accelerate(s)
    driven = system.n_l or system.signals.any()  # reactions and signals may act on massless unknowns
    if (len(consistent.massless.own) and driven) or len(system.sensed_multipliers):
        consistent.settle(s, h)
        consistent.accelerate(s)
    if len(system.driving_signals):
        from mecano.solve.time.driving_signals import settle_driving_signals  # few models have any

        consistent = settle_driving_signals(
            consistent, s, h, lambda: Consistent(system, linear, s, contradictions.length, compliance)
        )
    return s, consistent


def _with(s, v, a):
    out = s.copy()
    out.v[:], out.a[:] = v, a
    return out
