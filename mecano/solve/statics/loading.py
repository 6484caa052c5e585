r"""Parameter of a path of equilibria: the load factor, or the time in the laws of the loads.

At rest the equations are :math:`r(q) = 0`. The path from the initial configuration :math:`q_0`, in equilibrium or not,
is

.. math::  r_0(q) + \mu\, r_L(q) - \max(0, 1 - \mu)\, r_0(q_0) = 0, \qquad r_L\text{: loads and gravity},

so the start is an equilibrium for the load factor :math:`\mu = 0`, and exactly the loads act for :math:`\mu = 1`. If
reactions balance the start, :math:`\mu` is the fraction of the loads, dead or following, and the last term is left out;
otherwise the imbalance without loads is removed in proportion. Gravity is scaled by the principle of equivalence: a
frame that falls with :math:`(1 - \mu) g` has the gravity :math:`\mu g`, for every element with mass.
"""

from typing import Any, TypeAlias

import numpy as np

from mecano.model.assembly import Assembly
from mecano.model.state import State
from mecano.model.system import System

Loading: TypeAlias = "LoadFactor | Clock"
ROUNDING = 1e-9  # of the largest force: a smaller imbalance counts as zero
DENSE_ROWS = 600  # motions up to which reactions are found by dense least squares
STRESSED = (
    "; over: time, with heating, preload or natural lengths that grow by laws of time: over the load factor they act "
    "in full from the start, where forces that fade hold the model"
)


class LoadFactor:
    """Load factor mu of all loads and of gravity; functions of time are evaluated at the time of the state."""

    name, unit, hint = "load factor", "", ""
    beyond = "method: arc_length past a limit point; method: relaxation, which lets a mechanism fall into place"

    def __init__(self, system: System, start: State):
        """Take ``start`` as the configuration whose imbalance without loads is removed along the path."""
        self.system = system
        self.gravity = np.zeros(system.numbering.n_all)
        self.gravity[system.numbering.x[:, None] + np.arange(3)] = system.context.gravity
        self.imbalance = np.zeros(system.n_q)
        s = start.copy()
        s.v[:] = 0.0
        assembly = self.assemble(s, 0.0, cK=1.0)
        imbalance, least = assembly.residual[: system.n_q].copy(), ROUNDING * assembly.size.max(initial=0.0)
        if np.abs(imbalance).max(initial=0.0) <= least:
            return
        if np.abs(_without_reactions(system, assembly, imbalance)).max() > least:
            self.imbalance, self.hint = imbalance, STRESSED

    def assemble(
        self, s: State, mu: float, k: float = 1.0, penalty: float = 0.0, into: Assembly | None = None, **weights: Any
    ) -> Assembly:
        """Assemble ``system`` at the load factor mu; sets the accelerations of ``s``, which replace gravity.

        ``weights`` are cK, cC, cM and T of ``System.assemble``.
        """
        system = self.system
        np.multiply(self.gravity, 1.0 - mu, out=s.a)
        assembly = system.assemble(s, k, penalty, into=into, **weights)
        if mu != 1.0:
            system.scale_loads(assembly, s, mu, **weights)
            with np.errstate(invalid="ignore"):  # a force that is not finite is reported by Newton's method
                assembly.residual[: system.n_q] -= max(0.0, 1.0 - mu) * self.imbalance
        return assembly

    def slope(self, s: State, mu: float) -> np.ndarray:
        """Return the derivative (n,) of the residual by the load factor; at the corner mu = 1, the one to the right."""
        more, here = (self.assemble(s, factor).residual for factor in (2.0, 1.0))
        slope = more - here
        slope[: self.system.n_q] += self.imbalance if mu < 1.0 else 0.0
        return slope[: self.system.n]


class Clock:
    """Time [s] in the laws of the loads; all loads act in full."""

    name, unit, hint = "t", " s", ""
    beyond = "a run (time: in place of static:, with initial: static and some damping), in which it jumps"

    def __init__(self, system: System):
        self.system = system

    def assemble(
        self, s: State, t: float, k: float = 1.0, penalty: float = 0.0, into: Assembly | None = None,
        **weights: Any,
    ) -> Assembly:  # fmt: skip
        """Assemble ``system`` at rest at the time t [s], to which the time of ``s`` is set."""
        s.t = t
        s.a[:] = 0.0
        return self.system.assemble(s, k, penalty, into=into, **weights)


def _without_reactions(system, assembly, forces):
    """Return what reactions leave of ``forces`` (n_q,); the ``assembly`` of the state contains its stiffness."""
    n_q = system.n_q
    own = (system.rows < n_q) & (system.cols >= n_q)
    rows, columns, values = system.rows[own], system.cols[own] - n_q, assembly.data[: system.nnz][own]
    if n_q <= DENSE_ROWS:
        D = np.zeros((n_q, system.n - n_q))
        np.add.at(D, (rows, columns), values)
        return forces - D @ np.linalg.lstsq(D, forces, rcond=1e-12)[0]
    import scipy.sparse as sp  # takes 0.2 s to import, hence only when needed
    from scipy.sparse.linalg import lsqr

    D = sp.csr_matrix((values, (rows, columns)), shape=(n_q, system.n - n_q))
    return forces - D @ lsqr(D, forces, atol=1e-14, btol=1e-14, iter_lim=2000)[0]
