"""Inertia of a body as a matrix."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def inertia_matrix(inertia: "ArrayLike") -> np.ndarray:
    """Return the 3x3 matrix of 3 principal moments, 6 numbers [xx, yy, zz, xy, xz, yz] or a 3x3 matrix [kg m2]."""
    J = np.asarray(inertia, float)
    if J.shape == (3,):
        return np.diag(J)
    if J.shape == (6,):
        xx, yy, zz, xy, xz, yz = J
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return J
