"""Report of an integration method on a trial step."""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from mecano.errors import Failure
from mecano.model.state import History, RadauHistory, State
from mecano.solve.events.events import EventRecord

MOST_TURN = 2.4  # rad about one axis in a step: angles of joints are followed by less than half a turn
TURNS_TOO_FAR = f"a body turns by more than {MOST_TURN} rad in one step"
PATIENCE = 0.2  # s of wall-clock time between two calls of ``pause``


Trial: TypeAlias = "tuple[State, Any, StepInfo]"
"""A trial step: the state at its end, the history there, which is that of its method, and its outcome"""


@dataclass(slots=True)
class StepInfo:
    """Outcome of a trial step."""

    ok: bool
    iterations: int
    norms: tuple[float, ...]  # force, constraint, increment over their tolerances
    error: float  # local error, relative to the length scale (or rad); nan if not ok
    began: History | RadauHistory  # at the beginning of the step
    message: str = ""
    failure: Failure = Failure.NOT_CONVERGED  # where not ok
    lag: float = 0.0  # local error of massless unknowns, which relax
    signalled: float = 0.0  # local error of signals with a rate, which later steps do not undo
    plain: float = np.nan  # the error before it was bounded
    stages: tuple[State, ...] = ()  # within the step that satisfy the equations, in the order of time
    forces: np.ndarray | None = None  # (n_slots,) of the Assembly at the end of the step; None if it has none there
    event_records: tuple[EventRecord, ...] = ()  # captured in the step (solve/events/capture.py)
    work: np.ndarray | None = None  # (m, 2) dissipated and given from the beginning to the stages and the end [J]
