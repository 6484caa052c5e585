"""Operating points of small motions: the start of a run, an equilibrium or a saved state, and axes of the motions."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mecano.analyses.equilibria import follow
from mecano.analyses.failure_text import locating
from mecano.analyses.initial_state import describe, set_initial_state
from mecano.analyses.load_state import rest_at, state_at
from mecano.analyses.prepare import Prepared, integrator_of, prepare, startup_warnings
from mecano.deck.deck import Deck
from mecano.errors import UsageError
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.modal.linearize import Assemble
from mecano.solve.time.consistent import Consistent
from mecano.solve.time.run_state import RunState

LARGEST = 1e100  # rad/s
HELD = "delay", "sample_and_hold", "external"  # signals whose value does not depend on the current motion


@dataclass
class OperatingPoint:
    """A state about which modes are computed: its assembly (None: that of the system) and its description."""

    prepared: Prepared
    state: State
    assemble: Assemble | None
    words: str
    warnings: tuple[str, ...] = ()
    is_start: bool = False


def operating_point(deck: Deck, at: str | None = None, at_rest: bool = False) -> OperatingPoint:
    """Return the state of a checked deck about which modes are computed, as an OperatingPoint.

    The state is that of the saved time ``at`` = "results.h5:time", otherwise the static equilibrium or the start of the
    run. ``at_rest``: the equilibrium at which the mechanism would come to rest near the saved time.
    """
    with locating(deck):
        return _operating_point(deck, at, at_rest)


def _operating_point(deck: Deck, at: str | None, at_rest: bool) -> OperatingPoint:
    begun, held = prepare(deck), tuple(held_warnings(deck))
    prepared = begun
    if at is not None and at_rest:
        prepared, state, text, reported = rest_at(begun, at)
        return OperatingPoint(prepared, state, None, text, (*startup_warnings(prepared, begun=begun), *reported, *held))
    if at is not None:
        prepared, state, assemble, text, reported = state_at(begun, at)
        reported = (*startup_warnings(prepared, begun=begun), *reported, *held)
        return OperatingPoint(prepared, state, assemble, text, reported)
    if deck.values["static"]:
        result = follow(prepared)
        reported = (*startup_warnings(prepared), *result.warnings, *held)
        return OperatingPoint(
            prepared, result.point.state, result.assemble, f"static equilibrium at {result.where}", reported
        )
    reported = (*set_initial_state(prepared, disturbed=False), *held)
    run = integrator_of(prepared).begin(prepared.state, deck.values["time"]["step"])
    reported = (*startup_warnings(prepared, run), *reported)
    return OperatingPoint(prepared, _undeflected(prepared, run), None, describe(deck), reported, is_start=True)


def _undeflected(prepared: Prepared, run: RunState) -> State:
    """Return the state at the start of a run without the deflection of the compliances of redundant constraints.

    It strains stiff members next to these constraints, which would act as an unbalanced force.
    """
    s, soft = run.motion, run.compliance
    if soft is None:
        return s
    return Consistent(prepared.system, prepared.linear, s, prepared.length, soft).without_compliance(s)


def held_warnings(deck: Deck) -> Iterator[str]:
    """Yield a warning about signals whose values small motions do not change."""
    held = [(d["type"], name) for name, d in deck.values["signals"].items() if d["type"] in HELD]
    if held:
        names = ", ".join(f"{kind} '{name}'" for kind, name in held)
        counted = "found by `mecano margins`, or " if any(kind != "external" for kind, _ in held) else ""
        yield (
            f"{names}: modes take these values as constant, so that any feedback through them is missing; "
            f"whether it is stable is {counted}seen in a run"
        )


def angular_velocity_of(system: System, s: State, frame: str) -> np.ndarray:
    """Return the angular velocity (3,) [rad/s] of the axes ``frame``. Raises UsageError."""
    if not isinstance(frame, str):
        raise UsageError(f"frame={frame!r}: write 'inertial', the name of a node, or 'wx,wy,wz' [rad/s]")
    names = [node.name for node in system.nodes]
    if frame == "inertial":
        return np.zeros(3)
    if frame in names:
        i, of = names.index(frame), system.numbering
        return s.R[of.rotation[i]] @ s.v[of.r[i] : of.r[i] + 3]
    try:
        turning = np.array([float(part) for part in frame.split(",")])
    except ValueError:
        turning = np.zeros(0)
    if turning.shape != (3,):
        raise UsageError(f"there is no node '{frame}'; the frame is 'inertial', a node, or three numbers [rad/s]")
    if not np.all(np.abs(turning) <= LARGEST):  # nor not a number
        raise UsageError(f"frame '{frame}': an angular velocity [rad/s] is out of range")
    return turning
