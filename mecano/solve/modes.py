r"""Modes of small motions under constraints: complex eigenvalues and shapes of

.. math::  (\lambda^2 M + \lambda C + K)\, y + D \mu = 0, \qquad B y = 0, \qquad (\lambda E + F)\, y = 0.

*Dense*: the motions that holonomic constraints allow, y = Z p with an orthonormal basis Z of the null space of B, so no
eigenvalue comes from a constraint, redundant or not. Constraints on velocities leave :math:`\dot p = N r + G p`, with N
the null space of E Z and :math:`G = -(E Z)^+ F Z`. Motions without inertia and damping are condensed. A symmetric
undamped problem is solved as one (eigh), any other in first order (QR, or QZ where inertia is singular).

*Sparse*: the eigenvalues nearest to a real shift by Arnoldi's method (ARPACK) on the bordered matrix
:math:`K + \sigma C + \sigma^2 M`, factored once (linear.py); with Lanczos' where it is symmetric and undamped.

Every pair is judged by what it leaves of the equations above, relative to the sizes of their terms.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from mecano.errors import ConvergenceError
from mecano.solve.linear import LinearSolver
from mecano.solve.stability import null_space

DENSE = 400  # motions up to which all eigenvalues are computed
SYMMETRIC = 1e-9  # of the largest entry
MASSLESS = 1e-13  # of the largest inertia
FREE = 1e-9  # of the sizes of its terms, that K y may leave for a motion without stiffness
REAL = 1e-9  # of an eigenvalue, that its imaginary part is rounding
GROWS = 1e-7  # of an eigenvalue, above which a positive real part counts
INFINITE = 1e-13
ROUNDED = 1e-8  # of the largest stiffness: terms smaller than this are judged against it
CANCELLED = 1e-12  # a pivot cancelled to less than this asks for a shift
FEW_MOVE = 3000  # unknowns up to which a mechanism with few motions is solved dense
EXTRA = 6  # eigenvalues asked of ARPACK beyond those wanted


@dataclass(frozen=True)
class Modes:
    """Modes, natural frequencies ascending: of a conjugate pair the one with the positive imaginary part."""

    values: np.ndarray  # (m,) complex eigenvalues [1/s]; zero for motions without stiffness
    shapes: np.ndarray  # (m, n_q) complex; displacements inertial [m], rotations inertial [rad], scalars
    residuals: np.ndarray  # (m,) relative to the sizes of the terms
    method: str
    found: int  # how many modes there are; of a sparse solution, how many were computed

    @property
    def frequency(self):
        """Damped frequencies (m,) [Hz]."""
        return np.abs(self.values.imag) / (2.0 * np.pi)

    @property
    def natural_frequency(self):
        """Moduli of the eigenvalues over 2 pi (m,) [Hz]."""
        return np.abs(self.values) / (2.0 * np.pi)

    @property
    def damping_ratio(self):
        """Minus the real part over the modulus (m,); nan for free motions."""
        size = np.abs(self.values)
        return np.where(size > 0.0, -self.values.real / np.where(size > 0.0, size, 1.0), np.nan)

    @property
    def kinds(self):
        """(m,) texts: free, oscillation, flutter, decay or divergence."""
        return [_kind(value) for value in self.values]


def _kind(value):
    if value == 0.0:
        return "free"
    grows = value.real > GROWS * abs(value)
    if value.imag:
        return "flutter" if grows else "oscillation"
    return "divergence" if grows else "decay"


def solve(lin, number=10, method="automatic"):
    """The ``number`` modes of lowest natural frequency of a Linearization, and all unstable ones that were computed.

    ``method`` dense, sparse or automatic (by size). Shapes have the largest displacement 1, rotations counted by the
    length scale, real there. Raises ConvergenceError when ARPACK fails.
    """
    if method == "automatic":
        method = "dense" if lin.n_q <= DENSE else "sparse"
    scaled = _Scaled(lin)
    values, shapes, text = (_dense if method == "dense" else _sparse)(scaled, number)
    values, shapes = _told(*_with_free(scaled, values, shapes))
    order = np.argsort(np.abs(values), kind="stable")
    growing = [i for i in order[number:] if _kind(values[i]) in ("flutter", "divergence")]
    chosen = np.array([*order[:number], *growing], int)
    residuals = np.array([scaled.residual(values[i], shapes[i]) for i in chosen])
    shapes = np.array([_normal(shapes[i]) / lin.root for i in chosen]).reshape(len(chosen), lin.n_q)
    return Modes(values[chosen], shapes, residuals, text, len(values))


def _normal(shape):
    """The shape with its largest component 1."""
    largest = shape[np.argmax(np.abs(shape))]
    return shape / largest if largest else shape


class _Scaled:
    """The matrices in motions of one unit (rotations times the length scale), split into their blocks."""

    def __init__(self, lin):
        n_q = self.n_q = lin.n_q
        S = sp.diags(np.concatenate([1.0 / lin.root, np.ones(lin.K.shape[0] - n_q)]))
        self.full = tuple((S @ A @ S).tocsr() for A in (lin.M, lin.C, lin.K))
        self.M, self.C, self.K = (A[:n_q, :n_q] for A in self.full)
        self.D = self.full[2][:n_q, n_q:]
        rows_K, rows_C = -self.full[2][n_q:, :n_q], -self.full[1][n_q:, :n_q]
        self.on_velocity = np.asarray(abs(rows_C).sum(axis=1)).ravel() > 0.0
        self.B, self.E, self.F = rows_K[~self.on_velocity], rows_C[self.on_velocity], rows_K[self.on_velocity]
        self.groups = lin.groups
        self.size = [float(abs(A).max()) if A.nnz else 0.0 for A in (self.M, self.C, self.K)]

    @property
    def undamped(self):
        """True when the problem is symmetric, without first-order terms."""
        M, C, K = self.size
        scale = np.sqrt(M * K)
        asymmetric = abs(self.K - self.K.T).max() if self.K.nnz else 0.0
        return not self.on_velocity.any() and C <= 1e-14 * scale and asymmetric <= SYMMETRIC * K

    def residual(self, value, y):
        """What a pair leaves of the equations, relative to the sizes of their terms."""
        terms = [value**2 * (self.M @ y), value * (self.C @ y), self.K @ y]
        r = sum(terms)
        size = abs(value) ** 2 * np.linalg.norm(abs(self.M) @ abs(y))
        size += abs(value) * np.linalg.norm(abs(self.C) @ abs(y)) + np.linalg.norm(abs(self.K) @ abs(y))
        if self.D.shape[1]:
            mu = self.least(r)
            r = r + self.D @ mu
            size += np.linalg.norm(abs(self.D) @ abs(mu))
        size = max(size, ROUNDED * self.size[2] * np.linalg.norm(y))
        gaps = [_relative(self.B, y), _relative(value * self.E + self.F, y)]
        return float(max([np.linalg.norm(r) / max(size, 1e-300), *gaps]))

    def least(self, r):
        """Multipliers mu with the least r + D mu."""
        if self.D.shape[0] <= 3 * DENSE:
            return np.linalg.lstsq(self.D.toarray(), -r, rcond=1e-12)[0]
        parts = [spla.lsqr(self.D, -part, atol=1e-14, btol=1e-14, iter_lim=2000)[0] for part in (r.real, r.imag)]
        return parts[0] + 1j * parts[1]


def _relative(A, y):
    if not A.shape[0]:
        return 0.0
    return float(np.linalg.norm(A @ y) / max(spla.norm(A) * np.linalg.norm(y), 1e-300))


def _with_free(scaled, values, shapes):
    """The pairs with those that have no stiffness replaced by a basis of them, with the eigenvalue zero."""
    largest = np.abs(values).max(initial=0.0)
    still = np.array([_is_free(scaled, value, y, largest) for value, y in zip(values, shapes, strict=True)], bool)
    if not still.any():
        return values, shapes
    basis = np.array([part for y in shapes[still] for part in (y.real, y.imag)]).T
    U, sigma, _ = np.linalg.svd(basis / np.maximum(np.linalg.norm(basis, axis=0), 1e-300), full_matrices=False)
    free = _plain(U[:, sigma > 1e-3 * sigma[0]].T)
    moving = ~still
    return np.concatenate([np.zeros(len(free)), values[moving]]), np.concatenate([free, shapes[moving]])


def _plain(basis):
    """The same space (f, n_q) by motions of which each has a place of its own where the others vanish."""
    _, _, order = la.qr(basis, pivoting=True, mode="economic")
    return np.linalg.solve(basis[:, order[: len(basis)]], basis)


def _is_free(scaled, value, y, largest):
    """Whether the pair is a motion at rest anywhere along it: nothing in the equations but rounding."""
    size = np.linalg.norm(abs(scaled.K) @ abs(y))
    if not size:
        return abs(value) <= 1e-7 * largest
    if max(np.linalg.norm(value**2 * (scaled.M @ y)), np.linalg.norm(value * (scaled.C @ y))) > FREE * size:
        return False
    r = scaled.K @ y
    if scaled.D.shape[1]:
        r = r + scaled.D @ scaled.least(r)
    return np.linalg.norm(r) <= FREE * size


def _told(values, shapes):
    """One of each conjugate pair, imaginary parts of rounding removed."""
    real = np.abs(values.imag) <= REAL * np.abs(values)
    values = np.where(real, values.real + 0j, values)
    keep = values.imag >= 0.0
    return values[keep], shapes[keep]


def _dense(scaled, number):
    """All eigenvalues and shapes: (values, shapes (m, n_q), text)."""
    Z = null_space(scaled.B.toarray())
    M, C, K = (Z.T @ A @ Z for A in (scaled.M.toarray(), scaled.C.toarray(), scaled.K.toarray()))
    if not Z.shape[1]:
        return np.zeros(0, complex), np.zeros((0, scaled.n_q), complex), "dense: nothing moves"
    if scaled.on_velocity.any():
        values, p = _on_velocities(scaled, Z, M, C, K)
        return values, p @ Z.T, "dense, first order, with constraints on velocities"
    M, C, K, back = _condensed(M, C, K)
    if scaled.undamped:
        squares, vectors = la.eigh(0.5 * (K + K.T), 0.5 * (M + M.T))
        values = np.where(squares < 0.0, np.sqrt(np.abs(squares)), 1j * np.sqrt(np.abs(squares)))
        both = np.concatenate([values, -values[squares < 0.0]])
        return both, (np.concatenate([vectors.T, vectors.T[squares < 0.0]]) @ back.T) @ Z.T, "dense, undamped"
    values, p = _first_order(M, C, K)
    return values, (p @ back.T) @ Z.T, "dense, first order"


def _condensed(M, C, K):
    """M, C, K without the motions that have neither inertia nor damping, and the matrix that gives back all."""
    w, U = la.eigh(0.5 * (M + M.T))
    light = w <= MASSLESS * w[-1]
    U1, U2 = U[:, ~light], U[:, light]
    drag = max(np.abs(C @ U2).max(initial=0.0), np.abs(U2.T @ C).max(initial=0.0))
    if not light.any() or drag > 1e-12 * np.sqrt(np.abs(M).max() * np.abs(K).max()):
        return M, C, K, np.eye(len(M))
    follow = -np.linalg.lstsq(U2.T @ K @ U2, U2.T @ K @ U1, rcond=1e-13)[0]
    back = U1 + U2 @ follow
    lead = U1.T - (np.linalg.lstsq((U2.T @ K @ U2).T, (U1.T @ K @ U2).T, rcond=1e-13)[0]).T @ U2.T
    return U1.T @ M @ U1, U1.T @ C @ U1, lead @ K @ back, back


def _first_order(M, C, K):
    """Eigenvalues and position parts (m, r) of the vectors of M y'' + C y' + K y = 0."""
    r = len(M)
    rate = np.sqrt(np.abs(K).max() / np.abs(M).max()) or 1.0  # makes positions and velocities comparable
    M, C, K = M * rate**2, C * rate, K
    eye, zero = np.eye(r), np.zeros((r, r))
    w = la.eigvalsh(0.5 * (M + M.T))
    if w[0] > MASSLESS * w[-1]:
        inverse = la.lu_factor(M)
        A = np.block([[zero, eye], [-la.lu_solve(inverse, K), -la.lu_solve(inverse, C)]])
        values, vectors = la.eig(A)
    else:
        values, vectors = _finite(np.block([[zero, eye], [-K, -C]]), la.block_diag(eye, M))
    return values * rate, vectors[:r].T


def _finite(A, E):
    """Finite eigenvalues of A x = value E x and their vectors, by QZ."""
    (alpha, beta), vectors = la.eig(A, E, homogeneous_eigvals=True)
    size = np.hypot(np.abs(alpha), np.abs(beta))
    finite = np.abs(beta) > INFINITE**0.5 * size
    return alpha[finite] / beta[finite], vectors[:, finite]


def _on_velocities(scaled, Z, M, C, K):
    """Eigenvalues and p (m, r) where constraints hold velocities, too."""
    E, F = scaled.E @ Z, scaled.F @ Z
    N, G = null_space(E), -np.linalg.pinv(E, rcond=1e-12) @ F
    L = null_space((Z.T @ scaled.D[:, scaled.on_velocity]).T).T
    A = np.block([[G, N], [-L @ (M @ G @ G + C @ G + K), -L @ (M @ G @ N + C @ N)]])
    values, vectors = _finite(A, la.block_diag(np.eye(len(G)), L @ M @ N))
    return values, vectors[: len(G)].T


def _sparse(scaled, number):
    """The eigenvalues nearest to a small shift: (values, shapes (m, n_q), text)."""
    mobility = scaled.n_q - scaled.B.shape[0]  # at least
    if mobility <= 2 * (number + EXTRA) and scaled.n_q <= FEW_MOVE:
        return _dense(scaled, number)
    inverse, shift = _shifted(scaled)
    wanted = max(min(number + EXTRA, mobility - 2), 1)
    try:
        if scaled.undamped:
            return _lanczos(scaled, inverse, shift, wanted)
        return _arnoldi(scaled, inverse, shift, 2 * wanted)
    except spla.ArpackError as error:
        raise ConvergenceError(f"the modes were not found: {error}") from error


def _shifted(scaled):
    """The solver of K + s C + s^2 M, bordered, and the shift s: zero where K is regular."""
    M, C, K = scaled.full
    rate = np.sqrt(abs(K.diagonal()[: scaled.n_q]).mean() / abs(M.diagonal()[: scaled.n_q]).mean())
    k = float(abs(K.diagonal()[: scaled.n_q]).mean()) or 1.0
    n_q = scaled.n_q
    border = sp.diags(np.concatenate([np.ones(n_q), np.full(K.shape[0] - n_q, k)]))
    for shift in (0.0, *(rate * 10.0**power for power in (-6, -5, -4, -3, -2))):
        matrix = sp.coo_matrix(border @ (K + shift * C + shift**2 * M) @ border + _penalty(scaled, k))
        solver = LinearSolver(K.shape[0], matrix.row, matrix.col, scaled.groups, n_q)
        x, b = np.zeros(K.shape[0]), np.random.default_rng(2).normal(size=K.shape[0])
        status = solver.solve(np.ascontiguousarray(matrix.data), b, x)
        if status.ok and not status.null_pivots and solver.cancellation().min() > CANCELLED:
            return (lambda b, solver=solver: _resolved(solver, border, b)), shift
    raise ConvergenceError("the modes were not found: the bordered stiffness is singular at any shift")


def _penalty(scaled, k):
    """k B^T B, which changes no motion that the constraints allow, and the full diagonal of the pattern."""
    n = scaled.full[2].shape[0]
    top = k * (scaled.B.T @ scaled.B)
    corner = sp.csr_matrix((n - scaled.n_q,) * 2)
    return sp.block_diag([top, corner]) if n > scaled.n_q else top


def _resolved(solver, border, b):
    x = np.empty(len(b))
    solver.resolve(np.ascontiguousarray(border @ b), x)
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
    K, M = (vectors.T @ (A @ vectors) for A in (scaled.K, scaled.M))  # vectors that Lanczos mixed are told apart
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
    inverses, vectors = spla.eigs(operator, wanted, v0=start, ncv=min(2 * n, 3 * wanted + 20))
    finite = np.abs(inverses) > INFINITE * np.abs(inverses).max()
    values = shift + 1.0 / inverses[finite]
    return values, vectors[:n_q, finite].T, f"sparse (Arnoldi), about {shift:.3g}/s"
