"""Stability of equilibria of large models, by the signs of the pivots of the bordered tangent (stability.py)."""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from mecano.model.numbering import ANGLE_CONSTRAINT
from mecano.solve.diagnostics.scales import mean_diagonal
from mecano.solve.linear.sparse import LinearSolver, pattern_of
from mecano.solve.linear.symbolic_analysis import Analysis
from mecano.solve.statics.stability import NEUTRAL_WHERE_SOFT, UNKNOWN, Stability, StabilityTest, scaled

NEUTRAL_PIVOT = 1e-13  # relative pivot below which it counts as zero (sparse)
SHIFT = 1e-9  # of the mean stiffness: by which that of all directions is raised to find the softest
FARTHER = 4.0  # factor by which the shift to the most negative stiffness grows


class PivotSigns:
    """Count negative pivots of the tangents of one system, and find its softest motion by inverse iteration."""

    def __init__(self, test: StabilityTest, analysis: Analysis | None):
        """Analyse the pattern of the tangent, unless the ``analysis`` of its LinearSolver is given."""
        self.stability_test, self.system = test, test.system
        self._solver = LinearSolver(pattern_of(self.system), tolerance=0.0, analysis=analysis)

    def __call__(self, data: np.ndarray) -> Stability:
        """Return the Stability from ``data``, as StabilityTest."""
        unstable, zeros = self._negative(data)
        if unstable == UNKNOWN:
            stiffness, shape = self._softest(data)
            free = abs(stiffness) <= NEUTRAL_WHERE_SOFT * np.abs(data).max()
            return Stability(UNKNOWN, 1 if free else UNKNOWN, stiffness, shape)
        stiffness, shape = (np.nan, None) if not (unstable or zeros) else self._softest(data, unstable)
        return Stability(max(unstable, 0), zeros, stiffness, shape)

    def _matrix(self, data):
        shape = (self.system.n, self.system.n)
        return sp.csr_matrix((data[: self.system.nnz], (self.system.rows, self.system.cols)), shape=shape)

    def _negative(self, data):
        """Return (negative pivots beyond those of the constraints, zero pivots); UNKNOWN if rows were exchanged."""
        x = np.zeros(self.system.n)
        status = self._solver.solve(self._penalized(data), np.ones(self.system.n), x)
        if status.fallback:
            return UNKNOWN, UNKNOWN
        zero = self._solver.cancellation() <= NEUTRAL_PIVOT
        return int(np.sum((self._solver.pivots() < 0.0) & ~zero)) - self.system.n_l, int(zero.sum())

    def _penalized(self, data):
        """Return the tangent with k and penalty equal to its mean stiffness, to avoid zero pivots."""
        n_q, n = self.system.n_q, self.system.n
        if not self.system.n_l:
            return data
        of_angles = self.system.numbering.kind[n_q:n] == ANGLE_CONSTRAINT
        k = sp.diags(self._mean_stiffness(data) * np.where(of_angles, self.stability_test.length**2, 1.0))
        full = self._matrix(data)
        B = full[n_q:, :n_q]
        by_stiffness = k @ B
        matrix = full + sp.bmat([[B.T @ by_stiffness, (by_stiffness - B).T], [by_stiffness - B, None]])
        return np.asarray(matrix[self.system.rows, self.system.cols]).ravel()

    def _mean_stiffness(self, data):
        """Return the mean stiffness [N/m] of the tangent, or 1 N/m if it has none."""
        own = np.flatnonzero(~self.system.signals)
        return (
            mean_diagonal(data[self.system.diagonal[own]], self.system.numbering.kind[own], self.stability_test.length)
            or 1.0
        )

    def _softest(self, data, unstable=0):
        """Return (stiffness nearest to zero, or most negative one if ``unstable``, its motion); (nan, None) on failure.

        By inverse iteration; the shift exceeds the most negative stiffness.
        """
        n, n_q = self.system.n, self.system.n_q
        metric = sp.diags(np.concatenate([self.stability_test.metric, np.zeros(n - n_q)])).tocsc()
        matrix = self._matrix(data).tocsc()
        shift = SHIFT * self._mean_stiffness(data)
        while unstable > 0:
            shift *= FARTHER
            unstable = self._negative(self.stability_test.dragged(data, shift))[0]
        try:
            lu = spla.splu((matrix + shift * metric).tocsc())
        except RuntimeError:
            return np.nan, None
        x = np.random.default_rng(1).normal(size=n)
        for _ in range(30):
            x = lu.solve(metric @ x)
            x /= np.sqrt(x @ (metric @ x))
        if not np.all(np.isfinite(x)):
            return np.nan, None
        return float(x @ (matrix @ x)), scaled(x[:n_q], self.stability_test.root)
