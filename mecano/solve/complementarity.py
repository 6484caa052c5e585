r"""The complementarity problem of frictionless shocks: :math:`0 \le \Lambda \perp W \Lambda + b \ge 0`."""

import numpy as np

ROUNDING = 1e-13  # of the diagonal of W: makes it definite where contacts repeat one another
NEGLIGIBLE = 1e-11  # of the largest: a reaction that is none


def solve_complementarity(W, b, unit=None):
    """Reactions (n,) of n unilateral constraints: W (n, n) symmetric, positive semidefinite, b (n,).

    Minimizes the convex energy of which these are the conditions, as a problem of nonnegative least squares (Lawson &
    Hanson 1974) in a factor of W. Where contacts repeat one another the reactions are those of least norm, counted in
    ``unit`` (n,), among those that push, so that equal contacts share equally.
    """
    import scipy.linalg as sl  # 0.2 s of a run, which most models need not wait for
    from scipy.optimize import nnls

    largest = np.abs(b).max(initial=0.0)
    if largest == 0.0:
        return np.zeros(len(b))
    size = np.sqrt(np.maximum(np.diag(W), 0.0))
    size = np.where(size > 0.0, size, 1.0)
    scaled, right = W / np.outer(size, size), b / (size * largest)
    scaled = 0.5 * (scaled + scaled.T)
    root = sl.cholesky(scaled + ROUNDING * len(b) * np.eye(len(b)), lower=True)
    reactions, _ = nnls(root.T, -sl.solve_triangular(root, right, lower=True))
    push = np.flatnonzero(reactions > NEGLIGIBLE * reactions.max(initial=0.0))
    if len(push):
        share = (np.ones(len(b)) if unit is None else unit)[push] * size[push]
        block = share[:, None] * scaled[np.ix_(push, push)] * share
        refined = np.linalg.lstsq(block, -share * right[push], rcond=1e-10)[0] * share
        if refined.min() >= 0.0:
            reactions[:] = 0.0
            reactions[push] = refined
    return reactions * largest / size
