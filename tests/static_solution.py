"""Static equilibrium of decks whose loads grow with the time, by Newton on the assembled equations."""

import textwrap

import numpy as np
import scipy.sparse as sp
from marching import deck
from scipy.sparse.linalg import spsolve

from mecano.deck.build import build
from mecano.model.sampler import Sampler
from mecano.model.system import System
from mecano.solve.increments import displaced

MOST_ITERATIONS = 40
SMALL = 1e-9  # last increment [m, rad], from which Newton goes on quadratically


class Equilibrium:
    """A model without constraints in equilibrium under its loads at the time ``t``, reached in equal ``steps``."""

    def __init__(self, text, t=1.0, steps=1):
        self.system = System(build(deck(textwrap.dedent(text))))
        self.state = self.system.initial_state()
        self.iterations = []
        for time in np.linspace(0.0, t, steps + 1)[1:]:
            self._solve(time)

    def _solve(self, t):
        self.state.t = t
        for iteration in range(1, MOST_ITERATIONS):
            K, residual = self.tangent()
            change = spsolve(K.tocsc(), -residual)
            self.state = displaced(self.state, change, self.system.numbering)
            if np.abs(change).max() <= SMALL:
                self.iterations.append(iteration)
                return
        raise AssertionError(f"no equilibrium at t = {t}")

    def tangent(self, cK=1.0, cM=0.0):
        """cK K + cM M (n, n), and the residual (n,)."""
        system, n = self.system, self.system.n
        system.assemble(self.state, 1.0, 0.0, cK, 0.0, cM)
        return sp.csr_matrix((system.data[:-1], (system.rows, system.cols)), shape=(n, n)), system.residual[:n].copy()

    def position(self, name):
        """Position (3,) of a node."""
        i = [node.name for node in self.system.nodes].index(name)
        first = self.system.numbering.x[i]
        return self.state.z[first : first + 3].copy()

    def rotation(self, name):
        """Rotation (3, 3) of a node."""
        i = [node.name for node in self.system.nodes].index(name)
        return self.state.R[self.system.numbering.rotation[i]].copy()

    def output(self, path):
        """An output."""
        self.system.assemble(self.state, 1.0, 0.0, 0.0, 0.0, 0.0)
        self.system.observe(self.state)
        sampler = Sampler(self.system)
        row = sampler.take(_Still(self.state))
        c = next(column for column in sampler.columns if column.path == path)
        return row[c.start : c.start + c.size].copy()


class _Still:
    """What the sampler asks of a run, at rest."""

    dissipated = given = 0.0

    def __init__(self, motion):
        self.motion = motion
