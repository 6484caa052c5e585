"""Scalars without inertia, such as deflections of tyres and pressures: values and rates from their own equations."""

from functools import cached_property

import numpy as np

from mecano.model.assembly import Assembly
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.time.increments import moved

DIFFERENCE = 0.02  # of a step, for differences along the motion
RATE_ITERATIONS = 100
FIRST_REACH = 1e-3  # m/s or rad/s
RATE_TOLERANCE = 1e-12  # of the forces at work
GROWTH = 1.5  # of the forces in one iteration, towards rest
LEAST_DAMPING = 1e-12  # of the largest: a rate with less is not determined by its equation
MOST_GAIN = 1e12  # relative: a matrix with a larger one is singular
FAST = 1e-4  # of a step: a scalar without inertia that settles within this time counts as algebraic
SETTLING = 3  # rounds in which values and rates of massless unknowns are fitted to one another
IN_BALANCE = 0.02  # of the largest rate: with a larger drift, forces depend much on rates once the state has moved
ROUNDING = 1e-12  # of the largest value or rate: an iteration on them has converged


class MasslessScalars:
    """Scalars of a system without inertia, with the indices ``own`` (n,), and their equations."""

    def __init__(self, system: System, own: np.ndarray):
        self.system, self.own, self._assembly = system, own, system.kept(Assembly)

    def settle(self, s: State, h: float) -> None:
        """Set values and rates of these unknowns of ``s`` in place, consistent for steps of size h.

        Rates follow from their own equations. In directions whose time constants, the eigenvalues of K^-1 C, are far
        below h, the equations count as algebraic: they determine the values, and the rates keep them satisfied while
        all velocities are constant.
        """
        own = self.own
        for _ in range(SETTLING if len(own) else 0):
            last = s.z[own], s.v[own]
            self._settle_rates(s)
            K, C = self._tangent(s, cK=1.0), self._tangent(s, cC=1.0)
            fast = _fast(K, C, FAST * h)
            if fast is None:
                return
            s.v[own] -= fast @ K @ s.v[own]
            s.z[own] -= fast @ self._unbalanced(s)
            s.v[own] -= fast @ self._drift(s, DIFFERENCE * h)
            s.z[own] -= fast @ self._unbalanced(s)
            if all(_same(*pair) for pair in zip(last, (s.z[own], s.v[own]), strict=True)):
                break
        if len(own) and not self._stays_in_balance(s, fast, DIFFERENCE * h):
            self._search_rates(s, lambda s: self._fast_drift(s, fast, DIFFERENCE * h), np.inf)
            s.z[own] -= fast @ self._unbalanced(s)

    def _settle_rates(self, s):
        """Set the rates of these unknowns of ``s`` in place from their own equations."""

        def equations(s):
            assembly = self.system.assemble(s, cC=1.0, into=self._assembly)
            r = assembly.residual[self.own]
            return r, lambda: self._block(assembly), RATE_TOLERANCE * assembly.size.max()

        self._search_rates(s, equations, FIRST_REACH)

    def _stays_in_balance(self, s, fast, dt):
        """Return whether the fast unknowns of ``s``, in balance, hardly leave it within ``dt``."""
        ahead = moved(s.unaccelerated(), dt, self.system.numbering)
        return np.abs(fast @ self._unbalanced(ahead)).max() <= IN_BALANCE * dt * np.abs(s.v[self.own]).max()

    def _drift(self, s, dt):
        """Return the rates at which the equations leave balance while all velocities are constant."""
        steady, of = s.unaccelerated(), self.system.numbering
        now, next_, after = (self._unbalanced(moved(steady, i * dt, of)) for i in range(3))
        return (4.0 * next_ - 3.0 * now - after) / (2.0 * dt)

    def _fast_drift(self, s, fast, dt):
        """Return the drift of fast unknowns, a function of its derivative by the rates, and what is rounding.

        Friction of a tyre that touches down, for example, depends on the rates only later.
        """

        def derivative():
            steady, J = s.unaccelerated(), self._tangent(s, cK=1.0)
            for i, weight in enumerate((-3.0, 4.0, -1.0)):
                J += weight / (2.0 * dt) * self._tangent(moved(steady, i * dt, self.system.numbering), cC=1.0)
            return fast @ J

        return fast @ self._drift(s, dt), derivative, ROUNDING * np.abs(s.v[self.own]).max()

    def _search_rates(self, s, equations, reach):
        """Set the rates of these unknowns of ``s`` in place, solutions of ``equations`` (Levenberg).

        equations(s) returns residuals (n,), a function that returns their derivative by the rates, called where
        they are accepted, and the largest residual of a solution. No first change exceeds ``reach``.
        """
        best: tuple[float, np.ndarray] | None = None  # the least residual so far, by its size
        own, change = self.own, np.zeros(len(self.own))
        rates = s.v[own].copy()  # of it
        for _ in range(RATE_ITERATIONS):
            r, derivative, rounding = equations(s)
            if np.abs(r).max() <= rounding:
                return
            size = float(np.linalg.norm(r))
            # friction that slips does not fall with the slip, and may grow on the way to rest: as long as the force
            # keeps its direction the next step goes further
            if best is None or size < 0.99 * best[0] or (size <= GROWTH * best[0] and r @ best[1] > 0.0):
                best, rates, reach, J = (size, r), s.v[own].copy(), 2.0 * reach, derivative()
            else:
                reach = 0.25 * min(reach, float(np.linalg.norm(change)))
                if reach <= ROUNDING * np.abs(rates).max():
                    break
            change = np.linalg.lstsq(J + np.eye(len(own)) * (best[0] / reach), -best[1], rcond=LEAST_DAMPING)[0]
            s.v[own] = rates + change
        s.v[own] = rates

    def _tangent(self, s, **coefficients):
        return self._block(self.system.assemble(s, into=self._assembly, **coefficients))

    def _block(self, assembly):
        """Return the block of these unknowns of the assembled tangent, dense."""
        entries, places = self._of_block
        n = len(self.own)
        return np.bincount(places, assembly.data[: self.system.nnz][entries], n * n).reshape(n, n)

    @cached_property
    def _of_block(self):
        """Indices of the entries of the tangent of these unknowns, and their places in the dense block."""
        own = np.full(self.system.n, -1)
        own[self.own] = np.arange(len(self.own))
        rows, columns = own[self.system.rows], own[self.system.cols]
        entries = np.flatnonzero((rows >= 0) & (columns >= 0))
        return entries, rows[entries] * len(self.own) + columns[entries]

    def _unbalanced(self, s):
        return self.system.assemble(s, into=self._assembly).residual[self.own]


def _fast(K, C, limit):
    """Return P K^-1 (n, n), P the projector on unknowns with K z + C z' = 0 that settle within ``limit`` [s], or None.

    The time constants t are the eigenvalues of K^-1 C. Those of (K + C / limit)^-1 K, 1 / (1 + t / limit), exist also
    where K is singular.
    """
    both = _inverse(K + C / limit)
    if both is None:
        return None
    shares, X = np.linalg.eig(both @ K)
    quick = np.abs(1.0 - shares) <= np.abs(shares)
    if quick.all():
        return _inverse(K)
    inverse = _inverse(X) if quick.any() else None
    return None if inverse is None else (X[:, quick] / shares[quick] @ inverse[quick]).real @ both


def _inverse(A):
    """Return the inverse of a matrix, or None if it is singular to rounding at any scales of rows and columns.

    The products of its entries with those of the transposed inverse, Bristol's relative gains, do not depend on scales.
    """
    try:
        found = np.linalg.inv(A)
    except np.linalg.LinAlgError:
        return None
    return found if np.abs(A * found.T).max(initial=0.0) <= MOST_GAIN else None


def _same(before, now):
    """Return whether vectors differ by rounding only."""
    return np.abs(now - before).max() <= ROUNDING * np.abs(now).max()
