r"""Arc-length continuation past limit points: the load factor is an unknown like the displacements.

A step of length :math:`\Delta s` from the point n ends where the path meets the plane

.. math::  t_q^T S (q - q_n) + t_\mu (\mu - \mu_n) = \Delta s

perpendicular to its tangent t (Riks, Int. J. Solids Structures 15 (1979) 529-551; Keller 1977). The bordered system is
solved with two right-hand sides of one factor, :math:`K x = -r` and :math:`K y = -\partial r/\partial\mu`. The sense
of the tangent is that of the previous one, :math:`t_n^T S t_{n-1} > 0`. S scales displacements so that at the start
they have the same weight as the load factor that causes them.

Where a stop or contact closes or opens, the path has a corner, at which the load factor may turn back. The step then
ends there, and the path continues to the side on which closed contacts push and open ones stay open.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import ConvergenceError, Failure
from mecano.solve.linear.iteration import SINGULAR, Iterated, iterate
from mecano.solve.statics.continuation import SHRINK, Follower, Point
from mecano.solve.statics.loading import LoadFactor
from mecano.solve.statics.passed_events import apply_events
from mecano.solve.statics.stability import freedom_text
from mecano.solve.statics.static import CLOSED, PHASE_CHANGES, Statics, Status

if TYPE_CHECKING:
    from mecano.model.state import State

WANTED = 5  # desired number of iterations of a step
SHARPEST = 0.5  # least cosine between successive tangents of the path
LONGEST = 5.0  # largest step, relative to the first one
HALVINGS = 8  # number of bisections of a step in which stability is lost
MOST_TRIES = 30  # largest number of trial steps to meet an end of the path
MET = 1e-9  # relative tolerance of an end of the path
AHEAD = 1e-3  # of a step: distance from a corner at which its two sides are compared


@dataclass
class Target:
    """A displacement of a node along an inertial direction at which a path ends."""

    name: str
    place: int  # first entry of the position in z
    direction: np.ndarray  # (3,) unit vector
    origin: np.ndarray  # (3,) [m]
    value: float  # [m]

    def displacement(self, s: "State") -> float:
        """Return the displacement [m] of the node at the state ``s``."""
        return float(self.direction @ (s.z[self.place : self.place + 3] - self.origin))

    def gap(self, s: "State") -> float:
        """Return the displacement beyond the value, relative to the value."""
        return self.displacement(s) / self.value - 1.0


@dataclass
class Trial:
    """The end of a step of length ``ds``, converged or not."""

    state: "State"
    mu: float  # load factor
    ds: float
    found: Status
    tangent: np.ndarray | None = None  # (n_q + 1,), the load factor last
    rate: np.ndarray | None = None  # (n,) derivatives of displacements and multipliers by the load factor
    crossed: int | None = None  # first event that occurred within it


@dataclass
class ArcLength:
    """Continuation until the load factor reaches ``end`` or falls to ``lowest``, or a node reaches its target."""

    end: float
    count: int  # number of steps to the end if the stiffness remained that of the start
    minimum: float  # smallest step, relative to the first one
    most: int  # largest number of steps
    lowest: float = -np.inf
    target: Target | None = None
    hint: str = "more steps; method: relaxation, which lets a mechanism fall into place"
    more_steps: str = "a larger static.maximum_steps; fewer static.steps, which makes them longer"

    def follow(self, follower: Follower, point: Point) -> tuple[Point, str]:
        """Return (last Point, reason of the end). Raises ConvergenceError, NonFiniteError."""
        statics, s = follower.statics, follower.statics.begin(point.state)
        rate = rate_of(statics, s, point.parameter)
        if rate is None:
            singular = Iterated(False, 0, (), SINGULAR, Failure.SINGULAR)
            raise self._failure(follower, point, point.parameter, statics.status_of(singular, s, s))
        arc = Arc(statics, rate)
        first = ds = np.sqrt(2.0) * (self.end - point.parameter) / self.count
        for _ in range(self.most):
            point, ds = self._advance(follower, arc, point, ds, self.minimum * first)
            if reason := self._arrived(point):
                return point, reason
            ds = min(ds * min(max(np.sqrt(WANTED / max(point.iterations, 1)), 0.5), 1.5), LONGEST * first)
        why = f"{self.most} steps were made, as many as static.maximum_steps allows"
        free = freedom_text(follower.statics.system, point.state, point.stability, follower.statics.length)
        raise ConvergenceError(f"{self._stopped(point)}: {why}\nthere: {free}\nwhat to try: {self.more_steps}")

    def missed(self, point: Point) -> Iterator[str]:
        """Yield a warning if the path ended, at ``point``, before the target was reached."""
        if self.target and self.target.gap(point.state) < -MET:
            yield (
                f"the path ended at load factor {point.parameter:.6g} before node '{self.target.name}' was displaced "
                f"by {self.target.value:g} m (static.until): it is displaced by "
                f"{self.target.displacement(point.state):.6g} m; static.end and static.lowest bound the load factor"
            )

    def _stopped(self, point):
        """Return as text where the path stopped before it reached an end."""
        ends = [f"load factor {self.end:g}"]
        ends += [f"or {self.lowest:g}, falling"] if np.isfinite(self.lowest) else []
        ends += [f"or node '{self.target.name}' displaced by {self.target.value:g} m"] if self.target else []
        at = f"load factor {point.parameter:.6g}, {point.place:.6g} along it"
        last = f", after a step of {point.step:.3g}" if point.step else ""
        return f"the path did not reach its end ({' '.join(ends)}); it stopped at {at}{last}"

    def _failure(self, follower, point, mu, found):
        """Return the error for a failed step from ``point`` towards the load factor mu."""
        error = follower.failure(mu, found, point.state, point.parameter, self.hint)
        return type(error)(f"{self._stopped(point)}\n{error}")

    def _arrived(self, point):
        at = np.abs(self._gaps(point.state, point.parameter)) <= MET
        ends = ("the end was reached", f"the load factor fell to {self.lowest:g}", "")
        if at[2] and self.target:
            return f"node '{self.target.name}' was displaced by {self.target.value:g} m"
        return ends[int(np.argmax(at))] if at.any() else ""

    def _gaps(self, s, mu):
        """Return (3,) numbers that change sign at the ends of the path; -1 for ends that are not used."""
        low = (self.lowest - mu) / abs(self.end) if np.isfinite(self.lowest) else -1.0
        return np.array([mu / self.end - 1.0, low, self.target.gap(s) if self.target else -1.0])

    def _advance(self, follower, arc, point, ds, minimum):
        """Return the next Point and the length of the step to it; at a corner, the one that was planned."""
        rejected, planned, before = 0, None, self._gaps(point.state, point.parameter)
        while not (trial := arc.step(point, ds)).found.ok:
            if trial.crossed is not None and (corner := arc.corner(point, trial)).found.ok:
                trial, planned = corner, ds
                break
            if ds * SHRINK < minimum:
                raise self._failure(follower, point, trial.mu, trial.found)
            ds, rejected = ds * SHRINK, rejected + 1
        if np.any((before < 0.0) & (self._gaps(trial.state, trial.mu) > 0.0)):
            trial = self._meet(arc, point, before, trial)
        critical = self._critical(follower, arc, point, trial)
        arc.tangent, arc.rate = trial.tangent, trial.rate
        mu = self.end if abs(trial.mu / self.end - 1.0) <= MET else trial.mu
        new = follower.accept(trial.state, mu, point.place + trial.ds, trial.ds, trial.found, rejected, critical)
        return new, planned or trial.ds

    def _critical(self, follower, arc, point, trial):
        """Return the load factor at which stability is lost within the step, or None.

        It is found by bisection, then by interpolation of the least stiffness.
        """
        unstable = point.stability.unstable
        reached = follower.stability(trial.state, trial.mu)
        ends = [(0.0, point.parameter, point.stability), (trial.ds, trial.mu, reached)]
        if not 0 <= unstable < ends[1][2].unstable:
            return None
        for _ in range(HALVINGS):
            new = arc.step(point, 0.5 * (ends[0][0] + ends[1][0]))
            if not new.found.ok:
                break
            there = follower.stability(new.state, new.mu)
            ends[there.unstable > unstable] = (new.ds, new.mu, there)
        (_, stable_mu, stable), (_, unstable_mu, soft) = ends
        crossed = stable.stiffness > 0.0 > soft.stiffness
        share = stable.stiffness / (stable.stiffness - soft.stiffness) if crossed else 0.5
        return stable_mu + share * (unstable_mu - stable_mu)

    def _meet(self, arc, point, before, trial):
        """Return the Trial that ends at the first end of the path, by the Illinois method on the step length."""
        g = self._gaps(trial.state, trial.mu)
        crossed = np.flatnonzero((before < 0.0) & (g > 0.0))
        i = crossed[np.argmax(g[crossed] / (g[crossed] - before[crossed]))]
        low, high, g_low, g_high, side = 0.0, trial.ds, before[i], g[i], 0
        for _ in range(MOST_TRIES):
            new = arc.step(point, low - g_low * (high - low) / (g_high - g_low))
            if not new.found.ok:
                return trial
            trial, gap = new, self._gaps(new.state, new.mu)[i]
            if abs(gap) <= 0.1 * MET:
                break
            if gap > 0.0:
                high, g_high, g_low = new.ds, gap, g_low * (0.5 if side == 1 else 1.0)
            else:
                low, g_low, g_high = new.ds, gap, g_high * (0.5 if side == -1 else 1.0)
            side = 1 if gap > 0.0 else -1
        return trial


def slope_of(statics: Statics, s: "State", mu: float) -> np.ndarray:
    """Return the derivative (n,) of the residual by the load factor."""
    assert isinstance(statics.loading, LoadFactor), "only a load factor is an unknown of a path"
    return statics.loading.slope(s, mu)


def rate_of(statics: Statics, s: "State", mu: float) -> np.ndarray | None:
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
        return self._finished(trial) if trial.found.ok else trial

    def corner(self, point: Point, trial: Trial) -> Trial:
        """Return the Trial that ends at the first event within ``trial``, with the tangent of the path after it."""
        statics, crossed = self.statics, trial.crossed

        def solved(ds):
            return self._correct(point, self._predicted(point, ds), ds)

        def value(ds):
            return statics.monitor.values(solved(ds)[0])[crossed]

        if not value(0.0) < 0.0 < value(trial.ds):
            return trial
        from scipy.optimize import brentq  # takes 0.3 s to import, hence only when needed

        ds = brentq(value, 0.0, trial.ds, xtol=MET * trial.ds)
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

    def _predicted(self, point: "Point", ds: float) -> "State":
        """Return the state at the length ds along the tangent of the last ``point``."""
        return self._ahead(point.state, ds * self.tangent[-1], self.rate)

    def _ahead(self, s0: "State", more: float, rate: np.ndarray) -> "State":
        """Extrapolate ``s0`` by its ``rate`` to a load factor increased by ``more``."""
        s = self.statics.begin(s0)
        k, _ = self.statics.scales(s)
        guess = more * rate
        guess[self.statics.system.n_q :] /= k
        self.statics.move(s, s0, guess, k)
        return s

    def _finished(self, trial: Trial) -> Trial:
        """Return the trial with tangent and rate at its end; it fails if the path turns too sharply."""
        trial = self._directed(trial)
        if trial.found.ok and trial.tangent is not None and self._product(trial.tangent, self.tangent) < SHARPEST:
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

    def _correct(self, point: Point, s: "State", ds: float, mu: float | None = None) -> "tuple[State, float, Iterated]":
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
            change = (-gap - by_q @ x[:n_q]) / (by_mu + by_q @ rate[:n_q])
            return x + change * rate

        def move(dz):
            nonlocal mu
            mu += change
            return max(statics.move(s, point.state, dz, k), abs(change) / statics.tolerances.increment)

        most = statics.tolerances.max_iterations
        result = iterate(evaluate, solve, move, most=most, exhausted=statics.exhausted(s))
        return s, mu, result
