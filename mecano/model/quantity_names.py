"""Resolve the names of quantities in formulas.

``error`` is a signal, ``elbow.angle`` an output of an element, joint or load that can be measured (``Kind.measures``),
``tip.position.z`` a component of the position, velocity or angular_velocity of a node, inertial, also where an element
of the same name has such an output. ``elbow.force.magnitude`` is the length of a vector. A name that otherwise occurs
in several sections of the deck is prefixed by the section: ``joints.elbow.angle``.
"""

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from mecano.constraints.sensors import NODE_SENSORS, SENSORS
from mecano.element_interface import Context, Kind, Output, Part
from mecano.schema import Values

if TYPE_CHECKING:
    from mecano.model.mesh import Frame

Entries: TypeAlias = Mapping[tuple[str, str], tuple[Kind, Values]]  # (section, name) -> kind and deck values
AXES = "xyz"
MAGNITUDE = ".magnitude"
OF_NODES = {  # quantities of nodes that signals cannot measure: what to read instead
    "rotation": "read the angle of a joint, or compute an angle from the positions of two nodes of the body: "
    "atan2(nose.position.y - body.position.y, nose.position.x - body.position.x)",
    "acceleration": "read the 'washout' of a component of the velocity, with the gain 1/time_constant",
}
RATES = ("rate", "speed", "velocity", "derivative", "dot")  # names that an output with another name may be given


class UnknownQuantity(Exception):
    """A name in a formula is unknown or ambiguous; ``word``: the part at fault, ``known``: what it may have meant."""

    def __init__(self, message: str, word: str = "", known: Iterable[str] = ()):
        super().__init__(message)
        self.message, self.word, self.known = message, word, tuple(known)


def measurable(kind: Kind) -> list[Output]:
    """Return the outputs of a kind that signals can read, without those that options add."""
    return [
        o for o in kind.outputs if o.name not in kind.hidden or (kind.revealed and o.name not in kind.revealed.hidden)
    ]


def components(output: Output, label: str = "") -> list[str]:
    """Return the names of the numbers of an output in a formula: force.x, force.y, force.z of a vector."""
    name = output.name + label
    return [f"{name}.{axis}" for axis in AXES[: output.shape[0]]] if output.shape else [name]


def quantities(output: Output, label: str = "") -> list[str]:
    """Return the names of what a formula can read of an output: its components, and the magnitude of a vector."""
    return components(output, label) + [f"{output.name}{label}{MAGNITUDE}"] * (output.shape == (3,))


def magnitude_of(vector: str) -> str:
    """Return the formula of the length of a vector with this name."""
    return f"hypot(hypot({vector}.x, {vector}.y), {vector}.z)"


def index_of(what: str, kind: Kind, label: str = "") -> int | None:
    """Return the index of a number among the outputs of a kind, or None; ``what`` is named as by ``components``."""
    start = 0
    for output in kind.outputs:
        names = components(output, label)
        if what in names:
            return start + names.index(what)
        start += int(np.prod(output.shape, dtype=int))
    return None


def meaning(name: str, entries: Entries, nodes: Collection[str]) -> tuple[str, str, str]:
    """Return the quantity that a name in a formula refers to: (section, name of the entry, name of the quantity).

    ``entries``: {(section, name): (Kind, deck values)} of all entries of a deck; ``nodes``: names of the nodes. Raises
    UnknownQuantity.
    """
    words = name.split(".")
    if len(words) == 1:
        if ("signals", name) in entries:
            return "signals", name, ""
        signals = [n for section, n in entries if section == "signals"]
        hint = "; the time is written 'time'" if name.lower() in ("t", "time") else _of_owner(name, entries, nodes)
        raise UnknownQuantity(f"there is no signal '{name}'{hint}", name, () if hint else signals)
    sections = dict.fromkeys(section for section, _ in entries)
    if words[0] in (*sections, "nodes") and len(words) > 2:
        asked: tuple[str, ...] = (words[0],)
        owner, rest = words[1], ".".join(words[2:])
    else:
        asked, owner, rest = (*sections, "nodes"), words[0], ".".join(words[1:])
    owners = [section for section in asked if (owner in nodes if section == "nodes" else (section, owner) in entries)]
    if not owners:
        known = [*(n for section, n in entries if section in asked), *(nodes if "nodes" in asked else ())]
        raise UnknownQuantity(f"there is no '{owner}' with a measurable '{rest}'", owner, known)
    offered = {section: _offered(section, owner, entries) for section in owners}
    found = [section for section in owners if rest in offered[section]]
    if len(found) == 1 or found[-1:] == ["nodes"]:
        return found[-1], owner, rest
    if found:
        which = " or ".join(f"{section}.{name}" for section in found)
        raise UnknownQuantity(f"'{name}' is ambiguous: write {which}")
    known = [n for section in owners for n in offered[section]]
    nothing = "" if known else "; it has no measurable outputs"
    hint = next((f": {text}" for section in owners if (text := _advice(rest, *entries.get((section, owner), ())))), "")
    raise UnknownQuantity(f"'{rest}' of '{owner}' cannot be measured{nothing}{hint}", rest, () if hint else known)


def _of_owner(name, entries, nodes):
    """Return a hint for a name of an element, joint or node without the name of an output; "" for other names."""
    owners = [section for section, owner in entries if owner == name] + (["nodes"] if name in nodes else [])
    offered = [f"{name}.{what}" for section in owners for what in _offered(section, name, entries)]
    return f"; write what is measured of it, such as {offered[0]}" if offered else ""


def _offered(section, owner, entries):
    if section == "nodes":
        return [f"{quantity}.{what}" for quantity in NODE_SENSORS for what in (*AXES, MAGNITUDE[1:])]
    if section == "signals":
        return []
    return [name for output, label in measured_outputs(*entries[section, owner]) for name in quantities(output, label)]


def measured_outputs(kind: Kind, d: Values) -> list[tuple[Output, str]]:
    """Return [(Output, suffix of its name)] of what signals can measure of an element with these deck values."""
    options = [(part, label) for field, part, label in kind.optional if _is_given(d[field], label.removeprefix("_"))]
    return [(output, label) for one, label in [(kind.chosen(d), ""), *options] for output in measurable(one)]


def _is_given(value, axis):
    """Return whether a deck gives an option: its field, and the ``axis`` in it, if it is a mapping of axes."""
    return bool(value[axis] if type(value) is dict and axis in value else value)


def _advice(what, kind=None, d=None):
    """Return what to write for an output that cannot be measured, a vector or a rate; "" if unknown."""
    name = what.partition(".")[0]
    if kind is None:
        return OF_NODES.get(name, "")
    chosen = kind.chosen(d)
    if chosen.hidden.get(name):
        return chosen.hidden[name]
    for o in chosen.outputs:
        if o.shape and o.name == name:
            return f"write {', '.join(quantities(o))}"
    rates = (f"the rate of '{o.name}' is '{o.rate}'" for o in chosen.outputs if o.rate)
    return " and ".join(rates) if what.rpartition(".")[2] in RATES else ""


def sensor_of_node(what: str) -> Part:
    """Return the Part of the sensor of a component of the motion of a node: position.z."""
    quantity, _, axis = what.partition(".")
    values = {"direction": np.eye(3)[AXES.index(axis)]}
    if quantity == "position":
        values |= {"origin": np.zeros(3), "zero": 0.0}
    return Part(NODE_SENSORS[quantity], (0,), values)


def sensor_of_output(
    kind: Kind, output: str, values: Values, frames: "Sequence[Frame]", context: Context
) -> Part | None:
    """Return the Part of the sensor of a coordinate of an element or of its rate, at ``frames`` [(x, R)], or None."""
    for name in (output, *(o.name for o in kind.outputs if o.rate == output)):
        if name in kind.measures:
            return _sensor(kind.measures[name](values, frames, context), int(name != output))
    return None


def _sensor(found, which):
    return Part(SENSORS[found.coordinate][which], found.nodes, {**found.axes, "zero": found.zero})
