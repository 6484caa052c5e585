r"""Constraints on velocities in statics: wheels that do not slip, skates.

A constraint :math:`B(q)\,\dot q = 0` is satisfied by any body at rest, so it does not select a configuration. Under a
slowly growing load the body moves only along :math:`B\,dq = 0`, and the multipliers are the constraint forces: adhesion
of the wheel, the force across the blade. From a point :math:`q_n` of a path the next equilibrium satisfies

.. math::  r(q) - B(q)^T \Lambda = 0, \qquad B(q_n)\,(q - q_n) = 0

with rotation increments relative to :math:`q_n`. The forces are exact; the displacement along the path is of first
order in its steps, and exact if B is constant along it (a wheel that rolls straight on). Evaluated at :math:`q_n`,
redundant rows (two wheels on one axle) are always consistent.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import AssemblyError

if TYPE_CHECKING:
    import scipy.sparse as sp

    from mecano.model.assembly import Assembly
    from mecano.model.state import State
    from mecano.model.system import System

NONE = np.zeros(0, np.int64)


@dataclass(frozen=True)
class Held:
    """The constraints on velocities of one state as constraints on displacements, and their part of the tangent."""

    B: "sp.csr_matrix"  # (n_l, n_q): rows of other constraints are empty
    values: np.ndarray  # entries of B in the tangent, one for each of ``VelocityConstraints.entries``
    squares: np.ndarray  # entries of B^T B in the tangent
    square_places: np.ndarray  # their indices in the values of the tangent


class VelocityConstraints:
    """The constraints on velocities of a system, as constraints on displacements."""

    def __init__(self, system: "System", released: np.ndarray):
        """Find the entries of the constraints; those ``released`` (indices, compliance.py) are left out."""
        self.system = system
        of_rates = system.numbering.of_rates.copy()
        of_rates[released] = False
        of_row = np.zeros(system.n, bool)
        of_row[system.n_q :] = of_rates
        self.entries = np.flatnonzero(of_row[system.rows] & (system.cols < system.n_q))
        self.rows, self.cols = system.rows[self.entries] - system.n_q, system.cols[self.entries]
        self._of_rates, self.any = of_rates, bool(of_rates.any())

    def at(self, s: "State") -> Held | None:
        """Return the Held of ``s`` at rest, or None without constraints on velocities.

        Raises AssemblyError for a rate that is prescribed, which a body at rest does not have.
        """
        if not self.any:
            return None
        self._refuse_prescribed(s)
        import scipy.sparse as sp  # takes 0.2 s to import, hence only when needed

        system = self.system
        values = -system.assemble(s, cC=1.0).data[self.entries]
        B = sp.csr_matrix((values, (self.rows, self.cols)), shape=(system.n_l, system.n_q))
        squares = sp.coo_matrix(B.T @ B)
        pattern = system.rows * system.n + system.cols
        places = np.searchsorted(pattern, squares.row.astype(np.int64) * system.n + squares.col)
        return Held(B, values, squares.data, places)

    def _refuse_prescribed(self, s):
        rates = self.system.constraint_derivatives(replace(s, v=np.zeros_like(s.v)))[:, 1]
        if len(prescribed := np.flatnonzero(self._of_rates & (rates != 0.0))):
            name = self.system.numbering.name[self.system.n_q + prescribed[0]]
            raise AssemblyError(
                f"{name.place} prescribes a rate by a signal, which no equilibrium has: start the search from a deck "
                "without it, or give a law of time as the rate"
            ).about([name.place])

    def add(
        self, assembly: "Assembly", held: Held, displacement: np.ndarray, k: float, penalty: float, tangent: bool
    ) -> None:
        """Add ``held`` over a ``displacement`` (n_q,) to the residual, and to the tangent: -k B and penalty B^T B."""
        system, n_q = self.system, self.system.n_q
        gap = held.B @ displacement
        assembly.residual[n_q : system.n] -= k * gap
        assembly.residual[:n_q] += penalty * (held.B.T @ gap)
        if tangent:
            assembly.data[self.entries] -= k * held.values
            assembly.data[held.square_places] += penalty * held.squares
