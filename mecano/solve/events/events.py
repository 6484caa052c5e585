"""Events: detect them in a step, and apply the change of phase."""

from dataclasses import dataclass, replace

import numpy as np

from mecano.jit.entry import Vector, entry
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.time.signals import solve_signals

EQUAL = 1e-6  # relative to the value at the beginning of the step: values that differ by less are equal


@dataclass(frozen=True)
class EventRecord:
    """An event that happened: time, element, change of phase, and impulse if any."""

    t: float
    element: str
    name: str
    before: str
    after: str
    impulse: float = 0.0  # [N s, N m s] of a shock, along growing Phi; the magnitude where it is a vector
    unit: str = ""  # of the impulse; "" for an event without shock
    lost: float = 0.0  # energy [J]; negative if it is given


class EventMonitor:
    """Event functions of a system, and the phase changes they cause."""

    def __init__(self, system: System):
        self.system, self._batches = system, [batch for batch in system.batches if batch.kind.events]
        events = [e for batch in system.batches for _ in batch.names for e in batch.kind.events]
        self.within = np.array([e.before == e.after for e in events], bool)
        self.changes_energy = np.array([e.changes_energy for e in events], bool)
        self.elastic = np.array([e.elastic for e in events], bool)
        self.smooth = np.array([e.elastic and not e.shock for e in events], bool)  # velocities stay
        self.impacts = np.array([bool(e.shock) for e in events], bool)
        self.one_sided = np.array([e.one_sided for e in events], bool)
        self.brief = np.flatnonzero([e.brief for e in events])  # sought within steps, as are the conditions
        conditions = np.array([e.condition or bool(e.command) for e in events], bool)
        self.conditions = np.flatnonzero(conditions)
        lasting = [lasts for batch in system.batches for _ in batch.names for lasts in _lasting(batch.kind.events)]
        self.lasting = np.array(lasting, bool)
        self.reversible = conditions & ~self.lasting  # another event undoes them, as those of switches
        self.final = [  # phases of elements, and the one in which a run has ended
            (batch.phases, batch.kind.phases.index(event.after))
            for batch in self._batches
            for event in batch.kind.events
            if event.ends_run
        ]
        self.captures = False  # whether ``values`` omits elastic events

    def within_a_phase(self, hit: np.ndarray) -> bool:
        """Return whether some events ``hit`` (n_events,) bool make accelerations jump without a change of phase."""
        return bool(np.any(hit & self.within))

    def are_conditions(self, hit: np.ndarray) -> bool:
        """Return whether all events ``hit`` (n_events,) bool are conditions, such as switches of signals."""
        return int(np.sum(hit)) == int(np.sum(hit[self.conditions]))

    def ended(self, s: State) -> bool:
        """Return whether an event that ends the run has happened before or at ``s``."""
        return any(bool((s.phases[of] == phase).any()) for of, phase in self.final)

    def changing_energy(self, hit: np.ndarray) -> dict[int, tuple[str, str]]:
        """Return {index of the element: (its name, name of the event)} of the events ``hit`` that change its energy.

        Parts of the same element may have the same names.
        """
        found, changes = {}, hit & self.changes_energy
        for batch in self._batches if np.any(changes) else ():
            found |= {
                batch.first_phase + e: (batch.names[e], batch.kind.events[k].name)
                for e, k in zip(*np.nonzero(batch.events(changes)), strict=True)
            }
        return found

    def values(self, s: State) -> np.ndarray:
        """Return the event values (n_events,) of all elements; -inf for events not active in the current phase.

        Elastic events are omitted while they are captured (capture.py).
        """
        values = self.system.event_values(s)
        return np.where(self.elastic, -np.inf, values) if self.captures else values

    def captured(self, s: State) -> np.ndarray:
        """Return the elastic events (n_events,) bool that have happened at ``s``."""
        return self.elastic & (self.system.event_values(s) > 0.0)

    def together(self, hit: np.ndarray, before: np.ndarray, here: np.ndarray, committed: np.ndarray) -> np.ndarray:
        """Return the events ``hit`` (n_events,) bool together with all others at the same instant.

        ``before`` (n_events,) are the values at the beginning of the step, ``here`` at its end with consistent
        reactions, ``committed`` after the memories of the step are committed. A step yields reactions only to the
        tolerance of Newton's method, so that those of identical members vanish at different times; consistent
        reactions agree to rounding.
        """
        hit = hit | (self.within & np.isfinite(here) & (here != committed))
        for batch in self._batches:
            of_batch, g0, g, within = (batch.events(values) for values in (hit, before, here, self.within))
            level = np.where(of_batch, g, np.inf).min(axis=0, initial=np.inf)
            near = np.isfinite(g0) & np.isfinite(g) & np.isfinite(level) & (g0 < 0.0)
            near &= ~within
            of_batch |= near & (np.where(near, g - level, -np.inf) >= -EQUAL * np.abs(g0))
        return hit

    def apply(self, s: State, hit: np.ndarray) -> tuple[State, list[EventRecord]]:
        """Apply the events ``hit`` (n_events,) bool; return (state with new phases, [EventRecord])."""
        phases, event_records = s.phases.copy(), []
        for batch in self._batches:
            own = phases[batch.phases]
            for e, k in zip(*np.nonzero(batch.events(hit)), strict=True):
                event = batch.kind.events[k]
                own[e] = batch.kind.phases.index(event.after)
                event_records.append(EventRecord(s.t, batch.names[e], event.name, event.before, event.after))
        self.system.follow(phases)
        return replace(s, phases=phases), event_records

    def passed(self, s: State, hit: np.ndarray) -> State:
        """Return the state with new memories of elements with events ``hit`` within a phase, as of passing sliders."""
        if not self.within_a_phase(hit):
            return s
        events, memory = hit & self.within, []
        for batch in self.system.batches:
            memory.append(np.repeat(batch.events(events).any(axis=1), len(batch.kind.memory)))
        memory.append(np.zeros(int(self.system.states.sum()), bool))
        return replace(s, memory=np.where(np.concatenate(memory), self.system.commit(s), s.memory))

    def entered(self, s: State, element: str, name: str, before: str, after: str) -> State:
        """Return the state after the event ``name`` of an ``element``, if the element is in the phase before it."""
        phases = s.phases.copy()
        for batch in self._batches:
            changes = [(event.name, event.before, event.after) for event in batch.kind.events]
            if element in batch.names and (name, before, after) in changes:
                own, index = phases[batch.phases], batch.kind.phases.index
                own[(np.array(batch.names) == element) & (own == index(before))] = index(after)
        self.system.follow(phases)
        return replace(s, phases=phases)

    def settle(self, s: State, least: float | np.ndarray = 0.0) -> State:
        """Return the initial state with its phases consistent with the event values; these changes are not recorded.

        Events whose values do not exceed ``least``, a number or (n_events,), do not happen.
        """
        s = s.copy() if self.system.signals.any() else s
        for _ in range(10):
            hit = self.values(solve_signals(self.system, s)) > least
            if not hit.any():
                break
            s, _ = self.apply(self.passed(s, hit), hit)
        return s

    def due(self, s: State) -> np.ndarray:
        """Return the lasting conditions (n_events,) bool met at ``s``, with the switches that follow from it."""
        if not self.lasting.any():
            return self.lasting
        switches = self.settle(s, np.where(self.reversible, 0.0, np.inf))
        return self.lasting & (self.values(solve_signals(self.system, switches.copy())) > 0.0)


def _lasting(events):
    """Return whether each of the Events of a kind is by a condition or a command, and undone by no other: a release."""
    back = [(event.after, event.before) for event in events]
    return [(event.condition or bool(event.command)) and (event.before, event.after) not in back for event in events]


class Searching(EventMonitor):
    """Monitor in the search for the start of a motion, in which lasting conditions are not judged.

    The reactions of the motion, on which they may depend, are not known yet.
    """

    def values(self, s: State) -> np.ndarray:
        """Return the event values (n_events,), of lasting conditions -inf."""
        return np.where(self.lasting, -np.inf, super().values(s))


class NoEvents(EventMonitor):
    """Monitor that detects no events: elements keep their phases."""

    def values(self, s: State) -> np.ndarray:
        """Return -inf (n_events,) for all events."""
        return np.full_like(super().values(s), -np.inf)


@entry
def some_happened(g0: Vector, g1: Vector) -> bool:
    """Return whether an event value crosses zero from g0 to g1 (n_events,), or is positive at either end."""
    for i in range(g0.shape[0]):
        if g0[i] > 0.0 or g1[i] > 0.0 or (g0[i] < 0.0 and g1[i] == 0.0):
            return True
    return False
