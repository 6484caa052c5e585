r"""Equations of small motions about a state, at rest or moving, with their constraints.

The elements give the derivatives K, C, M of the residual with respect to displacements and material rotations,
velocities and accelerations (element_interface). Small motions are measured in a frame that rotates with a constant
angular velocity w (zero: inertial axes): displacements :math:`\delta x = Q \xi`, rotations
:math:`\delta R = \widehat{Q \varphi}\, R`, with
:math:`\dot Q = \hat w Q` and Q = 1 now. With the angular velocity :math:`\omega = R \Omega` of a node,

.. math::
   \delta\Theta = R^T \varphi, \quad
   \delta\Omega = R^T (\dot\varphi + \hat w \varphi), \quad
   \delta\alpha = R^T (\ddot\varphi + (2 \hat w - \hat\omega) \dot\varphi + (\hat w - \hat\omega) \hat w \varphi), \\
   \delta v = \dot\xi + \hat w \xi, \quad
   \delta a = \ddot\xi + 2 \hat w \dot\xi + \hat w^2 \xi,

so that, with P = diag(1, R^T) and the three block-diagonal matrices G of these formulas,

.. math::  M' = P^T M P, \quad C' = P^T (C P + M P G_2), \quad K' = P^T (K P + C P G_1 + M P G_3)

are the exact matrices of :math:`M' \ddot y + C' \dot y + K' y = 0`. They are constant if the state is an equilibrium
relative to the frame: a top that only spins, a wheel that rolls straight (w = 0), a rotor in its own axes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from mecano.maths.so3 import exp
from mecano.maths.vector import Vec3, skew
from mecano.model.assembly import Assembly
from mecano.model.numbering import ROTATION
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.diagnostics.scales import NO_STIFFNESS
from mecano.solve.events.compliance import Compliance
from mecano.solve.modal.small_motions import DENSE_ROWS, SparseLeastSquares
from mecano.solve.time.increments import displaced, moved

MOST_NUMBERS = 2e7  # of a dense matrix of constraints: 160 MB
PROBE = 1e-6  # [rad] motion over which the change of the matrices is measured
RESTING = 1e-12  # [m/s], [rad/s] velocities up to this are rounding errors, as of a drive at its turning point


class Assemble(Protocol):
    """Assembles a model as ``System.assemble`` does, or under other loads."""

    def __call__(self, s: State, *, cK: float = 0.0, cC: float = 0.0, cM: float = 0.0) -> Assembly:
        """Return residual and tangent cK K + cC C + cM M at the state ``s``."""


@dataclass(frozen=True)
class Linearization:
    """Sparse M, C, K (n, n) of small motions: n_q motions, then multipliers.

    K is bordered by -B and -B^T; the rows of constraints on velocities are in C.
    """

    M: sp.csr_matrix
    C: sp.csr_matrix
    K: sp.csr_matrix
    n_q: int
    groups: np.ndarray  # (n_q,) group number: motions of one node share it
    root: np.ndarray  # (n_q,) 1 for displacements, the length scale [m] for rotations: makes motions comparable
    signals: np.ndarray  # (n_q,) bool: scalars that are signals, whose equations have any unit
    variation: float = 0.0  # relative change of the matrices over one radian of rotation; zero for an equilibrium
    pace: float = 0.0  # [1/s] rate of change of the matrices: smaller eigenvalues have no meaning


def linearize(
    system: System,
    s: State,
    length: float,
    frame: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
    assemble: Assemble | None = None,
    compliance: Compliance | None = None,
) -> Linearization:
    """Return the Linearization of ``system`` at ``s`` with its velocities, accelerations and multipliers.

    ``frame`` (3,) [rad/s]: angular velocity of the axes, inertial; ``assemble`` replaces that of the system
    (loading.py); ``compliance``: compliance of redundant constraints.
    """
    assemble = assemble or system.assemble
    w = np.asarray(frame, float)
    base = displaced(s, np.zeros(system.n_q), system.numbering)
    matrices = _matrices(system, base, w, np.eye(3), assemble)
    rate = _fastest(system, base, w)
    variation = _variation(system, base, w, rate, assemble, matrices)
    M, C, K = matrices
    root = np.where(system.numbering.kind[: system.n_q] == ROTATION, length, 1.0)
    if _is_rounding(system, base, w, assemble, K, root):
        K = _border(K, system.n_q)
    if compliance is not None:
        c = compliance.matrix
        at = c.rows + system.n_q, c.columns + system.n_q
        K = (K - sp.csr_matrix((c.values, at), shape=K.shape)).tocsr()
    return Linearization(M, C, K, system.n_q, system.numbering.group, root, system.signals, variation, variation * rate)


def _is_rounding(system, s, w, assemble, K, root):
    """Return whether the stiffness of motions in ``K`` is all that of rounded reactions and accelerations.

    Reactions of a mechanism without forces are rounding errors, and so is their geometric stiffness.
    """
    own = K[: system.n_q, : system.n_q].tocoo()
    sizes = np.abs(own.data) / (root[own.row] * root[own.col])
    if not 0.0 < sizes.max(initial=0.0) <= NO_STIFFNESS:
        return False
    bare = displaced(s, np.zeros(system.n_q), system.numbering)
    bare.z[system.n_q : system.n], bare.a[:] = 0.0, 0.0
    return not np.any(_matrices(system, bare, w, np.eye(3), assemble)[2][: system.n_q, : system.n_q].data)


def _border(K, n_q):
    """Return K (n, n) without the stiffness of motions."""
    K = K.tocoo()
    kept = (K.row >= n_q) | (K.col >= n_q)
    return sp.csr_matrix((K.data[kept], (K.row[kept], K.col[kept])), K.shape)


def by_motions(system: System, s: State, w: np.ndarray) -> tuple[sp.csr_matrix, ...]:
    """Return the derivatives of the material unknowns by the motions y, y', y'' in axes that turn with ``w`` (3,).

    They are sparse (n, n), by rows of unknowns: displacements and material rotations by y, velocities by y,
    accelerations by y, accelerations by y'. All others equal the first.
    """
    P, G1, G2, G3 = _blocks(system, s, np.asarray(w, float), np.eye(3))
    return P, P @ G1, P @ G3, P @ G2


def _matrices(system, s, w, Q, assemble):
    """Return M', C', K' in the axes Q, which rotate with w."""
    parts = []
    for weights in ({"cM": 1.0}, {"cC": 1.0}, {"cK": 1.0}):
        values = assemble(s, **weights).data[: system.nnz]
        parts.append(sp.csr_matrix((values, (system.rows, system.cols)), shape=(system.n, system.n)))
    M, C, K = parts
    P, G1, G2, G3 = _blocks(system, s, w, Q)
    left = P.T.tocsr()
    M, C, K = left @ M @ P, left @ (C @ P + M @ P @ G2), left @ (K @ P + C @ P @ G1 + M @ P @ G3)
    return M.tocsr(), C.tocsr(), K.tocsr()


def _blocks(system, s, w, Q):
    """Return P, G1, G2, G3 (n, n): for scalars and multipliers, identity in P and zeros in the others."""
    of, n = system.numbering, system.n
    w_hat = np.array(skew(Q.T @ w))
    places, blocks = [], []
    for first in np.unique(of.x[of.x < of.n_q]):
        places.append(first)
        blocks.append((Q, w_hat, 2.0 * w_hat, w_hat @ w_hat))
    for r, first in enumerate(of.rotation_dof):
        if first < of.n_q:
            omega = np.array(skew(Q.T @ s.R[r] @ s.v[first : first + 3]))
            places.append(first)
            blocks.append((s.R[r].T @ Q, w_hat, 2.0 * w_hat - omega, (w_hat - omega) @ w_hat))
    rest = np.setdiff1d(np.arange(n), (np.array(places, int)[:, None] + np.arange(3)).ravel())
    return [_diagonal(n, places, [b[i] for b in blocks], rest, 1.0 if i == 0 else 0.0) for i in range(4)]


def _diagonal(n, places, blocks, rest, value):
    """Return the block-diagonal matrix (n, n) with 3x3 blocks at ``places`` and ``value`` at ``rest``."""
    first = np.array(places, int)[:, None, None]
    shape = (len(places), 3, 3)
    rows = np.broadcast_to(first + np.arange(3)[:, None], shape).ravel()
    cols = np.broadcast_to(first + np.arange(3), shape).ravel()
    data = np.array(blocks, float).reshape(-1)
    rows, cols = np.concatenate([rows, rest]), np.concatenate([cols, rest])
    return sp.csr_matrix((np.concatenate([data, np.full(len(rest), value)]), (rows, cols)), shape=(n, n))


def _fastest(system, s, w):
    """Return the largest angular velocity [rad/s] of the bodies and the axes."""
    return max([np.linalg.norm(w), *(np.linalg.norm(s.v[d : d + 3]) for d in system.numbering.rotation_dof)])


def _variation(system, s, w, rate, assemble, now):
    """Return the largest relative change of the matrices in the time of one radian at angular velocity ``rate``.

    It is measured between PROBE and twice PROBE, because at rest a jump of the tangent, such as that between
    compression and rebound of an oleo, depends on the sign of a rate that is rounding error.
    """
    if rate <= RESTING:
        return 0.0
    counts, n_q = _acting(system, now), system.n_q
    now, near, far = (
        [A[counts][:, counts] for A in matrices]
        for matrices in (now, *(_matrices_after(system, s, w, i * PROBE / rate, assemble) for i in (1, 2)))
    )
    changes, sizes = _changes(near, far, int(counts[:n_q].sum())), [sp.linalg.norm(A) for A in now]
    return float(max((x / size for x, size in zip(changes, sizes, strict=True) if size > 0.0), default=0.0)) / PROBE


def _acting(system, matrices):
    """Return (n,) bool: unknowns except signals that only measure, such as an inertial component in turning axes."""
    counts = np.ones(system.n, bool)
    read = sum(abs(A) for A in matrices).tocsr()
    read -= sp.diags(read.diagonal())
    signals = np.flatnonzero(system.signals)
    while len(signals):
        unread = signals[np.asarray(read[counts][:, signals].sum(axis=0)).ravel() == 0.0]
        if not len(unread):
            break
        counts[unread] = False
        signals = np.setdiff1d(signals, unread)
    return counts


def _changes(near, far, n_q):
    """Return the norms of the changes of M, C and K from ``near`` to ``far``, the border of constraints included.

    Two transverse axes that turn with a shaft constrain the same motions at any angle. Therefore only the part of the
    constraint rows, and of the multiplier columns, outside the span of the earlier ones counts.
    """
    M, C, K = (B - A for A, B in zip(near, far, strict=True))
    held = _outside(sp.hstack([near[1][n_q:, :n_q], near[2][n_q:, :n_q]]), sp.hstack([C[n_q:, :n_q], K[n_q:, :n_q]]))
    reactions = _outside(near[2][:n_q, n_q:].T, K[:n_q, n_q:].T)
    parts = (M,), (C[:n_q, :n_q], held[:n_q]), (K[:n_q, :n_q], held[n_q:], reactions)
    return [np.sqrt(sum((A.multiply(A) if sp.issparse(A) else A * A).sum() for A in part)) for part in parts]


def _outside(rows, change):
    """Return the part of ``change`` (columns) outside the span of ``rows``; all of it if they have too many numbers."""
    if not rows.shape[0] or rows.shape[0] * rows.shape[1] > MOST_NUMBERS:
        return change.T.tocsr()
    if rows.shape[1] <= DENSE_ROWS:
        A, change = rows.T.toarray(), change.T.toarray()
        return change - A @ np.linalg.lstsq(A, change, rcond=1e-9)[0]
    A, change = rows.T.tocsr(), change.T.toarray()
    return change - A @ SparseLeastSquares(A).solve(change)


def _matrices_after(system, s, w, dt, assemble):
    """Return M', C', K' after the motion of ``s`` for dt [s], in axes that have turned with it."""
    of, later, Q = system.numbering, moved(s, dt, system.numbering), np.array(exp(Vec3(*(w * dt))))
    for first in np.unique(of.x):
        later.a[first : first + 3] = Q @ s.a[first : first + 3]
    for r, first in enumerate(of.rotation_dof):
        later.a[first : first + 3] = later.R[r].T @ Q @ s.R[r] @ s.a[first : first + 3]
    later = displaced(later, np.zeros(system.n_q), of)
    _react(system, later, assemble)
    return _matrices(system, later, w, Q, assemble)


def _react(system, s, assemble):
    """Set the reactions of ``s`` in place to those that balance its motion: some have inertial components."""
    n_q, n = system.n_q, system.n
    if not system.n_l:
        return
    assembly, motions = assemble(s, cK=1.0), ~system.signals
    D = sp.csr_matrix((assembly.data[: system.nnz], (system.rows, system.cols)), shape=(n, n))[:n_q, n_q:][motions]
    r = assembly.residual[:n_q][motions]
    dense = n_q <= DENSE_ROWS
    s.z[n_q:n] -= np.linalg.lstsq(D.toarray(), r, rcond=1e-12)[0] if dense else SparseLeastSquares(D).solve(r)
