"""Grips that are closed at the start, because their conditions are true there."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.element_interface import LOCK
from mecano.solve.events.events import EventMonitor
from mecano.solve.time.signals import solve_signals

if TYPE_CHECKING:
    from mecano.element_interface import Kind
    from mecano.model.state import State
    from mecano.model.system import System


def may_grip(kind: "Kind") -> bool:
    """Return whether a condition activates constraints of a kind with a shock."""
    return any(event.shock == LOCK and event.condition for event in kind.events)


def with_closed_grips(system: "System", s: "State") -> "State":
    """Return the start ``s`` with the grips closed whose conditions are true, in the positions there.

    Their constraints count from the start on: for redundancies, in statics and for modes. Conditions on reactions,
    which are not known yet, are judged again at the start of a run.
    """
    monitor = EventMonitor(system)
    begun = replace(s, memory=system.commit(solve_signals(system, s.copy())))
    begun = monitor.settle(begun, np.where(monitor.reversible, 0.0, np.inf))
    if all(np.array_equal(begun.phases[b.phases], s.phases[b.phases]) for b in system.batches if may_grip(b.kind)):
        return s
    begun.memory[system.places_of_past] = 0.0
    return begun
