"""Minimum degree ordering: eliminate next the node with the fewest neighbours, including those by fill.

George & Liu 1989, "The evolution of the minimum degree ordering algorithm", SIAM Review 31.
"""

import heapq
from collections.abc import Sequence

import numpy as np

from mecano.process.memory import reserve_blas_buffer

SMALL = 1000  # nodes up to which SuperLU is not used; for more, its order takes less time and has less fill


def least_degree(neighbours: Sequence[np.ndarray]) -> np.ndarray:
    """Return the position (n,) of each node of a symmetric graph in the order; ``neighbours``: an array per node."""
    return _of_small(neighbours) if len(neighbours) <= SMALL else _of_large(neighbours)


def _of_small(neighbours):
    """Order by minimum degree; fill is stored as borders of eliminated nodes, whose nodes are all coupled."""
    near = [set(own.tolist()) for own in neighbours]
    borders: dict[int, set[int]] = {}
    # near: neighbours not in a border; inside: eliminated nodes whose border contains a node
    inside: list[set[int]] = [set() for _ in near]
    degree: list[int | None] = [len(own) for own in near]
    queue = [(len(own), i) for i, own in enumerate(near)]
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
            count = degree[j] = len(near[j].union(*(borders[e] for e in inside[j]))) - 1
            heapq.heappush(queue, (count, j))
    position = np.empty(len(order), dtype=np.int64)
    position[order] = np.arange(len(order))
    return position


def _of_large(neighbours):
    """Return the order that SuperLU finds for a diagonally dominant matrix."""
    import scipy.linalg as la
    import scipy.sparse as sp
    import scipy.sparse.linalg as spla

    reserve_blas_buffer(la.lapack.dgesv)
    n, degree = len(neighbours), np.array([len(own) for own in neighbours])
    starts = np.concatenate([[0], np.cumsum(degree)])
    graph = sp.csr_matrix((np.full(starts[-1], -1.0), np.concatenate(neighbours), starts), shape=(n, n))
    matrix = (graph + sp.diags(degree + 1.0)).tocsc()
    options = {"SymmetricMode": True}
    return spla.splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options).perm_c
