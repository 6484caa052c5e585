"""Mobility of a model: groups of redundant constraints and remaining mechanisms, by name.

Both follow from projectors of the scaled constraint gradient B, which do not depend on the choice of a basis: the left
null space of B couples redundant constraints, its null space couples unknowns that can move.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from mecano.immutable import immutable
from mecano.maths.sparse_rows import SparseRows, sparse_rows
from mecano.model.numbering import ROTATION, EquationName
from mecano.solve.diagnostics.constraint_names import by_joint
from mecano.solve.diagnostics.null_space import RANK_TOLERANCE, Entries, NullSpace, left_null_space, rows_by_groups

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System

SHARE = 1e-7  # entries of a projector below this count as zero
NEARLY = 0.99  # of the largest value: larger ones count as equal to it
MANY = 100_000  # unknowns above which free motions are not listed


@immutable
class Group:
    """Constraints with ``count`` redundancies, or unknowns that move together in ``count`` free motions."""

    count: int
    names: tuple[EquationName, ...]
    totals: dict[str, int] = field(default_factory=dict)  # place of a name -> number of its constraints

    def by_joint(self, most: int) -> list[str]:
        """Describe the constraints in one text per set of similar joints, naming up to ``most`` joints in each."""
        return by_joint(self.names, self.totals, most)


@immutable
class Analysis:
    """Mobility of a model at one configuration."""

    rank: int
    redundant: tuple[Group, ...]
    dependent: SparseRows | None  # projector (n_l, n_l) on the reactions in redundancies, see ``_directions``
    release_matrix: SparseRows | None  # (n_l, n_l) whose rows times reactions vanish, see ``_repeated``
    gradient: Entries
    group: np.ndarray  # (n_q,) nodes of the unknowns
    names: Sequence[EquationName]  # of the unknowns first, then of others
    signals: np.ndarray  # (n_q,) bool: unknowns that are signals, not motions
    active: np.ndarray  # (n_l,) bool: constraints that hold in the phases of the configuration

    @property
    def mobility(self) -> int:
        """Number of independent motions that the constraints allow."""
        return self.gradient.shape[1] - self.rank - int(self.signals.sum())

    @cached_property
    def mechanisms(self) -> tuple[Group, ...] | None:
        """Groups of unknowns that can move together; None if there are too many unknowns.

        Computed on demand, because a run does not need it.
        """
        if self.gradient.shape[1] > MANY:
            return None
        return groups(allowed_motions(self.gradient, self.group, ~self.signals), self.motions)

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
    null = left_null_space(B, of.group, holds)
    loops, rank = null.members, int(holds.sum()) - null.dimension
    redundant = groups(null, of.name[of.n_q :], lambda: of.name[of.n_q : of.n_q + system.n_l])
    release_matrix = None
    if of.of_rates[loops].any():
        rows, shares, basis = _repeated(null.dense(loops), of.of_rates[loops])
        if rows:
            null = NullSpace(system.n_l, ((loops, basis),))
            shares = shares * size[loops] / size[loops[rows], None]
            release_matrix = _spread(shares, loops[rows], loops, system.n_l)
    dependent = _directions(system, null, size) if null.dimension else None
    return Analysis(rank, redundant, dependent, release_matrix, B, of.group, of.name, system.signals, holds)


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


def allowed_motions(B: Entries, group: np.ndarray, moves: np.ndarray) -> NullSpace:
    """Return the space of motions (n_q,) with B dq = 0 of the unknowns that ``moves`` (n_q,) bool selects.

    ``group`` (n_q,) are the nodes of the unknowns; constraints between the same nodes are eliminated together.
    """
    between = np.zeros(B.shape[0], np.int64)
    for number, rows in enumerate(rows_by_groups(B, group, np.arange(B.shape[0])).values()):
        between[rows] = number
    return left_null_space(B.transpose, between, moves)


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


def _directions(system, null, size):
    """Return the projector (n_l, n_l), a block for each element, on the directions of its reactions in redundancies.

    Directions, not rows, make the result independent of the axes in which the constraints are written.
    """
    of_element, number = np.full(system.n_l, -1), 0
    for element in (rows for batch in system.batches for rows in batch.multipliers):
        of_element[element], number = number, number + 1
    rows, cols, values = [], [], []
    for members, projector in null.among(of_element).values():
        scale = 1.0 / size[members]
        share, direction = np.linalg.eigh(scale[:, None] * projector * scale)
        direction = direction[:, share > SHARE * np.max(scale, initial=0.0) ** 2]
        rows.append(np.repeat(members, len(members)))
        cols.append(np.tile(members, len(members)))
        values.append((direction @ direction.T).ravel())
    entries = np.concatenate(values)
    kept = np.abs(entries) >= SHARE
    return sparse_rows(np.concatenate(rows)[kept], np.concatenate(cols)[kept], entries[kept], system.n_l)


def groups(
    null: NullSpace, names: Sequence[EquationName], every: Callable[[], Iterable[EquationName]] = tuple
) -> tuple[Group, ...]:
    """Return the Groups of ``names`` (n,) that the vectors of a space couple, each with its dimension.

    Groups with the same names, such as those of one joint about two axes, are merged, and list a name twice.
    ``every()`` returns the names of all constraints, ``names`` included; it is called only if there are groups, as a
    large model has many names.
    """
    found: dict[tuple[EquationName, ...], tuple[int, list[EquationName]]] = {}
    for members in null.components():
        of = [names[i] for i in members]
        count, alike = found.get(tuple(dict.fromkeys(of)), (0, []))
        count += int(round(float(null.shares[members].sum())))
        found[tuple(dict.fromkeys(of))] = count, [*alike, *of]
    totals = Counter(name.place for name in every()) if found else Counter()
    return tuple(Group(count, tuple(of), totals) for count, of in found.values())
