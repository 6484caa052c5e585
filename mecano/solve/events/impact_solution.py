r"""Solution of one impact: velocities and impulses of the constraints and contacts (docs/shocks.md).

Positions are frozen; with the constraints that hold and those that become active (rates :math:`w = B v + \Phi_t`):

.. math::  M (v^+ - v^-) = B^T \Lambda, \qquad w^+ = 0 \text{ (held)}, \qquad
   0 \le \Lambda \perp w^+ + e\, w^- \ge 0 \text{ (contacts that close or are closed)}

Bilateral constraints cost one factorization; contacts add the dense matrix of their mutual responses.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mecano.errors import AssemblyError
from mecano.immutable import immutable
from mecano.maths.root import root
from mecano.model.state import State
from mecano.solve.diagnostics.mobility import Group
from mecano.solve.events.complementarity import solve_complementarity
from mecano.solve.events.compliance import Compliance
from mecano.solve.events.events import EventRecord
from mecano.solve.events.impact_candidates import ImpactCandidate
from mecano.solve.events.impact_friction import rough_contacts, solve_with_friction
from mecano.solve.events.restitution import restitutions
from mecano.solve.events.shocks import STILL, Shocks
from mecano.solve.time.consistent import Consistent

MASSLESS = 1e-14  # of the largest response: a contact with a smaller one moves no mass
LEVER = 1e-12  # of the largest entry of a gradient: a smaller lever arm is rounding error
ADHESIVE = 1e-9  # of the largest impulse: one below minus this is adhesive


@immutable
class Shock:
    """Result of an impact: velocities and phases after it, events, energy lost and given [J]."""

    state: State
    event_records: list[EventRecord]
    lost: float
    given: float
    impulses: np.ndarray  # (n_l,) of all constraints [N s, N m s]
    consistent: Consistent  # at this state
    compliance: Compliance | None  # of redundant constraints after the impact, or None
    redundant: tuple[Group, ...]  # of constraints that have become redundant


class ImpactSolution:
    """Velocities and impulses of an impact: complementarity of the contacts ``uncoupled``, all other rows held.

    The contacts and latches ``fast``, which close faster than they may without a rebound, determine the coefficients of
    restitution ``e`` (n,) of the contacts.
    """

    def __init__(
        self,
        shocks: Shocks,
        held: State,
        all_held: State,
        uncoupled: Sequence[ImpactCandidate],
        fast: Sequence[ImpactCandidate],
        compliance: Compliance | None,
        h: float,
    ):
        self.shocks, self.system, self.e = shocks, shocks.system, np.zeros(len(uncoupled))
        self.uncoupled = {c: i for i, c in enumerate(uncoupled)}
        self.held, self.all_held = held.copy(), all_held
        self.leads = np.array([c.lead for c in uncoupled], np.int64)
        self.before, self.friction_losses = self._rates(held.v), np.zeros(self.system.n_l)
        self.consistent, self.compliance, self.redundant = shocks.consistent(held, compliance, h)
        change, reactions = self.consistent.impose(-self.system.constraint_derivatives(held)[:, 1])
        self.pushing = np.zeros(len(uncoupled), bool)  # contacts that push in the last solution
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
        self.impulses = self.consistent.share(reactions - self.consistent.penalty * reached)
        if uncoupled:
            self.impulses[self.leads] = pushes
            self._add_friction_losses(along)

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
        Unconstrained massless unknowns do not resist an impulse; contacts of such unknowns are ``light``.
        """
        system, n_q = self.system, self.system.n_q
        data = np.zeros(system.n_data)
        system.add_constraints(self.all_held, 1.0, 0.0, data)
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

        If the rebound with friction creates energy, e is reduced to the value at which it conserves energy. If friction
        prevents a rebound, as in a groove narrower than its cone, whatever the impulses, e is zero.
        """
        free = self._rates(self._moved(change))[self.leads]
        free[np.abs(free) <= STILL * self.shocks.least[self.leads]] = 0.0  # rounding, which friction might amplify
        if not self.rough:
            return self._solve(free + self.e * self.before[self.leads]), np.zeros(0)
        n, slides = len(free), self._sliding(self._moved(change))
        before = np.concatenate([self.before[self.leads], self._sliding(self.all_held.v)])
        unpushed = before + np.concatenate([free, slides])

        def solved(share):
            target = free + share * self.e * self.before[self.leads]
            start = self._stopping(target, slides)
            return solve_with_friction(self._solve, self.W[:n, n:], self.W[n:, n:], target, slides, self.rough, start)

        def lost(impulses):
            x = np.concatenate(impulses)
            return -0.5 * x @ (unpushed + self.W @ x)

        try:
            impulses = solved(1.0)
        except AssemblyError:
            if not self.e.any():
                raise
            self.e = 0.0 * self.e
            return solved(0.0)
        if not self.e.any() or lost(impulses) >= 0.0:
            return impulses
        plastic = lost(solved(0.0))
        if lost(impulses) >= -STILL * abs(plastic):
            return impulses
        share = root(lambda share: lost(solved(share)), 0.0, 1.0) if plastic > 0.0 else 0.0
        impulses, self.e = solved(share), share * self.e
        return impulses

    def _stopping(self, free, slides):
        """Return impulses along the surfaces (2 m,): at jammed contacts those that stop their sliding, else zero.

        The impact problem of a contact that slides and does not approach has the solution zero. Where the friction of
        a sliding contact would press it into the surface, no accelerations exist (Painleve), and the other solution
        holds, an impact without collision (Genot & Brogliato, Eur. J. Mech. A 18, 1999).
        """
        names, n, along = {i: c.element for c, i in self.uncoupled.items()}, len(free), np.zeros(len(slides))
        for i, contact in enumerate(self.rough if self.shocks.jammed else ()):
            own, normal = slice(2 * i, 2 * i + 2), contact.contact
            at = [normal, n + 2 * i, n + 2 * i + 1]
            W, u = self.W[np.ix_(at, at)], slides[own]
            presses = contact.mu * (W[0, 1:] @ u) >= W[0, 0] * np.linalg.norm(u) > 0.0
            if presses and names[normal] in self.shocks.jammed:
                along[own] = -np.linalg.lstsq(W, np.array([free[normal], *u]), rcond=None)[0][1:]
        return along

    def _add_friction_losses(self, along):
        """Set ``friction_losses`` (n_l,) [J], by normals: energies that the impulses ``along`` surfaces dissipate."""
        for contact, P in zip(self.rough, along.reshape(-1, 2), strict=True):
            mean = 0.5 * contact.sliding(self.all_held.v + self.held.v)
            self.friction_losses[self.leads[contact.contact]] -= P @ mean

    def _rubbed(self, resting, met):
        """Return the energies (n_l,) [J] that friction takes at contacts at rest, in equal parts for those that close.

        Contacts at rest have no event of their own.
        """
        shares = np.zeros(self.system.n_l)
        if met:
            shares[[c.lead for c in met]] = self.friction_losses[[c.lead for c in resting]].sum() / len(met)
        return shares

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
        x, unit, guess = np.zeros(len(b)), self.shocks.unit[self.leads[at]], self.pushing[at]
        x[massive] = solve_complementarity(W[np.ix_(massive, massive)], b[massive], unit[massive], guess[massive])
        self.pushing[at] = x > 0.0
        return x

    def pulls(self, candidate: ImpactCandidate) -> bool:
        """Return whether a contact with tangential constraints would need an adhesive impulse."""
        return self.impulses[candidate.lead] < -ADHESIVE * np.abs(self.impulses).max()

    def shock(
        self,
        s: State,
        closing: list[ImpactCandidate],
        resting: list[ImpactCandidate],
        event_records: Sequence[EventRecord],
        h: float,
        no_force: np.ndarray,
    ) -> Shock:
        """Return the Shock from the state ``s`` before it, with steps of h [s] to follow.

        ``no_force`` (n_l,) [N, N m]: the rounding errors of reactions.
        """
        lost = self.friction_losses - 0.5 * self.impulses * (self.before + self.after)
        still = self._rates(np.zeros_like(s.v))
        new = set(closing)
        slow = all(self._is_slow(c) for c in closing)
        stay = {c: True for c in closing + resting if self._stays(c, c in new, slow)}  # in their order
        gone = [c for c in resting if c not in stay]
        end = self.shocks.impact_candidates.in_phase(replace(s, v=self.held.v), stay, "after")
        met = [c for c in closing if self._meets(c, stay)]
        shares = lost + self._rubbed(resting, met)
        happened = [*event_records, *(self._met(s.t, c, c in stay, shares) for c in met)]
        leaving = self._leaving([c for c in stay if c in self.uncoupled and c.through == c.after], h, no_force)
        happened += [_opened(s.t, c) for c in [*gone, *leaving]]
        end = self.shocks.impact_candidates.in_phase(end, [*gone, *leaving], "opened")
        consistent, compliance, redundant = self.consistent, self.compliance, self.redundant
        if not np.array_equal(end.phases, self.held.phases):
            consistent, compliance, more = self.shocks.consistent(end, self.compliance, h)
            redundant = (*redundant, *more)
        of = self.system.numbering
        rows = {of.name[of.n_q + row] for c in closing + resting for row in c.rows}
        redundant = tuple(group for group in redundant if rows & set(group.names))
        given = -float(self.impulses @ still)
        return Shock(end, happened, float(lost.sum()), given, self.impulses, consistent, compliance, redundant)

    def _is_slow(self, candidate):
        """Return whether a contact that closes would not rebound, whatever its restitution; latches are none."""
        return candidate.restitution >= 0.0 and self.before[candidate.lead] >= -self.shocks.least[candidate.lead]

    def _stays(self, candidate, closes, slow):
        """Return whether the contact is closed after the impact; contacts at rest are not parted by a ``slow`` one."""
        if candidate.restitution < 0.0:
            return True
        if candidate not in self.uncoupled:
            return self.held.phases[candidate.phase] == candidate.through
        before, after, least = (of[candidate.lead] for of in (self.before, self.after, self.shocks.least))
        if closes and before >= -self.shocks.rest[candidate.lead]:
            return after <= least and (before <= least or after >= -least)
        if slow and not closes:
            return after <= least
        rebounds = closes and self.e[self.uncoupled[candidate]] > 0.0 and self.impulses[candidate.lead] > 0.0
        largest = np.abs(self.before[self.leads]).max() + np.abs(self.after[self.leads]).max()
        return not rebounds and after <= STILL * max(largest, least)

    def _meets(self, candidate, stay):
        return candidate in stay or self.impulses[candidate.lead] != 0.0

    def _met(self, t, candidate, stays, lost):
        event = candidate.closing
        return EventRecord(
            t, candidate.element, event.name, event.before, event.after if stays else event.before,
            candidate.impulse(self.impulses), candidate.unit, float(lost[candidate.rows].sum()),
        )  # fmt: skip

    def _leaving(self, stay, h, no_force):
        """Return the closed contacts, light ones excepted, that the accelerations separate by more than rounding.

        Friction may press together what would part without it, as a belt presses a box against a stop.
        """
        stay = [c for c in stay if not self.light[self.uncoupled[c]]]
        if not stay:
            return []
        moving = self.held.copy()
        self.consistent.accelerate(moving)
        second = self.system.constraint_derivatives(replace(self.all_held, v=moving.v, a=moving.a))[self.leads, 2]
        at = [self.uncoupled[c] for c in stay]
        leads = self.leads[at]
        least = np.maximum(STILL * np.abs(second[at]).max(), STILL * self.shocks.rest[leads] / h)
        least = np.maximum(least, np.diag(self.W)[at] * no_force[leads])

        def parted(forces, of_friction):
            parting = second[at] + self.W[np.ix_(at, at)] @ forces + of_friction
            return [c for c, *of in zip(stay, forces, parting, least, strict=True) if of[0] == 0.0 and of[1] > of[2]]

        found = parted(self._solve(second[at], at), 0.0)
        if not found or not self.rough or not h < np.inf:
            return found
        try:
            forces, along = self._forces_with_friction(second, moving, at, h)
        except AssemblyError:  # undetermined forces decide nothing
            return found
        return parted(forces[at], self.W[at, len(self.leads) :] @ along)

    def _forces_with_friction(self, second, moving, at, h):
        """Return the mean forces (n,) of the contacts ``at`` and along the surfaces (2 m,), over a step of h [s].

        ``second`` (n,) are the accelerations along the normals without these forces, those of the state ``moving``.
        Friction obeys Coulomb's law at the end of the step (Moreau 1988).
        """
        n = len(self.leads)

        def normal(b):
            pushes = np.zeros(n)
            pushes[at] = self._solve(b[at], at)
            return pushes

        slides = self._sliding(moving.v) + h * self._sliding(moving.a)
        pushes, along = solve_with_friction(normal, self.W[:n, n:], self.W[n:, n:], h * second, slides, self.rough)
        return pushes / h, along / h


def _opened(t, candidate):
    event = candidate.opening
    return EventRecord(t, candidate.element, event.name, event.before, event.after)
