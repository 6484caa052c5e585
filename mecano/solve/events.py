"""Events: which happened in a step, when exactly, and the modes after them.

A step is pure, so an event is located by stepping again with a smaller h; no cooperation of the method is needed.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from mecano.compiled.entry import Vector, entry

TIME_TOLERANCE = 1e-10  # of the step in which the event lies
AT_ONCE = 1e-7  # an event in this first part of a step happens at its beginning
TOGETHER = 1e-6  # of its change in the step: an event that lacks no more happens with the one that is located
MAX_RESTEPS = 60


@dataclass(frozen=True)
class Happening:
    """An event that happened: when, where, and the change of mode."""

    t: float
    element: str
    name: str
    before: str
    after: str
    impulse: float = 0.0  # [N s, N m s] along growing Phi, of a shock
    unit: str = ""  # of the impulse; "" for an event without shock
    lost: float = 0.0  # energy [J]


class Located(NamedTuple):
    """Where in a step the first event lies."""

    h: float  # size of the step that ends at it [s]; 0 when it happens at the beginning
    trial: tuple | None  # that step, or the one that failed in Newton, which ended the search; None when h is 0
    hit: np.ndarray  # (n_events,) bool, events that happen there

    @property
    def ok(self):
        """False when the search met a step that Newton cannot take."""
        return self.trial is None or self.trial[2].ok


class Watch:
    """The event functions of a system."""

    def __init__(self, system):
        self.system = system
        within = [e.before == e.after for batch in system.batches for _ in batch.names for e in batch.kind.events]
        self.within = np.array(within, bool)

    def within_a_mode(self, hit):
        """True when accelerations jump at some of the events ``hit`` (n_events,) bool though no mode changes."""
        return bool(np.any(hit & self.within))

    def values(self, s):
        """One number for each event of each element, (n_events,); -inf for those not watched in the present mode."""
        return self.system.event_values(s)

    def apply(self, s, hit):
        """The state after the events ``hit`` (n_events,) bool: (state with new modes, [Happening])."""
        modes, happenings, first = s.modes.copy(), [], 0
        for batch in self.system.batches:
            n = batch.event_values.size
            of_batch, own = hit[first : first + n].reshape(batch.event_values.shape), modes[batch.modes]
            for e, k in zip(*np.nonzero(of_batch), strict=True):
                event = batch.kind.events[k]
                own[e] = batch.kind.modes.index(event.after)
                happenings.append(Happening(s.t, batch.names[e], event.name, event.before, event.after))
            first += n
        self.system.follow(modes)
        return replace(s, modes=modes), happenings

    def entered(self, s, event):
        """The state after an ``event`` with an element, a name and two modes, if that element is in the first."""
        modes = s.modes.copy()
        for batch in self.system.batches:
            names = [(of.name, of.before, of.after) for of in batch.kind.events]
            if event.element in batch.names and (event.name, event.before, event.after) in names:
                own, before, after = modes[batch.modes], *map(batch.kind.modes.index, (event.before, event.after))
                own[(np.array(batch.names) == event.element) & (own == before)] = after
        self.system.follow(modes)
        return replace(s, modes=modes)

    def settle(self, s):
        """The state with the modes that its event values tell: for a start. Happenings of a start are not reported."""
        for _ in range(10):
            hit = self.values(s) > 0
            if not hit.any():
                break
            s, _ = self.apply(s, hit)
        return s


@entry
def _some_happened(g0: Vector, g1: Vector) -> bool:
    """True when an event has happened between values g0 and g1 (n_events,), or had already before."""
    for i in range(g0.shape[0]):
        if (g0[i] < 0.0 and g1[i] >= 0.0) or (g0[i] >= 0.0 and g1[i] > 0.0):
            return True
    return False


def locate(watch, step, s0, g0, trial, h):
    """The first event in a trial step as ``Located``, or None when there is none.

    step(h) -> trial, whose first item is the state; trial = step(h); g0 values at s0. Illinois variant of the regula
    falsi on the step size, for the largest of the event functions that crossed.
    """
    g1 = watch.values(trial[0])
    if not _some_happened(g0, g1):
        return None
    if np.any((g0 > 0) & (g1 > 0)):  # happened together with the last event, behind its back
        return Located(0.0, None, (g0 > 0) & (g1 > 0))
    crossed = ((g0 < 0) & (g1 >= 0)) | ((g0 == 0) & (g1 > 0))
    lo, hi, best = 0.0, h, trial
    G_lo, G_hi = g0[crossed].max(), g1[crossed].max()
    side = 0
    for _ in range(MAX_RESTEPS):
        if hi - lo <= TIME_TOLERANCE * h or hi <= AT_ONCE * h or G_hi == 0.0:
            break
        middle = hi - G_hi * (hi - lo) / (G_hi - G_lo) if np.isfinite(G_lo) else 0.5 * (lo + hi)
        middle = min(max(middle, lo + 0.01 * (hi - lo)), hi - 0.1 * TIME_TOLERANCE * h)
        new = step(middle)
        if not new[2].ok:
            return Located(middle, new, crossed)
        g = watch.values(new[0])[crossed].max()
        if g >= 0:
            hi, G_hi, best = middle, g, new
            G_lo = G_lo * 0.5 if side == 1 else G_lo
            side = 1
        else:
            lo, G_lo = middle, g
            G_hi = G_hi * 0.5 if side == -1 else G_hi
            side = -1
    hit = crossed.copy()
    rise = g1[crossed] - np.maximum(g0[crossed], -g1[crossed])
    hit[crossed] = watch.values(best[0])[crossed] >= np.where(watch.within[crossed], 0.0, -TOGETHER * rise)
    # what happens within a mode is known to have happened by what a step commits: it takes a step, however short
    at_once = hi <= AT_ONCE * h and not watch.within_a_mode(hit)
    return Located(0.0, None, hit) if at_once else Located(hi, step(hi), hit)
