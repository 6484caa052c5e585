r"""Relaxation: the state creeps down to a stable equilibrium against a drag that fades, :math:`D \dot q = -r(q)`.

Implicit Euler with a drag that falls with the residual (pseudo-transient continuation, static.py) ends in Newton's
iteration, which finds unstable equilibria as well as stable ones: on a saddle, such as a straight column beyond its
critical load, no force acts. An equilibrium that is unstable is therefore left by a small displacement along its most
unstable motion, towards the side on which the state creeps farther, and then along the other one if there is nothing
on the first. From there on a step leads downhill only if K + D/2 has no negative direction that constraints allow (a
step of drag D multiplies a displacement along a stiffness -c by 1/(1 - c/D)), so the drag is kept above that.
"""

from dataclasses import dataclass, field

import numpy as np

from mecano.errors import ConvergenceError
from mecano.solve.diagnostics.failure import acting
from mecano.solve.statics.continuation import SHRINK
from mecano.solve.statics.stability import freedom, words
from mecano.solve.time.increments import displaced

FIRST_CREEP, MOST_CREEP = 0.1, 0.3  # of the length scale, or rad: displacement in the first and in any step of creep
MOST_CREEPS = 400
FADES = 0.02, 0.5  # least and most of the drag that remains after a step of creep
STIFFEST = 1e8  # of the first drag: largest drag with which a step is retried
NUDGE = 0.01  # of the length scale, or rad: displacement with which an unstable equilibrium is left
ALIKE = 1e-6  # of the larger creep: two sides that differ by less are alike, and the positive one is taken
DEPARTURES = 5  # unstable equilibria left before giving up


@dataclass
class Work:
    """Work of one search: Newton iterations, rejected steps, events."""

    iterations: int = 0
    rejected: int = 0
    event_records: list = field(default_factory=list)


@dataclass
class Relaxation:
    """At the one parameter ``end``, by creep against a drag that fades to nothing, to a stable equilibrium."""

    end: float
    hint: str = "supports or springs for what still moves"
    unstable_hint: str = (
        "supports or springs against this motion; method: steps, which takes an unstable equilibrium, too"
    )

    def follow(self, follower, point):
        """(the Point in stable equilibrium, reason). Raises ConvergenceError, NonFiniteError."""
        return self.find(follower, point.state), "an equilibrium was reached"

    def find(self, follower, s):
        """The Point in stable equilibrium to which the state ``s`` creeps. Raises as ``follow`` does."""
        work = Work()
        s, found, stability = self._equilibrium(follower, s, work)
        while stability.unstable > 0:
            if len(follower.departures) == DEPARTURES:
                self._refuse(follower, s, found, stability, work, f"{DEPARTURES} others were left so before")
            follower.departures.append(self._departure(follower, s, stability))
            s, found, stability = self._below(follower, s, found, stability, work)
        return self._accepted(follower, s, found, work)

    def _below(self, follower, s, found, stability, work):
        """The equilibrium beside the unstable one ``s``: what ``_equilibrium`` returns."""
        if stability.shape is None:
            self._refuse(follower, s, found, stability, work, "its unstable motion is not known")
        reasons = []
        for beside in self._sides(follower, s, stability):
            try:
                return self._equilibrium(follower, beside, work, downhill=True)
            except ConvergenceError as error:
                reasons.append(str(error).partition("\n")[0])
        self._refuse(follower, s, found, stability, work, "; ".join(dict.fromkeys(reasons)))

    def _sides(self, follower, s, stability):
        """The states on both sides of the unstable equilibrium ``s``, the one from which it creeps farther first."""
        statics, length = follower.statics, follower.statics.length
        sides = [displaced(s, sign * NUDGE * length * stability.shape, statics.system.numbering) for sign in (1, -1)]
        drag = self._downhill(follower, s, 4.0 * max(abs(stability.stiffness), 1e-300))
        creeps = [statics.correct(side, self.end, drag)[1] for side in sides]
        first, second = (found.change if found.ok else 0.0 for found in creeps)
        return sides if first >= (1.0 - ALIKE) * second else sides[::-1]

    def _equilibrium(self, follower, s, work, downhill=False):
        """(State, Found, Stability) of the equilibrium to which ``s`` creeps; ``downhill``: by no saddle's way."""
        s = self._creep(follower, s, work, downhill)
        found_s, found = follower.find(s, self.end)
        if not found.ok:
            raise follower.failure(self.end, found, s, self.end, self.hint)
        work.event_records += found.event_records
        follower.refuse(found_s, self.end)
        return found_s, found, follower.stability(found_s, self.end)

    def _creep(self, follower, s, work, downhill):
        """The state after creep to where forces are balanced to their tolerance."""
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
                    raise follower.failure(self.end, found, s, self.end, self.hint)
            work.event_records += found.event_records
            moved, s = statics.displacement(new, s), new
        found.message = f"it still moves after {MOST_CREEPS} steps: {words(statics.system, s, moved, statics.length)}"
        raise follower.failure(self.end, found, s, self.end, self.hint)

    def _downhill(self, follower, s, drag):
        """The least drag of ``drag`` and its doubles with which a step from ``s`` leads downhill."""
        while follower.stability(s, self.end, 0.5 * drag).unstable > 0:
            drag *= 2.0
        return drag

    def _size(self, statics, s):
        """Residual over its tolerance, and the largest residual force [N] (moments over the length scale)."""
        k, _ = statics.scales(statics.begin(s))
        size = max(statics.evaluate(s.copy(), self.end, k, 0.0, False))
        force = np.abs(statics.system.residual[: statics.system.n_q] / np.sqrt(statics.weight)).max(initial=0.0)
        return size, max(float(force), 1e-300)

    def _accepted(self, follower, s, found, work):
        found.iterations += work.iterations
        found.event_records = tuple(work.event_records)
        return follower.accept(s, self.end, self.end, self.end, found, work.rejected)

    def _departure(self, follower, s, stability):
        """Text on an unstable equilibrium that is left."""
        statics = follower.statics
        shape = stability.shape
        motion = "" if shape is None else f": {words(statics.system, s, shape, statics.length)}"
        return f"an unstable equilibrium was met and left on the way{motion}"

    def _refuse(self, follower, s, found, stability, work, why):
        """Raise the error of a search that ended at the unstable equilibrium ``s``, which becomes a Point."""
        statics, system = follower.statics, follower.statics.system
        self._accepted(follower, s, found, work)
        motion = freedom(system, s, stability, statics.length)
        if stability.shape is not None:
            most = int(np.argmax(np.abs(stability.shape) * np.sqrt(statics.weight)))
            motion += acting(system, most)
        at = f"{statics.loading.name} {self.end:.6g}{statics.loading.unit}"
        raise ConvergenceError(
            f"no stable equilibrium was found at {at}, only one with {motion}\n"
            f"beside it: {why}\nwhat to try: {self.unstable_hint}"
        )
