"""Runs that begin in a saved state of another run: ``initial: {from: stowed.h5:2.0}``.

Nodes, and scalars of elements, of the same names take their motion from the other run; the phases of elements (latches,
contacts) follow from its events, memory from all its rows (replay.py). New nodes and elements keep the values
of the deck.
"""

import math
import os
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.analyses.replay import MOST, gaps_at_start, miscounted, replayed, scalars_in
from mecano.errors import DeckError, Problem, ResultsError, name_list

if TYPE_CHECKING:
    from mecano.deck.deck import Deck
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.results.reader import Results

ROUNDING = 1e-9  # of the time: largest difference of a saved time from the requested one


def saved_time(text: str) -> tuple[str, float | None]:
    """Split "stowed.h5:2.0" into (file, time [s]); the time is None if not given."""
    name, colon, time = text.rpartition(":")
    try:
        found = float(time) if colon else math.nan
    except ValueError:
        found = math.nan
    return (name, found) if math.isfinite(found) else (text, None)


def carried_over(deck: "Deck", system: "System", state: "State", length: float) -> "tuple[State, list[str]]":
    """Return the state with which a run of the deck begins, and texts on the values carried over from another run.

    ``state`` is that of the deck alone, ``length`` the length scale [m]. Raises DeckError, with the place of
    ``initial.from``, if the file cannot be read, has no such saved time, or nothing in common with the deck.
    """
    text = deck.values["initial"]["from"]
    if text is None:
        return state, []
    from mecano.results.reader import open_results  # slow to import, and not needed by other decks

    name, time = saved_time(text)
    path = os.path.join(os.path.dirname(deck.file), name)
    try:
        with open_results(path) as results:
            near = gaps_at_start(deck, system, length)
            return _begun(system, state, results, _row(results, time), name, near)
    except ResultsError as error:
        raise DeckError([Problem(f"'initial.from': {error}", deck.mark("initial", "from"))]) from None


def _row(results: "Results", time: float | None) -> int:
    """Return the index of the row saved at a time [s], or of the last one. Raises ResultsError."""
    t = results.time
    if not len(t):
        raise ResultsError(f"{results.path} has no saved times yet")
    if time is None:
        return len(t) - 1
    row = int(np.argmin(np.abs(t - time)))
    if abs(t[row] - time) <= ROUNDING * max(abs(time), t[-1] - t[0]):
        return row
    if not t[0] <= time <= t[-1]:
        raise ResultsError(f"{results.path} is saved from {t[0]:.6g} to {t[-1]:.6g} s, not at {time:.9g} s")
    after = int(np.searchsorted(t, time))
    near = f"{t[after - 1]:.9g} and {t[after]:.9g} s"
    raise ResultsError(f"{time:.9g} s is not a saved time of {results.path}; the nearest ones are {near}")


def _begun(
    system: "System", state: "State", results: "Results", row: int, name: str, near: np.ndarray
) -> "tuple[State, list[str]]":
    named = [(i, node.name) for i, node in enumerate(system.nodes) if not node.internal]
    nodes = [(i, node) for i, node in named if f"nodes/{node}/position" in results.series]
    if not nodes:
        raise ResultsError(f"{results.path} has no node of this deck")
    scalars, missing = scalars_in(system, results)
    found = replayed(system, state, results, row, nodes, scalars, near)
    turns = list(miscounted(system, found, results, row))
    moves = np.arange(len(found.v)) < system.n_q
    memory, anew = _without_past(system, found.memory)
    found = replace(found, v=np.where(moves, found.v, 0.0), t=state.t, memory=memory)
    return found, [*_remarks(results, row, name, system, nodes, missing, anew), *turns]


def _without_past(system: "System", memory: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Clear the memory of signals, since it refers to times of the other run; return the memory and their names."""
    memory, anew = memory.copy(), []
    for b in system.batches:
        if b.kind.section == "signals" and b.kind.memory:
            memory[b.first_memory : b.first_memory + len(b.p) * len(b.kind.memory)] = 0.0
            anew += b.names
    return memory, anew


def _remarks(results, row, name, system, nodes, missing, anew):
    """Yield texts on the values carried over, on new nodes and on nodes that no longer exist."""
    begun = results.metadata["started"]
    yield f"the run begins with the state of {name} at {results.time[row]:.9g} {results.axis.unit}, begun {begun}"
    common = {node for _, node in nodes}
    new = [node.name for node in system.nodes if not node.internal and node.name not in common]
    saved = (path.split("/")[1] for path in results.names("nodes/*/position"))
    gone = [node for node in saved if node not in common]
    for names, what in ((new, "not in that file, and start as in the deck"), (gone, "in that file, but not here")):
        if names:
            yield f"nodes {what}: {name_list(names, MOST)}"
    if anew:
        yield f"signals that start without their history: {name_list(anew, MOST)}"
    if missing:
        unknowns = [f"{name} of {owner}" for owner, name in missing]
        yield f"unknowns not in that file, which start as in the deck: {name_list(unknowns, MOST)}"
