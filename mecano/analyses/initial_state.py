"""Computed initial states of dynamic runs: static equilibrium, straight steady running, or steady rotation."""

import time
from collections.abc import Callable

import numpy as np

from mecano.analyses.lint import node_at_start
from mecano.analyses.prepare import Prepared
from mecano.deck.deck import Deck
from mecano.errors import ConvergenceError
from mecano.model.mesh import inner_names
from mecano.solve.events.compliance import compliance

PATIENCE = 10.0  # s of wall-clock time between notes of a search for steady motion
WOBBLE = 1e-6  # of the inertia: a smaller product of inertia is rounding error


def set_initial_state(
    prepared: Prepared, disturbed: bool = True, announce: Callable[[str], object] = lambda text: None
) -> tuple[str, ...]:
    """Set ``prepared.state`` to the equilibrium or steady motion of ``initial`` in the deck, and return warnings.

    Velocities of the deck are added to steady running, unless ``disturbed`` is False. A long search for steady motion
    is announced at intervals. Raises ConvergenceError (exit code 3) if no such state is found, NonFiniteError.
    """
    initial = prepared.deck.values["initial"]
    if initial["static"]:
        from mecano.analyses.equilibria import equilibrium  # slow to import, and not needed by other decks

        warnings = equilibrium(prepared)
        _refuse_sunken_tyres(prepared, "an equilibrium")
        return warnings
    if not initial["steady"]:
        return ()
    # these take 0.2 s to import, and are not needed by other decks
    from mecano.analyses.wheels_in_air import lift_off_warnings, unloaded_text
    from mecano.solve.modal.steady import NOTICEABLE, Steady

    requested, before = prepared.state.v.copy(), prepared.state
    steady = Steady(prepared.system, prepared.length, _steady_motion(prepared), _Search(announce))
    try:
        prepared.state = steady.find(before)
        prepared.compliance = compliance(
            prepared.system, prepared.state, prepared.length, prepared.analysis, before=prepared.compliance
        )
    except ConvergenceError as error:
        unloaded = unloaded_text(prepared.system, before)
        raise ConvergenceError("".join([str(error), *_wobble_warnings(prepared), unloaded])) from None
    _refuse_sunken_tyres(prepared, "steady motion")
    if disturbed:
        prepared.state.v += requested
    moved, noticeable = steady.change_of_shape(before, prepared.state), NOTICEABLE * prepared.length
    reshaped = bool(moved.max(initial=0.0) > noticeable)
    lifted = lift_off_warnings(prepared.system, before, prepared.state, noticeable, reshaped)
    return (*lifted, *_displacement_warnings(prepared, moved))


class _Search:
    """Notes about a search that takes long."""

    def __init__(self, announce: Callable[[str], object]):
        self.announce, self.iterations, self.begun = announce, 0, time.monotonic()
        self.due = self.begun + PATIENCE

    def __call__(self, force: float) -> None:
        self.iterations += 1
        now = time.monotonic()
        if now >= self.due:
            self.due = now + PATIENCE
            self.announce(
                f"still searching steady motion at the start, for {now - self.begun:.0f} s: iteration "
                f"{self.iterations}, forces out of balance by {force:.3g} N"
            )


def _refuse_sunken_tyres(prepared, state):
    """Raise ConvergenceError if a tyre is deformed too much in ``prepared.state``."""
    from mecano.analyses.sunken_tyres import refuse_sunken_tyres  # not needed by other decks

    refuse_sunken_tyres(prepared.deck, prepared.system, prepared.state, state)


def _steady_motion(prepared):
    """Return the steady motion that the deck requests: Straight, a Rotation, or, with wheels on a ground, a Turn."""
    from mecano.solve.modal.steady_rotation import Rotation
    from mecano.solve.modal.steady_turn import Turn
    from mecano.solve.modal.straight_running import Straight

    requested, elements = prepared.deck.values["initial"]["steady"], prepared.deck.values["elements"]
    if requested["velocity"] is not None:
        return Straight(prepared.system, requested["velocity"])
    resting = set(requested["at_rest"] or ())
    for name, d in elements.items():
        if d.get("mesh", 1) > 1 and resting.issuperset(d["nodes"]):
            resting |= set(inner_names(name, d))
    on_wheels = any("ground" in d and "axis" in d for d in elements.values())
    motion = Turn if on_wheels else Rotation
    return motion(prepared.system, requested["angular_velocity"], requested["about"], resting)


def _wobble_warnings(prepared):
    """Yield a text for each wheel whose axle, in the axes of its node, is not a principal axis of inertia."""
    system, at = prepared.system, {node.name: i for i, node in enumerate(prepared.system.nodes)}
    for name, d in prepared.deck.values["elements"].items():
        if "tire_law" not in d or "node" not in d:
            continue
        node = node_at_start(system, prepared.state, at[d["node"]])
        axle, J = node.orientation.T @ d["axis"], node.inertia()
        if np.linalg.norm(np.cross(axle, J @ axle)) > WOBBLE * np.linalg.norm(J) * (axle @ axle):
            yield (
                f"\n{d['type']} '{name}' wobbles as it spins: its 'axis' is not a principal axis of the inertia of "
                f"node '{d['node']}'"
            )


def describe(deck: Deck) -> str:
    """Describe the initial state of a deck in words."""
    initial = deck.values["initial"]
    if initial["static"]:
        return "static equilibrium at the start"
    if initial["steady"]:
        straight = initial["steady"]["velocity"] is not None
        components = initial["steady"]["velocity" if straight else "angular_velocity"]
        vector = f"[{', '.join(f'{c:.9g}' for c in components)}]"
        return f"straight steady running at {vector} m/s" if straight else f"steady rotation at {vector} rad/s"
    return f"saved state of {initial['from']}" if initial["from"] else "initial state"


def _displacement_warnings(prepared, size):
    """Yield a warning about the node that moved most from its position in the deck; ``size`` (n_nodes,) [m]."""
    from mecano.solve.modal.steady import NOTICEABLE

    i = int(np.argmax(size))
    if size[i] > NOTICEABLE * prepared.length:
        name = prepared.system.nodes[i].name
        yield f"the steady motion requires another shape of the mechanism: node '{name}' moves by {size[i]:.3g} m"
