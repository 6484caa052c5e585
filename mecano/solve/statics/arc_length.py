"""Arc-length continuation past limit points: the load factor is an unknown like the displacements.

The path is followed in steps of a given length (arc_step.py) until it reaches the largest or the least load factor, or
a node its displacement; the last step is shortened to end there. Where the equilibrium loses its stability within a
step, the critical load factor is found by bisection. Where a stop or contact closes or opens, the step ends at the
corner of the path.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mecano.errors import ConvergenceError, Failure
from mecano.model.state import State
from mecano.solve.linear.iteration import SINGULAR, Iterated
from mecano.solve.statics.arc_step import MET, Arc, rate_of
from mecano.solve.statics.continuation import SHRINK, Follower, Point
from mecano.solve.statics.stability import freedom_text

WANTED = 5  # desired number of iterations of a step
LONGEST = 5.0  # largest step, relative to the first one
HALVINGS = 8  # number of bisections of a step in which stability is lost
MOST_TRIES = 30  # largest number of trial steps to meet an end of the path


@dataclass
class Target:
    """A displacement of a node along an inertial direction at which a path ends."""

    name: str
    place: int  # first entry of the position in z
    direction: np.ndarray  # (3,) unit vector
    origin: np.ndarray  # (3,) [m]
    value: float  # [m]

    def displacement(self, s: State) -> float:
        """Return the displacement [m] of the node at the state ``s``."""
        return float(self.direction @ (s.z[self.place : self.place + 3] - self.origin))

    def gap(self, s: State) -> float:
        """Return the displacement beyond the value, relative to the value."""
        return self.displacement(s) / self.value - 1.0


@dataclass
class ArcLength:
    """Continuation until the load factor reaches ``end`` or falls to ``lowest``, or a node reaches its target."""

    end: float
    count: int  # number of steps to the nearer end if the stiffness remained that of the start
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
        first = ds = self._first(point, rate)
        for _ in range(self.most):
            point, ds = self._advance(follower, arc, point, ds, self.minimum * first)
            if reason := self._arrived(point):
                return point, reason
            ds = min(ds * min(max(np.sqrt(WANTED / max(point.iterations, 1)), 0.5), 1.5), LONGEST * first)
        why = f"{self.most} steps were made, as many as static.maximum_steps allows"
        free = freedom_text(follower.statics.system, point.state, point.stability, follower.statics.length)
        raise ConvergenceError(f"{self._stopped(point)}: {why}\nthere: {free}\nwhat to try: {self.more_steps}")

    def _first(self, point: Point, rate: np.ndarray) -> float:
        """Return the length of the first step, ``count`` of which would lead to the nearer end at the first stiffness.

        The load factor of the end may be far above a limit load: one step by a share of it would skip the limit point.
        """
        way, target = self.end - point.parameter, self.target
        if target and (slope := float(target.direction @ rate[target.place :][:3]) / target.value) > 0.0:
            way = min(way, -target.gap(point.state) / slope)
        return float(np.sqrt(2.0) * way / self.count)

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
