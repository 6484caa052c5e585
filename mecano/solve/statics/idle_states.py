r"""States of signals and tyres without an equation at rest, such as the integrator of a velocity.

At rest the equation :math:`r_i = 0` of a state says that its rate vanishes. After elimination of the formulas f, whose
values follow from the other unknowns,

.. math::  \bar K_i = K_i - K_{if} K_{ff}^{-1} K_f, \qquad \bar r_i = r_i - K_{if} K_{ff}^{-1} r_f

it may contain no unknown. The state is idle if also :math:`\bar r_i = 0`, and keeps its value; otherwise it grows, and
there is no equilibrium.
"""

import numpy as np

from mecano.model.assembly import Assembly
from mecano.model.numbering import SIGNAL
from mecano.model.system import System

ROUNDED = 1e-12  # of the largest entry of a row: smaller ones are rounding errors of the elimination


class IdleStates:
    """Find the states of a system that have no equation at rest."""

    def __init__(self, system: System):
        self.system, self.states = system, np.flatnonzero(system.states)
        self.formulas = np.flatnonzero(system.numbering.kind[: system.n_q] == SIGNAL)
        both = np.concatenate([self.states, self.formulas])
        self._row = np.full(system.n, -1)
        self._row[both] = np.arange(len(both))
        self._entries = np.flatnonzero(self._row[system.rows] >= 0)
        self._of_state = [np.flatnonzero(system.rows == i) for i in self.states]

    def keep(self, assembly: Assembly) -> None:
        """Replace the equations of idle states in the tangent by ones on the diagonal: they keep their values."""
        if not len(self.states):
            return
        idle, grows = self._idle(assembly)
        for i, entries in zip(self.states[idle & ~grows], np.flatnonzero(idle & ~grows), strict=True):
            assembly.data[self._of_state[entries]] = 0.0
            assembly.data[self.system.diagonal[i]] = 1.0
            assembly.residual[i] = 0.0

    def growing(self, assembly: Assembly) -> list[str]:
        """Return the names of states that grow, whatever the other unknowns are."""
        if not len(self.states):
            return []
        idle, grows = self._idle(assembly)
        return [self.system.numbering.name[i].removesuffix(": value") for i in self.states[idle & grows]]

    def _idle(self, assembly):
        """Return for each state whether its equation has no unknown (n,), and whether it is violated (n,)."""
        system, many = self.system, len(self.states)
        K = np.zeros((many + len(self.formulas), system.n))
        rows = self._row[system.rows[self._entries]]
        np.add.at(K, (rows, system.cols[self._entries]), assembly.data[self._entries])
        r = assembly.residual[np.concatenate([self.states, self.formulas])]
        size, of_residual = np.abs(K[:many]).max(axis=1), np.abs(r).max(initial=0.0)
        if len(self.formulas):
            by = np.linalg.lstsq(K[many:, self.formulas].T, K[:many, self.formulas].T, rcond=None)[0].T
            K, r = K[:many] - by @ K[many:], r[:many] - by @ r[many:]
        return np.abs(K).max(axis=1) <= ROUNDED * size, np.abs(r) > ROUNDED * of_residual
