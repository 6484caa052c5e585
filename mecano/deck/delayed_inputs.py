"""Warnings of delays that cannot keep their inputs as exactly as a run computes them."""

from collections.abc import Iterator

from mecano.deck.motions import NotAMotion, motion_of
from mecano.elements.signals.delay import MOST
from mecano.errors import LocatedWarning
from mecano.schema import Values

COARSE = 2.0  # steps between kept values
POINTS = 9  # kept values in a period, from which the polynomial through them is right to 1e-3


def delayed_inputs(values: Values) -> Iterator[LocatedWarning]:
    """Yield (path, text) on delays of very many steps, and on inputs that adaptive steps do not resolve."""
    time = values["time"]
    for name, d in values["signals"].items():
        if time and d["type"] == "delay":
            apart = d["time"] / MOST
            if apart > COARSE * time["step"] and not time["adaptive"]:
                text = (
                    f"delay '{name}': 'time' has {d['time'] / time['step']:.0f} steps; values every {apart:.3g} s are "
                    f"kept, from which it interpolates waves up to {1.0 / (POINTS * apart):.3g} Hz"
                )
                yield ("signals", name, "time"), text
            if time["adaptive"] and _is_motion(d["input"], values["signals"]):
                text = (
                    f"delay '{name}': its input depends on the time alone, so adaptive steps do not resolve it until "
                    f"it acts; write it as a formula or law of 'time - {d['time']:g}' instead of a delay"
                )
                yield ("signals", name, "input"), text


def _is_motion(text, signals):
    """Return whether a formula (text) is one of the time alone."""
    try:
        return "time" in str(motion_of(text, signals)) or signals.get(text, {}).get("type") == "curve"
    except NotAMotion:
        return False
