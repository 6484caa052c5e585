"""Bases of a space of motions in which the motions are separated from one another as far as possible."""

import numpy as np


def separated_basis(basis: np.ndarray) -> np.ndarray:
    """Return a basis (m, n) of the same space: each motion has one component where all others vanish."""
    if not len(basis):
        return basis
    order, rest = [], basis.copy()
    for _ in basis:  # columns by pivoted Gram-Schmidt: the one farthest from the span of those before
        size = np.linalg.norm(rest, axis=0)
        order.append(int(np.argmax(size)))
        q = rest[:, order[-1]] / size[order[-1]]
        rest -= np.outer(q, q @ rest)
    return np.linalg.solve(basis[:, order], basis)
