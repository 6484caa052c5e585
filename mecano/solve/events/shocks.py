r"""Impacts: change of velocities, phases and energy at events with ``Event.shock`` (docs/shocks.md).

Positions are frozen; with the constraints that hold and those that become active (rates :math:`w = B v + \Phi_t`):

.. math::  M (v^+ - v^-) = B^T \Lambda, \qquad w^+ = 0 \text{ (held)}, \qquad
   0 \le \Lambda \perp w^+ + e\, w^- \ge 0 \text{ (contacts that close or are closed)}

Bilateral constraints cost one factorization; contacts add the dense matrix of their mutual responses.
"""

from collections.abc import Container, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.immutable import immutable
from mecano.model.numbering import LENGTH_CONSTRAINT
from mecano.solve.diagnostics.scales import constraint_scale
from mecano.solve.events.complementarity import solve_complementarity
from mecano.solve.events.events import EventMonitor, EventRecord
from mecano.solve.events.impact_candidates import ImpactCandidate, ImpactCandidates
from mecano.solve.events.impact_friction import rough_contacts, solve_with_friction
from mecano.solve.events.redundancy import reanalyse_redundancy
from mecano.solve.events.restitution import restitutions
from mecano.solve.linear.rounding import ROUNDING
from mecano.solve.time.increments import reach_of

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.diagnostics.mobility import Group
    from mecano.solve.events.compliance import Compliance
    from mecano.solve.time.consistent import Consistent
    from mecano.solve.time.run_state import Method

TOGETHER = 1e-6  # of a step: impacts closer in time than this are simultaneous
NEAR = 10.0  # times the tolerance of constraints: so are impacts of contacts with a smaller gap
STILL = 1e-10  # of the largest approach: a rate below this is zero
MASSLESS = 1e-14  # of the largest: a contact with a smaller response moves no mass
LEVER = 1e-12  # of the largest entry of a gradient: a smaller lever arm is rounding
ADHESIVE = 1e-9  # of the largest: an impulse below minus this is adhesive
STANDS = 1e-4  # of the gap within which contacts touch: less, in a step, by an acceleration, is rounding
DEPARTING = -1e-300  # event value of a contact that is touching and separating


@immutable
class Shock:
    """Result of an impact: velocities and phases after it, events, energy lost and given [J]."""

    state: "State"
    event_records: list[EventRecord]
    lost: float
    given: float
    impulses: np.ndarray  # (n_l,) of all constraints [N s, N m s]
    consistent: "Consistent"  # at this state
    compliance: "Compliance | None"  # of redundant constraints after the impact, or None
    redundant: "tuple[Group, ...]"  # of constraints that have become redundant


def touching_gaps(system: "System", tolerance: float, length: float) -> np.ndarray:
    """Return the gaps (n_l,) [m, rad] up to which contacts touch; ``tolerance`` of constraints, length scale [m]."""
    return NEAR * tolerance * constraint_scale(system, length)


class Shocks:
    """Impact solver of a system; ``rest`` (n_l,) approach speeds below which contacts do not rebound [m/s, rad/s]."""

    def __init__(self, system: "System", method: "Method", monitor: EventMonitor, rest: float):
        self.system, self.linear, self.monitor, self.length = system, method.linear, monitor, method.length
        scale = constraint_scale(system, method.length)
        self._least, self.near = rest * scale, touching_gaps(system, method.tolerances.constraint, method.length)
        self.rest = self._least
        self.unit = method.length / scale  # of reactions: moments count as forces at the length scale
        self.impact_candidates = ImpactCandidates(system)
        self.touching = self.impact_candidates.touching(self.near)

    def suppress_rebound(self, elements: Container[str]) -> None:
        """Treat impacts of the contacts of these ``elements``, and of no others, as perfectly plastic."""
        self.rest = self._least.copy()
        self.rest[[candidate.lead for candidate in self.impact_candidates if candidate.element in elements]] = np.inf

    def departing(self, s: "State", g: np.ndarray) -> np.ndarray:
        """Return the event values ``g`` at the beginning of a step, DEPARTING for open contacts that are separating."""
        if not self.impact_candidates.all:  # called in every step
            return g
        candidates = self.impact_candidates.standing_open(g)
        if not candidates:
            return g
        g = g.copy()
        derivatives = self._derivatives(s, candidates)
        for candidate in candidates:
            rate, second = derivatives[candidate.lead, 1:]
            if rate > 0.0 or (rate >= -self.rest[candidate.lead] and second > 0.0):
                g[candidate.event] = DEPARTING
        return g

    def undecided(self, g0: np.ndarray, s: "State", k: float, h: float) -> np.ndarray:
        """Return the events (n_events,) bool of contacts that touch without force over a step of size h to ``s``.

        Whether such a contact is open or closed is rounding, so it keeps its phase: an open one whose gap is below the
        tolerance of constraints at both ends of the step (event values ``g0`` and those at ``s``) and whose relative
        acceleration is rounding; and a closed one whose reaction is rounding, k [N/m] being the mean stiffness of the
        step.
        """
        found, candidates = np.zeros(len(g0), bool), self.impact_candidates.opening
        if not candidates:
            return found
        g, held = self.monitor.values(s), self.impact_candidates.held
        opens, leads = np.array([(c.opens, c.lead) for c in held], np.int64).reshape(-1, 2).T
        found[opens] = np.abs(g[opens]) <= self._no_force(s, k) * self.unit[leads]
        touching = [c for c in candidates if max(-g0[c.event], abs(g[c.event])) <= self.near[c.lead]]
        if touching:
            second = self._derivatives(s, touching)[:, 2]
            for c in touching:
                found[c.event] = abs(second[c.lead]) * h * h <= STANDS * self.near[c.lead]
        return found

    def pressed(self, s: "State", h: float) -> np.ndarray:
        """Return the events (n_events,) bool of open contacts that touch at rest and that the accelerations close.

        They do so by more than rounding in a step of h [s]. There are none while a touching contact approaches or
        slips: it closes with a shock, at which the state before it is recorded.
        """
        found, g = np.zeros(self.system.n_events, bool), self.monitor.values(s)
        touching = [c for c in self.impact_candidates.opening if abs(g[c.event]) <= self.near[c.lead]]
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
        """Return the rounding [N] of reactions, of the largest and of positions times the mean stiffness k [N/m]."""
        of = self.system.numbering
        reactions = s.z[of.n_q : of.n][of.kind[of.n_q : of.n] == LENGTH_CONSTRAINT]
        return ROUNDING * (np.abs(reactions).max(initial=0.0) + reach_of(s.z, of, self.length) * self.length * k)

    def together(self, s: "State", hit: np.ndarray, h: float) -> np.ndarray:
        """Return the events ``hit`` with the impacts that would follow within TOGETHER of a step ``h`` [s].

        The motions of identical parts of a model differ by rounding; this makes them lock at the same instant. A
        contact that touches at rest is not added: if the impact reaches it, it follows.
        """
        hit, g = hit.copy(), self.monitor.values(s)
        due, hitting = self.impact_candidates.due(hit, g), self.impact_candidates.split(hit)[0]
        if due:
            rates = self._derivatives(s, due + hitting)[:, 1]
            least = STILL * max(abs(rates[c.lead]) for c in hitting)
            for c in due:
                rate = -rates[c.lead] if c.restitution >= 0.0 else abs(rates[c.lead])
                hit[c.event] |= rate > least and -g[c.event] <= max(TOGETHER * h * rate, self.near[c.lead])
        return hit

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
    ) -> Shock:
        """Solve the impact of the events ``hit`` (n_events,) bool at ``s``; return a Shock.

        The velocities of ``s`` satisfy the constraints active before. ``h`` [s] is the next step: contacts that would
        not separate within it stay closed. ``at_once``: time does not advance, so contacts that do not separate
        noticeably count as closed. Closed contacts without a force, for the mean stiffness k [N/m], are opened first:
        if the impact reaches them, they follow at the same time, as in Newton's cradle.
        """
        in_phase = self.impact_candidates.in_phase
        closing, others = self.impact_candidates.split(hit | self._idle(s, k))
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
            solution = _Solution(self, in_phase(held, uncoupled, "opened"), all_held, uncoupled, fast, compliance)
            pulled = [c for c in coupled if solution.pulls(c)]
            if not pulled:
                break
            coupled = [c for c in coupled if c not in pulled]
            held, all_held = in_phase(held, pulled, "before"), in_phase(all_held, pulled, "before")
        return solution.shock(s, closing, resting, event_records, h)

    def _idle(self, s, k):
        """Return the events (n_events,) bool by which closed contacts without a force open."""
        idle, n_q = np.zeros(self.system.n_events, bool), self.system.n_q
        at = [(c.opens, c.lead) for c in self.impact_candidates.resting(s.phases)]
        if at:
            opens, leads = np.array(at).T
            idle[opens] = np.abs(s.z[n_q + leads]) < self._no_force(s, k) * self.unit[leads]
        return idle

    def consistent(
        self, s: "State", compliance: "Compliance | None"
    ) -> "tuple[Consistent, Compliance | None, tuple[Group, ...]]":
        """Return (Consistent, Compliance, redundant Groups) in the phases of ``s`` (redundancy.py)."""
        return reanalyse_redundancy(self.system, self.linear, s, compliance, self.length)


class _Solution:
    """Velocities and impulses of an impact: complementarity of the contacts ``uncoupled``, all other rows held.

    The contacts and latches ``fast``, which close faster than they may without a rebound, determine the coefficients of
    restitution ``e`` (n,) of the contacts.
    """

    def __init__(
        self,
        shocks: Shocks,
        held: "State",
        all_held: "State",
        uncoupled: Sequence[ImpactCandidate],
        fast: Sequence[ImpactCandidate],
        compliance: "Compliance | None",
    ):
        self.shocks, self.system, self.e = shocks, shocks.system, np.zeros(len(uncoupled))
        self.uncoupled = {c: i for i, c in enumerate(uncoupled)}
        self.held, self.all_held = held.copy(), all_held
        self.leads = np.array([c.lead for c in uncoupled], np.int64)
        self.before, self.rubbed = self._rates(held.v), np.zeros(self.system.n_l)
        self.consistent, self.compliance, self.redundant = shocks.consistent(held, compliance)
        change, reactions = self.consistent.exchange(-self.system.constraint_derivatives(held)[:, 1])
        if uncoupled:
            self.rough = rough_contacts(self.system, self.all_held, self.leads)
            self._gather_responses()
            owners = [*range(len(uncoupled)), *(contact.contact for contact in self.rough for _ in range(2))]
            self.e = restitutions(self.uncoupled, fast, owners, self.W, self.reactions)
            pushes, along = self._impulses(change)
            every = np.concatenate([pushes, along])
            change = change + self.responses @ every
            reactions = reactions + self.reactions @ every
        self.held.v = self._moved(change)
        self.after = self._rates(self.held.v)
        reached = self.system.constraint_derivatives(self.held)[:, 1] - self.system.constraint_derivatives(held)[:, 1]
        self.impulses = self.consistent.share(reactions - self.consistent.k * reached)
        if uncoupled:
            self.impulses[self.leads] = pushes
            self._rub(along)

    def _rates(self, v):
        """Return the rates (n_l,) of all constraints at velocities v (n_all,), with all contacts closed."""
        return self.system.constraint_derivatives(replace(self.all_held, v=v))[:, 1]

    def _moved(self, change):
        v = self.all_held.v.copy()
        v[: self.system.n_q] += change
        return v

    def _gather_responses(self):
        """Compute responses of velocities (n_q, n) and reactions (n_l, n) to unit impulses, and W (n, n).

        The impulses are those along the normals of the contacts, then two along the surface of each rough one.
        Unconstrained massless unknowns yield to any impulse; contacts of such unknowns are ``light``.
        """
        system, n_q = self.system, self.system.n_q
        bare = replace(self.all_held, z=self.all_held.z.copy())
        bare.z[n_q : system.n] = 0.0
        data = np.zeros(system.nnz + 1)
        system.add_constraints(bare, 1.0, 0.0, data)
        distinct, which = np.unique(n_q + self.leads, return_inverse=True)
        at = np.flatnonzero(np.isin(system.cols, distinct) & (system.rows < n_q))
        gradient = np.zeros((n_q, len(distinct)))
        gradient[system.rows[at], np.searchsorted(distinct, system.cols[at])] = -data[at]
        gradient = gradient[:, which]
        self.light = (np.abs(gradient[self.consistent.loose]) > LEVER * np.abs(gradient).max(axis=0)).any(axis=0)
        gradient = np.concatenate([gradient.T, *(contact.forces(n_q) for contact in self.rough)])
        answers = [self.consistent.respond(force) for force in gradient]
        self.responses = np.array([change for change, _ in answers]).T
        self.reactions = np.array([reaction for _, reaction in answers]).T
        self.W = gradient @ self.responses

    def _impulses(self, change):
        """Return the impulses along the normals and the surfaces; ``change`` (n_q,) is that of v without them.

        If the rebound with friction creates energy, e is reduced to the value at which it loses none.
        """
        free = self._rates(self._moved(change))[self.leads]
        if not self.rough:
            return self._solve(free + self.e * self.before[self.leads]), np.zeros(0)
        n, slides = len(free), self._sliding(self._moved(change))
        before = np.concatenate([self.before[self.leads], self._sliding(self.all_held.v)])
        unpushed = before + np.concatenate([free, slides])

        def solved(share):
            target = free + share * self.e * self.before[self.leads]
            return solve_with_friction(self._solve, self.W[:n, n:], self.W[n:, n:], target, slides, self.rough)

        def lost(impulses):
            x = np.concatenate(impulses)
            return -0.5 * x @ (unpushed + self.W @ x)

        impulses = solved(1.0)
        if not self.e.any() or lost(impulses) >= 0.0:
            return impulses
        plastic = lost(solved(0.0))
        if lost(impulses) >= -STILL * abs(plastic):
            return impulses
        from scipy.optimize import brentq  # takes 0.3 s to import, hence only when needed

        share = brentq(lambda share: lost(solved(share)), 0.0, 1.0) if plastic > 0.0 else 0.0
        impulses, self.e = solved(share), share * self.e
        return impulses

    def _rub(self, along):
        """Set the energies ``rubbed`` (n_l,) [J] lost by the impulses ``along`` the surfaces, by normals."""
        for contact, P in zip(self.rough, along.reshape(-1, 2), strict=True):
            mean = 0.5 * contact.sliding(self.all_held.v + self.held.v)
            self.rubbed[self.leads[contact.contact]] -= P @ mean

    def _sliding(self, v):
        """Return the velocities of sliding (2 m,) [m/s] of the m rough contacts at velocities v (n_all,)."""
        return np.concatenate([contact.sliding(v) for contact in self.rough])

    def _solve(self, b, at=None):
        """Return impulses or forces x (n,) with x >= 0, W x + b >= 0 and x (W x + b) = 0; zero without mass.

        ``at`` (n,) are the indices of the contacts; all by default.
        """
        at = np.arange(len(self.leads)) if at is None else np.asarray(at)
        W, weight = self.W[np.ix_(at, at)], np.diag(self.W)[at]
        massive = np.flatnonzero((weight > MASSLESS * weight.max(initial=0.0)) & ~self.light[at])
        x, unit = np.zeros(len(b)), self.shocks.unit[self.leads[at]]
        x[massive] = solve_complementarity(W[np.ix_(massive, massive)], b[massive], unit[massive])
        return x

    def pulls(self, candidate: ImpactCandidate) -> bool:
        """Return whether a contact with tangential constraints would need an adhesive impulse."""
        return self.impulses[candidate.lead] < -ADHESIVE * np.abs(self.impulses).max()

    def shock(
        self,
        s: "State",
        closing: list[ImpactCandidate],
        resting: list[ImpactCandidate],
        event_records: Sequence[EventRecord],
        h: float,
    ) -> Shock:
        """Return the Shock from the state ``s`` before it, with steps of h [s] to follow."""
        lost = self.rubbed - 0.5 * self.impulses * (self.before + self.after)
        still = self.system.constraint_derivatives(replace(self.all_held, v=np.zeros_like(s.v)))[:, 1]
        new = set(closing)
        stay = {c: True for c in closing + resting if self._stays(c, c in new)}  # in their order
        gone = [c for c in resting if c not in stay]
        end = self.shocks.impact_candidates.in_phase(replace(s, v=self.held.v), stay, "after")
        happened = [*event_records, *(self._met(s.t, c, c in stay, lost) for c in closing if self._meets(c, stay))]
        leaving = self._leaving([c for c in stay if c in self.uncoupled and c.through == c.after], h)
        happened += [_opened(s.t, c) for c in [*gone, *leaving]]
        end = self.shocks.impact_candidates.in_phase(end, [*gone, *leaving], "opened")
        consistent, compliance, redundant = self.consistent, self.compliance, self.redundant
        if not np.array_equal(end.phases, self.held.phases):
            consistent, compliance, more = self.shocks.consistent(end, self.compliance)
            redundant = (*redundant, *more)
        of = self.system.numbering
        rows = {of.name[of.n_q + row] for c in closing + resting for row in c.rows}
        redundant = tuple(group for group in redundant if rows & set(group.names))
        given = -float(self.impulses @ still)
        return Shock(end, happened, float(lost.sum()), given, self.impulses, consistent, compliance, redundant)

    def _stays(self, candidate, closes):
        """Return whether the contact is closed after the impact."""
        if candidate.restitution < 0.0:
            return True
        if candidate not in self.uncoupled:
            return self.held.phases[candidate.phase] == candidate.through
        before, after, rest = self.before[candidate.lead], self.after[candidate.lead], self.shocks.rest[candidate.lead]
        if closes and before >= -rest:
            return after <= max(before, rest)
        rebounds = closes and self.e[self.uncoupled[candidate]] > 0.0 and self.impulses[candidate.lead] > 0.0
        largest = np.abs(self.before[self.leads]).max() + np.abs(self.after[self.leads]).max()
        return not rebounds and after <= STILL * largest

    def _meets(self, candidate, stay):
        return candidate in stay or self.impulses[candidate.lead] != 0.0

    def _met(self, t, candidate, stays, lost):
        event = candidate.closing
        return EventRecord(
            t, candidate.element, event.name, event.before, event.after if stays else event.before,
            candidate.impulse(self.impulses), candidate.unit, float(lost[candidate.rows].sum()),
        )  # fmt: skip

    def _leaving(self, stay, h):
        """Return the closed contacts, light ones excepted, that the accelerations separate at once."""
        stay = [c for c in stay if not self.light[self.uncoupled[c]]]
        if not stay:
            return []
        moving = self.held.copy()
        self.consistent.accelerate(moving)
        second = self.system.constraint_derivatives(replace(self.all_held, v=moving.v, a=moving.a))[:, 2]
        at = [self.uncoupled[c] for c in stay]
        of_these = self.leads[at]
        forces = self._solve(second[of_these], at)
        parting = second[of_these] + self.W[np.ix_(at, at)] @ forces
        least = np.maximum(STILL * np.abs(second[of_these]).max(), STILL * self.shocks.rest[of_these] / h)
        return [c for c, *of in zip(stay, forces, parting, least, strict=True) if of[0] == 0.0 and of[1] > of[2]]


def _opened(t, candidate):
    event = candidate.opening
    return EventRecord(t, candidate.element, event.name, event.before, event.after)
