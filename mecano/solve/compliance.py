r"""Compliances that let redundant constraints share their forces: :math:`\Phi + c \Lambda = 0`.

See docs/theory.md, section 3.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from mecano.compiled.entry import Indices, Vector, entry
from mecano.model.numbering import LENGTH_CONSTRAINT, ROTATION

SOFTNESS = 1e-11  # of the length scale, or rad: a tenth of the tolerance of the constraints
SHARE_OF_PENALTY = 1e-3
TINY = 1e-300


@dataclass(frozen=True)
class Compliance:
    """The symmetric matrix c, which couples rows of one element only, and where it stands in the tangent.

    Constraints on velocities give way by c for each second: ``lag`` times c in a step, whose rows are displacements.
    """

    matrix: object  # csr_matrix (n_l, n_l) [m/N, rad/(N m)], per second for constraints on velocities
    places: np.ndarray  # (matrix.nnz,) in the values of the tangent
    of_rates: np.ndarray  # (matrix.nnz,) bool
    values: np.ndarray  # (matrix.nnz,) in a step

    @cached_property
    def largest_penalty(self):
        """Above it [N/m] the penalty would take a noticeable share of the reactions of constraints that give way."""
        return SHARE_OF_PENALTY / self.matrix.data.max()

    @property
    def rows(self):
        """c by rows, as ``soften`` takes it: where each begins, columns, values."""
        return self.matrix.indptr.astype(np.int64), self.matrix.indices.astype(np.int64), self.values

    def set_lag(self, lag):
        """Set the values for steps in which rates count ``lag`` [s] times."""
        self.values[:] = np.where(self.of_rates, lag, 1.0) * self.matrix.data

    def soften_tangent(self, k, data, values=None):
        """Put -k^2 c into the values of the tangent, where no element adds anything but to constraints let go."""
        data[self.places] += -k * k * (self.matrix.data if values is None else values)

    def to_plain(self):
        """Dict of arrays that ``from_plain`` turns into the same compliances."""
        c = self.matrix
        of = {"data": c.data, "indices": c.indices, "indptr": c.indptr}
        return {**of, "places": self.places, "of_rates": self.of_rates, "values": self.values}

    @classmethod
    def from_plain(cls, plain):
        """The compliances of ``to_plain``."""
        import scipy.sparse as sp  # no ordinary run needs it (docs/architecture.md, Start)

        n = len(plain["indptr"]) - 1
        matrix = sp.csr_matrix((plain["data"], plain["indices"], plain["indptr"]), shape=(n, n))
        return cls(matrix, plain["places"], plain["of_rates"], plain["values"].copy())


NO_ROWS = np.zeros(1, np.int64), np.zeros(0, np.int64), np.zeros(0)


@entry
def soften(k: float, starts: Indices, columns: Indices, values: Vector, multipliers: Vector, rows_out: Vector):
    """Add -k c Lambda to the rows of the constraints (n_l,); c by rows."""
    for i in range(starts.shape[0] - 1):
        for j in range(starts[i], starts[i + 1]):
            rows_out[i] -= k * values[j] * multipliers[columns[j]]


def compliance(system, s, length, dependent):
    """Compliance of a model, or None when no constraint is redundant.

    Reactions in the directions that the projector ``dependent`` (n_l, n_l) of the Analysis holds meet a compliance
    under which the forces at work in ``s``, or the weight of the heaviest body, move them by SOFTNESS of the length
    scale, or rad; all others are exact.
    """
    if dependent is None or not dependent.nnz:
        return None
    import scipy.sparse as sp  # no ordinary run needs it (docs/architecture.md, Start)

    system.assemble(s, 1.0, 0.0, 0.0, 0.0, 1.0)
    of = system.numbering
    sizes = np.where(of.kind == ROTATION, system.size / length, system.size)
    inertias = system.data[system.diagonal[: system.n_q]]
    masses = np.where(of.kind[: system.n_q] == ROTATION, inertias / length**2, inertias)
    force = max(sizes.max(), 9.81 * masses.max(initial=0.0), TINY)
    angular = of.kind[system.n_q : system.n] != LENGTH_CONSTRAINT
    root = sp.diags(np.sqrt(SOFTNESS * np.where(angular, 1.0 / (force * length), length / force)))
    matrix = sp.csr_matrix(root @ dependent @ root)
    matrix.sort_indices()
    entries = matrix.tocoo()
    codes = (system.n_q + entries.row.astype(np.int64)) * system.n + system.n_q + entries.col
    of_rates = of.of_rates[entries.row]
    places = np.searchsorted(system.rows * system.n + system.cols, codes)
    return Compliance(matrix, places, of_rates, matrix.data.copy())
