"""Events of a system that can cause an impact: their indices among the events, their constraint rows and phases."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from mecano.element_interface import CONTACT, LOCK, Event, Row
from mecano.immutable import immutable
from mecano.model.state import State
from mecano.model.system import System


@immutable
class ImpactCandidate:
    """An event of one element that causes an impact."""

    event: int  # index into the event values
    phase: int  # index into the phases of a state
    before: int
    after: int
    through: int
    opened: int  # phase after the event that reopens the contact; -1 if it never opens
    lead: int  # index of the multiplier along the contact normal
    rows: np.ndarray  # indices of the multipliers of the element and of the parts that share its phase, the lead first
    along: np.ndarray  # those of them whose impulses are recorded with the event: the lead, or the force of a LOCK
    unit: str  # of these impulses
    restitution: float  # coefficient; negative if it never opens
    element: str
    closing: Event
    opening: Event | None  # the event that reopens it
    opens: int  # index of that event; -1 if the contact never opens

    @property
    def opens_at_zero(self) -> bool:
        """Whether it opens where its reaction vanishes."""
        return self.opening is not None and not self.opening.elastic

    def impulse(self, impulses: np.ndarray) -> float:
        """Return the impulse to record, of a vector its magnitude, from the ``impulses`` (n_l,) of all constraints."""
        found = impulses[self.along]
        return float(found[0] if len(found) == 1 else np.linalg.norm(found))


class Candidates(tuple[ImpactCandidate, ...]):
    """Impact candidates, with their indices of ``events``, ``leads`` and ``opens`` (n,) as arrays."""

    def __init__(self, candidates: Iterable[ImpactCandidate]):
        self.events, self.leads, self.opens = (
            np.array([getattr(c, name) for c in self], np.int64) for name in ("event", "lead", "opens")
        )

    def where(self, chosen: np.ndarray) -> list[ImpactCandidate]:
        """Return the candidates that are ``chosen`` (n,) bool."""
        return [self[i] for i in np.flatnonzero(chosen)]

    def near(self, g: np.ndarray, gaps: np.ndarray) -> list[ImpactCandidate]:
        """Return those whose event values g (n_events,) are at most their ``gaps`` (n_l,) from zero."""
        return self.where(np.abs(g[self.events]) <= gaps[self.leads])


class ImpactCandidates:
    """All impact candidates of a system, in the order of their event values."""

    def __init__(self, system: "System"):
        self.system, self.all = system, Candidates(_impact_candidates(system))
        self.opening = Candidates(c for c in self.all if c.opens >= 0)
        self.held = Candidates(c for c in self.opening if c.opens_at_zero)
        # one of several candidates of a contact only
        self._reopening = Candidates(c for c in self.all if c.opened == c.before and c.after == c.through)
        self._closed = np.array([(c.phase, c.after) for c in self._reopening], np.int64).reshape(-1, 2).T

    def __iter__(self) -> Iterator[ImpactCandidate]:
        return iter(self.all)

    def among(self, hit: np.ndarray) -> bool:
        """Return whether some of the events ``hit`` (n_events,) bool cause an impact."""
        return bool(hit[self.all.events].any())

    def split(self, hit: np.ndarray) -> tuple[list[ImpactCandidate], np.ndarray]:
        """Return (candidates among the events ``hit`` (n_events,) bool, events (n_events,) bool without impact)."""
        others = hit.copy()
        others[self.all.events] = False
        return self.all.where(hit[self.all.events]), others

    def standing_open(self, g: np.ndarray) -> list[ImpactCandidate]:
        """Return the open contacts that touch or penetrate, by the event values ``g`` (n_events,), and can open."""
        return self.opening.where(g[self.opening.events] >= 0.0)

    def due(self, hit: np.ndarray, g: np.ndarray) -> list[ImpactCandidate]:
        """Return the candidates that may follow the events ``hit`` (n_events,) bool, by the event values g (n_events,).

        Of two that share a phase, only the nearer one.
        """
        values = g[self.all.events]
        ahead = self.all.where(~hit[self.all.events] & (-np.inf < values) & (values <= 0.0))
        return list({c.phase: c for c in sorted(ahead, key=lambda c: g[c.event])}.values())  # the nearer of two stops

    def touching(self, near: np.ndarray) -> np.ndarray:
        """Return the values (n_events,) of closing events up to which contacts touch, by their gaps ``near`` (n_l,)."""
        values = np.zeros(self.system.n_events)
        values[self.opening.events] = near[self.opening.leads]
        return values

    def resting(self, phases: np.ndarray) -> list[ImpactCandidate]:
        """Return the contacts that are closed and hold in the ``phases`` (n_elements,) of a state."""
        places, closed = self._closed
        return self._reopening.where(phases[places] == closed)

    def in_phase(self, s: State, candidates: Iterable[ImpactCandidate], which: str) -> State:
        """Return ``s`` with the elements of some candidates, and their parts, in their phase ``which``."""
        phases = s.phases.copy()
        for candidate in candidates:
            phases[candidate.phase] = getattr(candidate, which)
        self.system.follow(phases)
        return replace(s, phases=phases)


def _impact_candidates(system):
    """Yield the impact candidates in the order of their event values."""
    rows = _rows_by_phase(system)
    for batch in system.batches:
        events = batch.kind.events
        for e in range(len(batch.p)):
            for number, event in enumerate(events):
                if event.shock:
                    yield _impact_candidate(batch, e, event, batch.first_event + e * len(events), number, rows)


def _impact_candidate(batch, e, event, first, number, rows):
    kind, place, events = batch.kind, batch.first_phase + e, batch.kind.events
    back = [other for other in events if other.before == event.after and not other.shock]
    back.sort(key=lambda other: other.after != event.before)
    restitution = float(batch.p[event.restitution][e]) if event.restitution else 0.0
    restitution = restitution if event.shock == CONTACT else -1.0
    opens = bool(back) and restitution >= 0.0
    leads = sorted(rows[place], key=lambda row: not row[1].unilateral)
    unit = leads[0][1].unit
    along = [number for number, row in leads if row.unit == unit] if event.shock == LOCK else [leads[0][0]]
    before, after, through = map(kind.phases.index, (event.before, event.after, event.through or event.after))
    return ImpactCandidate(
        first + number, place, before, after, through, kind.phases.index(back[0].after) if opens else -1,
        leads[0][0], np.array([number for number, _ in leads], np.int64), np.array(along, np.int64), f"{unit} s",
        restitution, batch.names[e], event, back[0] if opens else None, first + events.index(back[0]) if opens else -1,
    )  # fmt: skip


def _rows_by_phase(system):
    """Return {index of a phase: [(index of a multiplier, its Row)]} of the element and the parts that share it."""
    own: dict[int, list[tuple[int, Row]]] = {}
    owner = dict(system.followers.tolist())
    for batch in system.batches:
        for e, numbers in enumerate(batch.multipliers):
            place = batch.first_phase + e
            of = own.setdefault(owner.get(place, place), [])
            of += zip(numbers.tolist(), batch.kind.multipliers, strict=True)
    return own
