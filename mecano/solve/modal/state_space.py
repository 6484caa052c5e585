r"""State space of a Plant: independent first-order equations, by dense matrices.

The unknowns x = (y, y', reactions) satisfy :math:`E x' = A x + B_0 u + B_1 u' + B_2 u''` with a singular E. Dependent
rows of E give conditions :math:`0 = A_2 x + \ldots` without rates: they are solved for some of the unknowns, chosen by
pivots, :math:`x = N z + G_0 u + G_1 u' + \ldots`, and fewer unknowns z are left. This is repeated until E is regular:
holonomic constraints take three rounds, filters one, motions without inertia up to two. Rates of inputs in the
equations are then removed by :math:`z = \bar z + E^{-1} B_k u^{(k-1)}`, which leaves

.. math::  \dot z = A z + B u, \qquad x = N z + D_0 u + D_1 u' + \ldots

The states are those unknowns of the model, or rates, that determine all others best, without the direct contribution of
the inputs.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from mecano.errors import UsageError
from mecano.solve.diagnostics.scales import NO_STIFFNESS
from mecano.solve.modal.frequency_response import Plant, scale_unread
from mecano.solve.statics.stability import null_space

SINGULAR = 1e-11  # of the largest singular value: smaller ones count as zero
IMPROPER = 1e-5  # of the terms of a transfer function: a smaller factor of the rate of an input is neglected
DEPENDENT = 1e-9  # of normalized rows of constraints
DETERMINED = 1e-6  # of a motion: least part of it that must be independent of the states chosen before
ROUNDED = 1e-14  # of the largest entry of a row, in balanced units: smaller ones are rounding errors
NOISE = 1e-12  # of the largest possible entry, in balanced units: a smaller one is no dependence on a state or input
AT_ONCE = 1e3  # preference, over motions, of unknowns to be solved for: signals without a state, reactions
TRIED, NEAR = 4, 100.0  # units of time to be tried; ratio to the mean eigenvalue up to which one is accepted
ZERO = 1e-9  # of the largest stiffness: a smaller one counts as zero
SLOW = 1e-3  # of the largest eigenvalue, and of the unit of time: a smaller one may be a multiple zero
BALANCED = 10  # rounds of the balance of unknowns and equations


@dataclass(frozen=True)
class StateSpace:
    """x' = A x + B u, z = C x + D u; ``states`` are indices of unknowns y, or of their rates, see ``is_rate``."""

    A: np.ndarray  # (n, n)
    B: np.ndarray  # (n, m)
    C: np.ndarray  # (p, n)
    D: np.ndarray  # (p, m)
    states: np.ndarray  # (n,) indices of unknowns
    is_rate: np.ndarray  # (n,) bool: the state is the rate of this unknown

    def motion(self, s: complex) -> np.ndarray:
        """Return (s - A)^-1 B, (n, m): the states for a unit of each input."""
        return np.linalg.solve(s * np.eye(len(self.A)) - self.A, self.B)


class ImproperError(UsageError):
    """Transfer functions grow with the frequency; ``pairs``: their (output, input)."""

    def __init__(self, pairs: Sequence[tuple[int, int]]):
        self.pairs = list(pairs)
        super().__init__(f"the transfer functions {self.pairs} (output, input) grow with the frequency")


@dataclass
class _Descriptor:
    """E z' = A z + sum of B[k] u^(k), (y, y') = N z + sum of X[k] u^(k), in balanced units and the time 1/rate."""

    E: np.ndarray
    A: np.ndarray
    B: list[np.ndarray]
    N: np.ndarray
    X: list[np.ndarray]
    preference: np.ndarray  # factors of the unknowns z: those with larger ones are solved for
    unknowns: np.ndarray  # indices of z among (y, y', reactions)


@dataclass
class _Reduced:
    """z' = A z + B u, (y, y') = N z + sum of X[k] u^(k), in these units (n,) and the time 1/rate."""

    A: np.ndarray
    B: np.ndarray
    N: np.ndarray
    X: list[np.ndarray]
    unknowns: np.ndarray
    units: np.ndarray
    rate: float


def state_space(plant: Plant) -> StateSpace:
    """Return the StateSpace of a Plant without delays.

    Raises ImproperError, and UsageError if the equations have no unique solution.
    """
    of, n_q = _paced(plant), plant.lin.n_q
    C, D = _outputs(plant, of)
    at = of.unknowns
    if np.any(at >= 2 * n_q) or not _stateful(plant.lin)[at % n_q].all():
        at = _chosen(of.N, plant.lin)
    at = np.sort(at)
    T = of.N[at]
    A, B = _rounded(np.linalg.solve(T.T, (T @ of.A).T).T), _rounded((T @ of.B).T).T
    C = _rounded(np.linalg.solve(T.T, C.T).T)
    _refuse_improper(A, B, C, D)
    is_rate = at >= n_q
    size = of.units[at % n_q] * np.where(is_rate, of.rate, 1.0)
    A, B = of.rate * A * size[:, None] / size, of.rate * B * size[:, None]
    return StateSpace(A, B, C / size, D[0], at % n_q, is_rate)


def _outputs(plant, of):
    """Return (C (p, n), [D[0], D[1], ...]) of the outputs z = C z + sum of D[k] u^(k), without rounding."""
    n_q = plant.lin.n_q
    R = [of.rate**k * (one[:, :n_q].toarray() * of.units[:n_q]) for k, one in enumerate(plant.outputs)]
    y, X = of.N[:n_q], [x[:n_q] for x in of.X]
    v, none = y @ of.A, 0.0 * X[0]
    C = R[0] @ y + R[1] @ v + R[2] @ (v @ of.A)
    of_inputs = [*X, none, none], [y @ of.B, *X, none], [v @ of.B, y @ of.B, *X]  # of y, y', y'', by rates of u
    D = [sum(a @ b for a, b in zip(R, parts, strict=True)) for parts in zip(*of_inputs, strict=True)]
    pace = np.abs(of.A).max(initial=1.0)
    size = sum(np.abs(one).sum(axis=1) * pace**k for k, one in enumerate(R))
    C[np.abs(C).max(axis=1, initial=0.0) <= NOISE * size] = 0.0
    noise = NOISE * np.outer(size, np.max([np.abs(x).max(axis=0, initial=0.0) for x in (y @ of.B, *X)], axis=0))
    return C, [np.where(np.abs(d) <= noise, 0.0, d) for d in D]


def _paced(plant):
    """Return the _Reduced equations of a Plant, with a unit of time that suits their eigenvalues."""
    lin = plant.lin
    stiff, mass = (np.abs(A.diagonal()[: lin.n_q]) for A in (lin.K, lin.M))
    both = (stiff > max(ZERO * stiff.max(initial=0.0), NO_STIFFNESS)) & (mass > 0.0) & ~lin.signals
    rate = float(np.exp(0.5 * np.mean(np.log(stiff[both] / mass[both])))) if both.any() else 1.0
    for _ in range(TRIED):
        found = _reduced(plant, rate)
        values = np.abs(np.linalg.eigvals(found.A))
        values = values[values > SLOW * max(1.0, values.max(initial=0.0))]
        pace = float(np.exp(np.mean(np.log(values)))) if len(values) else 1.0
        if 1.0 / NEAR < pace < NEAR:
            break
        rate *= pace
    return found


def _reduced(plant, rate):
    """Return the _Reduced equations of a Plant with the unit of time 1/rate."""
    units, rows = _units(plant, rate)
    one: _Descriptor | None = _first_order(plant, units, rows, rate)
    while one is not None:
        last, one = one, _solved(one)
    return _Reduced(*_without_rates(last), units, rate)


def _units(plant, rate):
    """Return units of the unknowns and factors of the equations (n,) that make entries about one.

    With them the inertia of each motion is one; the largest entries of other rows and columns are, too.
    """
    lin, n_q = plant.lin, plant.lin.n_q
    mass = np.zeros(lin.K.shape[0])
    mass[:n_q] = np.abs(lin.M.diagonal()[:n_q])
    mass[mass <= SINGULAR**2 * mass.max(initial=0.0)] = 0.0
    heavy = mass > 0.0
    units = np.where(heavy, 1.0 / (rate * np.sqrt(np.where(heavy, mass, 1.0))), 1.0)
    rows, light = units.copy(), np.flatnonzero(~heavy)
    A = abs(lin.K) + rate * abs(lin.C) + rate**2 * abs(lin.M)
    for _ in range(BALANCED):
        B = sp.csr_matrix(sp.diags(rows) @ A @ sp.diags(units))
        for factors, largest in ((rows, B.max(axis=1)), (units, B.max(axis=0))):
            size = largest.toarray().ravel()[light]
            factors[light] /= np.sqrt(np.where(size > 0.0, size, 1.0))
    scale_unread(A, rows, units)
    return units, rows


def _first_order(plant, units, rows, rate):
    """Return the equations of a Plant as a _Descriptor, in these units and the unit of time 1/rate."""
    n_q = plant.lin.n_q
    of = plant.lin
    K, C, M = (rate**k * (rows[:, None] * A.toarray() * units) for k, A in enumerate((of.K, of.C, of.M)))
    Q = [rate**k * (rows[:, None] * q) for k, q in enumerate(plant.inputs)]
    kept, S = _independent(K, C, n_q)
    K, C, M, Q = K[kept], C[kept], M[kept], [q[kept] for q in Q]
    n, r, eye, zero = len(kept), S.shape[1], np.eye(n_q), np.zeros((n_q, n_q))
    E = np.block([[eye, zero, np.zeros((n_q, r))], [np.zeros((n, n_q)), M[:, :n_q], np.zeros((n, r))]])
    A = np.block([[zero, eye, np.zeros((n_q, r))], [-K[:, :n_q], -C[:, :n_q], -K[:, n_q:] @ S]])
    B = [np.vstack([np.zeros((n_q, q.shape[1])), q]) for q in Q]
    N = np.eye(2 * n_q, 2 * n_q + r)
    own = np.where(_stateful(plant.lin), 1.0, AT_ONCE)
    preference = np.concatenate([own, own, np.full(r, AT_ONCE)])
    return _Descriptor(E, A, B, N, [np.zeros((2 * n_q, B[0].shape[1]))], preference, np.arange(2 * n_q + r))


def _stateful(lin):
    """Return (n_q,) bool: motions with inertia or damping, and states of signals."""
    n_q = lin.n_q
    return (lin.M.diagonal()[:n_q] != 0.0) | (lin.C.diagonal()[:n_q] != 0.0)


def _independent(K, C, n_q):
    """Return (indices of the equations without redundant constraints, S (n_l, r): reactions from independent ones).

    Redundant constraints share their reactions by their compliances, which are in K and removed there. A constraint on
    velocities that follows from those on positions is the redundant one.
    """
    of_rates = np.abs(C[n_q:, :n_q]).max(axis=1, initial=0.0) > 0.0
    J = np.where(of_rates[:, None], C[n_q:, :n_q], K[n_q:, :n_q])
    active = np.abs(J).max(axis=1, initial=0.0) > 0.0  # others have a reaction that is zero
    c = np.where(active[:, None] & active, K[n_q:, n_q:], 0.0)
    soft = np.abs(c).max(axis=1, initial=0.0) > 0.0
    groups = [np.flatnonzero(of) for of in (active & ~soft, soft & ~of_rates, soft & of_rates)]
    stays = active & ~soft
    stays[_pivots(J, groups, DEPENDENT)] = True
    kept, left = np.flatnonzero(stays), np.flatnonzero(active & ~stays)
    K[n_q:, n_q:] -= c
    equations = np.concatenate([np.arange(n_q), n_q + np.flatnonzero(stays | ~active)])
    if not len(left):
        return equations, np.eye(len(J))
    redundant = np.zeros((len(left), len(J)))
    redundant[:, left] = np.eye(len(left))
    redundant[:, kept] = -np.linalg.lstsq(J[kept].T, J[left].T, rcond=DEPENDENT)[0].T
    return equations, null_space(redundant @ c)


def _pivots(rows, groups, least):
    """Return the indices of independent rows (n, m), from the ``groups`` of indices in their order.

    A row is independent if its part orthogonal to those chosen before exceeds ``least`` of its size.
    """
    basis, chosen = np.zeros((0, rows.shape[1])), []
    size = np.linalg.norm(rows, axis=1)
    for group in groups:
        own = group[size[group] > NOISE * size.max(initial=0.0)]
        rest = rows[own] / size[own, None]
        for _ in range(2):  # twice is enough
            rest = rest - (rest @ basis.T) @ basis
        if not len(own):
            continue
        _, R, order = la.qr(rest.T, mode="economic", pivoting=True)
        found = own[order[: int(np.sum(np.abs(np.diag(R)) > least))]]
        chosen.append(found)
        basis = la.orth(np.vstack([basis, rows[found] / size[found, None]]).T, rcond=least).T
    return np.concatenate(chosen) if chosen else np.zeros(0, int)


def _solved(one):
    """Return the _Descriptor with its conditions without rates solved, or None if it has none. Raises UsageError."""
    kept, rest, W = _split(one.E.T)
    if not len(rest):
        return None
    E, A1 = one.E[kept], one.A[kept]
    A2, B2 = one.A[rest] - W.T @ A1, [b[rest] - W.T @ b[kept] for b in one.B]
    size = np.linalg.norm(A2, axis=1)[:, None]
    size[size == 0.0] = 1.0
    A2, B2 = A2 / size, [b / size for b in B2]
    solved, free, V = _split(A2 * one.preference)
    if len(solved) < len(A2):
        raise UsageError(
            "the model has no state space: some of its motions, signals or reactions are undetermined; `mecano modes` "
            "and `mecano check` describe the model"
        )
    follow = np.zeros((len(one.preference), len(free)))
    follow[free] = np.eye(len(free))
    follow[solved] = -one.preference[solved, None] * V / one.preference[free]
    G = [np.zeros((len(follow), b.shape[1])) for b in B2]
    for g, b in zip(G, B2, strict=True):
        g[solved] = -np.linalg.solve(A2[:, solved], b)
    by = [*(b[kept] + A1 @ g for b, g in zip(one.B, G, strict=True)), np.zeros((len(kept), B2[0].shape[1]))]
    by = [b - E @ g for b, g in zip(by, [np.zeros_like(G[0]), *G], strict=True)]
    X = [one.N @ g for g in G]
    for k, x in enumerate(one.X):
        X[k] = X[k] + x
    return _Descriptor(E @ follow, A1 @ follow, by, one.N @ follow, X, one.preference[free], one.unknowns[free])


def _split(A):
    """Return (indices of independent columns of A, those of the others, V): the others are the former times V.

    The entries of A are in balanced units.
    """
    if not A.size:
        return np.zeros(0, int), np.arange(A.shape[1]), np.zeros((0, A.shape[1]))
    _, R, order = la.qr(A, mode="economic", pivoting=True)
    size = np.abs(np.diag(R))
    rank = int(np.sum(size > SINGULAR * max(size[0], 1.0)))  # balanced entries are about one
    V = la.solve_triangular(R[:rank, :rank], R[:rank, rank:])
    return order[:rank], order[rank:], V


def _without_rates(one: _Descriptor) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[np.ndarray], np.ndarray]:
    """Return (A, B, N, X, unknowns), as in _Reduced, of a _Descriptor with a regular E."""
    A, B = np.linalg.solve(one.E, one.A), [np.linalg.solve(one.E, b) for b in one.B]
    X = [*one.X, *(np.zeros_like(one.X[0]) for _ in range(len(B) - len(one.X)))]
    for k in range(len(B) - 1, 0, -1):
        B[k - 1] = B[k - 1] + A @ B[k]
        X[k - 1] = X[k - 1] + one.N @ B[k]
    return A, B[0], one.N, X, one.unknowns


def _chosen(N, lin):
    """Return the indices (n,) of rows of N (2 n_q, n) that determine all others.

    Motions with inertia or damping, and states of signals, are preferred, then the rates of the same.
    """
    n_q = lin.n_q
    heavy, damped = (np.flatnonzero(A.diagonal()[:n_q]) for A in (lin.M, lin.C))
    positions = _pivots(N, [np.union1d(heavy, damped)], DETERMINED)
    rates = n_q + np.intersect1d(positions, heavy)
    others = np.flatnonzero(~lin.signals[:n_q]), np.arange(2 * n_q)
    found = _pivots(N, [positions, rates, n_q + heavy, *others], DETERMINED)
    return found if len(found) == N.shape[1] else _pivots(N, [np.arange(2 * n_q)], 0.0)[: N.shape[1]]


def _rounded(A):
    """Return a matrix without entries at the rounding level of the largest one of their row."""
    return np.where(np.abs(A) <= ROUNDED * np.abs(A).max(axis=1, keepdims=True, initial=0.0), 0.0, A)


def _refuse_improper(A, B, C, D):
    """Raise ImproperError if outputs depend on rates of inputs, D[1], D[2], ..., relative to a typical response."""
    states = np.linalg.solve((1.0 + 1.0j) * np.eye(len(A)) - A, B)
    terms = np.abs(C) @ np.abs(states) + sum(np.abs(d) for d in D)
    wrong = np.any([np.abs(d) > IMPROPER * terms for d in D[1:]], axis=0)
    if wrong.any():
        raise ImproperError(list(zip(*np.nonzero(wrong), strict=True)))
