"""Division of a large model into two halves and a separator, so that two threads can work on it.

No entry of the tangent couples one half with the other (George 1973, "Nested dissection of a regular finite element
mesh", SIAM J. Numer. Anal. 10). The halves depend on the model only, not on the number of threads.
"""

import numpy as np

from mecano.maths.distinct import distinct

LARGE = 10_000  # unknowns above which two threads are worth their coordination
PRICE = 4  # of an unknown of the separator, on which only one thread works, in unknowns of a half
MOST = 0.6  # price of the larger half and of the separator, over that of the whole model
ONE, OTHER, BETWEEN = range(3)


def halves(n: int, rows: np.ndarray, cols: np.ndarray, groups: np.ndarray) -> np.ndarray | None:
    """Return the part of each unknown (n,): ONE half, the OTHER one, or the separator BETWEEN them.

    None for a small model, or one that cannot be divided well.

    Parameters
    ----------
    n : int
        Number of unknowns.
    rows, cols : (nnz,) int
        Pattern of the tangent.
    groups : (n_q,) int
        Unknowns of the same group (one node) stay together; multipliers, from n_q on, are alone.
    """
    if n < LARGE:
        return None
    vertices = np.unique(groups, return_inverse=True)[1].reshape(-1)
    n_nodes, n_l = int(vertices.max()) + 1, n - len(groups)
    vertices = np.concatenate([vertices, np.arange(n_nodes, n_nodes + n_l)])
    size = np.bincount(vertices)
    i, j = _edges(vertices[rows], vertices[cols], len(size))
    rank = _breadth_first(i, j, len(size))
    lowest = rank.copy()
    np.minimum.at(lowest, i, rank[j])
    cut = _best_cut(rank, lowest, size)
    part = np.where(rank < cut, ONE, np.where(lowest < cut, BETWEEN, OTHER))
    _place_multipliers(part, i, j, n_nodes)
    found = part[vertices]
    one, other, between = np.bincount(found, minlength=3)
    return found if max(one, other) + PRICE * between <= MOST * n else None


def _edges(i, j, n):
    """Return the pairs of different vertices that entries couple, in both orders, each once."""
    off = i != j
    pairs = distinct(i[off] * n + j[off])  # nodes of 6 unknowns have 36 entries per pair
    i, j = np.divmod(pairs, n)
    return np.divmod(distinct(np.concatenate([pairs, j * n + i])), n)


def _breadth_first(i, j, n):
    """Return the rank (n,) of each vertex in a breadth-first search from a vertex far from the first one."""
    import scipy.sparse as sp
    from scipy.sparse.csgraph import breadth_first_order, connected_components

    graph = sp.csr_matrix((np.ones(len(i), np.int8), (i, j)), shape=(n, n))
    count, label = connected_components(graph, directed=False)
    if count > 1:  # one after the other
        first = np.unique(label, return_index=True)[1]
        ties = sp.csr_matrix((np.ones(count - 1, np.int8), (first[:-1], first[1:])), shape=(n, n))
        graph = graph + ties + ties.T
    far = breadth_first_order(graph, 0, directed=False, return_predecessors=False)[-1]
    rank = np.empty(n, np.int64)
    rank[breadth_first_order(graph, far, directed=False, return_predecessors=False)] = np.arange(n)
    return rank


def _best_cut(rank, lowest, size):
    """Return the rank at which to cut, such that both the larger half and the separator are small.

    ``lowest``: the lowest rank of a vertex and its neighbours. A vertex belongs to the separator of a cut at c if
    lowest < c <= rank.
    """
    change = np.zeros(len(rank) + 1, np.int64)
    np.add.at(change, lowest + 1, size)
    np.add.at(change, rank + 1, -size)
    between = np.cumsum(change)[:-1]
    before = np.empty(len(rank), np.int64)
    before[rank] = size
    before = np.cumsum(before) - before  # unknowns in the first half, by the rank of the cut
    return int(np.argmin(np.maximum(before, size.sum() - before - between) + PRICE * between))


def _place_multipliers(part, i, j, n_nodes):
    """Move multipliers that constrain nodes outside of their half to the separator: they are eliminated last."""
    tied = (i >= n_nodes) & (part[i] != part[j])
    part[i[tied]] = BETWEEN
