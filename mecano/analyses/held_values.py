"""Saved values of signals that do not depend on the present motion: of delays, sampled and external values."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mecano.elements.signals import delay, external, sample_and_hold
from mecano.model.state import State
from mecano.model.system import System
from mecano.results.reader import Results


def with_held_values(system: System, state: State, results: Results, row: int) -> State:
    """Return the State of a row of results with the memory by which such signals have their saved values.

    They depend on instants between the rows, at which inputs were sampled or read. Signals without saved values keep
    the memory that follows from the rows.
    """
    memory = state.memory.copy()
    for batch in system.batches:
        hold = next((hold for name, hold in HELD if name == batch.kind.name), None)
        if hold is None:
            continue
        width = len(batch.kind.memory)
        own = memory[batch.first_memory :][: width * len(batch.p)].reshape(-1, width)
        for m, p, (path, _) in zip(own, batch.p, batch.paths, strict=True):
            if (name := f"{path}/value") in results.series:
                hold(p, m, float(results[name].values[row]), state.t)
    return replace(state, memory=memory)


def _delayed(p: np.void, m: np.ndarray, value: float, t: float) -> None:
    """Let the input have had this value a delay ago, and nothing be known of it since."""
    m[: delay.FIRST + 2] = 1.0, delay.NEVER, 0.0, t - p["time"], value


def _sampled(p: np.void, m: np.ndarray, value: float, t: float) -> None:
    m[sample_and_hold.HELD], m[sample_and_hold.START], m[sample_and_hold.COUNT] = value, t, 1.0


def _set(p: np.void, m: np.ndarray, value: float, t: float) -> None:
    m[external.VALUE], m[external.STARTED] = value, 1.0


HELD: tuple[tuple[str, Callable[[np.void, np.ndarray, float, float], None]], ...] = (
    ("delay", _delayed), ("sample_and_hold", _sampled), ("external", _set)
)  # fmt: skip
