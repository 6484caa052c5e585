r"""The complementarity problem of frictionless shocks: :math:`0 \le \Lambda \perp W \Lambda + b \ge 0`."""

import numpy as np

from mecano.errors import AssemblyError, Failure

ROUNDING = 1e-13  # of the diagonal of W: makes it definite if contacts are redundant
NEGLIGIBLE = 1e-11  # of the largest reaction: a smaller one counts as zero
MOST = 3  # times the number of contacts: changes of the set of those that push, in nonnegative least squares
FITS = 1e-9  # of the largest entry of b: largest residual of a solution in which all contacts push


def solve_complementarity(
    W: np.ndarray, b: np.ndarray, unit: np.ndarray | None = None, guess: np.ndarray | None = None
) -> np.ndarray:
    """Return the reactions (n,) of n unilateral constraints; W (n, n) symmetric, positive semidefinite, b (n,).

    In most cases all contacts push. Otherwise the equivalent convex minimization is solved as a problem of nonnegative
    least squares in a factor of W. If contacts are redundant, the reactions are those of least norm, in units of
    ``unit`` (n,), among the contacts that push, so that equal contacts share equally. ``guess`` (n,) bool are those
    that may push, which is tried first. Raises AssemblyError for a W that is not semidefinite, or not finite.
    """
    if b.min(initial=0.0) >= 0.0:
        return np.zeros(len(b))
    largest = np.abs(b).max()
    size = np.sqrt(np.maximum(np.diag(W), 0.0))
    size = np.where(size > 0.0, size, 1.0)
    scaled, right = W / np.outer(size, size), b / (size * largest)
    scaled = 0.5 * (scaled + scaled.T)
    try:
        guess = np.zeros(len(b), bool) if guess is None else guess
        return _reactions(scaled, right, size if unit is None else unit * size, guess) * largest / size
    except np.linalg.LinAlgError:
        raise AssemblyError(
            "the impulses of an impact cannot be found: the mechanism is too near a singular position for its response "
            "to them to be known; give the contacts a 'law', which resolves the impact in time",
            Failure.SINGULAR,
        ) from None


def _reactions(W, b, share, guess):
    """Return the reactions (n,) for a diagonal of W of ones."""
    reactions = _least(W, b, share)
    violation = np.abs(W @ reactions + b).max()
    if reactions.min() <= NEGLIGIBLE * reactions.max() or violation > FITS * np.abs(b).max():
        reactions = _of_these(W, b, share, np.flatnonzero(guess))
        if not reactions.any():
            reactions = _of_some(W, b, share)
        reactions = _shared(W, b, share, reactions)
    return reactions


def _least(W, b, share):
    """Return the x (n,) of least norm, in units of ``share``, with W x + b = 0."""
    return np.linalg.lstsq(share[:, None] * W * share, -share * b, rcond=1e-10)[0] * share


def _of_these(W, b, share, push):
    """Return the reactions (n,) if just the contacts ``push`` (indices) do, zeros if these are no solution."""
    found, x = np.zeros(len(b)), _least(W[np.ix_(push, push)], b[push], share[push]) if len(push) else b[push]
    if x.min(initial=np.inf) > NEGLIGIBLE * x.max(initial=0.0) and (W[:, push] @ x + b).min() >= -NEGLIGIBLE:
        found[push] = x
    return found


def _of_some(W, b, share):
    """Return the reactions (n,) if not all contacts push."""
    root = np.linalg.cholesky(W + ROUNDING * len(b) * np.eye(len(b)))
    reactions = _nonnegative(root.T, -np.linalg.solve(root, b))
    push = np.flatnonzero(reactions > NEGLIGIBLE * reactions.max(initial=0.0))
    if len(push):
        refined = _least(W[np.ix_(push, push)], b[push], share[push])
        if refined.min() >= 0.0:
            reactions[:] = 0.0
            reactions[push] = refined
    return reactions


def _shared(W, b, share, x):
    """Return the solution of least norm, in units of ``share``, of those in which all contacts move as in x (n,).

    One that rests without pushing shares the load of others that it repeats as long as that reduces the norm.
    """
    A = share[:, None] * W * share
    for _ in range(MOST * len(x)):
        push, rests = x > 0.0, (x <= 0.0) & (np.abs(W @ x + b) <= NEGLIGIBLE)
        if not (push.any() and rests.any()):
            break
        right = np.column_stack([x[push] / share[push], A[np.ix_(push, rests)]])
        weights = np.linalg.lstsq(A[np.ix_(push, push)], right, rcond=1e-10)[0]
        gain, own = A[np.ix_(rests, push)] @ weights[:, 0], np.diag(A)[rests]
        repeats = own - np.sum(right[:, 1:] * weights[:, 1:], axis=0) <= FITS * own
        gain = np.where(repeats, gain, 0.0)
        if gain.max() <= FITS * right[:, 0].max():
            break
        push[np.flatnonzero(rests)[np.argmax(gain)]] = True
        x = _towards(x, push, lambda of: _least(W[np.ix_(of, of)], b[of], share[of]))
    return x


def _towards(x, free, best_of):
    """Return the best x (n,) >= 0 of those ``free`` (n,) bool; ``best_of(free)`` may be negative: these are dropped."""
    while True:
        best = np.zeros(len(x))
        best[free] = best_of(free)
        if best[free].min(initial=1.0) > 0.0:
            return best
        blocks = free & (best <= 0.0)
        x = x + (x[blocks] / (x[blocks] - best[blocks])).min() * (best - x)
        free = free & (x > NEGLIGIBLE * x.max())
        x = np.where(free, x, 0.0)


def _nonnegative(A, b):
    """Return the x (n,) >= 0 that minimizes |A x - b|, by the active set method of Lawson & Hanson (1974, 23.3)."""
    x, free = np.zeros(A.shape[1]), np.zeros(A.shape[1], bool)
    for _ in range(MOST * len(x)):
        descent = np.where(free, 0.0, A.T @ (b - A @ x))
        if descent.max() <= NEGLIGIBLE:
            break
        free[np.argmax(descent)] = True
        x = _towards(x, free, lambda of: np.linalg.lstsq(A[:, of], b, rcond=None)[0])
        free = x > 0.0
    return x
