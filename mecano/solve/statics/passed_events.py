"""Apply events at an equilibrium, at the places on the way to it where they occur.

A rigid stop, latch, contact or flank holds the place that its memory recorded at the end of the previous step
(docs/shocks.md). Time steps end at events, but a step of statics passes them. The memory is therefore evaluated on the
straight line from the beginning of the step to the equilibrium, where the event value vanishes. An event within a
phase, such as that of a slider which passes to another element of its beam, only records where the equilibrium is.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.maths.root import root

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.solve.events.events import EventRecord
    from mecano.solve.statics.static import Statics

ROUNDING = 1e-15  # of the line


def apply_events(statics: "Statics", s: "State", s0: "State", hit: np.ndarray) -> "tuple[State, list[EventRecord]]":
    """Return (state, [EventRecord]) of the equilibrium ``s`` with the events ``hit`` (n_events,) bool.

    ``s``, in its phases before the events, is displaced from ``s0``; the places of the events lie between both.
    """
    after, records = s, []
    for i in np.flatnonzero(hit):
        one = np.zeros_like(hit)
        one[i] = True
        phases = after.phases
        after, found = statics.monitor.apply(statics.monitor.passed(after, one), one)
        records += found
        held = _memory_of(statics.system, after.phases != phases)
        if held.any() and (place := _place(statics, s, s0, i)) is not None:
            after = replace(after, memory=np.where(held, statics.system.commit(place), after.memory))
    return after, records


def _memory_of(system, elements):
    """Return (n_memory,) bool: items of the memory that belong to the ``elements`` (n_phases,) bool."""
    parts = [np.repeat(elements[batch.phases], len(batch.kind.memory)) for batch in system.batches]
    return np.concatenate([*parts, np.zeros(int(system.states.sum()), bool)])


def _place(statics, s, s0, i):
    """Return the state between ``s0`` and ``s`` in which the event value i vanishes, or None."""
    start, way = replace(s0, phases=s.phases), np.zeros(statics.system.n)
    way[: statics.system.n_q] = statics.displacement(s, s0)

    def at(share):
        state = statics.begin(start)
        statics.move(state, start, share * way, 1.0)
        return state

    def value(share):
        return statics.monitor.values(at(share))[i]

    if not value(0.0) < 0.0 < value(1.0):
        return None
    return at(root(value, 0.0, 1.0, ROUNDING))
