r"""Some modes of a large model: the eigenvalues nearest to a real shift, by ARPACK.

The bordered matrix :math:`K + \sigma C + \sigma^2 M` is factored once (solve/linear/sparse.py); the shift is zero if K
is regular. A symmetric undamped problem is solved by Lanczos' method, any other one by Arnoldi's on

.. math::  (y, u) \to (y', y + \sigma y'), \qquad y' = -(K + \sigma C + \sigma^2 M)^{-1} (M u + C y + \sigma M y),

whose eigenvalues are :math:`1/(\lambda - \sigma)`.
"""

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from mecano.errors import ConvergenceError
from mecano.solve.linear.sparse import LinearSolver
from mecano.solve.linear.symbolic_analysis import Pattern
from mecano.solve.modal.modes_dense import dense
from mecano.solve.modal.small_motions import SmallMotions

CANCELLED = 1e-12  # relative pivot below which a larger shift is tried
FEW_MOVE = 3000  # unknowns up to which a mechanism with few motions is solved by dense matrices
EXTRA = 6  # eigenvalues requested from ARPACK beyond those wanted
SHIFTS = (-6, -5, -4, -3, -2)  # decimal exponents of the shifts tried, relative to the mean frequency
SINGULAR = 1e-12  # of the mean frequency: a smaller eigenvalue indicates a singular stiffness
RESTARTS = 40  # of Arnoldi's method: separate eigenvalues need one or two; those that damping makes accumulate, more
INFINITE = 1e-13  # smaller inverses of eigenvalues count as zero


def sparse(scaled: SmallMotions, number: int, *, far: bool = False) -> tuple[np.ndarray, np.ndarray, str]:
    """Return the eigenvalues nearest to a small shift: (values (m,), shapes (m, n_q), name of the method).

    ``far``: only the larger shifts, about which rounding of the double zeros of free motions perturbs others less.
    """
    mobility = scaled.n_q - scaled.B.shape[0]  # lower bound
    if mobility <= 2 * (number + EXTRA) and scaled.n_q <= FEW_MOVE:
        return dense(scaled)
    if not scaled.M.count_nonzero() and not scaled.C.count_nonzero():
        return np.zeros(0, complex), np.zeros((0, scaled.n_q), complex), "sparse: nothing has inertia or damping"
    wanted = max(min(number + EXTRA, mobility - 2), 1)
    M, _, K = scaled.full
    rate = np.sqrt(abs(K.diagonal()[: scaled.n_q]).mean() / abs(M.diagonal()[: scaled.n_q]).mean())
    try:
        for inverse, shift in _shifted(scaled, rate, SHIFTS[2:] if far else (None, *SHIFTS)):
            of = (scaled, inverse, shift)
            found = _lanczos(*of, wanted) if scaled.undamped else _arnoldi(*of, 2 * wanted)
            if shift or np.abs(found[0]).min(initial=np.inf) > SINGULAR * rate:
                return found
    except spla.ArpackError as error:
        raise ConvergenceError(f"the modes were not found: {error}") from error
    raise ConvergenceError("the modes were not found: the bordered stiffness is singular at any shift")


def _shifted(scaled, rate, powers):
    """Yield the solution functions of the bordered K + s C + s^2 M, and those of the shifts s at which it is regular.

    ``rate`` [1/s] is the mean frequency; the shifts are rate 10^power, for the power None zero. If K is singular to
    rounding, the eigenvalue closest to zero hides all others.
    """
    M, C, K = scaled.full
    k = float(abs(K.diagonal()[: scaled.n_q]).mean()) or 1.0
    n_q = scaled.n_q
    border = sp.diags(np.concatenate([np.ones(n_q), np.full(K.shape[0] - n_q, k)]))
    for shift in (0.0 if power is None else rate * 10.0**power for power in powers):
        matrix = sp.coo_matrix(border @ (K + shift * C + shift**2 * M) @ border + _penalty(scaled, k))
        solver = LinearSolver(Pattern(K.shape[0], matrix.row, matrix.col, scaled.groups))
        x, b = np.zeros(K.shape[0]), np.random.default_rng(2).normal(size=K.shape[0])
        status = solver.solve(np.ascontiguousarray(matrix.data), b, x)
        if status.ok and not status.null_pivots and solver.cancellation().min() > CANCELLED:
            yield (lambda b, solver=solver: _resolved(solver, border, b)), shift


def _penalty(scaled, k):
    """Return k B^T B, which does not affect motions that the constraints allow, padded with zeros to full size."""
    n = scaled.full[2].shape[0]
    top = k * (scaled.B.T @ scaled.B)
    corner = sp.csr_matrix((n - scaled.n_q,) * 2)
    return sp.block_diag([top, corner]) if n > scaled.n_q else top


def _resolved(solver, border, b):
    x = np.empty(len(b))
    solver.solve_again(np.ascontiguousarray(border @ b), x)
    return border @ x


def _lanczos(scaled, inverse, shift, wanted):
    n, n_q = scaled.full[2].shape[0], scaled.n_q
    pad = np.zeros(n - n_q)

    def apply(b):
        return inverse(np.concatenate([b, pad]))[:n_q]

    start = apply(scaled.M @ np.random.default_rng(3).normal(size=n_q))
    operator = spla.LinearOperator((n_q, n_q), matvec=apply, dtype=float)
    squares, vectors = spla.eigsh(
        scaled.K, wanted, M=scaled.M, sigma=-(shift**2), OPinv=operator, v0=start, ncv=min(n_q, 3 * wanted + 20)
    )
    K, M = (vectors.T @ (A @ vectors) for A in (scaled.K, scaled.M))  # separates vectors that Lanczos mixed
    squares, mixed = la.eigh(0.5 * (K + K.T), 0.5 * (M + M.T))
    vectors = vectors @ mixed
    values = np.where(squares < 0.0, np.sqrt(np.abs(squares)), 1j * np.sqrt(np.abs(squares)))
    return values, vectors.T.astype(complex), f"sparse (Lanczos), undamped, about -({shift:.3g}/s)^2"


def _arnoldi(scaled, inverse, shift, wanted):
    M, C, _ = scaled.full
    n, n_q = M.shape[0], scaled.n_q

    def apply(x):
        y, u = x[:n], x[n:]
        moved = -inverse(M @ u + C @ y + shift * (M @ y))
        return np.concatenate([moved, y + shift * moved])

    start = apply(apply(np.random.default_rng(3).normal(size=2 * n)))
    operator = spla.LinearOperator((2 * n, 2 * n), matvec=apply, dtype=float)
    wanted = min(wanted, 2 * n - 2)
    method = f"sparse (Arnoldi), about {shift:.3g}/s"
    try:
        inverses, vectors = spla.eigs(operator, wanted, v0=start, ncv=min(2 * n, 3 * wanted + 20), maxiter=RESTARTS)
    except spla.ArpackNoConvergence as error:
        inverses, vectors = error.eigenvalues, error.eigenvectors
        if not len(inverses):
            raise
        method += f", {len(inverses)} of {wanted} eigenvalues: damping makes the others accumulate"
    finite = np.abs(inverses) > INFINITE * np.abs(inverses).max()
    values = shift + 1.0 / inverses[finite]
    return values, vectors[:n_q, finite].T, method
