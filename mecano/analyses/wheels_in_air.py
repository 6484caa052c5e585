"""Wheels in the air in steady motion: those without load at the start, and those that lift off."""

from typing import TYPE_CHECKING

from mecano.errors import ConvergenceError, name_list
from mecano.solve.events.events import EventMonitor

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System

AIR, TOUCH_DOWN = "air", "touch_down"  # phase and event of a wheel
TOUCHING = 1e-5  # m: a rim at this height touches, and steady motion is found from there
MOST_NAMED = 4


def heights_in_air(system: "System", s: "State") -> dict[str, float]:
    """Return {title: height of the rim above the ground [m]} of the wheels that do not touch their grounds at ``s``."""
    s = EventMonitor(system).settle(s)
    values, found = system.event_values(s), {}
    for batch in system.batches:
        events = [event.name for event in batch.kind.events]
        if TOUCH_DOWN not in events:
            continue
        depths, air = batch.events(values)[:, events.index(TOUCH_DOWN)], batch.kind.phases.index(AIR)
        for name, phase, depth in zip(batch.names, s.phases[batch.phases], depths, strict=True):
            if phase == air:
                found[name] = max(0.0, -float(depth))
    return found


def unloaded_text(system: "System", start: "State") -> str:
    """Return the lines on wheels that do not touch their grounds at the ``start``, for an error; "" if all do."""
    texts = [
        f"{name} carries no load at the start: lower it by {1e3 * height:.3g} mm and by the deformation of its tyre"
        for name, height in heights_in_air(system, start).items()
        if height > TOUCHING
    ]
    return "".join(f"\n{text}" for text in texts)


def lift_off_warnings(system: "System", start: "State", s: "State", noticeable: float, reshaped: bool) -> list[str]:
    """Return the warnings about wheels in the air in the steady motion ``s`` found from ``start``.

    If the mechanism is ``reshaped``, and a wheel has lifted off or risen by a ``noticeable`` height [m], it raises
    ConvergenceError: the mechanism balances on its other wheels, as a motorcycle may on one.
    """
    before, heights = heights_in_air(system, start), heights_in_air(system, s)
    risen = [name for name, height in heights.items() if height > before.get(name, -noticeable) + noticeable]
    if risen and reshaped:
        lifted = [f"{name}, {1e3 * heights[name]:.3g} mm above its ground" for name in risen]
        raise ConvergenceError(
            f"steady motion was found only with wheels in the air: {name_list(lifted, MOST_NAMED, '; ')}\n"
            "what to try: initial positions in which each wheel carries its share of the weight, its tyre deformed; "
            "smaller loads that lift; if these wheels are to be in the air, initial positions in which they are"
        )
    return [
        f"{name} is in the air in the steady motion at the start, {1e3 * height:.3g} mm above its ground, and carries "
        "no load; is it too high?"
        for name, height in heights.items()
    ]
