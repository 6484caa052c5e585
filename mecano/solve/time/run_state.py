"""The state from which a run continues, and its conversion to plain arrays and back."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, TypeAlias

from mecano.model.state import History, RadauHistory, State
from mecano.solve.events.compliance import Compliance

if TYPE_CHECKING:
    from mecano.solve.time.generalized_alpha import GeneralizedAlpha
    from mecano.solve.time.radau import Radau

Method: TypeAlias = "GeneralizedAlpha | Radau"  # a method of time integration


@dataclass(slots=True)
class RunState:
    """Motion, history, planned step and counters of a run; never changed in place."""

    motion: State
    history: History | RadauHistory
    h: float  # size of the next step [s]
    steps: int = 0  # accepted
    rejected: int = 0
    iterations: int = 0
    dissipated: float = 0.0  # [J] since the start
    given: float = 0.0  # [J] by the surroundings since the start
    powers: tuple[float, float] = (0.0, 0.0)  # [W] dissipated and given at the motion
    compliance: Compliance | None = None  # of redundant constraints in the present phases

    def tried(self, rejected: int, iterations: int) -> "RunState":
        """Return the same run with more rejected trials and Newton iterations counted."""
        return RunState(
            motion=self.motion, history=self.history, h=self.h, steps=self.steps, powers=self.powers,
            compliance=self.compliance,
            rejected=self.rejected + rejected, iterations=self.iterations + iterations,
            dissipated=self.dissipated, given=self.given,
        )  # fmt: skip


def to_plain(run: RunState) -> dict[str, Any]:
    """Return nested dicts of arrays and numbers, from which ``from_plain`` restores the same run, bit for bit."""
    plain, history = _values(run), _values(run.history)
    if "tangent" in history:
        history["tangent"] = history["tangent"] and _values(history["tangent"])
    dissipated, given = run.powers
    powers = {"dissipated": dissipated, "given": given}
    plain["compliance"] = run.compliance and run.compliance.to_plain()
    return plain | {"motion": _values(run.motion), "history": history, "powers": powers}


def from_plain(plain: Mapping[str, Any]) -> RunState:
    """Return the RunState from the result of ``to_plain``."""
    history = _history(dict(plain["history"]))
    powers = plain["powers"]["dissipated"], plain["powers"]["given"]
    motion = _state(plain["motion"])
    soft = plain["compliance"] and Compliance.from_plain(plain["compliance"])
    return RunState(**{**plain, "motion": motion, "history": history, "powers": powers, "compliance": soft})


def _values(record):
    return {field.name: getattr(record, field.name) for field in fields(record)}


def _history(plain):
    if "tangent" not in plain:
        return RadauHistory(**plain)
    tangent = plain["tangent"] and _state(plain["tangent"])
    return History(**(plain | {"tangent": tangent}))


def _state(plain):
    return State(**{field.name: plain[field.name] for field in fields(State)})
