"""Reconstruction of the state of a model at a saved time of a results file."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mecano.analyses.carry_over import saved_time
from mecano.analyses.equilibria import loaded, rest
from mecano.analyses.held_values import with_held_values
from mecano.analyses.prepare import Prepared, integrator_of
from mecano.analyses.replay import Scalar, gaps_at_start, miscounted, place_row, replayed, scalars_in, traces_of
from mecano.errors import ResultsError, UsageError
from mecano.results.opening import errors_as_damage
from mecano.results.reader import Results, open_results

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.modal.linearize import Assemble


def parse(text: str) -> tuple[str, float | None]:
    """Split "results.h5:1.25" into (path, time); time is None if not given. Raises UsageError."""
    path, time = saved_time(text)
    if time is None and ":" in text and not text.endswith(".h5"):
        raise UsageError(f"'{text}' cannot be understood; write results.h5:time, such as results.h5:1.25")
    return path, time


def state_at(prepared: Prepared, text: str) -> "tuple[Prepared, State, Assemble | None, str, tuple[str, ...]]":
    """Return (Prepared, State, assemble, words, warnings) of the saved time nearest to ``text``, "results.h5:time".

    The Prepared is the model in that state, with the redundant constraints of its phases. Velocities, accelerations and
    reactions are made consistent; elements are in the phases implied by the state and the events. ``assemble`` replaces
    that of the system for the load factor of a static result; otherwise it is None. Raises UsageError, and ResultsError
    if the results do not belong to the deck or lack some of its unknowns.
    """
    state, factor, words, warnings = _saved(prepared, text)
    if factor is None:
        prepared = prepared.at(state)
        return prepared, _dynamic_state(prepared, state), None, words, warnings
    return prepared, *_static_state(prepared, state, factor), words, warnings


def rest_at(prepared: Prepared, text: str) -> "tuple[Prepared, State, str, tuple[str, ...]]":
    """Return (Prepared, State, words, warnings) of the rest position near a saved time, see ``equilibria.rest``.

    Raises the errors of ``state_at`` and ``rest``.
    """
    state, factor, words, warnings = _saved(prepared, text)
    if factor is not None:
        raise UsageError("results of a static analysis are already at rest: omit --at-rest (in Python at_rest)")
    prepared = prepared.at(state)
    state, found = rest(prepared, _dynamic_state(prepared, state))
    return prepared, state, f"equilibrium at rest near {words}", (*warnings, *found)


def _saved(prepared: Prepared, text: str) -> "tuple[State, float | None, str, tuple[str, ...]]":
    """Return (State, load factor, words, warnings) of a saved time; the load factor of a dynamic run is None."""
    path, time = parse(text)
    with errors_as_damage(path), open_results(path) as results:
        if not len(results.time):
            raise ResultsError(f"{path}: no saved times yet")
        row = len(results.time) - 1 if time is None else _row_at(results, path, time)
        state = _state_of_row(prepared, results, row)
        warnings = tuple(miscounted(prepared.system, state, results, row))
        axis = results.axis
        state.t = float(results.time[row]) if axis.unit == "s" else state.t
        state = with_held_values(prepared.system, state, results, row)
        words = f"{path} at {axis.path} {results.time[row]:.6g} {axis.unit}".rstrip()
        if "static/load_factor" not in results.series:
            return state, None, words, warnings
        return state, results["static/load_factor"].values[row], words, warnings


def _row_at(results: Results, path: str, time: float) -> int:
    """Return the row of the saved time nearest to a time; raise UsageError if it is beyond the saved times."""
    first, last, axis = results.time[0], results.time[-1], results.axis
    apart = max(np.diff(results.time).max(initial=0.0), 1e-9 * abs(last))
    if not first - apart <= time <= last + apart:
        unit = f" {axis.unit}" if axis.unit else ""
        raise UsageError(f"{path} has saved states from {first:g} to {last:g}{unit}, and none near {time:g}{unit}")
    return int(np.argmin(np.abs(results.time - time)))


def _state_of_row(prepared: Prepared, results: Results, row: int) -> "State":
    """Return the State of a row. Raises ResultsError if the results lack a node or an unknown of the deck."""
    nodes, scalars = _unknowns_in(prepared.system, results)
    near = gaps_at_start(prepared.deck, prepared.system, prepared.length)
    return replayed(prepared.system, prepared.state, results, row, nodes, scalars, near)


def _unknowns_in(system: "System", results: Results) -> tuple[list[tuple[int, str]], list[Scalar]]:
    """Return nodes and scalars as in ``replayed``. Raises ResultsError if one of the deck is not in the results."""
    nodes = [(i, node.name) for i, node in enumerate(system.nodes) if " " not in node.name]
    missing = [name for _, name in nodes if f"nodes/{name}/position" not in results.series]
    if missing:
        raise ResultsError(f"{results.path} does not belong to this deck: it has no node '{missing[0]}'")
    scalars, unknown = scalars_in(system, results)
    if unknown:
        raise ResultsError(_missing_unknown(results, *unknown[0]))
    return nodes, scalars


def motions_in(prepared: Prepared, path: str) -> "Iterator[State]":
    """Yield a State with the motion of each saved time of a dynamic run; the next one overwrites it.

    Phases, memory and reactions are not those of the run. Raises UsageError and ResultsError as ``state_at``.
    """
    if prepared.deck.values["time"] is None:
        raise UsageError("the deck has 'static': nothing moves in statics")
    with errors_as_damage(path), open_results(path) as results:
        if not len(results.time):
            raise ResultsError(f"{path}: no saved times yet")
        nodes, scalars = _unknowns_in(prepared.system, results)
        traces, state = traces_of(results, nodes), prepared.state.copy()
        for row in range(len(results.time)):
            place_row(prepared.system, state, results.time, row, nodes, traces, scalars)
            yield state


def _missing_unknown(results, owner, name):
    """Return the text on an unknown of an element that the results lack."""
    kind, element, _ = owner.split("'")
    if not any(path.split("/")[1] == element for path in results.series):
        return f"{results.path} does not belong to this deck: it has no unknown '{name}' of {owner}"
    return (
        f"{results.path} does not contain the unknown '{name}' of {owner}: the plugin has to declare it among the "
        f"outputs of '{kind.strip()}', as '{name}', and its rate as '{name}_rate' unless it is one of its 'states'"
    )


def _dynamic_state(prepared: Prepared, state: "State") -> "State":
    """Return the State of a dynamic run with consistent velocities, accelerations and reactions."""
    if prepared.deck.values["time"] is None:
        raise UsageError("these are results of a dynamic analysis, but the deck has 'static'")
    return integrator_of(prepared).begin(state, prepared.deck.values["time"]["step"]).motion


def _static_state(prepared: Prepared, state: "State", factor: float) -> "tuple[State, Assemble]":
    """Return the equilibrium at a load factor, with its reactions, and its function ``assemble``."""
    if prepared.deck.values["static"] is None:
        raise UsageError("these are results of a static analysis, but the deck has 'time'")
    statics = loaded(prepared, prepared.deck.values["static"])
    s, found = statics.correct(state, float(factor))
    if not found.ok:
        raise ResultsError(f"the saved state is not an equilibrium of this deck: {found.message}")
    statics.evaluate(s, float(factor), 1.0, 0.0, False)

    def assemble(s, *, cK=0.0, cC=0.0, cM=0.0):
        return statics.loading.assemble(s, float(factor), cK=cK, cC=cC, cM=cM)

    return s, assemble
