"""Resolve the names of quantities in formulas.

``error`` is a signal, ``elbow.angle`` an output of an element, joint or load that can be measured (``Kind.measures``),
``tip.position.z`` a component of the position, velocity or angular_velocity of a node, inertial. A name that occurs in
several sections of the deck is prefixed by the section: ``joints.elbow.angle``.
"""

import numpy as np

from mecano.constraints.sensors import NODE_SENSORS, SENSORS
from mecano.element_interface import Measured, Part

AXES = "xyz"


class UnknownQuantity(Exception):
    """A name in a formula is unknown or ambiguous; ``word``: the part at fault, ``known``: what it may have meant."""

    def __init__(self, message, word="", known=()):
        super().__init__(message)
        self.message, self.word, self.known = message, word, tuple(known)


def measurable(kind):
    """Return the names of the outputs of a kind that signals can read."""
    names = list(kind.measures)
    rates = {output.name: output.rate for output in kind.outputs}
    return list(dict.fromkeys([*names, *(rates[name] for name in names if rates.get(name))]))


def meaning(name, kinds, nodes):
    """Return the quantity that a name in a formula refers to: (section, name of the entry, name of the quantity).

    ``kinds``: {(section, name): Kind} of all entries of a deck; ``nodes``: names of the nodes. Raises UnknownQuantity.
    """
    words = name.split(".")
    if len(words) == 1:
        if ("signals", name) in kinds:
            return "signals", name, ""
        signals = [n for section, n in kinds if section == "signals"]
        raise UnknownQuantity(f"there is no signal '{name}'", name, signals)
    sections = dict.fromkeys(section for section, _ in kinds)
    if words[0] in (*sections, "nodes") and len(words) > 2:
        asked, owner, rest = (words[0],), words[1], ".".join(words[2:])
    else:
        asked, owner, rest = (*sections, "nodes"), words[0], ".".join(words[1:])
    owners = [section for section in asked if (owner in nodes if section == "nodes" else (section, owner) in kinds)]
    if not owners:
        known = [*(n for section, n in kinds if section in asked), *(nodes if "nodes" in asked else ())]
        raise UnknownQuantity(f"there is no '{owner}' with a measurable '{rest}'", owner, known)
    offered = {section: _offered(section, owner, kinds) for section in owners}
    found = [section for section in owners if rest in offered[section]]
    if len(found) == 1:
        return found[0], owner, rest
    if found:
        which = " or ".join(f"{section}.{name}" for section in found)
        raise UnknownQuantity(f"'{name}' is ambiguous: write {which}")
    known = [n for section in owners for n in offered[section]]
    nothing = "" if known else "; it has no measurable outputs (of a load, give its formula a name among the signals)"
    raise UnknownQuantity(f"'{rest}' of '{owner}' cannot be measured{nothing}", rest, known)


def _offered(section, owner, kinds):
    if section == "nodes":
        return [f"{quantity}.{axis}" for quantity in NODE_SENSORS for axis in AXES]
    if section == "signals":
        return []
    return measurable(kinds[section, owner])


def sensor_of_node(what):
    """Return the Part of the sensor of a component of the motion of a node: position.z."""
    quantity, _, axis = what.partition(".")
    values = {"direction": np.eye(3)[AXES.index(axis)]}
    if quantity == "position":
        values |= {"origin": np.zeros(3), "zero": 0.0}
    return Part(NODE_SENSORS[quantity], (0,), values)


def sensor_of_output(kind, output, values, frames, context):
    """Return the Part of the sensor of an output of an element with these deck values at ``frames`` [(x, R)]."""
    if output in kind.measures:
        found = kind.measures[output](values, frames, context)
        return found if isinstance(found, Part) else _sensor(found, 0)
    name = next(o.name for o in kind.outputs if o.rate == output and o.name in kind.measures)
    return _sensor(kind.measures[name](values, frames, context), 1)


def _sensor(found, which):
    assert isinstance(found, Measured)
    return Part(SENSORS[found.coordinate][which], found.nodes, {**found.axes, "zero": found.zero})
