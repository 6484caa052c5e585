"""What the constraints do to a model: redundant groups and remaining mechanisms, by name.

Both come from projectors of the scaled constraint gradient B, which do not depend on the choice of a basis: the
left null space of B couples the constraints that repeat one another, its null space the unknowns that can move.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from mecano.model.numbering import ROTATION, motion_name

RANK_TOLERANCE = 1e-9  # singular values of rows of unit length below this count as zero
SHARE = 1e-7  # entries of a projector below this count as zero
NEARLY = 0.99  # of the largest: as large
DENSE_ROWS = 3000  # beyond this many constraints in closed loops, or unknowns, no singular values are computed


@dataclass(frozen=True)
class Group:
    """Constraints that repeat one another, or unknowns that move together: ``count`` of them too many, or free."""

    count: int
    names: tuple


@dataclass(frozen=True)
class Analysis:
    """Mobility of a model at one configuration.

    ``complete`` is False where too many constraints in closed loops leave the rank unknown; ``mechanisms`` is None
    where that, or too many unknowns, keeps them from being named.
    """

    unknowns: int
    constraints: int
    rank: int
    redundant: tuple  # Group
    mechanisms: tuple | None  # Group
    dependent: sp.csr_matrix  # projector on the reactions that take part in a redundancy, see ``_directions``
    let_go: sp.csr_matrix  # (n_l, n_l): its rows times the reactions vanish, instead of constraints; see ``_repeated``
    complete: bool = True

    @property
    def mobility(self):
        """Number of independent motions that the constraints leave."""
        return self.unknowns - self.rank

    @property
    def released(self):
        """Constraints (n,) that are let go."""
        return np.flatnonzero(np.diff(self.let_go.indptr))


def analyse(system, s, length):
    """Redundant constraints and mechanisms of ``system`` at ``s``; rotations are counted by the length scale."""
    B, size, holds = gradient(system, s, length)
    of = system.numbering
    loops, n_l = _in_loops(B, of.group), int(holds.sum())
    loops = loops[holds[loops]]
    if len(loops) > DENSE_ROWS:
        every, none = sp.diags(holds.astype(float), format="csr"), sp.csr_matrix((system.n_l, system.n_l))
        return Analysis(system.n_q, n_l, n_l, (), None, every, none, False)
    null = _left_null(B[loops].toarray())
    projector, deficiency = null @ null.T, null.shape[1]
    names = of.name[system.n_q : system.n]
    redundant = _groups(projector, [names[i] for i in loops])
    rank = n_l - deficiency
    mechanisms = None
    if system.n_q <= DENSE_ROWS:
        motions = [motion_name(name) for name in of.name[: of.n_q]]
        mechanisms = _groups(_null_projector(B.toarray(), rank), motions)
    rows, shares, null = _repeated(null, of.of_rates[loops])
    dependent = _directions(system, null @ null.T, loops, size)
    let_go = _spread(shares * size[loops] / size[loops[rows], None], loops[rows], loops, system.n_l)
    return Analysis(system.n_q, n_l, rank, redundant, mechanisms, dependent, let_go)


def gradient(system, s, length):
    """B = dPhi/dq (n_l, n_q), sparse; columns of rotations over the length scale, rows of length 1; sizes; what holds.

    A constraint that is let go in the present modes has a diagonal entry, and no gradient.
    """
    bare = s.copy()
    bare.z[system.n_q : system.n] = 0.0
    data = np.zeros(system.nnz + 1)
    system.add_constraints(bare, 1.0, 0.0, data)
    full = sp.csr_matrix((-data[:-1], (system.rows, system.cols)), shape=(system.n, system.n))
    B = full[system.n_q :, : system.n_q]
    B = B @ sp.diags(np.where(system.numbering.kind[: system.n_q] == ROTATION, 1.0 / length, 1.0))
    size = np.sqrt(np.asarray(B.multiply(B).sum(axis=1)).ravel())
    size = np.where(size > 0, size, 1.0)
    B = sp.csr_matrix(sp.diags(1.0 / size) @ B)
    B.data[np.abs(B.data) < 1e-14] = 0.0
    B.eliminate_zeros()
    return B, size, data[system.diagonal[system.n_q :]] == 0.0


def _in_loops(B, group):
    """Rows that are left when those are peeled off which a node of their own makes independent, again and again.

    What hangs on a chain peels off from its end; only closed loops stay.
    """
    columns = sp.csc_matrix(B)
    members = _members(group, np.flatnonzero(np.diff(columns.indptr)))
    alive = np.ones(B.shape[0], bool)
    touched = [np.unique(columns[:, m].indices) for m in members]
    nodes_of = [[] for _ in range(B.shape[0])]
    for node, rows in enumerate(touched):
        for row in rows:
            nodes_of[row].append(node)
    todo = set(range(len(members)))
    while todo:
        node = todo.pop()
        rows = touched[node][alive[touched[node]]]
        if not 0 < len(rows) <= len(members[node]):
            continue
        block = B[rows][:, members[node]].toarray()
        if np.linalg.svd(block, compute_uv=False)[-1] > 1e-6:
            alive[rows] = False
            todo.update(other for row in rows for other in nodes_of[row])
    return np.flatnonzero(alive)


def _members(group, tied):
    """Unknowns (n,) of each group that has one of the unknowns ``tied`` (m,)."""
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    touched = np.isin(group[order][starts], group[tied])
    return [some for some, one in zip(np.split(order, starts[1:]), touched, strict=True) if one]


def _left_null(B):
    """Orthonormal basis (m, d) of the y with B^T y = 0."""
    if not B.size:
        return np.eye(B.shape[0])
    U, sigma, _ = np.linalg.svd(B, full_matrices=True)
    return U[:, int(np.sum(sigma > RANK_TOLERANCE)) :]


def _repeated(null, of_rates):
    """Constraints on velocities that are let go because those on positions imply them (docs/theory.md, section 3).

    They are taken one by one until no redundancy in ``null`` (m, d) is of both kinds; of those that are equally suited
    the first. Returns their rows (r,); of the projector on the reactions of constraints on velocities that those on
    positions could balance the same rows (r, m); and the null space (m, d - r) of the others.
    """
    rows, balanced = [], np.zeros((len(null), 0))
    while of_rates.any():
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
    """The dense ``block`` in a sparse matrix (n, n), without what is rounding."""
    block = np.where(np.abs(block) < SHARE, 0.0, block)
    i, j = np.nonzero(block)
    return sp.csr_matrix((block[i, j], (rows[i], cols[j])), shape=(n, n))


def _null_projector(B, rank):
    """Projector (n, n) on the motions dq with B dq = 0."""
    if not rank:
        return np.eye(B.shape[1])
    _, _, Vt = np.linalg.svd(B, full_matrices=False)
    span = Vt[:rank]
    return np.eye(B.shape[1]) - span.T @ span


def _directions(system, projector, loops, size):
    """Projector (n_l, n_l), a block for each element, on the directions of its reactions that redundancies make use of.

    The directions, not the rows: what it does not hold is the same in whatever axes the constraints are written.
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
    found = sp.csr_matrix((values, (rows, cols)), shape=(system.n_l, system.n_l))
    found.data[np.abs(found.data) < SHARE] = 0.0
    found.eliminate_zeros()
    return found


def _groups(projector, names):
    """Groups of things that a projector couples, with the number of dimensions of each."""
    taking_part = np.flatnonzero(np.diag(projector) > SHARE)
    if not len(taking_part):
        return ()
    block = np.abs(projector[np.ix_(taking_part, taking_part)]) > SHARE
    n, label = connected_components(sp.csr_matrix(block), directed=False)
    found = []
    for g in range(n):
        members = taking_part[label == g]
        count = int(round(float(np.trace(projector[np.ix_(members, members)]))))
        found.append(Group(count, tuple(dict.fromkeys(names[i] for i in members))))
    return tuple(found)
