"""Events of a system that can cause an impact, with their constraint rows and phases."""

from dataclasses import dataclass

import numpy as np

from mecano.element_interface import CONTACT


@dataclass(frozen=True, eq=False)
class ImpactCandidate:
    """An event of one element that comes with an impact."""

    event: int  # place in the event values
    phase: int  # index into the phases of a state
    before: int
    after: int
    through: int
    opened: int  # phase after the event that reopens the contact; -1 if it never opens
    rows: np.ndarray  # numbers of the multipliers of the element and of the parts that share its phase, the lead first
    unit: str  # of the impulse of the lead
    restitution: float  # coefficient; negative if it never opens
    element: str
    names: tuple  # of the event, the phases before and after it, the event that reopens it, the phase reopened

    @property
    def lead(self):
        """Number of the multiplier along the contact normal."""
        return self.rows[0]

    def rests(self, phases):
        """Return whether the contact is closed and its constraints hold; of several ways to close, the first."""
        return self.opened == self.before and phases[self.phase] == self.after == self.through


def impact_candidates(system):
    """Yield all impact candidates in the order of their event values."""
    first, rows = 0, _rows_by_phase(system)
    for batch in system.batches:
        events = batch.kind.events
        for e in range(len(batch.p)):
            for number, event in enumerate(events):
                if event.shock:
                    yield _impact_candidate(batch, e, event, first + e * len(events), number, rows)
        first += len(batch.p) * len(events)


def _impact_candidate(batch, e, event, first, number, rows):
    kind, place = batch.kind, batch.first_phase + e
    back = [other for other in kind.events if other.before == event.after and not other.shock]
    back.sort(key=lambda other: other.after != event.before)
    restitution = float(batch.p[event.restitution][e]) if event.restitution else 0.0
    restitution = restitution if event.shock == CONTACT else -1.0
    opens = bool(back) and restitution >= 0.0
    leads = sorted(rows[place], key=lambda row: not row[1].unilateral)
    return ImpactCandidate(
        first + number, place,
        *(kind.phases.index(phase) for phase in (event.before, event.after, event.through or event.after)),
        kind.phases.index(back[0].after) if opens else -1,
        np.array([number for number, _ in leads], np.int64), f"{leads[0][1].unit} s",
        restitution, batch.names[e],
        (event.name, event.before, event.after, *((back[0].name, back[0].after) if opens else ("", ""))),
    )  # fmt: skip


def _rows_by_phase(system):
    """Return {index of a phase: [(number of a multiplier, its Row)]} of the element and the parts that share it."""
    own, owner = {}, dict(system.followers.tolist())
    for batch in system.batches:
        for e, numbers in enumerate(batch.multipliers):
            place = batch.first_phase + e
            of = own.setdefault(owner.get(place, place), [])
            of += zip(numbers.tolist(), batch.kind.multipliers, strict=True)
    return own
