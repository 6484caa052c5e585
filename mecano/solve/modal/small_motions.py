"""Matrices of small motions in uniform units, split into motions and constraints; residuals of modes."""

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from mecano.solve.linear.rounding import TINY
from mecano.solve.modal.balance import balance

if TYPE_CHECKING:
    from mecano.solve.modal.linearize import Linearization

SYMMETRIC = 1e-9  # of the largest entry: largest asymmetry of a symmetric stiffness
ROUNDED = 1e-8  # of the largest stiffness: lower bound of the magnitude to which residuals are relative
ROUNDED_REACTION = 1e-12  # of the largest factor of a multiplier in a signal: rounding
SINGULAR = 1e-8  # of the largest singular value of the equations of signals
REGULARIZED, REFINED = 1e-13, 3  # of the largest diagonal entry of D^T D; solutions, each with the rest of the last
FEW = 400  # motions up to which balancing multipliers are found by dense least squares
DENSE_ROWS = 1200  # motions up to which multipliers are found by dense least squares


class SmallMotions:
    """The matrices of a Linearization with rotations times the length scale and signals balanced, split into blocks.

    Each signal has one of the ``units`` (n_q,), and its equation a factor, such that the largest entries of the rows
    and columns of signals are about one. Otherwise a gain of 1e5 would make other equations look negligible. M, C, K
    (n_q, n_q) are the matrices of motions, D (n_q, n_l) the columns of multipliers, B the holonomic constraints, B y =
    0, and E, F the constraints on velocities, (value E + F) y = 0.
    """

    def __init__(self, lin: "Linearization"):
        n_q = self.n_q = lin.n_q
        rows, self.units = _balance(lin)
        rest = np.ones(lin.K.shape[0] - n_q)
        L, R = (sp.diags(np.concatenate([by / lin.root, rest])) for by in (rows, self.units))
        M, C, K = ((L @ A @ R).tocsr() for A in (lin.M, lin.C, lin.K))
        self.full = self._without_reactions((M, C, K), lin.signals)
        self.M, self.C, self.K = (A[:n_q, :n_q] for A in self.full)
        self.D = self.full[2][:n_q, n_q:]
        rows_K, rows_C = -self.full[2][n_q:, :n_q], -self.full[1][n_q:, :n_q]
        self.on_velocity = np.asarray(abs(rows_C).sum(axis=1)).ravel() > 0.0
        self.B, self.E, self.F = rows_K[~self.on_velocity], rows_C[self.on_velocity], rows_K[self.on_velocity]
        self.signals = lin.signals
        self.groups = lin.groups
        self.size = [float(abs(A).max()) if A.nnz else 0.0 for A in (self.M, self.C, self.K)]

    def _without_reactions(self, matrices, signals):
        """Return the matrices with the reactions that signals read replaced by the forces that they balance.

        Combinations of the equations of motion are subtracted from those of the signals, such that the latter contain
        no multiplier.
        """
        if not (read := np.flatnonzero(signals[: self.n_q] & self._read(matrices[2]))).size:
            return matrices
        D, motions = matrices[2][:, self.n_q :], np.flatnonzero(~signals)
        parts = _least_squares(D[motions].T.tocsr(), D[read].T.toarray())
        at = np.repeat(read, len(motions)), np.tile(motions, len(read))
        rows = sp.csr_matrix((parts.T.ravel(), at), matrices[2].shape)
        M, C, K = ((A - rows @ A).tocsr() for A in matrices)
        rest = K.tocoo()  # rounding errors of multipliers would keep a signal that acts on nothing among the unknowns
        rounded = np.isin(rest.row, read) & (rest.col >= self.n_q)
        rounded &= np.abs(rest.data) <= ROUNDED_REACTION * abs(D[read]).max()
        at = rest.row[~rounded], rest.col[~rounded]
        return M, C, sp.csr_matrix((rest.data[~rounded], at), K.shape)

    def _read(self, K):
        """Return (n_q,) bool: equations in which multipliers occur."""
        return np.diff(K[: self.n_q, self.n_q :].tocsr().indptr) > 0

    @property
    def undamped(self) -> bool:
        """True if the problem is symmetric, without first-order terms."""
        M, C, K = self.size
        scale = np.sqrt(M * K)
        asymmetric = abs(self.K - self.K.T).max() if self.K.nnz else 0.0
        if self.on_velocity.any() or C > 1e-14 * scale or asymmetric > SYMMETRIC * K:
            return False
        friction = abs(self.D + self.B.T)  # that follows reactions; else D is -B^T
        return not friction.nnz or friction.max() <= SYMMETRIC * abs(self.B).max()

    def residual(self, value: complex, y: np.ndarray) -> float:
        """Return the residual of an eigenvalue and its shape y (n_q,), relative to the magnitudes of the terms."""
        terms = [value**2 * (self.M @ y), value * (self.C @ y), self.K @ y]
        r = sum(terms)
        size = abs(value) ** 2 * np.linalg.norm(abs(self.M) @ abs(y))
        size += abs(value) * np.linalg.norm(abs(self.C) @ abs(y)) + np.linalg.norm(abs(self.K) @ abs(y))
        if self.D.shape[1]:
            mu = self.balancing_multipliers(r)
            r = r + self.D @ mu
            size += np.linalg.norm(abs(self.D) @ abs(mu))
        least = ROUNDED * self.size[2] * float(np.linalg.norm(y))
        gaps = [_relative(self.B, y), _relative(value * self.E + self.F, y)]
        return float(max([np.linalg.norm(r) / max(float(size), least, TINY), *gaps]))

    def balancing_multipliers(self, r: np.ndarray) -> np.ndarray:
        """Return the multipliers mu that minimize |r + D mu| for r (n_q,)."""
        if self.n_q <= FEW:
            return np.linalg.lstsq(self.D.toarray(), -r, rcond=1e-12)[0]
        return self._balance.solve(-r.real) + 1j * self._balance.solve(-r.imag)

    @cached_property
    def _balance(self):
        return SparseLeastSquares(self.D)


class SparseLeastSquares:
    """Solutions x that minimize |A x - b|, for a sparse real A (m, n) whose columns may depend on one another.

    The normal matrix is regularized and factored once; further solutions remove what the regularization has left.
    """

    def __init__(self, A: sp.sparray | sp.spmatrix):
        self._A, N = A, (A.T @ A).tocsc()
        share = REGULARIZED * (N.diagonal().max() or 1.0)
        self._factors = spla.splu(N + share * sp.identity(N.shape[0], format="csc"))

    def solve(self, b: np.ndarray) -> np.ndarray:
        """Return x (n,) or (n, k) for b (m,) or (m, k), real."""
        x = np.zeros((self._A.shape[1], *b.shape[1:]))
        for _ in range(REFINED):
            x += self._factors.solve(self._A.T @ (b - self._A @ x))
        return x


def _least_squares(A, b):
    """Return the smallest x (n, m) that minimizes |A x - b|; A is sparse, b (rows, m)."""
    if max(A.shape) <= DENSE_ROWS:
        return np.linalg.lstsq(A.toarray(), b, rcond=1e-12)[0]
    return np.array([spla.lsqr(A, column, atol=1e-14, btol=1e-14, iter_lim=2000)[0] for column in b.T]).T


def signals_follow(lin: "Linearization", value: complex) -> bool:
    """Return whether the signals of a mode follow from its motions: ``value`` is no eigenvalue of the signals alone.

    Otherwise its motions follow from the signals, or there are none, as where a filter only measures.
    """
    own = np.flatnonzero(lin.signals)
    if not len(own):
        return False
    rows, units = (factors[own] for factors in _balance(lin))
    M, C, K = (A.tocsr()[own][:, own].toarray() for A in (lin.M, lin.C, lin.K))
    sizes = np.linalg.svd(rows[:, None] * (value * value * M + value * C + K) * units, compute_uv=False)
    return bool(sizes[-1] > SINGULAR * sizes[0])


def _balance(lin):
    """Return factors of equations and units of unknowns (n_q,), one except for signals."""
    rows, columns = np.ones(lin.n_q), np.ones(lin.n_q)
    own = np.flatnonzero(lin.signals)
    if not len(own):
        return rows, columns
    A = sum(abs(part[: lin.n_q, : lin.n_q].tocsr()[own][:, own]).toarray() for part in (lin.C, lin.K))
    rows[own], columns[own] = balance(A)
    return rows, columns


def _relative(A, y):
    if not A.shape[0]:
        return 0.0
    return float(np.linalg.norm(A @ y) / max(spla.norm(A) * np.linalg.norm(y), TINY))
