"""Static equilibria of decks, with the quantities needed by the tests of beams."""

import textwrap

import scipy.sparse as sp
from time_runs import deck

from mecano.analyses.equilibria import follow
from mecano.analyses.prepare import prepare
from mecano.model.sampler import Sampler


class Equilibrium:
    """A deck with ``static`` at the end of its path; without loads, at its start."""

    def __init__(self, text):
        checked = deck(textwrap.dedent(text))
        prepared = prepare(checked)
        self.system, self.state = prepared.system, prepared.state
        if checked.values["loads"]:
            self.state = follow(prepared).point.state

    def tangent(self, cK=1.0, cM=0.0):
        """cK K + cM M (n, n), by material variations."""
        system, n = self.system, self.system.n
        data = system.assemble(self.state, cK=cK, cM=cM).data
        return sp.csr_matrix((data[: system.nnz], (system.rows, system.cols)), shape=(n, n))

    def position(self, name):
        """Position (3,) of a node."""
        i = [node.name for node in self.system.nodes].index(name)
        first = self.system.numbering.x[i]
        return self.state.z[first : first + 3].copy()

    def output(self, path):
        """An output."""
        sampler = Sampler(self.system)
        row = sampler.take(_Still(self.state), self.system.observe(self.state))
        c = next(column for column in sampler.columns if column.path == path)
        return row[c.start : c.start + c.size].copy()


class _Still:
    """The attributes of a run used by the sampler, at rest."""

    dissipated = given = 0.0

    def __init__(self, motion):
        self.motion = motion
