r"""All modes of a small model, by dense matrices.

Signals without a state are functions of motions and other signals: they are eliminated. Holonomic constraints restrict
motions to y = Z p with an orthonormal basis Z of the null space of B, so no eigenvalue belongs to a constraint,
redundant or not. The equations are projected on these motions, too, or, if friction follows reactions, on the null
space of :math:`D^T`, in which reactions do no work. Constraints on velocities restrict the motions further to
:math:`\dot p = N r + G p`, with N the null space of E Z and :math:`G = -(E Z)^+ F Z`. Motions without inertia and
damping are condensed. A symmetric undamped problem is solved by eigh, any other one in first-order form: by QR if the
rates of motions without inertia follow from their damping, by QZ if that damping is singular.
"""

from functools import partial

import numpy as np
import scipy.linalg as la

from mecano.solve.modal.balance import balance
from mecano.solve.modal.small_motions import SmallMotions
from mecano.solve.statics.stability import null_space

MASSLESS = 1e-13  # of the largest inertia: a smaller one counts as zero
ZERO, SINGULAR = 1e-12, 1e-9  # of the largest singular value: zero to rounding; zero in the test of a singular matrix
EXACT_ZERO = 2e-14  # of the largest singular value: tighter bound of rounding, as stiff and soft motions occur together
ROOM, GAP = 10.0, 1e-6  # factor on these bounds if no singular value lies between and this share of the largest
ROUNDED_MASS = 1e-12  # of the largest inertia: asymmetry that is rounding error
ROUNDED = 1e-15  # of the largest entry of its row: a smaller entry is rounding error
COUPLED = 3e-14  # of the same: smaller entries do not scale unknowns, else undetermined angles would amplify rounding
SLOW = 1e-8  # of the largest squared frequency: smaller ones lose half of their digits
ROUNDED_REACTION = 1e-9  # of the largest entry of B: work of reactions that is rounding error
INFINITE = 3e-7  # smaller denominators of the generalized eigenvalues count as zero


def dense(scaled: SmallMotions) -> tuple[np.ndarray, np.ndarray, str]:
    """Return all eigenvalues and shapes: (values (m,), shapes (m, n_q), name of the method)."""
    kept, (M, C, K), follow = _without_signals(scaled)
    B, E, F, D = (A.toarray() for A in (scaled.B[:, kept], scaled.E[:, kept], scaled.F[:, kept], scaled.D[kept]))
    states = scaled.signals[kept] & ~np.vstack([B, E, F, D.T]).any(axis=0)
    if states.any():
        rows, units = _comparable(states, M, C, K)
        M, C, K, follow = *(rows[:, None] * A * units for A in (M, C, K)), partial(_in_units, follow, units)
    Z = null_space(B)
    if not Z.shape[1]:
        return np.zeros(0, complex), np.zeros((0, scaled.n_q), complex), "dense: nothing moves"
    L = _workless(D[:, ~scaled.on_velocity], B, Z)
    M, C, K = (L.T @ A @ Z for A in (M, C, K))
    if scaled.on_velocity.any():
        values, p = _on_velocities(E @ Z, F @ Z, L.T @ D[:, scaled.on_velocity], M, C, K)
        return values, follow(values, p @ Z.T), "dense, first order, with constraints on velocities"
    asymmetric = np.abs(M - M.T).max(initial=0.0) > ROUNDED_MASS * np.abs(M).max(initial=0.0)
    if L is not Z or asymmetric:  # signals or friction that read reactions
        values, p = _general(M, C, K)
        return values, follow(values, p @ Z.T), "dense, first order"
    M, C, K, back = _condensed(M, C, K)
    if not len(M):
        return np.zeros(0, complex), np.zeros((0, scaled.n_q), complex), "dense: nothing has inertia or damping"
    if scaled.undamped and kept.all():
        squares, vectors = _undamped(0.5 * (M + M.T), 0.5 * (K + K.T))
        values = np.where(squares < 0.0, np.sqrt(np.abs(squares)), 1j * np.sqrt(np.abs(squares)))
        both = np.concatenate([values, -values[squares < 0.0]])
        return both, (np.concatenate([vectors.T, vectors.T[squares < 0.0]]) @ back.T) @ Z.T, "dense, undamped"
    values, p = _first_order(M, C, K)
    return values, follow(values, (p @ back.T) @ Z.T), "dense, first order"


def _workless(D, B, Z):
    """Return the combinations (n, m) of equations that contain no multiplier: Z where reactions are along B^T.

    Friction adds to the columns of the multipliers that it follows. Redundant constraints share their reactions
    equally: these are combinations of the columns of B.
    """
    if np.abs(D.T @ Z).max(initial=0.0) <= ROUNDED_REACTION * np.abs(B).max(initial=0.0):
        return Z
    reactions = np.linalg.svd(B, full_matrices=False)[0][:, : Z.shape[0] - Z.shape[1]]
    L = null_space((D @ reactions).T)
    return L if L.shape == Z.shape else Z


def _without_signals(scaled):
    r"""Return (kept (n_q,) bool, their [M, C, K], function (values, shapes (m, kept)) -> shapes (m, n_q)).

    Signals are eliminated: :math:`s = -K_{ss}^{-1} (K_{sy} + \lambda C_{sy} + \lambda^2 M_{sy})\, y`, also those whose
    rates act, as those of set points do on dampers, unless that leads to higher powers of :math:`\lambda`.
    """
    M, C, K = (A.toarray() for A in (scaled.M, scaled.C, scaled.K))
    functions = scaled.signals & ~M.any(axis=0) & (np.diff(scaled.D.tocsr().indptr) == 0)
    acting = C.any(axis=0)
    for at_once in (functions & ~(acting & C[functions].any(axis=0)), functions & ~acting):
        rows, units = balance(abs(K[np.ix_(at_once, at_once)]))
        own = rows[:, None] * K[np.ix_(at_once, at_once)] * units
        if _is_singular(own):
            continue
        kept = ~at_once
        by = [units[:, None] * np.linalg.solve(own, rows[:, None] * A[np.ix_(at_once, kept)]) for A in (M, C, K)]
        by_value, by_rate = (A[np.ix_(kept, at_once)] for A in (K, C))
        if (by_rate @ by[0]).any():
            continue
        reduced = [A[np.ix_(kept, kept)] - by_value @ part for A, part in zip((M, C, K), by, strict=True)]
        reduced[0] -= by_rate @ by[1]
        reduced[1] -= by_rate @ by[2]
        return kept, reduced, partial(_with_signals, kept, by)
    return np.ones(len(M), bool), (M, C, K), lambda values, shapes: shapes


def _is_singular(A):
    """Return whether A (n, n) is singular, up to rounding, in whatever units of its equations and unknowns.

    The least condition number of all scaled matrices is the spectral radius of abs(A^-1) abs(A) (Bauer, Numerische
    Mathematik 5, 1963, 73-87).
    """
    if not len(A):
        return False
    try:
        inverse = np.linalg.inv(A)
    except np.linalg.LinAlgError:
        return True
    return not np.abs(la.eigvals(np.abs(inverse) @ np.abs(A))).max() < 1.0 / SINGULAR


def _with_signals(kept, by, values, shapes):
    """Return the shapes (m, n_q) with eliminated signals that follow from those of the ``kept`` unknowns."""
    whole = np.zeros((len(shapes), len(kept)), complex)
    powers = (values[:, None] ** 2, values[:, None], 1.0)
    whole[:, kept] = shapes
    whole[:, ~kept] = -sum(power * (shapes @ part.T) for power, part in zip(powers, by, strict=True))
    return whole


def unstrained(scaled: SmallMotions) -> np.ndarray:
    """Return independent shapes (m, n_q) without forces of stiffness, up to rounding, but with inertia or damping.

    They are as many as the motions without stiffness. ``dense`` may find fewer: where stiff forces cancel, rounding
    links these motions in what looks like a single Jordan chain of the eigenvalue zero, which has one eigenvector.
    """
    kept, (M, C, K), follow = _without_signals(scaled)
    B, F, D = (A.toarray() for A in (scaled.B[:, kept], scaled.F[:, kept], scaled.D[kept]))
    Z = null_space(B)
    L = _workless(D[:, ~scaled.on_velocity], B, Z)
    held = np.where(np.abs(F @ Z) <= ZERO * np.abs(F).max(initial=0.0), 0.0, F @ Z)
    L, Z = L @ null_space(D[:, scaled.on_velocity].T @ L), Z @ null_space(held)
    _, sigma, Vt = np.linalg.svd(L.T @ K @ Z)
    still = Z @ Vt[int(np.sum(sigma > ZERO * np.abs(K).max(initial=0.0))) :].T
    moving = np.vstack([A @ still / (np.abs(A).max(initial=0.0) or 1.0) for A in (M, C)])
    _, sigma, Vt = np.linalg.svd(moving)
    count = int(np.sum(sigma > ZERO))
    return follow(np.zeros(count), (still @ Vt[:count].T).T).real


def _comparable(states, M, C, K):
    """Return factors of equations and units of unknowns (n,), one except for ``states`` of signals.

    They make these comparable to motions: the pressure in a small chamber grows by 1e14 Pa per metre of its piston.
    """
    factors = balance(np.abs(M) + np.abs(C) + np.abs(K))
    return tuple(
        np.where(states, factor / np.exp(np.log(factor[~states]).mean()) if (~states).any() else factor, 1.0)
        for factor in factors
    )


def _in_units(follow, units, values, shapes):
    """Return what ``follow`` gives for ``shapes`` (m, n) in other ``units`` (n,)."""
    return follow(values, shapes * units)


def _condensed(M, C, K):
    """Return (M, C, K without motions that have neither inertia nor damping, matrix that recovers all motions)."""
    w, U = la.eigh(0.5 * (M + M.T))
    U2 = U[:, w <= MASSLESS * w[-1]]
    drag = np.vstack([C @ U2, C.T @ U2])
    least = ZERO * max(np.sqrt(np.abs(M).max() * np.abs(K).max()), np.abs(C).max())
    _, sigma, Vt = np.linalg.svd(drag)
    U2 = U2 @ Vt[int(np.sum(sigma > least)) :].T
    if not U2.shape[1]:
        return M, C, K, np.eye(len(M))
    U1 = null_space(U2.T)
    follow = -np.linalg.lstsq(U2.T @ K @ U2, U2.T @ K @ U1, rcond=1e-13)[0]
    back = U1 + U2 @ follow
    lead = U1.T - (np.linalg.lstsq((U2.T @ K @ U2).T, (U1.T @ K @ U2).T, rcond=1e-13)[0]).T @ U2.T
    return U1.T @ M @ U1, U1.T @ C @ U1, lead @ K @ back, back


def _undamped(M, K):
    """Return the squares (m,) of the circular frequencies, ascending, and the shapes (n, m) of K y = square M y.

    Rounding perturbs all squares in proportion to the largest one, which may exceed the square of a slow motion of
    members much lighter than their loads. The slow ones are recomputed from M y = (K + shift M) y/(square + shift),
    where that matrix is positive definite: there they are the largest, and perturbed in proportion to the shift only.
    """
    squares, vectors = la.eigh(K, M)
    shift = squares[-1]
    for _ in range(2):
        shift *= SLOW
        slow = int(np.sum(squares < shift))
        if not slow:
            break
        try:
            inverse, found = la.eigh(M, K + shift * M, subset_by_index=[len(M) - slow, len(M) - 1])
        except la.LinAlgError:
            break
        squares[:slow] = (1.0 / inverse - shift)[::-1]
        vectors[:, :slow] = (found / np.sqrt(inverse))[:, ::-1]
    return squares, vectors


def _first_order(M, C, K):
    """Return the eigenvalues (m,) and the position parts (m, r) of the eigenvectors of M y'' + C y' + K y = 0."""
    r = len(M)
    rate = _pace(M, C, K)
    M, C, K = M * rate**2, C * rate, K
    w, U = la.eigh(0.5 * (M + M.T))
    U1, U2 = U[:, w > MASSLESS * w[-1]], U[:, w <= MASSLESS * w[-1]]
    drag = U2.T @ C @ U2
    sigma = np.linalg.svd(drag, compute_uv=False)
    if len(sigma) and sigma[-1] <= SINGULAR * sigma[0]:
        values, vectors = _of_blocks(M, C, K)
        return values * rate, vectors
    rates = np.hstack([np.zeros((r, r)), U1])  # p' from (p, v); without inertia, rates follow from the damping
    rates -= U2 @ np.linalg.solve(drag, U2.T @ np.hstack([K, C @ U1]))
    forces = np.hstack([K, np.zeros_like(U1)]) + C @ rates
    A = np.vstack([rates, -np.linalg.solve(U1.T @ M @ U1, U1.T @ forces)])
    A[_below(ROUNDED, A)] = 0.0
    T = la.matrix_balance(np.where(_below(COUPLED, A), 0.0, A), permute=False)[1]  # signals have any unit
    A = A * np.diag(T) / np.diag(T)[:, None]
    values, vectors = _without_zeros(A, np.eye(len(A)), EXACT_ZERO * np.linalg.norm(A, 2), _all)
    return values * rate, (T @ vectors)[:r].T


def _below(share, A):
    """Return where entries of A (n, n) are at most this share of the largest one of their row."""
    return np.abs(A) <= share * np.abs(A).max(axis=1, keepdims=True)


def _pace(M, C, K):
    """Return a rate [1/s] that makes positions and velocities comparable, also without inertia (filters alone)."""
    m, c, k = (np.abs(A).max() for A in (M, C, K))
    return (np.sqrt(k / m) if m else k / c if c else 0.0) or 1.0


def _general(M, C, K):
    """Return eigenvalues and vectors as ``_first_order`` does, for any M."""
    rate, eye = _pace(M, C, K), np.eye(len(M))
    size = max(np.abs(A).max() for A in (M * rate**2, C * rate, K)) or 1.0
    M, C, K = M * (rate**2 / size), C * (rate / size), K / size
    A = np.block([[0.0 * eye, eye], [-K, -C]])
    values, vectors = _without_zeros(A, la.block_diag(eye, M), ZERO * np.linalg.norm(A, 2), _finite)
    return values * rate, vectors[: len(M)].T


def _of_blocks(M, C, K):
    """Return finite eigenvalues (m,) and position parts (m, r) of the eigenvectors of M y'' + C y' + K y = 0 by QZ."""
    eye, zero = np.eye(len(M)), np.zeros_like(M)
    values, vectors = _finite(np.block([[zero, eye], [-K, -C]]), la.block_diag(eye, M))
    return values, vectors[: len(M)].T


def _all(A, E):
    """Return eigenvalues and eigenvectors of A x = value E x by QR; E must be regular and well conditioned."""
    return la.eig(np.linalg.solve(E, A))


def _finite(A, E):
    """Return the finite eigenvalues and their eigenvectors of A x = value E x by QZ."""
    (alpha, beta), vectors = la.eig(A, E, homogeneous_eigvals=True)
    size = np.hypot(np.abs(alpha), np.abs(beta))
    finite = np.abs(beta) > INFINITE * size
    return alpha[finite] / beta[finite], vectors[:, finite]


def _on_velocities(E, F, D, M, C, K):
    """Return eigenvalues (m,) and p (m, r) under (value E + F) p = 0, whose multipliers act along D (r, n)."""
    N, G = null_space(E), -np.linalg.pinv(E, rcond=1e-12) @ F
    L = null_space(D.T).T
    M, C, K = L @ M, L @ (C + M @ G), L @ (M @ G @ G + C @ G + K)
    mass = np.abs(M).max(initial=0.0) or 1.0
    own = np.sqrt(np.abs(K).max(initial=0.0) / mass)
    rate = max(own, np.abs(G).max(initial=0.0)) or 1.0  # makes the rows, and p and r, comparable
    A = np.block([[G / rate, N], [-K / (mass * rate**2), -C @ N / (mass * rate)]])
    E = la.block_diag(np.eye(len(G)), M @ N / mass)
    values, vectors = _without_zeros(A, E, ZERO * np.linalg.norm(A, 2), _finite)
    return values * rate, vectors[: len(G)].T


def _rank(sigma, least):
    """Return the number of singular values (n,), in descending order, that are not zero."""
    certain = int(np.sum(sigma > ROOM * least))
    apart = certain > 0 and sigma[certain - 1] > GAP * sigma[0]
    return certain if apart else int(np.sum(sigma > least))


def _without_zeros(A, E, least, solve, chains=False):
    """Return finite eigenvalues and eigenvectors of A x = value E x; zero eigenvalues are deflated first, exactly.

    Undetermined positions and headings form Jordan chains of the eigenvalue zero (a change of heading makes the
    position drift): vectors for which A x is E times another vector of the chain. Without deflation they perturb all
    small eigenvalues by the square root of rounding. Eigenvectors of zero are returned, generalized ones are not; with
    ``chains`` neither is. Singular values up to ``least``, or slightly larger ones below a gap, are zero.
    ``solve(A, E)`` finds the remaining eigenvalues.
    """
    _, sigma, Vt = np.linalg.svd(A)
    rank = _rank(sigma, least)
    X1, X2 = Vt[rank:].T, Vt[:rank].T
    Q, R = np.linalg.qr(E @ X1, mode="complete")
    count = X1.shape[1]
    if not count or np.abs(np.diag(R)).min() <= SINGULAR * np.abs(R).max():
        return solve(A, E)
    Q1, Q2, E1 = Q[:, :count], Q[:, count:], R[:count]
    values, y = np.zeros(0), np.zeros((0, 0))
    if rank:
        values, y = _without_zeros(Q2.T @ A @ X2, Q2.T @ E @ X2, least, solve, chains=True)
    x = X1 @ np.linalg.solve(E1, (Q1.T @ A @ X2) @ y / values - (Q1.T @ E @ X2) @ y) + X2 @ y
    if chains:
        return values, x
    return np.concatenate([np.zeros(count), values]), np.hstack([X1, x])
