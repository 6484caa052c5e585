r"""Null spaces of sparse matrices: orthonormal bases by multifrontal orthogonal elimination.

The left null space of a matrix :math:`B`, of the :math:`y` with :math:`B^T y = 0`, is found front by front. A front
holds all rows with columns of one group, such as the unknowns of a node. Orthogonal combinations of its rows divide
into some that are independent in these columns, which cannot take part in the null space, and others that contain none
of them. The latter are rows of later fronts; those without any column belong to the null space. Groups with few
neighbours come first, so that fronts remain small, and the work grows with the size of a chain or a mast, not with its
cube.
"""

from collections import defaultdict
from collections.abc import Iterator
from functools import cached_property
from heapq import heapify, heappop, heappush
from typing import NamedTuple

import numpy as np

from mecano.immutable import immutable
from mecano.maths.distinct import distinct
from mecano.model.numbering import Classes

RANK_TOLERANCE = 1e-9  # singular values of rows of unit length below this count as zero
PRESENT = 1e-12  # a smaller entry on the diagonal of a projector counts as zero
COUPLED = 1e-10  # the same elsewhere
ROUNDING = 1e-12  # entries of a basis below this are left out


class Entries(NamedTuple):
    """Sparse matrix in coordinate form without duplicate entries."""

    rows: np.ndarray
    cols: np.ndarray
    values: np.ndarray
    shape: tuple[int, int]

    @property
    def transpose(self) -> "Entries":
        """The transposed matrix."""
        return Entries(self.cols, self.rows, self.values, self.shape[::-1])

    def dense(self, rows: np.ndarray) -> np.ndarray:
        """Return the given rows (m,) as a dense matrix (m, n)."""
        place = np.full(self.shape[0], -1)
        place[rows] = np.arange(len(rows))
        at = np.flatnonzero(place[self.rows] >= 0)
        out = np.zeros((len(rows), self.shape[1]))
        out[place[self.rows[at]], self.cols[at]] = self.values[at]
        return out


@immutable
class NullSpace:
    """A space of vectors (n,) with an orthonormal basis in ``blocks``: (ascending indices (m,), basis (m, d)) each."""

    n: int
    blocks: tuple[tuple[np.ndarray, np.ndarray], ...]

    @property
    def dimension(self) -> int:
        """Number of vectors of the basis."""
        return sum(basis.shape[1] for _, basis in self.blocks)

    @cached_property
    def shares(self) -> np.ndarray:
        """Diagonal (n,) of the projector on the space."""
        shares = np.zeros(self.n)
        for at, basis in self.blocks:
            shares[at] += (basis**2).sum(axis=1)
        return shares

    @property
    def members(self) -> np.ndarray:
        """Indices, ascending, of the components that are not zero in all vectors of the space."""
        return np.flatnonzero(self.shares > PRESENT)

    def dense(self, at: np.ndarray) -> np.ndarray:
        """Return the components ``at`` (m,) of the basis as a matrix (m, dimension)."""
        place = np.full(self.n, -1)
        place[at] = np.arange(len(at))
        columns = []
        for own, basis in self.blocks:
            column, kept = np.zeros((len(at), basis.shape[1])), place[own] >= 0
            column[place[own[kept]]] = basis[kept]
            columns.append(column)
        return np.hstack([np.zeros((len(at), 0)), *columns])

    def among(self, sets: np.ndarray) -> dict[int, tuple[np.ndarray, np.ndarray]]:
        """Return for each set its members that are not zero (m,), and their block (m, m) of the projector.

        ``sets`` (n,) are the numbers of the sets of the components; those below zero are left out.
        """
        found: defaultdict[int, list[tuple[np.ndarray, np.ndarray]]] = defaultdict(list)
        for at, basis in self.blocks:
            order = np.argsort(sets[at], kind="stable")
            for own in np.split(order, np.flatnonzero(np.diff(sets[at[order]])) + 1):
                found[int(sets[at[own[0]]])].append((at[own], basis[own]))
        return {number: _projector(parts) for number, parts in sorted(found.items()) if number >= 0}

    def components(self) -> list[np.ndarray]:
        """Return the indices of each set of components that the projector couples, by their first index.

        The blocks of an elimination couple nothing that their space does not: the null space of the rows before a front
        and those of parts of them are sums over sets, and so are the orthogonal complements, which blocks span.
        """
        sets = [at[members] for at, basis in self.blocks for members in _coupled(basis)]
        classes, latest = Classes(len(sets)), np.full(self.n, -1)
        for number, members in enumerate(sets):
            for other in distinct(latest[members]).tolist():
                if other >= 0:
                    classes.join(other, number)
            latest[members] = number
        united = defaultdict(list)
        for number, members in enumerate(sets):
            united[classes.find(number)].append(members)
        return sorted((distinct(np.concatenate(parts)) for parts in united.values()), key=lambda members: members[0])


def _projector(parts):
    """Return (indices (m,), projector (m, m)) from the (indices, basis) of several blocks."""
    members = distinct(np.concatenate([at for at, _ in parts]))
    block = np.zeros((len(members), len(members)))
    for at, basis in parts:
        own = np.searchsorted(members, at)
        block[np.ix_(own, own)] += basis @ basis.T
    return members, block


def _coupled(basis):
    """Yield the indices of each set of rows that the projector of a ``basis`` (m, d) couples.

    A set grows by all rows that the projection of a vector with irregular components in the set reaches.
    """
    irregular = np.sin(np.arange(1.0, len(basis) + 1.0) ** 2)
    left = (basis**2).sum(axis=1) > PRESENT
    while left.any():
        members = np.flatnonzero(left)[:1]
        while True:
            y = basis @ (irregular[members] @ basis[members])
            y[members] = np.inf
            reached = np.flatnonzero((np.abs(y) > COUPLED) & left)
            if len(reached) == len(members):
                break
            members = reached
        left[members] = False
        yield members


class Front:
    """Combinations of rows: the ``basis`` (r, m) of those of the ``parts``, or rows of the matrix in a first front.

    ``blocks`` are their columns (m, c) in each group of columns.
    """

    __slots__ = ("basis", "blocks", "parts", "rows", "size", "weight", "width")

    def __init__(self, blocks, size, parts=(), basis=None, rows=None):
        self.blocks, self.size, self.parts, self.basis, self.rows = blocks, size, parts, basis, rows
        self.width = sum(block.shape[1] for block in blocks.values())
        self.weight = size + sum(front.weight for front in parts)


def left_null_space(B: Entries, group: np.ndarray, holds: np.ndarray | None = None) -> NullSpace:
    """Return the left null space of B; ``group`` (n,) are the groups of its columns, eliminated together.

    Its rows have unit length, or are zero; singular values below RANK_TOLERANCE count as zero. ``holds`` (m,) bool
    selects the rows that count, by default all.
    """
    fronts, empty = _first_fronts(B, group, np.arange(B.shape[0]) if holds is None else np.flatnonzero(holds))
    blocks = [(np.array([row]), np.ones((1, 1))) for row in empty]
    for parts, basis in Elimination(fronts).null_fronts():
        at, basis = _in_rows(parts, basis)
        order = np.argsort(at)
        blocks.append((at[order], basis[order]))
    return NullSpace(B.shape[0], tuple(blocks))


def rows_by_groups(B: Entries, group: np.ndarray, rows: np.ndarray) -> dict[bytes, list[int]]:
    """Return which of the ``rows`` (m,) of B have columns in the same groups, by a code of these."""
    groups = int(group.max(initial=-1)) + 1
    codes = distinct(B.rows * groups + group[B.cols])
    first, last = np.searchsorted(codes, groups * np.array([rows, rows + 1]))
    alike: dict[bytes, list[int]] = {}
    for row, a, b in zip(rows.tolist(), first.tolist(), last.tolist(), strict=True):
        alike.setdefault((codes[a:b] - groups * row).tobytes(), []).append(row)
    return alike


def _first_fronts(B, group, rows):
    """Return the Fronts of the ``rows`` of B, one for all with columns in the same groups, and the rows without any."""
    alike = rows_by_groups(B, group, rows)
    empty, sets = alike.pop(b"", []), [np.array(own) for own in alike.values()]
    return [Front(blocks, len(own), rows=own) for own, blocks in zip(sets, _blocks(B, group, sets), strict=True)], empty


def _blocks(B, group, sets):
    """Return for each of the ``sets`` of rows of B, by group, the columns of a group that are not zero in all of B."""
    groups = int(group.max(initial=-1)) + 1
    of_set, place, local = np.full(B.shape[0], -1), np.zeros(B.shape[0], np.int64), np.zeros(B.shape[1], np.int64)
    for number, own in enumerate(sets):
        of_set[own], place[own] = number, np.arange(len(own))
    used = distinct(B.cols.copy())
    used = used[np.argsort(group[used], kind="stable")]
    widths = np.bincount(group[used], minlength=groups)
    local[used] = np.arange(len(used)) - (np.cumsum(widths) - widths)[group[used]]
    kept = of_set[B.rows] >= 0
    rows, cols = B.rows[kept], B.cols[kept]
    codes = of_set[rows] * groups + group[cols]
    pairs = distinct(codes.copy())
    heights, widths = np.array([len(own) for own in sets], np.int64)[pairs // groups], widths[pairs % groups]
    ends = np.cumsum(heights * widths)
    block = np.searchsorted(pairs, codes)
    entries = np.zeros(ends[-1] if len(ends) else 0)
    entries[(ends - heights * widths)[block] + place[rows] * widths[block] + local[cols]] = B.values[kept]
    blocks: list[dict[int, np.ndarray]] = [{} for _ in sets]
    parts = np.split(entries, ends[:-1])
    for pair, height, width, part in zip(pairs.tolist(), heights.tolist(), widths.tolist(), parts, strict=False):
        blocks[pair // groups][pair % groups] = part.reshape(height, width)
    return blocks


class Elimination:
    """Elimination of groups of columns, those with the fewest columns and rows in their fronts first."""

    def __init__(self, fronts: list[Front]):
        self.touching: defaultdict[int, dict[Front, None]] = defaultdict(dict)
        for front in fronts:
            self._add(front)

    def null_fronts(self) -> "Iterator[tuple[tuple[Front, ...], np.ndarray]]":
        """Yield (parts, basis (r, d)) of the rows of fronts whose d combinations have no columns."""
        heap = [(*self._cost(g), g) for g in self.touching]
        heapify(heap)
        while heap:
            *cost, g = heappop(heap)
            if not self.touching[g]:
                continue
            now = self._cost(g)
            if now > tuple(cost):
                heappush(heap, (*now, g))
                continue
            parts, neighbours = tuple(self.touching[g]), self._neighbours(g)
            kept, null = self._eliminate(g, parts, neighbours)
            if null.shape[1]:
                yield parts, null
            for front in parts:
                self._remove(front)
            if kept is not None:  # the costs of neighbours grow
                self._add(kept)
                continue
            for other in neighbours:
                heappush(heap, (*self._cost(other), other))

    def _eliminate(self, g, parts, neighbours):
        """Return the Front of the rows without columns of ``g``, or None, and the basis (r, d) of those without any."""
        U, rank, _ = _decomposed(np.vstack([front.blocks[g] for front in parts]))
        basis = U[:, rank:]
        if not basis.shape[1] or not neighbours:
            return None, basis
        columns = np.hstack(
            [np.vstack([_columns(front, o, width) for front in parts]) for o, width in neighbours.items()]
        )
        U, rank, columns = _decomposed(basis.T @ columns)
        basis, null = basis @ U[:, :rank], basis @ U[:, rank:]
        if not rank:
            return None, null
        ends = np.cumsum(list(neighbours.values()))
        blocks = dict(zip(neighbours, np.split(columns, ends[:-1], axis=1), strict=True))
        return Front(blocks, rank, parts, basis), null

    def _neighbours(self, g):
        """Return the other groups with columns in the front of ``g``, with the numbers of these, ascending."""
        found = {o: block.shape[1] for front in self.touching[g] for o, block in front.blocks.items() if o != g}
        return dict(sorted(found.items()))

    def _cost(self, g):
        """Return the magnitude of the columns in the front of ``g`` times the rows in and before it, and its own size.

        Fronts thus combine pairs of about the same size, so that most null vectors have few components.
        """
        fronts = self.touching[g]
        columns = sum(front.width for front in fronts)
        return (columns * sum(front.weight for front in fronts)).bit_length(), columns * sum(f.size for f in fronts)

    def _add(self, front):
        for g in front.blocks:
            self.touching[g][front] = None

    def _remove(self, front):
        for g in front.blocks:
            del self.touching[g][front]


def _decomposed(rows):
    """Return orthogonal U (m, m), the rank r, and the rows R (r, n) of a matrix U [R; 0] (m, n)."""
    m, n = rows.shape
    U, sigma, Vt = np.linalg.svd(rows, full_matrices=m > n)
    rank = int(np.sum(sigma > RANK_TOLERANCE))
    return U, rank, sigma[:rank, None] * Vt[:rank]


def _columns(front, g, width):
    return front.blocks[g] if g in front.blocks else np.zeros((front.size, width))


def _in_rows(parts, basis):
    """Return (rows (m,) of the matrix, basis (m, d)) of combinations, given in the rows of ``parts`` (r, d)."""
    todo, rows, values = [(parts, basis)], [np.zeros(0, np.int64)], [np.zeros((0, basis.shape[1]))]
    while todo:
        parts, basis = todo.pop()
        for front, own in zip(parts, np.split(basis, np.cumsum([front.size for front in parts])[:-1]), strict=True):
            if np.abs(own).max(initial=0.0) < ROUNDING:
                continue
            if front.rows is None:
                todo.append((front.parts, front.basis @ own))
            else:
                rows.append(front.rows)
                values.append(own)
    return np.concatenate(rows), np.vstack(values)
