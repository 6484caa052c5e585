"""An order of elimination with little fill: next is what has fewest neighbours, those by filled entries included.

George & Liu 1989, "The evolution of the minimum degree ordering algorithm", SIAM Review 31.
"""

import heapq

import numpy as np

SMALL = 1000  # nodes; for more, SuperLU's order takes less time and fills less, and its import is a small part of a run


def least_degree(neighbours):
    """Position (n,) of each node of a symmetric graph in the order; ``neighbours`` has an array for each node."""
    return _of_small(neighbours) if len(neighbours) <= SMALL else _of_large(neighbours)


def _of_small(neighbours):
    """The filled entries are borders of eliminated nodes: all neighbours of such a node have one another."""
    near, borders = [set(own.tolist()) for own in neighbours], {}
    inside = [set() for _ in near]  # eliminated nodes in whose border a node is; ``near`` is what no border has yet
    degree = [len(own) for own in near]
    queue = [(count, i) for i, count in enumerate(degree)]
    heapq.heapify(queue)
    order = []
    while queue:
        count, i = heapq.heappop(queue)
        if count != degree[i]:
            continue
        order.append(i)
        joined, degree[i] = inside[i], None
        border = near[i].union(*(borders.pop(e) for e in joined)) - {i}
        borders[i] = border
        for j in border:
            near[j] -= border
            near[j].discard(i)
            inside[j] = (inside[j] - joined) | {i}
            degree[j] = len(near[j].union(*(borders[e] for e in inside[j]))) - 1
            heapq.heappush(queue, (degree[j], j))
    position = np.empty(len(order), dtype=np.int64)
    position[order] = np.arange(len(order))
    return position


def _of_large(neighbours):
    """The order that SuperLU finds for a diagonally dominant matrix."""
    import scipy.sparse as sp
    import scipy.sparse.linalg as spla

    n, degree = len(neighbours), np.array([len(own) for own in neighbours])
    starts = np.concatenate([[0], np.cumsum(degree)])
    graph = sp.csr_matrix((np.full(starts[-1], -1.0), np.concatenate(neighbours), starts), shape=(n, n))
    matrix = (graph + sp.diags(degree + 1.0)).tocsc()
    options = {"SymmetricMode": True}
    return spla.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).perm_c
