"""Balance of matrices whose equations and unknowns have any units."""

import numpy as np

ROUNDS = 20


def balance(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return factors of the rows (n,) and columns (m,) of A (n, m), not negative, that bring all maxima to one.

    The algorithm is that of Ruiz (CERFACS report TR/PA/01/35); rows and columns of zeros keep the factor one.
    """
    rows, columns = np.ones(A.shape[0]), np.ones(A.shape[1])
    for _ in range(ROUNDS):
        B = rows[:, None] * A * columns
        for factors, largest in ((rows, B.max(axis=1, initial=0.0)), (columns, B.max(axis=0, initial=0.0))):
            factors /= np.sqrt(np.where(largest > 0.0, largest, 1.0))
    return rows, columns
