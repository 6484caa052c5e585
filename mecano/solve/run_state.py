"""All that a run needs to go on, as one value; to plain arrays and back."""

from dataclasses import dataclass, fields

from mecano.model.state import History, State


@dataclass(slots=True)
class RunState:
    """Motion, history, planned step and counters of a run; never changed in place."""

    motion: State
    history: History
    h: float  # size of the next step [s]
    steps: int = 0  # accepted
    rejected: int = 0
    iterations: int = 0
    dissipated: float = 0.0  # [J] since the start
    given: float = 0.0  # [J] by the surroundings since the start
    powers: tuple = (0.0, 0.0)  # [W] dissipated and given at the motion

    @property
    def work(self):
        """Energy dissipated and given since the start [J]."""
        return self.dissipated, self.given

    def tried(self, rejected, iterations):
        """The same run with more rejected trials and Newton iterations counted."""
        return RunState(
            motion=self.motion, history=self.history, h=self.h, steps=self.steps, powers=self.powers,
            rejected=self.rejected + rejected, iterations=self.iterations + iterations,
            dissipated=self.dissipated, given=self.given,
        )  # fmt: skip


def to_plain(run):
    """Nested dict of arrays and numbers that ``from_plain`` turns into the same run, bit for bit."""
    plain = {field.name: getattr(run, field.name) for field in fields(run)}
    motion = {field.name: getattr(run.motion, field.name) for field in fields(run.motion)}
    for name in ("modes", "memories"):
        motion[name] = {f"{i:06d}": array for i, array in enumerate(motion[name])}
    history = {field.name: getattr(run.history, field.name) for field in fields(run.history)}
    dissipated, given = run.powers
    return plain | {"motion": motion, "history": history, "powers": {"dissipated": dissipated, "given": given}}


def from_plain(plain):
    """The RunState of ``to_plain``."""
    motion = dict(plain["motion"])
    for name in ("modes", "memories"):
        motion[name] = tuple(motion[name][key] for key in sorted(motion[name]))
    powers = plain["powers"]["dissipated"], plain["powers"]["given"]
    return RunState(
        **(plain | {"motion": State(**motion), "history": History(**plain["history"]), "powers": powers})
    )  # fmt: skip
