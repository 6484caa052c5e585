"""Start of a run: phases, consistent motion, contacts that are pressed together, conditions that are met, samples."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.solve.time.contradictions import start_stiff, stiffened
from mecano.solve.time.run_state import RunState
from mecano.solve.time.signals import solve_signals

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.solve.events.events import EventRecord
    from mecano.solve.time.time_integration import TimeIntegrator

SAME = 1e-9  # relative and absolute change of a sampled value that is rounding


class Beginning:
    """The start of a run by a TimeIntegrator.

    Contacts that touch are closed if they are pressed together. Those that separate are open, even if rounding makes
    them overlap. Lasting conditions, such as that of a release, are judged with the reactions, velocities and closed
    contacts of the start. Samples and delayed inputs, unless they are known, begin with these.
    """

    def __init__(self, integrator: "TimeIntegrator"):
        self.integrator, self.system, self.method = integrator, integrator.system, integrator.method
        self.monitor, self.shocks = integrator.monitor, integrator.shocks
        self.least = np.where(self.monitor.lasting, np.inf, self.shocks.touching)  # of events of the first phases

    def of(self, s: "State", h: float) -> "tuple[RunState, list[EventRecord]]":
        """Return the RunState at the start ``s``, for a first step ``h`` [s], and the events there."""
        self.samples = not s.memory[self.system.places_of_past].any()
        s = replace(s, memory=self.system.commit(solve_signals(self.system, s.copy())))
        s, due = self.monitor.settle(s, self.least), []
        if self.monitor.due(s).any():
            s, due = self._judged(s, h)
        run, closed = self._begun(s, h)
        return run, [*closed, *due]

    def _judged(self, s, h):
        """Return ``s`` with the lasting conditions that are met in the motion that begins without them, and events."""
        compliance = self.method.compliance
        run, _ = self._begun(s.copy(), h)
        self.method.use(compliance)
        s, due = self.monitor.apply(s, self.monitor.due(run.motion))
        return self.monitor.settle(s, self.least), due

    def _begun(self, s, h):
        """Return the RunState of consistent ``s``, and the events of the contacts that are pressed together."""
        s, history = start_stiff(self.method, s, h)
        run = RunState(s, history, h, compliance=self.method.compliance)
        run, events = self._close_pressed(replace(run, powers=self.integrator.observe(s).powers))
        return self._sampled(run), events

    def _close_pressed(self, run):
        """Close the contacts that are pressed together, repeatedly, as in a pile; return the run and the events."""
        events = []
        for _ in self.shocks.impact_candidates:
            hit = self.shocks.pressed(run.motion, run.h)
            if not hit.any():
                break
            run, s, happened, consistent = self.integrator.events.apply(run, run.motion, hit, at_once=True)
            run = self._stiffened(self.integrator.start_again(run, s, consistent))
            events += happened
        return run, events

    def _stiffened(self, run):
        """Return the run with compliances of redundant contacts for the forces there, or others would not touch."""
        while displacement := self.method.contradictions.displaced(run.motion):
            run = stiffened(self.method, run, displacement)
            run = replace(run, powers=self.integrator.observe(run.motion).powers)
        return run

    def _sampled(self, run):
        """Return the run with samples and delayed inputs that begin with its velocities and reactions."""
        past = self.system.places_of_past
        if not past.size or not self.samples:
            return run
        memory = run.motion.memory.copy()
        memory[past] = 0.0
        s = solve_signals(self.system, replace(run.motion.copy(), memory=memory))
        memory[past] = self.system.commit(s)[past]
        if np.allclose(memory[past], run.motion.memory[past], rtol=SAME, atol=SAME):
            return run
        return self.integrator.start_again(run, replace(run.motion, memory=memory))
