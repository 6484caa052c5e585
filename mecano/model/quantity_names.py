"""Resolve the names of quantities in formulas.

``path`` is the value of a signal, ``path.slope`` another output of it, ``elbow.angle`` an output of an element, joint
or load that can be measured (``Kind.measures``), ``tip.position.z`` a component of the position, velocity or
angular_velocity of a node, inertial, also where an element of the same name has such an output.
``elbow.force.magnitude`` is the length of a vector. A name that otherwise occurs in several sections of the deck is
prefixed by the section: ``joints.elbow.angle``.
"""

from collections.abc import Collection, Iterable, Mapping
from typing import TypeAlias

from mecano.constraints.sensors import NODE_SENSORS
from mecano.element_interface import SECTIONS, Kind
from mecano.model.measured_outputs import AXES, MAGNITUDE, measured_outputs, powers, quantities
from mecano.schema import Values

Entries: TypeAlias = Mapping[tuple[str, str], tuple[Kind, Values]]  # (section, name) -> kind and deck values
OF_NODES = {  # quantities of nodes that signals cannot measure: quantities to read instead
    **dict.fromkeys(
        ("rotation", "angle", "yaw", "pitch", "roll"),
        "read the angle of a joint, or add an element of the type 'attitude' with this node and read its yaw, pitch or "
        "roll",
    ),
    **{axis: f"write position.{axis} or velocity.{axis}" for axis in AXES},
    "acceleration": "read the 'washout' of a component of the velocity, with the gain 1/time_constant; an element "
    "of the type 'attitude' has the acceleration as an output for plots",
}
VALUE = "value"
WORK = ("work", "energy", "heat", "dissipated_energy", "given_energy")  # names that an integral may be given
RATES = ("rate", "speed", "velocity", "derivative", "dot")  # names that an output with another name may be given


class UnknownQuantity(Exception):
    """A name in a formula is unknown or ambiguous; ``word``: the part at fault, ``known``: possible names."""

    def __init__(self, message: str, word: str = "", known: Iterable[str] = ()):
        super().__init__(message)
        self.message, self.word, self.known = message, word, tuple(known)


def resolve(name: str, entries: Entries, nodes: Collection[str]) -> tuple[str, str, str]:
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
    if len(words) > 2 and _has_section(words[0], entries):
        searched: tuple[str, ...] = (words[0],)
        owner, rest = words[1], ".".join(words[2:])
    else:
        searched, owner, rest = (*SECTIONS, "nodes"), words[0], ".".join(words[1:])
    owners = [
        section for section in searched if (owner in nodes if section == "nodes" else (section, owner) in entries)
    ]
    if not owners:
        known = [*(n for section, n in entries if section in searched), *(nodes if "nodes" in searched else ())]
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


def _has_section(name, entries):
    """Return whether a deck has a section of this name with entries that formulas refer to."""
    return name == "nodes" or (name in SECTIONS and any(section == name for section, _ in entries))


def _of_owner(name, entries, nodes):
    """Return a hint for a name of an element, joint or node without the name of an output; "" for other names."""
    owners = [section for section, owner in entries if owner == name] + (["nodes"] if name in nodes else [])
    offered = [f"{name}.{what}" for section in owners for what in _offered(section, name, entries)]
    return f"; write what is measured of it, such as {offered[0]}" if offered else ""


def _offered(section, owner, entries):
    if section == "nodes":
        return [f"{quantity}.{what}" for quantity in NODE_SENSORS for what in (*AXES, MAGNITUDE[1:])]
    if section == "signals":  # whose value has the name of the signal
        kind, d = entries[section, owner]
        return [output.name for output in kind.chosen(d).outputs if output.name != VALUE]
    kind, d = entries[section, owner]
    if d.get("mesh", 1) > 1:
        return []
    outputs = [name for output, label in measured_outputs(kind, d) for name in quantities(output, label)]
    return [*outputs, *powers(kind.chosen(d))]


def _advice(what, kind=None, d=None):
    """Return what to write for an output that cannot be measured, a vector or a rate; "" if unknown."""
    name = what.partition(".")[0]
    if kind is None:
        return OF_NODES.get(name, "")
    chosen = kind.chosen(d)
    if chosen.section == "signals" and name == VALUE:
        return "the value of a signal is written as its name alone"
    if chosen.hidden.get(name):
        return chosen.hidden[name]
    if d.get("mesh", 1) > 1:
        return "it is divided by its 'mesh'; end it with an element of its own, without 'mesh', and read that"
    if name in WORK and powers(chosen):
        return "it is the integral, by a signal of the type 'integrator', of its 'given_power' or 'dissipated_power'"
    for o in chosen.outputs:
        if o.shape and o.name == name:
            return f"write {', '.join(quantities(o))}"
    rates = (f"the rate of '{o.name}' is '{o.rate}'" for o in chosen.outputs if o.rate)
    return " and ".join(rates) if what.rpartition(".")[2] in RATES else ""
