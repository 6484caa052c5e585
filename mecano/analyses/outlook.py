"""Notice, while a run goes on, that it will take long because its steps are very short, or end at events."""

import time as clock
from collections.abc import Callable
from typing import TYPE_CHECKING

from mecano.errors import name_list

if TYPE_CHECKING:
    from mecano.solve.time.run_state import RunState
    from mecano.solve.time.time_integration import TimeIntegrator

WATCHED = 20.0  # s of wall-clock time over which the pace is measured
LONG = 600.0  # s of wall-clock time that the rest of the run would take, at least
SHORT = 1e-3  # of the longest step so far: shorter ones are reported
MANY = 0.5  # of the steps: that many end at events, and are reported
MOST_NAMES = 5
UNITS = (3.1557e7, "years"), (86400.0, "days"), (3600.0, "hours"), (60.0, "minutes")


class Outlook:
    """Watch over the pace of a run to the time ``end`` [s], which passes one notice to ``announce``.

    ``run`` is its RunState at the beginning of the watch.
    """

    def __init__(self, integrator: "TimeIntegrator", end: float, announce: Callable[[str], object], run: "RunState"):
        self.integrator, self.end, self.announce = integrator, end, announce
        self._since, self._given = (clock.monotonic(), run, *self._counted()), False

    def look(self, run: "RunState", longest: float) -> None:
        """Judge the pace up to ``run``, at intervals; ``longest``: step of the run so far [s]."""
        now, (then, before, instants, happened) = clock.monotonic(), self._since
        if self._given or now - then < WATCHED:
            return
        self._since = now, run, *self._counted()
        steps, passed = run.steps - before.steps, run.motion.t - before.motion.t
        at_events = self._since[2] - instants >= MANY * steps
        if passed <= 0.0 or not (at_events or passed <= SHORT * longest * steps):
            return
        left = (self.end - run.motion.t) * (now - then) / passed
        if left > LONG:
            self._given = True
            where = self._at_events(self._since[2] - instants, happened) if at_events else self._where()
            self.announce(self._text(now - then, passed / steps, longest, left, where))

    def _counted(self):
        """Return the number of instants with events so far, and the events by element."""
        events = self.integrator.events
        return events.instants, events.happened.copy()

    def _text(self, watched, mean, longest, left, where):
        return (
            f"during the last {watched:.0f} s of computing the steps were {mean:.2g} s on average, "
            f"{longest / mean:.2g} times less than the longest; at this pace the rest of the run takes "
            f"{_duration(left)}{where}. Is the motion so far as intended (`mecano post`)? Ctrl-C stops the "
            "run, which can be resumed"
        )

    def _at_events(self, instants, before):
        """Return sentences on the elements that had most events since those ``before``, and on what to change."""
        names = [f"{name} ({count})" for name, count in (self._since[3] - before).most_common()]
        return (
            f". Steps ended at {instants} instants of events, most of {name_list(names, MOST_NAMES)}. "
            "'time.located_events: 1' takes those of cables, belts, stops and contacts with a law at ends of steps; "
            "more mass, or less stiffness or clearance, makes them fewer"
        )

    def _where(self):
        """Return a clause on the unknown that limits the steps; "" for a method that does not compare accelerations."""
        method = self.integrator.method
        if method.order != 2:
            return ""
        from mecano.solve.diagnostics.failure import acting_clause
        from mecano.solve.time.short_steps import changing_most

        i, system = changing_most(method, self.integrator.control), method.system
        return f". The acceleration changes most in {system.numbering.name[i].motion}{acting_clause(system, i)}"


def _duration(seconds):
    """Return a time [s] in a unit of days, hours or minutes, as text."""
    size, unit = next(((size, unit) for size, unit in UNITS if seconds >= 2.0 * size), UNITS[-1])
    return f"{seconds / size:.3g} {unit}"
