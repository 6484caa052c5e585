"""Outputs of elements that signals can measure, and the names of their numbers in formulas.

A vector ``force`` has the components ``force.x``, ``force.y``, ``force.z``; ``force.magnitude`` is its length. The
powers of an element and its parts together, ``given_power`` and ``dissipated_power``, are measured, too.
"""

from mecano.element_interface import POWERS, Kind, Output
from mecano.schema import Values

AXES = "xyz"
MAGNITUDE = ".magnitude"


def measurable(kind: Kind) -> list[Output]:
    """Return the outputs of a kind that signals can read, without those that options add."""
    return [
        o for o in kind.outputs if o.name not in kind.hidden or (kind.revealed and o.name not in kind.revealed.hidden)
    ]


def measured_outputs(kind: Kind, d: Values) -> list[tuple[Output, str]]:
    """Return [(Output, suffix of its name)] of the outputs that signals can read of an element with these values."""
    options = [(part, label) for field, part, label in kind.optional if _is_given(d[field], label.removeprefix("_"))]
    return [(output, label) for one, label in [(kind.chosen(d), ""), *options] for output in measurable(one)]


def powers(kind: Kind) -> dict[str, int]:
    """Return {name in formulas: index among the energies} of the powers that signals can read of an element."""
    own = {output.name for output in kind.outputs}
    found = {name: i for name, i in POWERS.items() if name not in own | kind.hidden.keys()}
    return found if kind.section != "signals" and kind.outputs else {}


def _is_given(value, axis):
    """Return whether a deck gives an option: its field, and the ``axis`` in it, if it is a mapping of axes."""
    return bool(value[axis] if type(value) is dict and axis in value else value)


def components(output: Output, label: str = "") -> list[str]:
    """Return the names of the numbers of an output in a formula: force.x, force.y, force.z of a vector."""
    name = output.name + label
    return [f"{name}.{axis}" for axis in AXES[: output.shape[0]]] if output.shape else [name]


def quantities(output: Output, label: str = "") -> list[str]:
    """Return the names in formulas of the numbers of an output: its components, and the magnitude of a vector."""
    return components(output, label) + [f"{output.name}{label}{MAGNITUDE}"] * (output.shape == (3,))


def magnitude_of(vector: str) -> str:
    """Return the formula of the length of a vector with this name."""
    return f"hypot(hypot({vector}.x, {vector}.y), {vector}.z)"


def index_of(what: str, kind: Kind, label: str) -> int | None:
    """Return the index of a number among the outputs of a kind, or None; ``what`` is named as by ``components``."""
    start = 0
    for output in kind.outputs:
        names = components(output, label)
        if what in names:
            return start + names.index(what)
        start += output.size
    return None
