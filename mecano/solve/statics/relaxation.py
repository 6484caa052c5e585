r"""Relaxation: the state creeps to a stable equilibrium against a vanishing drag, :math:`D \dot q = -r(q)`.

Implicit Euler with a drag that decreases with the residual (pseudo-transient continuation, static.py) becomes Newton's
iteration in the end, which finds unstable equilibria as well as stable ones: at a saddle, such as a straight column
beyond its critical load, no force acts. An unstable equilibrium is therefore left by a small displacement along its
most unstable motion, first to the side on which the state creeps farther, then to the other side if no equilibrium is
found on the first. From there on a step leads downhill only if K + D/2 has no negative direction that the constraints
allow (a step of drag D multiplies a displacement along a stiffness -c by 1/(1 - c/D)), so the drag is kept large
enough.
"""

from dataclasses import dataclass, field
from typing import NoReturn

import numpy as np

from mecano.errors import ConvergenceError
from mecano.model.state import State
from mecano.solve.diagnostics.failure import acting_clause
from mecano.solve.events.events import EventRecord
from mecano.solve.linear.rounding import ROUNDING, TINY
from mecano.solve.statics.continuation import SHRINK, Follower, Point
from mecano.solve.statics.stability import Stability, freedom_text, motion_text
from mecano.solve.statics.static import Status
from mecano.solve.time.increments import displaced, reach_of

FIRST_CREEP, MOST_CREEP = 0.1, 0.3  # displacement in the first step and in any step, in length scales or rad
MOST_CREEPS = 400  # largest number of steps
FADES = 0.02, 0.5  # least and largest factor on the drag per step
STIFFEST = 1e8  # largest drag with which a step is retried, relative to the first one
NUDGE = 0.01  # displacement by which an unstable equilibrium is left, in length scales or rad
NO_DRAG = 0.01  # of the tolerated force: largest force of the drag on a state at rest
ALIKE = 1e-6  # relative difference of creep up to which both sides are equivalent, and the positive one is used
DEPARTURES = 5  # unstable equilibria left before the search fails


@dataclass
class Work:
    """Work of one search: Newton iterations, rejected steps, events."""

    iterations: int = 0
    rejected: int = 0
    event_records: list[EventRecord] = field(default_factory=list)


@dataclass
class Relaxation:
    """Search for a stable equilibrium at the parameter ``end`` by creep against a vanishing drag."""

    end: float
    hint: str = (
        "supports or springs for the parts that still move, or the model without the load that drives them, such as "
        "the motor of a controller: --set loads.NAME=null"
    )
    unstable_hint: str = (
        "supports or springs against this motion; method: steps, which takes an unstable equilibrium, too"
    )

    def follow(self, follower: Follower, point: Point) -> tuple[Point, str]:
        """Return (Point in stable equilibrium, reason of the end). Raises ConvergenceError, NonFiniteError."""
        return self.find(follower, point.state), "an equilibrium was reached"

    def find(self, follower: Follower, s: State) -> Point:
        """Return the Point in stable equilibrium to which the state ``s`` creeps. Raises as ``follow`` does."""
        work = Work()
        s, found, stability = self._equilibrium(follower, s, work)
        while stability.unstable > 0:
            if len(follower.departures) == DEPARTURES:
                self._refuse(follower, s, found, stability, work, f"{DEPARTURES} others have already been left")
            follower.departures.append(self._departure(follower, s, stability))
            s, found, stability = self._below(follower, s, found, stability, work)
        return self._accepted(follower, s, found, work)

    def _below(
        self, follower: Follower, s: State, found: Status, stability: Stability, work: Work
    ) -> tuple[State, Status, Stability]:
        """Return (State, Status, Stability) of an equilibrium next to the unstable one ``s``."""
        if stability.shape is None:
            self._refuse(follower, s, found, stability, work, "its unstable motion is unknown")
        reasons = []
        for beside in self._sides(follower, s, stability.shape, stability.stiffness):
            try:
                return self._equilibrium(follower, beside, work, downhill=True)
            except ConvergenceError as error:
                reasons.append(str(error).partition("\n")[0])
        self._refuse(follower, s, found, stability, work, "; ".join(dict.fromkeys(reasons)))

    def _sides(self, follower: Follower, s: State, shape: np.ndarray, stiffness: float) -> list[State]:
        """Return the states on both sides of the unstable equilibrium ``s``; first the one that creeps farther.

        ``shape`` (n_q,) is its softest motion, ``stiffness`` [N/m] that along it.
        """
        statics, length = follower.statics, follower.statics.length
        sides = [displaced(s, sign * NUDGE * length * shape, statics.system.numbering) for sign in (1, -1)]
        drag = self._downhill(follower, s, 4.0 * max(abs(stiffness), TINY))
        creeps = [statics.correct(side, self.end, drag)[1] for side in sides]
        first, second = (found.change if found.ok else 0.0 for found in creeps)
        return sides if first >= (1.0 - ALIKE) * second else sides[::-1]

    def _equilibrium(
        self, follower: Follower, s: State, work: Work, downhill: bool = False
    ) -> tuple[State, Status, Stability]:
        """Return (State, Status, Stability) of the equilibrium to which ``s`` creeps; ``downhill``: avoid saddles."""
        s = self._creep(follower, s, work, downhill)
        found_s, found = follower.find(s, self.end)
        if not found.ok:
            raise follower.failure(self.end, found, s, self.end, self.hint)
        work.event_records += found.event_records
        follower.refuse(found_s, self.end, follower.observe(found_s, self.end))
        return found_s, found, follower.stability(found_s, self.end)

    def _creep(self, follower: Follower, s: State, work: Work, downhill: bool) -> State:
        """Return the state after creep, with forces balanced to their tolerance or, in stiff members, to rounding."""
        statics, drag, last = follower.statics, None, None
        for _ in range(MOST_CREEPS):
            size, force = self._size(statics, s)
            if size <= 1.0 and drag is not None:
                return s
            first = force / (FIRST_CREEP * statics.length)
            drag = first if drag is None else drag * min(max(force / last, FADES[0]), FADES[1])
            drag = self._downhill(follower, s, drag) if downhill else drag
            last = force
            while True:
                new, found = statics.correct(s, self.end, drag)
                work.iterations += found.iterations
                if found.ok and found.change <= MOST_CREEP:
                    break
                drag, work.rejected = drag / SHRINK, work.rejected + 1
                if drag > STIFFEST * first:
                    found.message = found.message or f"it moves by more than {MOST_CREEP:g} in a step, however short"
                    raise follower.failure(self.end, found, s, self.end, self.hint)
            work.event_records += found.event_records
            moved, s = statics.displacement(new, s), new
            if self._stands_still(statics, s, found.change, drag * size / force):
                return s
        motion = motion_text(statics.system, s, moved, statics.length)
        found.message = f"it still moves after {MOST_CREEPS} steps: {motion}"
        raise follower.failure(self.end, found, s, self.end, self.hint)

    def _stands_still(self, statics, s, change, drag):
        """Return whether a step of creep has moved ``s`` by no more than rounding, for reasons other than its ``drag``.

        ``drag`` is over the tolerated force [1/m].
        """
        rounding = ROUNDING * reach_of(s.z, statics.system.numbering, statics.length)
        return change <= rounding and drag * change * statics.length <= NO_DRAG

    def _downhill(self, follower, s, drag):
        """Return the least of ``drag``, 2 ``drag``, 4 ``drag``, ... with which a step from ``s`` leads downhill."""
        while follower.stability(s, self.end, 0.5 * drag).unstable > 0:
            drag *= 2.0
        return drag

    def _size(self, statics, s):
        """Return (residual over its tolerance, largest residual force [N], moments over the length scale)."""
        k, _ = statics.scales(statics.begin(s))
        size = max(statics.evaluate(s.copy(), self.end, k, 0.0, False))
        own = statics.weight > 0.0
        force = statics.assembly.residual[: statics.system.n_q][own] / np.sqrt(statics.weight[own])
        return size, max(float(np.abs(force).max(initial=0.0)), TINY)

    def _accepted(self, follower: Follower, s: State, found: Status, work: Work) -> Point:
        found.iterations += work.iterations
        found.event_records = tuple(work.event_records)
        return follower.accept(s, self.end, self.end, self.end, found, work.rejected)

    def _departure(self, follower, s, stability):
        """Return the text on an unstable equilibrium that is left."""
        statics = follower.statics
        shape = stability.shape
        motion = "" if shape is None else f": {motion_text(statics.system, s, shape, statics.length)}"
        return f"an unstable equilibrium was found and left on the way{motion}"

    def _refuse(
        self, follower: Follower, s: State, found: Status, stability: Stability, work: Work, why: str
    ) -> NoReturn:
        """Raise ConvergenceError for a search that ended at the unstable equilibrium ``s``, which becomes a Point."""
        statics, system = follower.statics, follower.statics.system
        self._accepted(follower, s, found, work)
        motion = freedom_text(system, s, stability, statics.length)
        if stability.shape is not None:
            most = int(np.argmax(np.abs(stability.shape) * np.sqrt(statics.weight)))
            motion += acting_clause(system, most)
        at = f"{statics.loading.name} {self.end:.6g}{statics.loading.unit}"
        raise ConvergenceError(
            f"no stable equilibrium was found at {at}, only one with {motion}\n"
            f"next to it: {why}\nwhat to try: {self.unstable_hint}"
        )
