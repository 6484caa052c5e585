"""Apply events: change the phases of elements, solve shocks, and account for the energies of these changes."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import field, replace
from typing import Any, TypeAlias

import numpy as np

from mecano.errors import name_list
from mecano.immutable import mutable
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.diagnostics import failure
from mecano.solve.events.capture import EventCapture
from mecano.solve.events.events import EventMonitor, EventRecord
from mecano.solve.events.shocks import Shocks
from mecano.solve.time.consistent import Consistent
from mecano.solve.time.run_state import Method, RunState

Applied: TypeAlias = "tuple[RunState, State, list[EventRecord], Consistent | None]"
"""Run with the energy of shocks, state after the events, their records, what is factored there"""
STANDSTILL = 1e-3  # of a step: a smaller advance of time counts as none
MOST_REBOUNDS = 10  # of one contact at one instant, after which it is at rest
MOST_IDLE = 5  # closings of one contact without impulse at one instant, after which an impact stops its sliding
MOST_AT_ONCE = 20  # occurrences of one event of one element at one instant
MOST_NAMES = 8  # named in a warning


@mutable
class EventApplication:
    """Applies events to the run of ``system`` by ``method``; counts those that repeat at one instant."""

    system: System
    method: "Method"
    monitor: EventMonitor
    capture: EventCapture
    shocks: Shocks
    warnings: list[str] = field(default_factory=list)  # on constraints that become redundant, and on friction in shocks
    since: float = -np.inf  # instant of the counted events [s]
    repeats: Counter = field(default_factory=Counter)  # events by element and name since then
    kept_until: float = -np.inf  # [s]: until then contacts stay closed that have opened again and again at one instant
    idle: Counter = field(default_factory=Counter)  # closings without impulse since then, by element
    neglecting: set[str] = field(default_factory=set)  # joints, by title, whose friction a shock has neglected
    instants: int = 0  # at which events were applied, since the program started
    happened: Counter = field(default_factory=Counter)  # the events at these instants, by element

    def apply(self, run: RunState, s: State, hit: np.ndarray, at_once: bool = False) -> Applied:
        """Apply events ``hit`` at ``s``.

        Return (run with the energy of shocks, releases and activations, state after, [EventRecord], Consistent or
        None).
        """
        self.capture.count(hit, run)
        self._forget(run)
        applied = self._with_energies(run, s, hit, at_once)
        self.instants += 1
        self.happened.update(event.element for event in applied[2])
        return applied

    def _with_energies(self, run, s, hit, at_once):
        """Apply events ``hit`` at ``s``, and count the energies that releases and activations change."""
        changing = self.monitor.changing_energy(hit)
        if not changing:
            return self._exchange(run, s, hit, at_once)
        before = self._potentials(s, changing)
        run, after, event_records, consistent = self._exchange(run, s, hit, at_once)
        rest = self._potentials(after, changing)
        lost = [x - y for x, y in zip(before, rest, strict=True)]
        dissipated, given = sum(max(x, 0.0) for x in lost), sum(max(-x, 0.0) for x in lost)
        run = replace(run, dissipated=run.dissipated + dissipated, given=run.given + given)
        return run, after, _with_losses(event_records, changing.values(), lost), consistent

    def _potentials(self, s, elements):
        """Return the potential energies [J] at ``s`` of the ``elements`` (numbers)."""
        energies = self.system.observe(s).energies
        return [float(energies[e, 1]) for e in elements]

    def _exchange(self, run: RunState, s: State, hit: np.ndarray, at_once: bool) -> Applied:
        """Apply events ``hit`` at ``s`` with their shocks; return the same as ``apply``."""
        if not self.shocks.impact_candidates.among(hit):
            before, compliance, consistent = s.phases, self.method.compliance, None
            s, event_records = self.monitor.apply(s, hit)
            self._guard(run, hit, event_records)
            if compliance and len(compliance.released) and not np.array_equal(before, s.phases):
                consistent, compliance, redundant = self.shocks.consistent(s, compliance, run.h)
                self._soften(compliance, s.t, event_records, redundant)
            return replace(run, compliance=compliance), s, event_records, consistent
        hit = self.shocks.together(s, hit, run.h)
        shock = self.shocks.solve_impact(s, hit, self.method.compliance, run.h, at_once, run.history.k)
        impossible = [] if shock.event_records else self.monitor.apply(s, hit)[1]  # a contact would pull
        self._guard(run, hit, shock.event_records or impossible)
        self._soften(shock.compliance, s.t, shock.event_records, shock.redundant)
        self._report_friction(s.t, shock)
        dissipated, given = run.dissipated + shock.lost, run.given + shock.given
        run = replace(run, compliance=shock.compliance, dissipated=dissipated, given=given)
        return run, shock.state, shock.event_records, shock.consistent

    def _soften(self, compliance, t, event_records, redundant):
        """Use a ``compliance`` that may be new, and add a warning for each of the ``redundant`` Groups."""
        if compliance is not self.method.compliance:
            self.method.use(compliance)
        self.warnings += [_redundant(t, event_records, group) for group in redundant]

    def _report_friction(self, t, shock):
        """Add a warning for each joint whose friction a shock neglects for the first time."""
        if not shock.event_records:
            return
        from mecano.solve.events import joint_friction  # not needed by runs without shocks

        for found in joint_friction.missing_friction(self.system, shock):
            if found[0] not in self.neglecting:
                self.neglecting.add(found[0])
                self.warnings.append(joint_friction.omission_warning(t, shock, *found))

    def _forget(self, run):
        """Forget the events of an earlier instant: contacts that rebounded often then rebound again."""
        if run.motion.t - self.since > STANDSTILL * run.h:
            self.since = run.motion.t
            self.repeats.clear()
            self.idle.clear()
            self._suppress_rebound()

    def _guard(self, run, hit, event_records):
        """Capture elastic events if one of the events ``hit`` repeats at one instant.

        Raises ConvergenceError if that event is not elastic, or if it repeats as often again because no phases are
        consistent with the end of a step (capture.py).
        """
        t = run.motion.t
        once = {(event.element, event.name): event for event in event_records}  # of parts only once
        self.repeats.update(once.keys())
        self.idle.update(event.element for event in once.values() if event.unit and not event.impulse)
        often = [event for key, event in once.items() if self.repeats[key] > MOST_AT_ONCE]
        most = max((self.repeats[key] for key in once), default=0)
        if max(self.repeats.values(), default=0) >= MOST_REBOUNDS:
            self.kept_until = t + run.h
        if often and (most > 2 * MOST_AT_ONCE or not self.capture.begin(hit, run)):
            raise failure.standstill(often[0], most, t)
        self._suppress_rebound()

    def _suppress_rebound(self):
        often = {name for name, count in self.repeats.items() if count >= MOST_REBOUNDS}
        self.shocks.suppress_rebound({element for element, _ in often})
        self.shocks.keep_closed(often, self.kept_until)
        self.shocks.jammed = {element for element, count in self.idle.items() if count >= MOST_IDLE}

    def to_plain(self) -> dict[str, Any]:
        """Return a dict of numbers and lists from which ``from_plain`` continues."""
        repeats = [[*key, count] for key, count in self.repeats.items()]
        own = {"since": self.since, "repeats": repeats, "idle": dict(self.idle), "kept_until": self.kept_until}
        return {**own, "neglecting": sorted(self.neglecting)}

    def from_plain(self, plain: Mapping[str, Any]) -> None:
        """Continue from the result of ``to_plain``."""
        self.since = plain["since"]
        self.repeats = Counter({(element, name): count for element, name, count in plain["repeats"]})
        self.idle, self.neglecting = Counter(plain.get("idle", {})), set(plain["neglecting"])
        self.kept_until = plain["kept_until"]
        self._suppress_rebound()


def _with_losses(event_records, names, lost):
    """Return the records with the energies ``lost`` [J], given by (element, event), in the same order."""
    energies: dict[tuple[str, str], list[float]] = {}
    for name, energy in zip(names, lost, strict=True):
        energies.setdefault(name, []).append(energy)
    found = []
    for event in event_records:
        of = energies.get((event.element, event.name))
        found.append(replace(event, lost=event.lost + of.pop(0)) if of else event)
    return found


def _redundant(t, event_records, group):
    """Return the warning on constraints that become redundant at events."""
    found = group.by_joint(MOST_NAMES)
    names = name_list(found, MOST_NAMES, "; ")
    which = ", ".join(dict.fromkeys(f"{h.element} {h.name}" for h in event_records[:MOST_NAMES]))
    return (
        f"since t = {t:.6g} s ({which}) {group.count} constraint(s) are redundant among: {names}; the motion is not "
        "affected, but the reactions, and the impulses of the shock, are not unique: those of least size are given"
    )
