"""Mobility of a model: groups of redundant constraints and remaining mechanisms, by name.

Both follow from projectors of the scaled constraint gradient B, which do not depend on the choice of a basis: the left
null space of B couples redundant constraints, its null space couples unknowns that can move.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mecano.immutable import immutable
from mecano.maths.sparse_rows import SparseRows, sparse_rows
from mecano.model.numbering import ROTATION, EquationName
from mecano.solve.diagnostics.constraint_names import by_joint

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System

RANK_TOLERANCE = 1e-9  # singular values of rows of unit length below this count as zero
SHARE = 1e-7  # entries of a projector below this count as zero
NEARLY = 0.99  # of the largest value: larger ones count as equal to it
DENSE_ROWS = 3000  # with more constraints in closed loops, or more unknowns, no singular values are computed


@immutable
class Group:
    """Constraints with ``count`` redundancies, or unknowns that move together in ``count`` free motions."""

    count: int
    names: tuple[EquationName, ...]
    totals: dict[str, int] = field(default_factory=dict)  # place of a name -> number of its constraints

    def by_joint(self, most: int) -> list[str]:
        """Describe the constraints in one text per set of similar joints, naming up to ``most`` joints in each."""
        return by_joint(self.names, self.totals, most)


class Entries(NamedTuple):
    """Sparse matrix in coordinate form without duplicate entries."""

    rows: np.ndarray
    cols: np.ndarray
    values: np.ndarray
    shape: tuple[int, int]

    def dense(self, rows: np.ndarray) -> np.ndarray:
        """Return the given rows (m,) as a dense matrix (m, n)."""
        place = np.full(self.shape[0], -1)
        place[rows] = np.arange(len(rows))
        at = np.flatnonzero(place[self.rows] >= 0)
        out = np.zeros((len(rows), self.shape[1]))
        out[place[self.rows[at]], self.cols[at]] = self.values[at]
        return out


@immutable
class Analysis:
    """Mobility of a model at one configuration.

    ``complete`` is False if the rank is unknown because of too many constraints in closed loops.
    """

    rank: int
    redundant: tuple[Group, ...]
    dependent: SparseRows | None  # projector (n_l, n_l) on the reactions in redundancies, see ``_directions``
    release_matrix: SparseRows | None  # (n_l, n_l) whose rows times reactions vanish, see ``_repeated``
    gradient: Entries
    names: Sequence[EquationName]  # of the unknowns first, then of others
    signals: np.ndarray  # (n_q,) bool: unknowns that are signals, not motions
    active: np.ndarray  # (n_l,) bool: constraints that hold in the phases of the configuration
    complete: bool = True

    @property
    def mobility(self) -> int:
        """Number of independent motions that the constraints allow."""
        return self.gradient.shape[1] - self.rank - int(self.signals.sum())

    @cached_property
    def mechanisms(self) -> tuple[Group, ...] | None:
        """Groups of unknowns that can move together; None if there are too many unknowns or the rank is unknown.

        Computed on demand, because a run does not need it and the decomposition of all constraints takes time.
        """
        if not self.small:
            return None
        projector = _null_projector(self.gradient.dense(np.arange(self.gradient.shape[0])), self.rank)
        projector[self.signals] = projector[:, self.signals] = 0.0
        return groups(projector, self.motions)

    @property
    def small(self) -> bool:
        """True if the rank is known and the unknowns are few enough for a decomposition."""
        return self.complete and self.gradient.shape[1] <= DENSE_ROWS

    @property
    def motions(self) -> list[EquationName]:
        """Names (n_q,) of the motions of the unknowns."""
        return [name.motion for name in self.names[: len(self.signals)]]

    @property
    def released(self) -> np.ndarray:
        """Indices (n,) of the released constraints."""
        return np.zeros(0, np.int64) if self.release_matrix is None else self.release_matrix.filled


def analyse(system: "System", s: "State", length: float) -> Analysis:
    """Return the Analysis of ``system`` at ``s``; rotations are multiplied by the length scale."""
    B, size, holds = gradient(system, s, length)
    of = system.numbering
    (loops, null), n_l, names = dependent_rows(B, of.group, holds), int(holds.sum()), of.name
    if null is None:
        rows = np.flatnonzero(holds)
        identity = sparse_rows(rows, rows, np.ones(len(rows)), system.n_l)
        return Analysis(n_l, (), identity, None, B, names, system.signals, holds, False)
    redundant = groups(
        null @ null.T, [of.name[of.n_q + i] for i in loops], lambda: of.name[of.n_q : of.n_q + system.n_l]
    )
    rank = n_l - null.shape[1]
    rows, shares, null = _repeated(null, of.of_rates[loops])
    release_matrix = (
        _spread(shares * size[loops] / size[loops[rows], None], loops[rows], loops, system.n_l) if rows else None
    )
    dependent = _directions(system, null @ null.T, loops, size) if null.shape[1] else None
    return Analysis(rank, redundant, dependent, release_matrix, B, names, system.signals, holds)


def gradient(system: "System", s: "State", length: float) -> tuple[Entries, np.ndarray, np.ndarray]:
    """Return the scaled gradient B = dPhi/dq (Entries (n_l, n_q)), sizes (n_l,) of its rows, active rows (n_l,) bool.

    Columns of rotations are divided by the length scale, then rows are normalized. A constraint that is inactive in the
    current phases has a diagonal entry in the tangent, and no gradient.
    """
    data = np.zeros(system.n_data)
    system.add_constraints(s, 1.0, 0.0, data)
    at = np.flatnonzero((system.rows >= system.n_q) & (system.cols < system.n_q))
    rows, cols = system.rows[at] - system.n_q, system.cols[at]
    values = -data[at] / np.where(system.numbering.kind[cols] == ROTATION, length, 1.0)
    size = np.sqrt(np.bincount(rows, values**2, system.n_l))
    size = np.where(size > 0, size, 1.0)
    values /= size[rows]
    kept = np.abs(values) >= 1e-14
    B = Entries(rows[kept], cols[kept], values[kept], (system.n_l, system.n_q))
    return B, size, data[system.diagonal[system.n_q :]] == 0.0


def dependent_rows(B: Entries, group: np.ndarray, holds: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Return (indices (m,) of the rows of B in closed loops, orthonormal basis (m, d) of their left null space).

    The basis is None for more than ``DENSE_ROWS`` rows; ``group`` (n,) is the index of the node of each column,
    ``holds`` (bool) selects the rows that are active.
    """
    loops = in_loops(B, group)
    loops = loops[holds[loops]]
    return loops, (None if len(loops) > DENSE_ROWS else _left_null(B.dense(loops)))


def in_loops(B: Entries, group: np.ndarray) -> np.ndarray:
    """Return the indices (n,) of the rows of B in closed loops; ``group`` (n_q,) are the nodes of its columns.

    Rows whose columns of one node are independent of all other rows are removed repeatedly: open chains are removed
    from their ends, closed loops remain.
    """
    alive = np.ones(B.shape[0], bool)
    blocks = [_block(B, entries) for entries in _by_node(B, group)]
    nodes_of: list[list[int]] = [[] for _ in range(B.shape[0])]
    for node, (rows, _) in enumerate(blocks):
        for row in rows:
            nodes_of[row].append(node)
    todo = set(range(len(blocks)))
    while todo:
        rows, block = blocks[todo.pop()]
        kept = alive[rows]
        rows, block = rows[kept], block[kept]
        if 0 < len(rows) <= block.shape[1] and np.linalg.svd(block, compute_uv=False)[-1] > 1e-6:
            alive[rows] = False
            todo.update(other for row in rows for other in nodes_of[row])
    return np.flatnonzero(alive)


def _by_node(B, group):
    """Return, for each constrained node, the indices of its entries of B."""
    node = group[B.cols]
    order = np.argsort(node, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(node[order])) + 1)


def _block(B, entries):
    """Return (rows (m,) of some entries, dense matrix (m, n) of these rows and of the columns of the entries)."""
    rows, i = np.unique(B.rows[entries], return_inverse=True)
    cols, j = np.unique(B.cols[entries], return_inverse=True)
    block = np.zeros((len(rows), len(cols)))
    block[i, j] = B.values[entries]
    return rows, block


def _left_null(B):
    """Return an orthonormal basis (m, d) of the y with B^T y = 0."""
    if not B.size:
        return np.eye(B.shape[0])
    U, sigma, _ = np.linalg.svd(B, full_matrices=True)
    return U[:, int(np.sum(sigma > RANK_TOLERANCE)) :]


def _repeated(null, of_rates):
    """Choose the constraints on velocities to release because those on positions imply them (docs/theory.md, 3).

    They are chosen one by one, the first among equals, until no redundancy in ``null`` (m, d) involves both kinds.
    Returns their rows (r,); these rows (r, m) of the projector on the reactions of constraints on velocities that
    reactions of constraints on positions can balance; and the left null space (m, d - r) of the other rows.
    """
    rows, balanced = [], np.zeros((len(null), 0))
    while null.shape[1] and of_rates.any():
        _, sigma, Vt = np.linalg.svd(null[~of_rates], full_matrices=False)
        mixed = null @ Vt[sigma > RANK_TOLERANCE].T
        mixed[~of_rates] = 0.0
        size = np.linalg.norm(mixed, axis=1)
        if size.max() <= SHARE:
            break
        row = int(np.argmax(size >= NEARLY * size.max()))
        rows.append(row)
        balanced = np.column_stack([balanced, mixed @ mixed[row]])
        null = null @ np.linalg.svd(null[row : row + 1])[2][1:].T
    return rows, balanced[rows] @ np.linalg.pinv(balanced), null


def _spread(block, rows, cols, n):
    """Return a sparse matrix (n, n) with the dense ``block`` at ``rows`` and ``cols``, without rounding errors."""
    i, j = np.nonzero(np.abs(block) >= SHARE)
    return sparse_rows(rows[i], cols[j], block[i, j], n)


def _null_projector(B, rank):
    """Return the projector (n, n) on the motions dq with B dq = 0."""
    if not rank:
        return np.eye(B.shape[1])
    _, _, Vt = np.linalg.svd(B, full_matrices=False)
    span = Vt[:rank]
    return np.eye(B.shape[1]) - span.T @ span


def _directions(system, projector, loops, size):
    """Return the projector (n_l, n_l), a block for each element, on the directions of its reactions in redundancies.

    Directions, not rows, make the result independent of the axes in which the constraints are written.
    """
    place = {row: i for i, row in enumerate(loops)}
    rows, cols, values = [], [], []
    for element in (rows for batch in system.batches for rows in batch.multipliers):
        members = [row for row in element if row in place]
        if not members:
            continue
        at = [place[row] for row in members]
        scale = 1.0 / size[members]
        block = scale[:, None] * projector[np.ix_(at, at)] * scale
        share, direction = np.linalg.eigh(block)
        direction = direction[:, share > SHARE * np.max(scale, initial=0.0) ** 2]
        rows += np.repeat(members, len(members)).tolist()
        cols += members * len(members)
        values += (direction @ direction.T).ravel().tolist()
    kept = np.abs(values) >= SHARE
    return sparse_rows(
        np.array(rows, np.int64)[kept], np.array(cols, np.int64)[kept], np.array(values, float)[kept], system.n_l
    )


def groups(
    projector: np.ndarray, names: Sequence[EquationName], every: Callable[[], Iterable[EquationName]] = tuple
) -> tuple[Group, ...]:
    """Return the Groups of ``names`` that a ``projector`` couples, each with its dimension.

    Groups with the same names, such as those of one joint about two axes, are merged, and list a name twice.
    ``every()`` returns the names of all constraints, ``names`` included; it is called only if there are groups, as a
    large model has many names.
    """
    taking_part = np.flatnonzero(np.diag(projector) > SHARE)
    if not len(taking_part):
        return ()
    found: dict[tuple[EquationName, ...], tuple[int, list[EquationName]]] = {}
    for component in connected(np.abs(projector[np.ix_(taking_part, taking_part)]) > SHARE):
        members = taking_part[component]
        of = [names[i] for i in members]
        count, alike = found.get(tuple(dict.fromkeys(of)), (0, []))
        count += int(round(float(np.trace(projector[np.ix_(members, members)]))))
        found[tuple(dict.fromkeys(of))] = count, [*alike, *of]
    totals = Counter(name.place for name in every())
    return tuple(Group(count, tuple(of), totals) for count, of in found.values())


def connected(coupled: np.ndarray) -> Iterator[np.ndarray]:
    """Yield the masks (n,) of the connected components of the graph with edges ``coupled`` (n, n) bool."""
    coupled, unvisited = coupled | coupled.T, np.ones(len(coupled), bool)
    while unvisited.any():
        component, reached = np.zeros_like(unvisited), np.zeros_like(unvisited)
        reached[np.argmax(unvisited)] = True
        while reached.any():
            component |= reached
            reached = coupled[reached].any(axis=0) & ~component
        unvisited &= ~component
        yield component
