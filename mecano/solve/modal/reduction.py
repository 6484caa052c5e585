r"""Reduction of a part to its boundary nodes and some modes (Craig & Bampton 1968).

With the boundary coordinates b, the inner motions i, and the matrices M, K of the part at rest under its holonomic
constraints :math:`B\, u = 0`, the motions are

.. math::  u = T \begin{pmatrix} u_b \\ \eta \end{pmatrix}, \qquad
    T = \begin{pmatrix} 1 & 0 \\ \Psi & \Phi \end{pmatrix}

Psi: inner motions under unit displacements of the boundary; Phi: modes of the part with its boundary fixed. The modes
of lowest frequency are kept and scaled to a modal mass equal to the mass of the part, so amplitudes are in metres.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from mecano.elements.bodies.reduced_matrices import RIGID, mass_moments, resistance, rigid_motions
from mecano.errors import AssemblyError, UsageError
from mecano.solve.modal.linearize import linearize
from mecano.solve.statics.stability import null_space

if TYPE_CHECKING:
    from mecano.model.system import System

DENSE = 500  # inner motions up to which all modes are computed
STRESSED = 1e-9  # of stiffness times length: largest force in the reference
SOFT = 1e-13  # of the largest stiffness: a softer motion is free
MASSLESS = 1e-13  # of the largest inertia with unit stiffness: a smaller one counts as zero
TIED = 1e-9  # of the largest entry of the constraints: largest residual of the constraints
ASYMMETRIC = 1e-8  # of the largest entry of the stiffness: largest asymmetry


@dataclass(frozen=True)
class Reduction:
    """The content of a file of reduced matrices, and data for the summary."""

    content: dict[str, np.ndarray]  # key -> array, see docs/superelements.md
    frequencies: np.ndarray  # (m,) frequencies of the modes kept [Hz], boundary fixed
    inner: int  # number of inner motions of the part
    found: int  # number of modes of the part that have inertia; -1 if not all were computed
    mass: float  # [kg]
    next_frequency: float  # of the first mode left out [Hz]; nan if there is none or it was not computed


def reduce(system: "System", boundary: Sequence[str], number: int | None, length: float) -> Reduction:
    """Return the Reduction of ``system``, at rest in its reference, to the nodes named ``boundary``.

    ``number`` of modes, or None for all. Axes and origin are those of the first boundary node. Raises UsageError
    (names, numbers), AssemblyError (a part that is stressed, held, or has free inner motions).
    """
    nodes, own = _boundary(system, boundary)
    state = system.initial_state()
    M, C, K = _matrices(system, state, length)
    rest = np.setdiff1d(np.arange(system.n_q), own)
    Z = _inner_motions(K, rest, system.n_q)
    T, frequencies, found, left_out = _basis(system, M, K, own, rest, Z, number)
    axes = system.nodes[nodes[0]].R
    turn = sp.block_diag([axes] * (2 * len(nodes)) + [sp.eye(len(frequencies))]).tocsr()
    T = turn.T.dot(T.T).T  # columns by coordinates in the axes of the superelement
    stiffness = _boundary_stiffness(K, own, len(frequencies))
    M, C, K = (_symmetric(T.T @ (A[: system.n_q, : system.n_q] @ T)) for A in (M, C, K))
    modes = slice(6 * len(nodes), len(K))
    K[modes, : modes.start] = K[: modes.start, modes] = 0.0  # the modes do no work on the static shapes
    content = {"positions": _positions(system, nodes, nodes[0], axes)}
    K = _without_rigid_forces(K, content["positions"], stiffness)
    mass = mass_moments(M, content["positions"])[0]
    content |= {"stiffness": K, "mass": M} | ({"damping": C} if np.any(C) else {})
    scale = np.ones(len(K))
    scale[modes] = np.sqrt(mass)
    for key in ("stiffness", "mass", "damping"):
        if key in content:
            content[key] = content[key] * np.outer(scale, scale)
    content |= _interior(system, nodes, T * scale, axes)
    return Reduction(content, frequencies, len(rest), found, mass, left_out)


def _boundary(system, names):
    """Return the indices (n,) of the boundary nodes and those of their unknowns (6 n,)."""
    index = {node.name: i for i, node in enumerate(system.nodes)}
    of, nodes, own = system.numbering, [], []
    for name in names:
        if name not in index:
            raise UsageError(f"the part has no node '{name}'; it has {', '.join(list(index)[:12])}")
        i = index[name]
        first = (of.x[i], of.r[i])
        if max(first) >= of.n_q:
            what = "position" if of.x[i] >= of.n_q else "rotation"
            raise UsageError(f"node '{name}' cannot be a boundary node: no element of the part acts on its {what}")
        nodes.append(i)
        own += [d + k for d in first for k in range(3)]
    if len(set(own)) < len(own):
        raise UsageError(f"boundary nodes share unknowns or are named twice: {', '.join(names)}")
    return nodes, np.array(own)


def _matrices(system, state, length):
    """Return M, C, K (n, n) about the reference, inertial axes; raises AssemblyError if the reference is stressed."""
    lin = linearize(system, state, length)
    stiffness = abs(lin.K[: system.n_q, : system.n_q]).max()
    force = np.abs(system.assemble(state).residual[: system.n_q])
    if force.max(initial=0.0) > STRESSED * stiffness * length:
        worst = int(np.argmax(force))
        text = f"forces act in the part at the start: {force[worst]:.3g} in {system.numbering.name[worst]}"
        raise AssemblyError(f"{text}; a part is reduced about its unstressed reference, without loads and gravity")
    gap = abs(lin.K - lin.K.T).max()
    if gap > ASYMMETRIC * abs(lin.K).max():
        raise AssemblyError(f"the stiffness of the part is not symmetric (by {gap:.3g}): it has follower forces")
    return lin.M, lin.C, lin.K


def _inner_motions(K, rest, n_q):
    """Return a basis (n_rest, m) of the inner motions under the constraints, boundary fixed; None if all are free."""
    B = K[n_q:, :n_q]
    return null_space(B[:, rest].toarray()) if B.shape[0] else None


def _basis(system, M, K, own, rest, Z, number):
    """Return T (n_q, n_b + m), the frequencies (m,) of the modes kept [Hz], the number of modes or -1.

    And the frequency of the first one left out [Hz], or nan.
    """
    n_q = system.n_q
    K_ii, M_ii = K[rest][:, rest], M[rest][:, rest]
    if Z is not None:
        K_ii, M_ii = sp.csc_matrix(Z.T @ (K_ii @ Z)), sp.csc_matrix(Z.T @ (M_ii @ Z))
    solve = _factor(system, K_ii, rest, Z)
    static = _static(K, own, rest, n_q, Z, solve)
    squares, shapes, found, left_out = _modes(K_ii, M_ii, number, solve)
    shapes = shapes if Z is None else Z @ shapes
    T = np.zeros((n_q, len(own) + len(squares)))
    T[own, np.arange(len(own))] = 1.0
    T[rest, : len(own)], T[rest, len(own) :] = static, shapes
    return T, np.sqrt(squares) / (2.0 * np.pi), found, np.sqrt(left_out) / (2.0 * np.pi)


def _factor(system, K_ii, rest, Z):
    """Return a function that solves with the inner stiffness; raises AssemblyError if it is singular."""
    n = K_ii.shape[0]
    if not n:
        return lambda b: b
    if n <= DENSE:
        values, vectors = la.eigh(K_ii.toarray())
        if values[0] <= SOFT * values[-1]:
            shape = np.abs(vectors[:, 0] if Z is None else Z @ vectors[:, 0])
            name = system.numbering.name[rest[int(np.argmax(shape))]].motion
            raise AssemblyError(f"with its boundary held, the part can still move freely: {name} has no stiffness")
        factor = la.cho_factor(K_ii.toarray())
        return lambda b: la.cho_solve(factor, b)
    try:
        return spla.splu(sp.csc_matrix(K_ii), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve
    except RuntimeError as error:
        raise AssemblyError(f"with its boundary held, the part can still move freely: {error}") from None


def _static(K, own, rest, n_q, Z, solve):
    """Return Psi (n_rest, n_b), the inner motions under unit displacements of the boundary.

    Raises AssemblyError if constraints hold the boundary nodes.
    """
    K_ib = K[rest][:, own].toarray()
    if not len(rest):
        return K_ib
    if Z is None:
        return -solve(K_ib)
    B_i, B_b = K[n_q:][:, rest].toarray(), K[n_q:][:, own].toarray()
    particular, *_ = la.lstsq(B_i, -B_b)
    if np.abs(B_i @ particular + B_b).max() > TIED * max(np.abs(B_i).max(), np.abs(B_b).max()):
        raise AssemblyError("the constraints inside the part hold its boundary nodes: these must be free to move")
    return particular - Z @ solve(Z.T @ (K_ib + K[rest][:, rest] @ particular))


def _modes(K, M, number, solve):
    """Return omega^2 ascending (m,), shapes (n, m) of unit modal mass, the number of modes or -1, the next omega^2."""
    n = K.shape[0]
    if number == 0 or n == 0:
        return np.zeros(0), np.zeros((n, 0)), -1, np.nan
    if n > DENSE and number is not None and number < n // 4:
        operator = spla.LinearOperator((n, n), matvec=solve)
        start = np.random.default_rng(1).normal(size=n)
        values, vectors = spla.eigsh(sp.csc_matrix(K), number, sp.csc_matrix(M), sigma=0.0, OPinv=operator, v0=start)
        order = np.argsort(values)
        return values[order], vectors[:, order], -1, np.nan
    inverse, vectors = la.eigh(M.toarray(), K.toarray())
    heavy = inverse > MASSLESS * inverse.max(initial=0.0)
    order = np.argsort(-inverse[heavy])
    left_out = 1.0 / inverse[heavy][order[number]] if number is not None and number < len(order) else np.nan
    values, vectors = inverse[heavy][order[:number]], vectors[:, heavy][:, order[:number]]
    return 1.0 / values, vectors / np.sqrt(values), int(heavy.sum()), left_out


def _symmetric(A):
    return 0.5 * (A + A.T)


def _positions(system, chosen, origin, axes):
    """Return the positions (n, 3) of nodes relative to the node ``origin``, in ``axes``."""
    x = np.array([system.nodes[i].x for i in chosen], float).reshape(-1, 3)
    return (x - system.nodes[origin].x) @ axes


def _boundary_stiffness(K, own, n_modes):
    """Return the stiffness (n,) of elements at the boundary coordinates, the same along all axes; 0 for modes."""
    largest = K.diagonal()[own].reshape(-1, 3).max(axis=1)
    return np.concatenate([np.repeat(largest, 3), np.zeros(n_modes)])


def _without_rigid_forces(K, positions, stiffness):
    """Return K without forces under rigid motions, which rounding of the ``stiffness`` (n,) causes."""
    rigid = np.hstack(rigid_motions(positions, len(K)))
    if max(resistance(K, r, stiffness) for r in rigid.T) > RIGID:
        raise AssemblyError("the part resists rigid motions: a node or joint inside it is held by the ground")
    P = np.eye(len(K)) - rigid @ np.linalg.pinv(rigid)
    if len(positions) == 1:  # all motions of a single node are rigid
        P[:6] = P[:, :6] = 0.0
    return _symmetric(P.T @ K @ P)


def _interior(system, nodes, T, axes):
    """Return names, positions and displacements (3 rows each) of the inner nodes of the part."""
    of = system.numbering
    inner = [
        i for i in range(len(system.nodes)) if i not in nodes and of.x[i] < of.n_q and " " not in system.nodes[i].name
    ]
    if not inner:
        return {}
    basis = np.concatenate([axes.T @ T[of.x[i] : of.x[i] + 3] for i in inner])
    return {
        "interior_names": np.array([system.nodes[i].name for i in inner]),
        "interior_positions": _positions(system, inner, nodes[0], axes),
        "interior_basis": basis,
    }
