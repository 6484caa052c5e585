"""Symbolic analysis of a fixed pattern for the multifrontal LU factorization: done once, in NumPy.

The pattern is made symmetric and compressed to *blocks*. A block holds either the unknowns of one node, which
are eliminated together, or the multipliers that constrain the same nodes. The nodes are ordered by minimum degree.
Each block of multipliers follows the **last** of the nodes it constrains: only then has elimination filled its zero
diagonal with ``-B S^-1 B^T``, so that there is no null pivot although the order is fixed. The pivot of a multiplier
placed after the first of its nodes would lack the other nodes: backward errors of order 0.1.

The elimination tree of the blocks is cut into *fronts*, dense matrices that eliminate a few blocks at once and
pass the rest, the contribution, to their parent (Duff & Reid 1983, "The multifrontal solution of indefinite
sparse symmetric linear equations", ACM TOMS 9; Liu 1992, SIAM Review 34).
"""

import hashlib
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numpy as np

from mecano.jit.memory import LANES
from mecano.maths.distinct import distinct
from mecano.solve.linear.least_degree import least_degree

# Columns of the table of fronts
FIRST = 0  # position, in elimination order, of the first unknown that the front eliminates
PIVOTS = 1  # number of unknowns that it eliminates
SIZE = 2  # number of rows: pivots, then the border
BORDER = 3  # offset in links: positions of the border rows (SIZE - PIVOTS), ascending
PARENT_ROWS = 4  # offset in links: rows of the parent front that the border rows are
LAST_CHILD = 5  # front, or -1
ELDER = 6  # previous child of the same parent, or -1
ENTRIES = 7  # offset in links: pairs (index in data, row in the front times 2**ROW_BITS plus column)
ENTRY_COUNT = 8
CONTRIBUTION = 9  # offset in the stack of contributions
FACTOR = 10  # offset in the factors
COLUMNS = 11

ROW_BITS, COLUMN_BITS = 16, 0xFFFF  # of a place in a front; larger fronts would take 30 GB
STRIP = LANES  # pivots handled in one sweep; rows of fronts are stored with a stride rounded up to it

FRONT_WORK = 2000.0  # overhead of one front, in floating point operations
WEIGHTS = 30  # extra nodes, which raise the degree of others above that of most models
Count = TypeVar("Count", int, np.ndarray)
MOST_ENTRIES = 1_000_000  # entries placed at a time


class Analysis(NamedTuple):
    """Symbolic factorization of a pattern: the constant tables of the compiled factorization."""

    order: np.ndarray  # (n,) unknown at each position of the elimination
    fronts: np.ndarray  # (n_fronts, COLUMNS), children before parents
    links: np.ndarray  # index lists of the fronts, one after the other
    equations: np.ndarray  # (n + 1 + 2 nnz,) row starts, then columns and indices in data of the entries by rows
    factor_length: int
    stack_length: int
    largest: int  # rows of the largest front
    ends: np.ndarray  # front after the last one of each part; the last part is eliminated after the others


class Pattern(NamedTuple):
    """The entries of a matrix that may differ from zero, and the order in which its unknowns may be eliminated.

    Attributes
    ----------
    n : int
        Number of equations and unknowns, at least 1; those from n_q on are of multipliers, each of which follows the
        last of the unknowns that it ties.
    rows, cols : (nnz,) int
        Each entry once, in any order. Structural symmetry is not required.
    groups : (n_q,) int
        Unknowns of the same group (those of one node) are eliminated together.
    parts : (n,) int, optional
        Part of each unknown (model/halves.py): no entry couples parts other than with the last one. The unknowns of a
        group belong to the same part, multipliers to the part of their unknowns, or to the last one.
    """

    n: int
    rows: np.ndarray
    cols: np.ndarray
    groups: np.ndarray
    parts: np.ndarray | None = None


def analyse(pattern: Pattern) -> Analysis:
    """Order the unknowns of a Pattern and lay out the fronts.

    Raises ValueError if it has an entry twice, MemoryError if a front has more than COLUMN_BITS unknowns.
    """
    n, parts, n_q = pattern.n, pattern.parts, len(pattern.groups)
    rows, cols, groups = (np.asarray(given, np.int64) for given in pattern[1:4])
    nodes = np.unique(groups, return_inverse=True)[1].reshape(-1)
    n_nodes = int(nodes.max()) + 1 if n_q else 0
    position = _position(rows, cols, nodes, n_q, n_nodes, parts)
    ties = _ties(rows, cols, nodes, n_q, n_nodes)
    parts = np.zeros(n, np.int64) if parts is None else parts
    block, part = _insert_multipliers(n, nodes, n_nodes, position, ties, parts)
    n_blocks, starts = len(part), np.searchsorted(part, np.arange(part[-1] + 1))
    structures, parent = _structures(_neighbours(block[rows], block[cols], n_blocks))
    final = _final_order(parent, part, [*starts, n_blocks])
    structures = [np.sort(final[structures[b]]) for b in np.argsort(final)]
    block = final[block]
    sizes = np.bincount(block, minlength=n_blocks)
    ends, borders = _join(structures, sizes, frozenset(starts.tolist()))
    return _tables(n, rows, cols, block, sizes, ends, borders, np.searchsorted(ends, [*starts[1:], n_blocks]) + 1)


def _position(rows, cols, nodes, n_q, n_nodes, parts):
    """Return the position (n_nodes,) of each node in the order of elimination, by minimum degree."""
    own = (rows < n_q) & (cols < n_q)
    neighbours = _neighbours(nodes[rows[own]], nodes[cols[own]], n_nodes)
    if parts is None:
        return least_degree(neighbours)
    position = least_degree(_with_weights(neighbours, np.unique(nodes[parts[:n_q] == parts.max()])))
    return np.argsort(np.argsort(position[:n_nodes]))


def _final_order(parent, part, bounds):
    """Return the rank of each block: a postorder of the elimination tree of each part, which ends at a bound."""
    own_parent = np.where(part[parent] == part, parent, -1)  # roots have any part, and the parent -1
    ranks = [start + _postorder(np.maximum(own_parent[start:end] - start, -1)) for start, end in pairwise(bounds)]
    return np.concatenate(ranks)


def _ties(rows, cols, nodes, n_q, n_nodes):
    """Return the distinct pairs of a multiplier (numbered from 0) and a node it constrains, as two arrays."""
    below = (rows >= n_q) & (cols < n_q)
    right = (cols >= n_q) & (rows < n_q)
    multiplier = np.concatenate([rows[below], cols[right]]) - n_q
    node = nodes[np.concatenate([cols[below], rows[right]])]
    pairs = np.sort(multiplier * n_nodes + node)
    return np.divmod(pairs[np.diff(pairs, prepend=-1) > 0], max(n_nodes, 1))


def _neighbours(block_rows, block_cols, n_blocks):
    """Return the symmetric graph of blocks without loops: for each block, an ascending array of its neighbours."""
    off = block_rows != block_cols
    pairs = distinct(block_rows[off] * n_blocks + block_cols[off])  # nodes of 6 unknowns have 36 entries per pair
    i, j = np.divmod(pairs, max(n_blocks, 1))
    i, j = np.divmod(distinct(np.concatenate([pairs, j * n_blocks + i])), max(n_blocks, 1))
    return np.split(j, np.searchsorted(i, np.arange(1, n_blocks)))[:n_blocks]


def _with_weights(neighbours, last):
    """Return the graph with WEIGHTS further nodes, coupled to each other and to the nodes ``last``.

    Minimum degree then eliminates the other nodes first, towards these. Otherwise it might eliminate a chain of nodes
    from the cut to its end, and every node would fill the border with the node at the cut.
    """
    weights = np.arange(len(neighbours), len(neighbours) + WEIGHTS)
    found = [*neighbours, *(np.concatenate([last, weights[weights != one]]) for one in weights)]
    for node in last:
        found[node] = np.concatenate([found[node], weights])
    return found


def _insert_multipliers(n, nodes, n_nodes, position, ties, parts):
    """Return the block (n,) of each unknown, in elimination order, and the part of each block, ascending."""
    n_q = len(nodes)
    last = np.full(n - n_q, -1)
    np.maximum.at(last, ties[0], position[ties[1]])
    last[last < 0] = n_nodes
    # multipliers that constrain the same nodes share a block: sets of nodes are compared by a sum of random marks
    marks = np.frombuffer(hashlib.shake_128().digest(8 * n_nodes), np.uint64)  # numpy.random takes 5 ms to import
    mark = np.zeros(n - n_q, dtype=np.uint64)
    np.add.at(mark, ties[0], marks[ties[1]])
    _, first, label = np.unique(mark, return_index=True, return_inverse=True)
    label = np.argsort(np.argsort(first))[label.reshape(-1)]  # in the order of the multipliers, not of the marks
    block_last = np.empty(len(first), dtype=np.int64)
    block_last[label] = last
    keys = np.concatenate([2 * position, 2 * block_last + 1])
    vertices, part = np.concatenate([nodes, n_nodes + label]), np.zeros(len(keys), dtype=np.int64)
    np.maximum.at(part, vertices, parts)
    rank, order = np.empty(len(keys), dtype=np.int64), np.lexsort((keys, part))
    rank[order] = np.arange(len(keys))
    return rank[vertices], part[order]


def _structures(neighbours):
    """Return, for each block, the later blocks that its elimination couples (ascending), and the elimination tree."""
    n = len(neighbours)
    structures: list[np.ndarray] = []
    parent = np.full(n, -1)
    children: list[list[int]] = [[] for _ in range(n)]
    for j, own in enumerate(neighbours):
        parts = [own[own > j]] + [structures[c][1:] for c in children[j]]
        structure = distinct(np.concatenate(parts)) if children[j] else parts[0]
        structures.append(structure)
        if len(structure):
            parent[j] = structure[0]
            children[structure[0]].append(j)
    return structures, parent


def _postorder(parent):
    """Return the rank of each vertex of a forest in postorder: a parent directly follows its last child's subtree."""
    n = len(parent)
    rank = np.empty(n, dtype=np.int64)
    size = np.ones(n, dtype=np.int64)
    for v in range(n):
        if parent[v] >= 0:
            size[parent[v]] += size[v]
    begin = np.zeros(n + 1, dtype=np.int64)  # next free rank below each vertex; the last one: of the roots
    for v in range(n - 1, -1, -1):
        start = begin[parent[v]]
        begin[parent[v]] += size[v]
        begin[v] = start
        rank[v] = start + size[v] - 1
    return rank


def _join(structures, sizes, starts):
    """Join blocks into fronts: each block with the preceding one, its child, if that saves time.

    ``starts``: the first blocks of the parts, with which a front begins. Returns the index of the block after each
    front, and the border of each front (blocks, ascending).
    """
    widths = [int(sizes[s].sum()) for s in structures]
    ends, borders = [], []
    pivots, last = int(sizes[0]), 0
    for j in range(1, len(sizes)):
        size = int(sizes[j])
        if len(structures[last]) and structures[last][0] == j and j not in starts:
            apart = _work(pivots, widths[last]) + _work(size, widths[j])
            if _work(pivots + size, widths[j]) <= apart + FRONT_WORK:
                pivots, last = pivots + size, j
                continue
        ends.append(j)
        borders.append(structures[last])
        pivots, last = size, j
    return np.array([*ends, len(sizes)]), [*borders, structures[last]]


def _work(pivots, width):
    """Return the number of floating point operations for a front with these pivots and border of this width."""
    return pivots * (pivots * (2.0 / 3.0 * pivots + 2.0 * width) + 2.0 * width**2)


def _ranges(starts, lengths):
    """Return the concatenation of the ranges starts[i] ... starts[i] + lengths[i] - 1."""
    offsets = np.cumsum(lengths) - lengths
    return np.arange(int(lengths.sum())) + np.repeat(starts - offsets, lengths)


def _offsets(lengths):
    """Return the offsets of consecutive pieces of these lengths, and the end of the last one."""
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)


def _tables(n, rows, cols, block, sizes, ends, borders, part_ends):
    """Number the unknowns within the blocks and write the tables of the fronts."""
    order = np.argsort(block, kind="stable")
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    starts = _offsets(sizes)
    first = starts[np.r_[0, ends[:-1]]]
    pivots = starts[ends] - first
    counts = np.array([len(b) for b in borders])
    border_blocks = np.concatenate(borders).astype(np.int64)
    border_rows = _ranges(starts[border_blocks], sizes[border_blocks])
    border_of = np.repeat(np.arange(len(ends)), counts)
    widths = np.bincount(border_of, weights=sizes[border_blocks], minlength=len(ends)).astype(np.int64)
    fronts = np.empty((len(ends), COLUMNS), dtype=np.int64)
    fronts[:, FIRST], fronts[:, PIVOTS], fronts[:, SIZE] = first, pivots, pivots + widths
    if (largest := int(fronts[:, SIZE].max())) > COLUMN_BITS:
        raise MemoryError(f"a front of {largest} unknowns")
    parent = _family(fronts, border_rows, _offsets(widths))
    links = _link(fronts, parent, border_rows, place[rows], place[cols])
    factor_length, stack_length = _storage(fronts, part_ends)
    return Analysis(order, fronts, links, _by_rows(n, rows, cols), factor_length, stack_length, largest, part_ends)


def _family(fronts, border_rows, border_starts):
    """Fill in LAST_CHILD and ELDER; return the parent of each front, -1 for roots."""
    widths = np.diff(border_starts)
    parent = np.full(len(fronts), -1)
    inner = widths > 0
    parent[inner] = np.searchsorted(fronts[:, FIRST], border_rows[border_starts[:-1][inner]], side="right") - 1
    fronts[:, LAST_CHILD] = fronts[:, ELDER] = -1
    for f in np.flatnonzero(inner):
        fronts[f, ELDER] = fronts[parent[f], LAST_CHILD]
        fronts[parent[f], LAST_CHILD] = f
    return parent


def _link(fronts, parent, border_rows, row_place, col_place):
    """Write the index lists: border rows, their rows in the parent, entries of the matrix."""
    n_fronts = len(fronts)
    n = int(fronts[-1, FIRST] + fronts[-1, PIVOTS])
    widths = fronts[:, SIZE] - fronts[:, PIVOTS]
    border_of = np.repeat(np.arange(n_fronts), widths)
    border_starts, keys = _offsets(widths), border_of * n + border_rows

    def row_in(front, place):
        """Return the row, in a front, of the unknown at an elimination position."""
        row, pivots = place - fronts[front, FIRST], fronts[front, PIVOTS]
        border = np.flatnonzero(row >= pivots)
        at = front[border]
        row[border] = pivots[border] + np.searchsorted(keys, at * n + place[border]) - border_starts[at]
        return row

    def target_of(entries):
        """Return the places, in their fronts, of some entries of the matrix."""
        at = front[entries]
        found = (row_in(at, row_place[entries]) << ROW_BITS) + row_in(at, col_place[entries])
        return found.astype(np.uint32)

    parent_rows = row_in(parent[border_of], border_rows)
    front = np.searchsorted(fronts[:, FIRST], np.minimum(row_place, col_place), side="right") - 1
    by_front = np.argsort(front, kind="stable")
    parts = np.array_split(by_front, 1 + len(by_front) // MOST_ENTRIES)  # for the memory of large models
    target = np.concatenate([target_of(part) for part in parts])
    entry_starts = _offsets(np.bincount(front, minlength=n_fronts))
    fronts[:, BORDER] = border_starts[:-1]
    fronts[:, PARENT_ROWS] = border_starts[:-1] + len(border_rows)
    fronts[:, ENTRIES] = 2 * (len(border_rows) + entry_starts[:-1])
    fronts[:, ENTRY_COUNT] = np.diff(entry_starts)
    pairs = np.column_stack([by_front.astype(np.uint32), target]).ravel()
    return np.concatenate([border_rows.astype(np.uint32), parent_rows.astype(np.uint32), pairs])


def _storage(fronts, part_ends):
    """Fill in CONTRIBUTION and FACTOR; return the lengths of the factors and of the stacks, one for each part."""
    widths = fronts[:, SIZE] - fronts[:, PIVOTS]
    lengths = padded(fronts[:, PIVOTS]) * (padded(fronts[:, SIZE]) + widths)
    offsets = _offsets(lengths)
    fronts[:, FACTOR] = offsets[:-1]
    peak = 0
    for begin, end in pairwise([0, *part_ends]):
        top = peak
        for f in range(begin, end):
            child = fronts[f, LAST_CHILD]
            while child >= begin:  # the contributions of other parts stay on their stacks
                top = fronts[child, CONTRIBUTION]
                child = fronts[child, ELDER]
            fronts[f, CONTRIBUTION] = top
            top += widths[f] ** 2
            peak = max(peak, top)
    return int(offsets[-1]), int(peak)


def padded(count: Count) -> Count:
    """Return the count rounded up to a multiple of STRIP."""
    return (count + STRIP - 1) // STRIP * STRIP


def work_length(largest: int) -> int:
    """Return the numbers of work for fronts of up to ``largest`` rows: the front, and two integers for each row."""
    return largest * (padded(largest) + 2)


def _by_rows(n, rows, cols):
    """Return the pattern by rows, for the residual: row starts, columns of the entries, their indices in data."""
    keys = rows * n + cols
    by_row = np.argsort(keys, kind="stable")
    if not np.all(np.diff(keys[by_row])):
        raise ValueError("the pattern of the matrix holds an entry twice")
    starts = _offsets(np.bincount(rows, minlength=n))
    return np.concatenate([starts, cols[by_row], by_row]).astype(np.uint32)
