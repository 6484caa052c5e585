"""Capture of events: elements take the phases consistent with the end of a step, instead of one step per event.

A run in which all events are located does not end where they accumulate: stiff lines on light nodes may become slack
and taut much faster than the steps. Time-stepping schemes (Acary & Brogliato, Numerical Methods for Nonsmooth Dynamical
Systems, Springer 2008) pass such instants: like the motion, the phases follow from the equations at the end of the
step. The step is repeated in other phases until no element has an event that is new in this step. For lines that only
pull, the equations are a linear complementarity problem, and this is Newton's method on it; of an elastic line with a
winder it is the return mapping of plasticity: the elastic line first, its winder if the tension is too large.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from typing import Any

import numpy as np

from mecano.immutable import mutable
from mecano.model.state import State
from mecano.solve.events.events import EventMonitor, EventRecord
from mecano.solve.time.run_state import RunState
from mecano.solve.time.step_info import Trial


@mutable
class EventCapture:
    """Decides when elastic events (``Event.elastic``) are captured, and makes the steps that capture them.

    Elastic events are located until, over some part of the run, they outnumber the steps without events by more than
    ``most``, which bounds the work. From then on they are captured, until a whole step has none; meanwhile the
    ``monitor`` omits their values.
    """

    monitor: EventMonitor
    most: int
    excess: int = 0  # of instants over steps
    counted: int = 0  # steps of the run up to the last instant
    first: float = np.inf  # [s] at which capturing began for the first time
    steps: int = 0  # that captured events
    by_element: Counter = field(default_factory=Counter)  # captured events

    def count(self, hit: np.ndarray, run: RunState) -> None:
        """Count the instant at the end of ``run`` if elastic events are among ``hit`` (n_events,) bool."""
        if self.monitor.captures or not np.any(hit & self.monitor.elastic):
            return
        between = max(run.steps - self.counted - 1, 0)
        self.excess, self.counted = max(self.excess - between, 0) + 1, run.steps
        if self.excess > self.most:
            self.begin(hit, run)

    def begin(self, hit: np.ndarray, run: RunState) -> bool:
        """Begin to capture events at the end of ``run``; return whether any ``hit`` (n_events,) was located before."""
        begins = not self.monitor.captures and bool(np.any(hit & self.monitor.elastic))
        if begins:
            self.monitor.captures = True
            self.first = min(self.first, run.motion.t)
        return begins

    def accepted(self, event_records: Sequence[EventRecord], whole: bool) -> None:
        """Note the events captured in an accepted step; end the capture if there are none in a ``whole`` step."""
        self.steps += bool(event_records)
        self.by_element.update(event.element for event in event_records)
        if whole and not event_records:
            self.monitor.captures = False

    def step(self, step: "Callable[[State], Trial]", s: State) -> "Trial | None":
        """Return the trial ``step(s)`` in the phases that fit its end, or None if none are found.

        Its info has the events captured. An element has each event at most once, so the repetitions end; if an event is
        due again, the phases contradict the end of the step, which lines with much damping may cause.
        """
        monitor, had, iterations = self.monitor, np.zeros(len(self.monitor.elastic), bool), 0
        event_records: list[EventRecord] = []
        trial = None
        while True:
            if trial is None:
                trial = step(s)
                iterations += trial[2].iterations
            hit = monitor.captured(trial[0]) & ~had if trial[2].ok else np.zeros_like(had)
            if not np.any(hit):
                if trial[2].ok and np.any(monitor.captured(trial[0]) & had):
                    return None
                trial[2].iterations, trial[2].event_records = iterations, tuple(event_records)
                return trial
            had |= hit
            s, found = monitor.apply(s, hit)
            event_records += [replace(event, t=trial[0].t) for event in found]
            trial = self._in_phases(trial, s.phases)

    def _in_phases(self, trial: "Trial", phases: np.ndarray) -> "Trial | None":
        """Return the ``trial`` with these ``phases`` at its end, or None if the forces there depend on the change."""
        end = replace(trial[0], phases=phases)
        forces = self.monitor.system.forces
        return (end, *trial[1:]) if np.array_equal(forces(trial[0]), forces(end)) else None

    def to_plain(self) -> dict[str, Any]:
        """Return a dict of numbers from which ``from_plain`` continues."""
        own = {name: getattr(self, name) for name in ("excess", "counted", "first", "steps")}
        return {**own, "active": self.monitor.captures, "by_element": dict(self.by_element)}

    def from_plain(self, plain: Mapping[str, Any]) -> None:
        """Continue from the result of ``to_plain``."""
        self.excess, self.counted = plain["excess"], plain["counted"]
        self.first, self.steps, self.by_element = plain["first"], plain["steps"], Counter(plain["by_element"])
        self.monitor.captures = plain["active"]
