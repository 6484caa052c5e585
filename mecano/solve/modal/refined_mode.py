r"""Refinement of modes of a large model by Newton's method on the quadratic eigenvalue problem.

With :math:`P(\lambda) = K + \lambda C + \lambda^2 M`, bordered by the constraints, and a vector v with v.y = 1 (Ruhe,
SIAM J. Numer. Anal. 10, 1973, 674-689),

.. math::

    u = P(\lambda)^{-1} P'(\lambda)\, y, \qquad \lambda \leftarrow \lambda - 1/(v \cdot u), \qquad
    y \leftarrow u/(v \cdot u).

ARPACK finds eigenvalues 1/(lambda - shift) to the rounding of the largest one. If a model floats freely, that is the
inverse of the shift, the eigenvalue of its free motions, and modes of higher frequency are left with few digits.
"""

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from mecano.solve.modal.small_motions import SmallMotions

STEPS = 3  # each squares the error
ENOUGH = 1e-9  # residual that is not refined further
NEAR = 1e-2  # relative change of an eigenvalue up to which it is that of the same mode
SLOW = 1e-2  # of the lowest frequency: rate at which free motions are separated from the others
REGULARIZED = 1e-13  # of the stiffness: compliance of constraints, of which some may be redundant


def refined(scaled: SmallMotions, value: complex, y: np.ndarray) -> tuple[complex, np.ndarray]:
    """Return a mode (eigenvalue, shape (n_q,)) with a smaller residual than that of the given one, or the given one."""
    M, C, _ = scaled.full
    n_q, start, x = scaled.n_q, value, np.concatenate([y, np.zeros(M.shape[0] - scaled.n_q)])
    best = scaled.residual(value, y), value, y
    for _ in range(STEPS):
        if best[0] <= ENOUGH:
            break
        if (solved := _solver(scaled, value)) is None:  # singular: the eigenvalue is exact
            break
        u = solved(C @ x + 2.0 * value * (M @ x))
        along = np.vdot(x[:n_q], u[:n_q]) / np.vdot(x[:n_q], x[:n_q])
        value, x = value - 1.0 / along, u / along
        if not abs(value - start) <= NEAR * abs(start):
            break
        best = min(best, (scaled.residual(value, x[:n_q]), value, x[:n_q]), key=lambda found: found[0])
    return best[1:]


def without_strain(scaled: SmallMotions, shapes: np.ndarray, lowest: float) -> np.ndarray:
    """Return the shapes (m, n_q) of free motions without parts that strain the model, below the frequency ``lowest``.

    (K + s^2 M)^-1 s^2 M leaves motions without stiffness as they are, and multiplies others by about (s/omega)^2.
    """
    M, n_q, rate = scaled.full[0], scaled.n_q, SLOW * lowest
    solved = _solver(scaled, rate)
    if solved is None:
        return shapes
    padded = np.concatenate([shapes, np.zeros((len(shapes), M.shape[0] - n_q))], axis=1)
    return np.array([solved(rate**2 * (M @ x) + rate * (scaled.full[1] @ x))[:n_q] for x in padded])


def _solver(scaled: SmallMotions, value: complex) -> Callable[[np.ndarray], np.ndarray] | None:
    """Return the solution function of the bordered K + value C + value^2 M; None if it is singular."""
    M, C, K = scaled.full
    rest = K.shape[0] - scaled.n_q
    k = float(abs(K.diagonal()[: scaled.n_q]).mean()) or 1.0
    border = sp.diags(np.concatenate([np.ones(scaled.n_q), np.full(rest, k)]))
    soft = sp.diags(np.concatenate([np.zeros(scaled.n_q), np.full(rest, REGULARIZED * k)]))
    P = border @ (K + value * C + value**2 * M) @ border - soft
    try:
        factored = spla.splu(P.tocsc().astype(complex))
    except RuntimeError:
        return None
    return lambda b: border @ factored.solve(border @ b.astype(complex))
