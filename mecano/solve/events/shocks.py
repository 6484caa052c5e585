"""Impacts: change of velocities, phases and energy at events with ``Event.shock`` (docs/shocks.md).

This module decides which events happen together and which contacts they reach; impact_solution.py solves the equations.
"""

from collections.abc import Set
from typing import TYPE_CHECKING

import numpy as np

from mecano.model.numbering import LENGTH_CONSTRAINT
from mecano.solve.diagnostics.scales import constraint_scale
from mecano.solve.events.events import EventMonitor
from mecano.solve.events.impact_candidates import ImpactCandidate, ImpactCandidates
from mecano.solve.events.redundancy import reanalyse_redundancy
from mecano.solve.linear.rounding import ROUNDING
from mecano.solve.time.increments import reach_of

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.diagnostics.mobility import Group
    from mecano.solve.events.compliance import Compliance
    from mecano.solve.events.impact_solution import Shock
    from mecano.solve.time.consistent import Consistent
    from mecano.solve.time.run_state import Method

TOGETHER = 1e-6  # of a step: impacts closer in time than this are simultaneous
NEAR = 10.0  # times the tolerance of constraints: impacts of contacts with a smaller gap are simultaneous, too
CLOSE = 1e-6  # length scales, or rad: contacts with a smaller gap nearly touch
STILL = 1e-10  # of the largest approach: a rate below this is zero
STANDS = 1e-4  # of the gap within which contacts touch: a smaller gap, or change by an acceleration, is rounding error


def touching_gaps(system: "System", tolerance: float, length: float) -> np.ndarray:
    """Return the gaps (n_l,) [m, rad] up to which contacts touch; ``tolerance`` of constraints, length scale [m]."""
    return NEAR * tolerance * constraint_scale(system, length)


class Shocks:
    """Impact solver of a system; ``rest`` (n_l,) approach speeds below which contacts do not rebound [m/s, rad/s].

    ``least`` (n_l,) are these speeds without those contacts whose rebound is suppressed at any speed. ``jammed`` are
    the elements of contacts at which friction leaves no acceleration: their impact stops the sliding.
    """

    def __init__(self, system: "System", method: "Method", monitor: EventMonitor, rest: float):
        self.system, self.linear, self.monitor, self.length = system, method.linear, monitor, method.length
        scale = constraint_scale(system, method.length)
        self.least, self.near = rest * scale, touching_gaps(system, method.tolerances.constraint, method.length)
        self.rest, self.close = self.least, CLOSE * scale
        self.unit = method.length / scale  # of reactions: moments count as forces at the length scale
        self.impact_candidates, self.jammed = ImpactCandidates(system), set[str]()
        self.touching = self.impact_candidates.touching(self.near)
        self.kept_until = np.full(system.n_events, -np.inf)  # [s], of openings

    def suppress_rebound(self, elements: Set[str]) -> None:
        """Treat impacts of the contacts of these ``elements``, and of no others, as perfectly plastic."""
        self.rest = self.least.copy()
        if elements:
            self.rest[[c.lead for c in self.impact_candidates if c.element in elements]] = np.inf

    def keep_closed(self, often: Set[tuple[str, str]], until: float) -> None:
        """Keep contacts closed ``until`` [s] whose openings, by element and name, are among the events ``often``.

        Where friction leaves a contact neither closed nor open, it would open and close without end. It may pull for a
        step, which does no work.
        """
        self.kept_until[:] = -np.inf
        for c in self.impact_candidates.held if often else ():
            if c.opening is not None and (c.element, c.opening.name) in often:
                self.kept_until[c.opens] = until

    def departing(self, s: "State", g: np.ndarray) -> np.ndarray:
        """Return event values g (n_events,) at the beginning of a step, with those of separating contacts changed.

        Rounding decides the sign of their gap. The value is that of the gap up to which contacts touch: a search for
        their next impact would else be led to the beginning of the step, where rounding shows one.
        """
        if not self.impact_candidates.all:  # called in every step
            return g
        candidates = self.impact_candidates.standing_open(g + STANDS * self.touching)
        if not candidates:
            return g
        g = g.copy()
        derivatives = self._derivatives(s, candidates)
        for candidate in candidates:
            rate, second = derivatives[candidate.lead, 1:]
            if rate > 0.0 or (rate >= -self.rest[candidate.lead] and second > 0.0):
                g[candidate.event] = -self.near[candidate.lead]
        return g

    def approaching(self, s: "State", g: np.ndarray) -> dict[ImpactCandidate, float]:
        """Return the rates [m/s] of open contacts that nearly touch and approach at ``s``; g (n_events,): event values.

        The motion of a long step may lead through such a surface and back, as over the side of a ball, which the event
        values at the ends of the step do not show. A single contact has just opened where it touches.
        """
        opening = self.impact_candidates.opening
        if len(opening) < 2:
            return {}
        values, leads = g[opening.events], opening.leads
        close = opening.where((-self.close[leads] < values) & (values != -self.near[leads]))
        rates = self._derivatives(s, close)[:, 1] if close else self.least
        return {c: rates[c.lead] for c in close if rates[c.lead] < -self.least[c.lead]}

    def undecided(self, g0: np.ndarray, s0: "State", s: "State", k: float) -> np.ndarray:
        """Return the events (n_events,) bool of contacts that touch without force over a step from ``s0`` to ``s``.

        Rounding errors decide whether such a contact is open or closed, so it keeps its phase: an open one whose gap is
        below the tolerance of constraints at both ends of the step (event values ``g0`` and those at ``s``) and whose
        relative acceleration is rounding error; a separating one whose overlap at ``s0`` shrinks, however slowly, or is
        below that tolerance at ``s``; a closed one whose reaction is rounding error, k [N/m] being the mean stiffness
        of the step; and one that is kept closed.
        """
        found, candidates = np.zeros(len(g0), bool), self.impact_candidates.opening
        if not candidates:
            return found
        g, held, events = self.monitor.values(s), self.impact_candidates.held, candidates.events
        found[held.opens] = np.abs(g[held.opens]) <= self._no_force(s, k) * self.unit[held.leads]
        found |= self.kept_until >= s.t
        touching = candidates.where(np.maximum(-g0[events], np.abs(g[events])) <= self.near[candidates.leads])
        if touching:
            second, h = self._derivatives(s, touching)[:, 2], s.t - s0.t
            for c in touching:
                found[c.event] = abs(second[c.lead]) * h * h <= STANDS * self.near[c.lead]
        separating = g0[events] == -self.near[candidates.leads]
        if separating.any():
            events, leads = events[separating], candidates.leads[separating]
            found[events] |= g[events] <= np.maximum(self.near[leads], self.monitor.values(s0)[events])
        return found

    def pressed(self, s: "State", h: float) -> np.ndarray:
        """Return the events (n_events,) bool of open contacts that touch at rest and that the accelerations close.

        They do so by more than rounding in a step of h [s]. There are none while a touching contact approaches or
        slips: it closes with a shock, at which the state before it is recorded.
        """
        found, g = np.zeros(self.system.n_events, bool), self.monitor.values(s)
        touching = self.impact_candidates.opening.near(g, self.near)
        if not touching:
            return found
        _, rates, seconds = self._derivatives(s, touching).T
        for c in touching:
            near, resting = self.near[c.lead], np.abs(rates[c.rows]) <= self.rest[c.rows]
            if rates[c.lead] * h > near:
                continue  # it separates
            if not resting.all():
                return np.zeros_like(found)
            found[c.event] = seconds[c.lead] * h * h < -STANDS * near
        return found

    def _no_force(self, s, k):
        """Return the rounding error [N] of the largest reaction, and of positions times the mean stiffness k [N/m]."""
        of = self.system.numbering
        reactions = s.z[of.n_q : of.n][of.kind[of.n_q : of.n] == LENGTH_CONSTRAINT]
        return ROUNDING * (np.abs(reactions).max(initial=0.0) + reach_of(s.z, of, self.length) * self.length * k)

    def together(self, s: "State", hit: np.ndarray, h: float) -> np.ndarray:
        """Return the events ``hit`` (n_events,) bool and the impacts that follow within TOGETHER of a step ``h`` [s].

        The motions of identical parts of a model differ by rounding; this makes them lock at the same instant. A
        contact that touches at rest is not added: if the impact reaches it, it follows. All contacts that touch are
        solved for together where impacts would run to and fro between them and fade without end: if none of those that
        close rebounds, and once the impacts of a contact have repeated at this instant until its rebound is suppressed.
        """
        hit, g = hit.copy(), self.monitor.values(s)
        due, hitting = self.impact_candidates.due(hit, g), self.impact_candidates.split(hit)[0]
        rates = self._derivatives(s, due + hitting)[:, 1]
        if due:
            least = STILL * max(abs(rates[c.lead]) for c in hitting)
            for c in due:
                rate = -rates[c.lead] if c.restitution >= 0.0 else abs(rates[c.lead])
                hit[c.event] |= rate > least and -g[c.event] <= max(TOGETHER * h * rate, self.near[c.lead])
        if self._all_touching(hitting, rates):
            hit[[c.event for c in self.impact_candidates.opening.near(g, self.near)]] = True
        return hit

    def _all_touching(self, hitting, rates):
        """Return whether all contacts that touch take part in the impact of the candidates ``hitting``."""
        return np.isinf(self.rest).any() or self._are_slow(hitting, rates)

    def _are_slow(self, hitting, rates):
        """Return whether some contacts close at their ``rates`` (n_l,), but none so fast that it rebounds."""
        speeds = [-rates[c.lead] for c in hitting]
        slow = all(v <= self.rest[c.lead] and c.restitution >= 0.0 for v, c in zip(speeds, hitting, strict=True))
        return slow and max(speeds, default=0.0) > 0.0

    def _derivatives(self, s, candidates):
        """Return the constraint derivatives (n_l, 3) at ``s`` with the constraints of some candidates active."""
        return self.system.constraint_derivatives(self.impact_candidates.in_phase(s, candidates, "through"))

    def solve_impact(
        self,
        s: "State",
        hit: np.ndarray,
        compliance: "Compliance | None" = None,
        h: float = np.inf,
        at_once: bool = False,
        k: float = 0.0,
    ) -> "Shock":
        """Solve the impact of the events ``hit`` (n_events,) bool at ``s``; return a Shock.

        The velocities of ``s`` satisfy the constraints active before. ``h`` [s] is the next step: contacts that would
        not separate within it stay closed. ``at_once``: time does not advance, so contacts that do not separate
        noticeably count as closed. Closed contacts without a force, for the mean stiffness k [N/m], are opened first:
        if the impact reaches them, they follow at the same time, as in Newton's cradle. If it does not change their
        rates they stay closed: two idle contacts that rounding errors close would else open each other without end.
        None is opened where all that touch are hit together: impacts would run to and fro between them.
        """
        idle = self._idle(s, k)
        if idle.any():
            hitting = self.impact_candidates.split(hit)[0]
            idle &= not self._all_touching(hitting, self._derivatives(s, hitting)[:, 1])
        shock = self._solve(s, hit | idle, compliance, h, at_once, k)
        missed = self._missed(s, shock.state, idle)
        return self._solve(s, hit | idle & ~missed, compliance, h, at_once, k) if missed.any() else shock

    def _missed(self, s, after, idle):
        """Return those of the events ``idle`` (n_events,) whose contacts an impact leaves the rates that they have."""
        missed = np.zeros_like(idle)
        contacts = [c for c in self.impact_candidates.resting(s.phases) if idle[c.opens]] if idle.any() else []
        if contacts:
            change = (self._derivatives(after, contacts) - self._derivatives(s, contacts))[:, 1]
            for c in contacts:
                missed[c.opens] = (np.abs(change[c.rows]) <= STILL * self.least[c.rows]).all()
        return missed

    def _solve(self, s, hit, compliance, h, at_once, k):
        """Solve the impact of the events ``hit``, idle contacts that open among them; see ``solve_impact``."""
        from mecano.solve.events.impact_solution import ImpactSolution  # not needed by runs without impacts

        in_phase = self.impact_candidates.in_phase
        closing, others = self.impact_candidates.split(hit)
        s, event_records = self.monitor.apply(s, others)
        if not at_once:
            rates = self._derivatives(s, closing)[:, 1]
            closing = [c for c in closing if c.restitution < 0.0 or rates[c.lead] <= self.rest[c.lead]]
        resting = self.impact_candidates.resting(s.phases)
        uncoupled = [c for c in closing + resting if c.restitution >= 0.0 and len(c.rows) == 1]
        coupled = [c for c in closing + resting if c.restitution >= 0.0 and len(c.rows) > 1]
        held = in_phase(s, closing, "through")
        all_held = in_phase(held, uncoupled, "through")
        w = self.system.constraint_derivatives(all_held)[:, 1]
        fast = [c for c in closing if -w[c.lead] > self.rest[c.lead] or c.restitution < 0.0]
        while True:
            opened = in_phase(held, uncoupled, "opened")
            solution = ImpactSolution(self, opened, all_held, uncoupled, fast, compliance, h)
            pulled = [c for c in coupled if solution.pulls(c)]
            if not pulled:
                break
            coupled = [c for c in coupled if c not in pulled]
            held, all_held = in_phase(held, pulled, "before"), in_phase(all_held, pulled, "before")
        return solution.shock(s, closing, resting, event_records, h, self._no_force(s, k) * self.unit)

    def _idle(self, s, k):
        """Return the events (n_events,) bool by which closed contacts without a force open."""
        idle, n_q = np.zeros(self.system.n_events, bool), self.system.n_q
        at = [(c.opens, c.lead) for c in self.impact_candidates.resting(s.phases)]
        if at:
            opens, leads = np.array(at).T
            idle[opens] = np.abs(s.z[n_q + leads]) < self._no_force(s, k) * self.unit[leads]
        return idle

    def consistent(
        self, s: "State", compliance: "Compliance | None", h: float
    ) -> "tuple[Consistent, Compliance | None, tuple[Group, ...]]":
        """Return (Consistent, Compliance, redundant Groups) in the phases of ``s`` for steps of h (redundancy.py)."""
        return reanalyse_redundancy(self.system, self.linear, s, compliance, self.length, h)
