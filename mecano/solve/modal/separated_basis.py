"""Bases of a space of motions in which the motions are separated from one another as far as possible."""

import numpy as np
import scipy.linalg as la


def separated_basis(basis: np.ndarray) -> np.ndarray:
    """Return a basis (m, n) of the same space: each motion has one component where all others vanish."""
    if not len(basis):
        return basis
    _, _, order = la.qr(basis, pivoting=True, mode="economic")
    return np.linalg.solve(basis[:, order[: len(basis)]], basis)
