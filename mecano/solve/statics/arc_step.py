r"""Steps of the arc-length continuation (arc_length.py), and corners of the path.

A step of length :math:`\Delta s` from the point n ends where the path meets the plane

.. math::  t_q^T S (q - q_n) + t_\mu (\mu - \mu_n) = \Delta s

perpendicular to its tangent t (Riks, Int. J. Solids Structures 15 (1979) 529-551; Keller 1977). The bordered system is
solved with two right-hand sides of one factor, :math:`K x = -r` and :math:`K y = -\partial r/\partial\mu`. The sense
of the tangent is that of the previous one, :math:`t_n^T S t_{n-1} > 0`. S scales displacements so that at the start
they have the same weight as the load factor that causes them.

Where a stop or contact closes or opens, the path has a corner, at which the load factor may turn back. The step then
ends there, and the path continues to the side on which closed contacts push and open ones stay open.
"""

from dataclasses import dataclass

import numpy as np

from mecano.errors import Failure
from mecano.maths.root import root
from mecano.model.state import State
from mecano.solve.linear.iteration import SINGULAR, Iterated, iterate
from mecano.solve.statics.continuation import Point
from mecano.solve.statics.loading import LoadFactor
from mecano.solve.statics.passed_events import apply_events
from mecano.solve.statics.static import CLOSED, PHASE_CHANGES, Statics, Status

SHARPEST = 0.5  # least cosine between successive tangents of the path
LOST = 1e-14  # of the terms of the rate along the tangent: a smaller sum is rounding
MET = 1e-9  # relative tolerance of an end of the path
AHEAD = 1e-3  # of a step: distance from a corner at which its two sides are compared


@dataclass
class Trial:
    """The end of a step of length ``ds``, converged or not."""

    state: State
    mu: float  # load factor
    ds: float
    found: Status
    tangent: np.ndarray | None = None  # (n_q + 1,), the load factor last
    rate: np.ndarray | None = None  # (n,) derivatives of displacements and multipliers by the load factor
    crossed: int | None = None  # first event that occurred within it


def slope_of(statics: Statics, s: State, mu: float) -> np.ndarray:
    """Return the derivative (n,) of the residual by the load factor."""
    assert isinstance(statics.loading, LoadFactor), "only a load factor is an unknown of a path"
    return statics.loading.slope(s, mu)


def rate_of(statics: Statics, s: State, mu: float) -> np.ndarray | None:
    """Return the derivatives (n,) of displacements and multipliers by the load factor, or None if singular."""
    k, penalty = statics.scales(s)
    slope = slope_of(statics, s, mu)
    statics.evaluate(s, mu, k, penalty, True)
    x = statics.factor(-slope)
    if x is None:
        return None
    rate = x.copy()
    rate[statics.system.n_q :] *= k
    return rate


class Arc:
    """Arc-length steps of ``statics``, with tangent and rate at the last accepted point."""

    def __init__(self, statics: Statics, rate: np.ndarray):
        """Begin at a point with the ``rate`` (n,), see ``rate_of``."""
        self.statics, self.rate = statics, rate
        self.metric = statics.weight / statics.length**2
        q = rate[: statics.system.n_q]
        size = float(q @ (self.metric * q))
        self.metric = self.metric / size if np.isfinite(size) and size > 0.0 else self.metric
        self.tangent = self._direction(rate)

    def _direction(self, rate: np.ndarray) -> np.ndarray:
        """Return the unit tangent (n_q + 1,) of the path, in the sense in which the load factor grows."""
        tangent = np.append(rate[: self.statics.system.n_q], 1.0)
        return tangent / np.sqrt(self._product(tangent, tangent))

    def _product(self, t, u):
        return float(t[:-1] @ (self.metric * u[:-1]) + t[-1] * u[-1])

    def step(self, point: Point, ds: float) -> Trial:
        """Return the Trial of a step of length ds from ``point``, to which tangent and rate belong."""
        statics, crossed, reported = self.statics, None, []
        s, mu, result = self._correct(point, self._predicted(point, ds), ds)
        for _ in range(PHASE_CHANGES):
            hit = statics.monitor.values(s) > CLOSED * statics.length
            if not result.ok or not hit.any():
                break
            crossed = int(np.argmax(hit)) if crossed is None else crossed
            s, event_records = apply_events(statics, s, point.state, hit)
            reported += event_records
            s, mu, result = self._correct(point, s, ds, mu)
        else:
            result.ok, result.message = False, "contacts do not settle"
        trial = Trial(s, mu, ds, statics.status_of(result, s, point.state), crossed=crossed)
        trial.found.event_records = tuple(reported)
        return self._finished(point, trial) if trial.found.ok else trial

    def corner(self, point: Point, trial: Trial) -> Trial:
        """Return the Trial that ends at the first event within ``trial``, with the tangent of the path after it."""
        statics, crossed = self.statics, trial.crossed

        def solved(ds):
            return self._correct(point, self._predicted(point, ds), ds)

        def value(ds):
            return statics.monitor.values(solved(ds)[0])[crossed]

        if not value(0.0) < 0.0 < value(trial.ds):
            return trial
        ds = root(value, 0.0, trial.ds, MET * trial.ds)
        s, mu, result = solved(ds)
        found = statics.status_of(result, s, point.state)
        hit = np.arange(statics.monitor.values(s).size) == crossed
        s, reported = statics.monitor.apply(statics.committed(s), hit)
        found.event_records = tuple(reported)
        corner = self._directed(Trial(s, mu, ds, found))
        tangent, rate = corner.tangent, corner.rate
        if corner.found.ok and tangent is not None and rate is not None:
            ahead = self._ahead(statics.begin(s), AHEAD * ds * tangent[-1], rate)
            if self._crosses(s, ahead):
                corner.tangent = -tangent
        return corner

    def _crosses(self, s, ahead):
        """Return whether an event occurs between the corner ``s`` and a state ``ahead`` of it."""
        now, then = (self.statics.monitor.values(state) for state in (s, ahead))
        return bool(np.any(then > np.maximum(now, 0.0)))

    def _predicted(self, point: Point, ds: float) -> State:
        """Return the state at the length ds along the tangent of the last ``point``."""
        return self._ahead(point.state, ds * self.tangent[-1], self.rate)

    def _ahead(self, s0: State, more: float, rate: np.ndarray) -> State:
        """Extrapolate ``s0`` by its ``rate`` to a load factor increased by ``more``."""
        s = self.statics.begin(s0)
        k, _ = self.statics.scales(s)
        guess = more * rate
        guess[self.statics.system.n_q :] /= k
        self.statics.move(s, s0, guess, k)
        return s

    def _finished(self, point: Point, trial: Trial) -> Trial:
        """Return the trial with tangent and rate at its end; it fails if the path turns too sharply.

        Beyond two limit points the tangent may be the first one again: the chord must be near it, as on an arc that
        turns by no more than the tangent may.
        """
        trial = self._directed(trial)
        chord = np.append(self.statics.displacement(trial.state, point.state), trial.mu - point.parameter)
        strays = trial.ds < np.sqrt(0.5 * (1.0 + SHARPEST) * self._product(chord, chord))
        turns = trial.tangent is not None and self._product(trial.tangent, self.tangent) < SHARPEST
        if trial.found.ok and (strays or turns):
            trial.found.ok, trial.found.message = False, "the path turns too sharply"
        return trial

    def _directed(self, trial: Trial) -> Trial:
        """Return the trial with tangent and rate at its end; it fails if these are singular."""
        trial.rate = rate_of(self.statics, self.statics.begin(trial.state), trial.mu)
        if trial.rate is None:
            trial.found.ok, trial.found.message, trial.found.failure = False, SINGULAR, Failure.SINGULAR
            return trial
        tangent = self._direction(trial.rate)  # in the sense of the previous one
        trial.tangent = tangent if self._product(tangent, self.tangent) >= 0.0 else -tangent
        return trial

    def _correct(self, point: Point, s: State, ds: float, mu: float | None = None) -> tuple[State, float, Iterated]:
        """Iterate by Newton's method in the plane of the step, changing ``s`` in place: (s, load factor, Iterated)."""
        statics, n, n_q = self.statics, self.statics.system.n, self.statics.system.n_q
        mu = point.parameter + ds * self.tangent[-1] if mu is None else mu
        k, penalty = statics.scales(statics.begin(point.state))
        by_q, by_mu = self.metric * self.tangent[:-1], self.tangent[-1]
        slope, rate, change = np.zeros(n), np.zeros(n), 0.0
        step = statics.step(point.state, s.phases)

        def evaluate(tangent):
            if tangent:
                slope[:] = slope_of(statics, s, mu)
            return statics.evaluate(s, mu, k, penalty, tangent, step)

        def solve(fresh):
            """Return the correction (n,), or None if the tangent is singular; ``fresh``: the tangent is new."""
            nonlocal change
            r, x = statics.assembly.residual[:n].copy(), np.empty(n)
            if fresh:
                found = statics.factor(-slope)
                if found is None:
                    return None
                rate[:] = found
            statics.linear.solve_again(-r, x)
            gap = by_q @ statics.displacement(s, point.state) + by_mu * (mu - point.parameter) - ds
            along = by_mu + by_q @ rate[:n_q]
            if abs(along) <= LOST * (abs(by_mu) + np.abs(by_q) @ np.abs(rate[:n_q])):
                return None
            change = (-gap - by_q @ x[:n_q]) / along
            return x + change * rate

        def move(dz):
            nonlocal mu
            mu += change
            return max(statics.move(s, point.state, dz, k), abs(change) / statics.tolerances.increment)

        most = statics.tolerances.max_iterations
        result = iterate(evaluate, solve, move, most=most, exhausted=statics.exhausted(s))
        return s, mu, result
