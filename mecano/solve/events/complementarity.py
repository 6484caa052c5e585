r"""The complementarity problem of frictionless shocks: :math:`0 \le \Lambda \perp W \Lambda + b \ge 0`."""

import numpy as np

ROUNDING = 1e-13  # of the diagonal of W: makes it definite where contacts repeat one another
NEGLIGIBLE = 1e-11  # of the largest: a reaction that is none
FITS = 1e-9  # of the largest of b: what the reactions may leave of the equations if all push


def solve_complementarity(W, b, unit=None):
    """Reactions (n,) of n unilateral constraints: W (n, n) symmetric, positive semidefinite, b (n,).

    Most often all push. Otherwise the convex energy of which these are the conditions is minimized, as a problem of
    nonnegative least squares (Lawson & Hanson 1974) in a factor of W. Where contacts repeat one another the reactions
    are those of least norm, counted in ``unit`` (n,), among those that push, so that equal contacts share equally.
    """
    if b.min(initial=0.0) >= 0.0:
        return np.zeros(len(b))
    largest = np.abs(b).max()
    size = np.sqrt(np.maximum(np.diag(W), 0.0))
    size = np.where(size > 0.0, size, 1.0)
    scaled, right = W / np.outer(size, size), b / (size * largest)
    scaled = 0.5 * (scaled + scaled.T)
    share = size if unit is None else unit * size
    reactions = _least(scaled, right, share)
    left = np.abs(scaled @ reactions + right).max()
    if reactions.min() <= NEGLIGIBLE * reactions.max() or left > FITS * np.abs(right).max():
        reactions = _of_some(scaled, right, share)
    return reactions * largest / size


def _least(W, b, share):
    """The x (n,) of least norm, counted in ``share``, with W x + b = 0."""
    return np.linalg.lstsq(share[:, None] * W * share, -share * b, rcond=1e-10)[0] * share


def _of_some(W, b, share):
    """The reactions (n,) where not all push."""
    from scipy.optimize import nnls  # 0.3 s, for which only such a problem waits

    root = np.linalg.cholesky(W + ROUNDING * len(b) * np.eye(len(b)))
    reactions, _ = nnls(root.T, -np.linalg.solve(root, b))
    push = np.flatnonzero(reactions > NEGLIGIBLE * reactions.max(initial=0.0))
    if len(push):
        refined = _least(W[np.ix_(push, push)], b[push], share[push])
        if refined.min() >= 0.0:
            reactions[:] = 0.0
            reactions[push] = refined
    return reactions
