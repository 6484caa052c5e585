"""Events: which happened in a step, when exactly, and the modes after them.

A step is pure, so an event is located by stepping again with a smaller h; no cooperation of the method is needed.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from mecano.compiled.entry import Vector, entry
from mecano.solve.time.signals import solve_signals

TIME_TOLERANCE = 1e-10  # of the step in which the event lies
AT_ONCE = 1e-7  # an event in this first part of a step happens at its beginning
TOGETHER = 1e-6  # of its change in the step: an event that lacks no more happens with the one that is located
EQUAL = 1e-6  # of its value at the beginning of the step: what differs by less, with consistent reactions, is equal
NEAR = 0.01  # of the step: the first place that is tried is no nearer to its ends
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

    def together(self, hit, before, here, committed):
        """The events ``hit`` (n_events,) bool and all others of the same instant.

        ``before`` (n_events,) are the values at the beginning of the step, ``here`` at its end, with consistent
        reactions, ``committed`` with what the step has committed. Of a step, reactions are known to the tolerance of
        Newton's method, so that those of equal members vanish at different times; consistent ones are equal to
        rounding.
        """
        hit, first = hit | (self.within & np.isfinite(here) & (here != committed)), 0
        for batch in self.system.batches:
            n, shape = batch.event_values.size, batch.event_values.shape
            of_batch, g0, g = (values[first : first + n].reshape(shape) for values in (hit, before, here))
            level = np.where(of_batch, g, np.inf).min(axis=0, initial=np.inf)
            near = np.isfinite(g0) & np.isfinite(g) & np.isfinite(level) & (g0 < 0.0)
            near &= ~self.within[first : first + n].reshape(shape)
            of_batch |= near & (np.where(near, g - level, -np.inf) >= -EQUAL * np.abs(g0))
            first += n
        return hit

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
        s = s.copy() if self.system.signals.any() else s
        for _ in range(10):
            hit = self.values(solve_signals(self.system, s)) > 0
            if not hit.any():
                break
            s, _ = self.apply(s, hit)
        return s


class NoEvents(Watch):
    """No events: elements stay in the modes in which they are."""

    def values(self, s):
        """-inf for all events of each element, (n_events,)."""
        return np.full_like(super().values(s), -np.inf)


@entry
def _some_happened(g0: Vector, g1: Vector) -> bool:
    """True when an event has happened between values g0 and g1 (n_events,), or had already before."""
    for i in range(g0.shape[0]):
        if (g0[i] < 0.0 and g1[i] >= 0.0) or (g0[i] >= 0.0 and g1[i] > 0.0):
            return True
    return False


def locate(watch, step, s0, g0, trial, h):
    """The first event in a trial step as ``Located``, or None when there is none.

    step(h) -> trial, whose first item is the state; trial = step(h); g0 values at s0. Chandrupatla's method (Adv. Eng.
    Software 28, 1997, 145-149) on the step size, for the largest of the event functions that crossed, from both sides
    of the event: five to eight steps where they are smooth.
    """
    g1 = watch.values(trial[0])
    if not _some_happened(g0, g1):
        return None
    if np.any((g0 > 0) & (g1 > 0)):  # happened together with the last event, behind its back
        return Located(0.0, None, (g0 > 0) & (g1 > 0))
    crossed = ((g0 < 0) & (g1 >= 0)) | ((g0 == 0) & (g1 > 0))
    early, late, best = (0.0, float(g0[crossed].max())), (h, float(g1[crossed].max())), trial
    newest, opposite, share = late, early, late[1] / (late[1] - early[1]) if np.isfinite(early[1]) else 0.5
    share = min(max(share, NEAR), 1.0 - NEAR)  # what has just departed may come back
    for _ in range(MAX_RESTEPS):
        between = late[0] - early[0]
        if between <= TIME_TOLERANCE * h or late[0] <= AT_ONCE * h or late[1] == 0.0:
            break
        least = 0.5 * TIME_TOLERANCE * h / between
        middle = newest[0] + min(max(share, least), 1.0 - least) * (opposite[0] - newest[0])
        new = step(middle)
        if not new[2].ok:
            return Located(middle, new, crossed)
        place = middle, float(watch.values(new[0])[crossed].max())
        older, opposite = (newest, opposite) if (place[1] >= 0) == (newest[1] >= 0) else (opposite, newest)
        newest = place
        if place[1] >= 0:
            late, best = place, new
        else:
            early = place
        share = _share(newest, opposite, older)
    hit = crossed.copy()
    rise = g1[crossed] - np.maximum(g0[crossed], -g1[crossed])
    hit[crossed] = watch.values(best[0])[crossed] >= np.where(watch.within[crossed], 0.0, -TOGETHER * rise)
    # what happens within a mode is known to have happened by what a step commits: it takes a step, however short
    at_once = late[0] <= AT_ONCE * h and not watch.within_a_mode(hit)
    return Located(0.0, None, hit) if at_once else Located(late[0], best, hit)


def _share(newest, opposite, older):
    """How far on the way from the ``newest`` place to the ``opposite`` one, (step size, value), the value is zero.

    By a parabola of the step size over the value where it is sure to be monotonous, else half of the way.
    """
    (a, f_a), (b, f_b), (c, f_c) = newest, opposite, older
    if not np.isfinite([f_a, f_b, f_c]).all() or f_c == f_b:
        return 0.5
    x, f = (a - b) / (c - b), (f_a - f_b) / (f_c - f_b)
    if f * f >= x or (1.0 - f) ** 2 >= 1.0 - x:
        return 0.5
    return f_a / (f_b - f_a) * f_c / (f_b - f_c) + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b)
