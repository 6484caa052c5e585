r"""Stability of an equilibrium, and its softest motion.

Stability follows from the tangent on the motions that the constraints allow, :math:`Z^T K Z` with :math:`B Z = 0`;
displacements are in metres, rotations times the length scale. Signals follow the motion: the stiffness of a controller
counts as that of a spring. Small models: the eigenvalues of the tangent. If it is not symmetric to rounding (as it is
under conservative forces), only real negative ones count; complex ones concern the motion (modes.py). Large models: the
signs of the pivots of the bordered matrix without row exchanges (Sylvester's law: one negative pivot for each
constraint, and one for each unstable direction); for an unsymmetric tangent only the parity of their number indicates
divergence.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import name_list
from mecano.model.numbering import ROTATION
from mecano.solve.diagnostics.scales import NO_STIFFNESS

if TYPE_CHECKING:
    import scipy.sparse as sp

    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.linear.symbolic_analysis import Analysis
    from mecano.solve.statics.pivot_signs import PivotSigns

DENSE = 400  # unknowns up to which all eigenvalues are computed
FEW = 100  # motions up to which all eigenvalues take less time than the import of scipy.linalg
LOWEST = 8  # eigenvalues computed first: the six rigid motions of a free model, an unstable one, and one above
NEUTRAL = 1e-13  # of the largest stiffness: softer directions are neutral (dense)
NEUTRAL_WHERE_SOFT = 1e-10  # the same if redundant constraints are compliant
SYMMETRIC = 1e-7  # of the largest entry: largest asymmetry of a symmetric tangent
ROUNDED = 1e-11  # of the largest entry: asymmetry that is rounding error, also if a direction is softer
RANK = 1e-9  # singular value of normalized rows below which it counts as zero
UNKNOWN = -1
MOST_NAMES = 2  # nodes named in the description of a motion
SMALL = 0.2  # of the largest displacement: nodes that move less are not named


@dataclass(frozen=True)
class Stability:
    """Unstable and neutral directions of an equilibrium; UNKNOWN (-1) if undetermined."""

    unstable: int
    neutral: int
    stiffness: float = np.nan  # [N/m] of the softest direction, as far as known
    shape: np.ndarray | None = None  # (n_q,) the softest motion, largest displacement 1

    @property
    def stable(self) -> bool:
        """True if no direction is known to be unstable or neutral."""
        return self.unstable <= 0 and self.neutral <= 0


class StabilityTest:
    """Determine the stability of equilibria of one system from tangents on its pattern."""

    def __init__(self, system: "System", length: float, soft: bool, analysis: "Analysis | None"):
        """Set the limit of neutral directions; ``soft``: compliant redundant constraints may stiffen free motions.

        ``analysis``: that of the LinearSolver of the system, if there is one.
        """
        self.system, self.length, self.neutral = system, length, NEUTRAL_WHERE_SOFT if soft else NEUTRAL
        self.dense = system.n_q <= DENSE
        self.root = np.where(system.numbering.kind[: system.n_q] == ROTATION, length, 1.0)
        self.metric = np.where(system.signals, 0.0, self.root**2)
        self._analysis = analysis
        self._pivots: PivotSigns | None = None

    def __call__(self, data: np.ndarray, drag: float = 0.0) -> Stability:
        """Return the Stability from ``data``, the tangent with k = 1 and no penalty: K and the borders -B, -B^T.

        ``drag`` [N/m] is added to the stiffness against all motions.
        """
        if not np.isfinite(data).all():
            return Stability(UNKNOWN, UNKNOWN)
        data = self.dragged(data, drag) if drag else data
        if self.dense:
            return self._dense(data)
        if self._pivots is None:
            from mecano.solve.statics.pivot_signs import PivotSigns  # with SciPy, which takes 0.3 s to import

            self._pivots = PivotSigns(self, self._analysis)
        return self._pivots(data)

    def dragged(self, data: np.ndarray, drag: float) -> np.ndarray:
        """Return ``data`` (n_data,) with ``drag`` [N/m] added to the stiffness against all motions."""
        data = data.copy()
        data[self.system.diagonal[: self.system.n_q]] += drag * self.metric
        return data

    def _dense(self, data):
        n_q, full, own = self.system.n_q, np.zeros((self.system.n, self.system.n)), ~self.system.signals
        full[self.system.rows, self.system.cols] = data[: self.system.nnz]
        K, root = condensed(full[:n_q, :n_q], own), self.root[own]
        if K is None:
            return Stability(UNKNOWN, UNKNOWN)
        Z = null_space(full[n_q:, :n_q][:, own] / root)
        if not Z.shape[1]:
            return Stability(0, 0)
        K = K / np.outer(root, root)
        largest = np.abs(K).max()
        K = Z.T @ K @ Z
        limit = max(self.neutral * largest, NO_STIFFNESS)
        values, vectors = _lowest(0.5 * (K + K.T), limit)
        if _unsymmetric(K, largest, values):
            values, vectors = _real(*np.linalg.eig(K))
        if not len(values):
            return Stability(0, 0)
        shape = np.zeros(n_q)
        shape[own] = (Z @ vectors[:, 0]) / root
        unstable, neutral = int(np.sum(values < -limit)), int(np.sum(np.abs(values) <= limit))
        return Stability(unstable, neutral, float(values[0]), scaled(shape, self.root))


def condensed(K: np.ndarray, own: np.ndarray) -> np.ndarray | None:
    """Condense the stiffness to the m unknowns ``own`` (m, m); return None if the others are undetermined.

    The others are signals: those of a controller add its stiffness, those of an integrator have no value at rest.
    """
    if own.all():
        return K
    others = K[~own][:, ~own]
    if np.linalg.matrix_rank(others) < len(others):
        return None
    return K[own][:, own] - K[own][:, ~own] @ np.linalg.solve(others, K[~own][:, own])


def null_space(B: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis (n, n - rank) of the null space of B (m, n), whose rows may be of any size."""
    if not B.shape[0]:
        return np.eye(B.shape[1])
    size = np.linalg.norm(B, axis=1)
    _, sigma, Vt = np.linalg.svd(B[size > 0] / size[size > 0, None], full_matrices=True)
    return Vt[int(np.sum(sigma > RANK)) :].T


def _lowest(K, limit):
    """Return the lowest eigenvalues of K, symmetric, with their vectors: all up to ``limit``, and the next above it.

    If none is below the limit, a few suffice, in half of the time of all.
    """
    if len(K) > FEW:
        import scipy.linalg as la

        values, vectors = la.eigh(K, subset_by_index=[0, LOWEST - 1])
        if values[-1] > limit:
            return values, vectors
    return np.linalg.eigh(K)


def _unsymmetric(K, largest, values):
    """Return whether the asymmetry of K matters relative to its ``largest`` entry, or to its softest direction.

    ``values``: the lowest eigenvalues of the symmetric part. By the theorem of Bauer and Fike the eigenvalues of K
    differ from them by at most the norm of the antisymmetric part, which for follower loads on slender beams is small
    relative to the axial stiffness.
    """
    other = 0.5 * np.linalg.norm(K - K.T)
    return np.abs(K - K.T).max() > SYMMETRIC * largest or other > max(ROUNDED * largest, np.abs(values).min())


def _real(values, vectors):
    """Return the real ones of the eigenvalues in ascending order, with their vectors."""
    rounding = np.maximum(1e-13 * np.abs(values).max(initial=0.0), 1e-6 * np.abs(values))
    real = np.flatnonzero(np.abs(values.imag) <= rounding)
    order = real[np.argsort(values[real].real)]
    return values[order].real, vectors[:, order].real


def scaled(shape: np.ndarray, root: np.ndarray) -> np.ndarray:
    """Return the motion scaled to a largest displacement of 1 (rotations times the length scale)."""
    size = np.abs(shape * root)
    return shape / (shape[np.argmax(size)] * root[np.argmax(size)])


def freedom_text(system: "System", s: "State", stability: Stability, length: float) -> str:
    """Return as text the number of unstable or neutral directions of a state, and its softest motion."""
    if stability.shape is None:
        return "undetermined stability" if stability.unstable == UNKNOWN else "stable"
    motion = motion_text(system, s, stability.shape, length)
    if stability.unstable > 0:
        return f"{stability.unstable} unstable direction(s); the most unstable motion: {motion}"
    if stability.neutral > 0:
        return f"{stability.neutral} direction(s) without stiffness, such as this motion: {motion}"
    return f"stable; the softest motion ({stability.stiffness:.3g} N/m): {motion}"


FREE = 1e-9  # of the sum of its terms: a smaller force in a rigid motion of the model is rounding error


def is_floating(system: "System", s: "State", stability: Stability) -> bool:
    """Return whether the neutral directions at ``s`` are the six rigid motions of the model, such as a satellite."""
    if stability.unstable > 0 or stability.neutral != 6:
        return False
    data, n_q, of = system.assemble(s, cK=1.0).data[: system.nnz], system.n_q, system.numbering
    motions = np.zeros((system.n, 6))
    for x, r, rotation in zip(of.x, of.r, of.rotation, strict=True):
        if x < n_q:
            motions[x : x + 3] = np.hstack([np.eye(3), np.cross(np.eye(3), s.z[x : x + 3]).T])
        if r < n_q:
            motions[r : r + 3, 3:] = s.R[rotation].T
    own = np.append(~system.signals, np.ones(system.n - n_q, bool))
    terms = data[:, None] * motions[system.cols]
    forces, sizes = np.zeros_like(motions), np.zeros_like(motions)
    np.add.at(forces, system.rows, terms)
    np.add.at(sizes, system.rows, np.abs(terms))
    forces, largest = np.abs(forces)[own], sizes.max(initial=0.0)
    return bool((forces <= FREE * largest).all())


STILL = 1e-9  # of the largest component: smaller motions of nodes count as zero
MASSLESS = 1e-12  # of the largest inertia, times the square of the largest component: no kinetic energy


def motion_text(
    system: "System",
    s: "State",
    shape: np.ndarray,
    length: float,
    inertial: bool = False,
    most: int = MOST_NAMES,
    M: "sp.csr_matrix | None" = None,
) -> str:
    """Describe a motion (n_q,) of the free unknowns at ``s``: at most ``most`` nodes, the most mobile first.

    Rotations of ``shape`` are in the axes of the nodes, or ``inertial``. With the sparse mass matrix ``M``, motions are
    compared by their kinetic energies, otherwise, or if all are zero, as displacements, rotations times ``length``.
    """
    moves = []
    seen = set()
    of = system.numbering
    first_scalar = next((i for i in range(system.n_q) if of.kind[i] > ROTATION), system.n_q)
    sizes = _sizes(of.kind[: system.n_q], first_scalar, shape, length, M)
    for node, x, r, rotation in zip(system.nodes, of.x, of.r, of.rotation, strict=True):
        for first, R, verb in ((x, np.eye(3), "moves along"), (r, s.R[rotation], "turns about")):
            if first >= system.n_q or first in seen:
                continue
            seen.add(first)
            vector = (np.eye(3) if inertial else R) @ shape[first : first + 3]
            moves.append((float(sizes[first]), f"node '{node.name}' {verb} {_direction(vector)}"))
    changes = [(float(sizes[i]), f"{of.name[i]} changes") for i in range(first_scalar, system.n_q)]
    signals = system.signals[first_scalar:]
    moves += [change for change, signal in zip(changes, signals, strict=True) if not signal]
    if max(moves, default=(0.0,))[0] <= STILL * np.abs(shape).max(initial=0.0):  # the units of signals are arbitrary
        moves = changes
    moves.sort(key=lambda move: -move[0])
    named = [text for size, text in moves if size > SMALL * moves[0][0]]
    return name_list(named, most, "; ")


def _sizes(kind, first_scalar, shape, length, M):
    """Return the size (n_q,) of each displacement and rotation, at the first of its three unknowns, and each scalar."""
    first = np.arange(len(shape))
    first[:first_scalar] -= first[:first_scalar] % 3
    if M is not None:
        M = M.tocoo()
        own = (M.row < len(shape)) & (M.col < len(shape))
        i, j, entries = M.row[own], M.col[own], M.data[own]
        own = first[i] == first[j]
        products = (shape[i] * entries * shape[j])[own]
        energy = np.bincount(first[i[own]], products, len(shape))
        if energy.max(initial=0.0) > MASSLESS * np.abs(entries).max(initial=0.0) * np.abs(shape).max(initial=0.0) ** 2:
            return np.sqrt(np.maximum(energy, 0.0))
    squares = np.where(kind == ROTATION, length * shape, shape) ** 2
    return np.sqrt(np.bincount(first, squares, len(shape)))


def _direction(vector):
    size = np.linalg.norm(vector)
    if not size > 0.0:
        return "nothing"
    unit = vector / size
    unit = unit * np.sign(unit[np.argmax(np.abs(unit))])
    return "[" + ", ".join(f"{c + 0.0:.3g}" for c in np.where(np.abs(unit) < 5e-4, 0.0, unit)) + "]"
