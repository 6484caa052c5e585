"""Warnings about the bearings and bodies of wheels: axes that are not those of the wheels, wheels without a bearing."""

from collections import Counter
from collections.abc import Iterator, Mapping

import numpy as np

from mecano.deck.physics import own_nodes
from mecano.deck.turning_axes import are_parallel, bodies, listed, turning_together
from mecano.element_interface import SECTIONS, Kind
from mecano.element_interface.kind import FREELY
from mecano.errors import LocatedWarning
from mecano.maths.inertia import inertia_matrix
from mecano.maths.so3 import exp
from mecano.maths.vector import Vec3
from mecano.model.model import GROUND
from mecano.schema import Values

APART = 0.2  # sine of the angle between the axes of a wheel and of its bearing; toe and camber turn both
SKEWED = 0.1  # the same between the axes of a wheel and of its body: toe and camber of smaller angles wobble little
ROUND, FLAT = 1e-6, 0.01  # of the largest moment of inertia: differences in a body of revolution, and from a ball


def misplaced_bearings(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on wheels that turn about another axis than theirs, that nothing holds, beside a bearing."""
    wheels = _wheels(values, kinds)
    yield from _beside(values, kinds, wheels)
    yield from _held(values, kinds, wheels)
    yield from _skewed(values, wheels)
    around = {name: _at_node(values, kinds, node, name) for name, (node, _) in wheels.items()}
    for name, (node, axis) in wheels.items():
        if not around[name] and (values["joints"] or any(around.values())):
            held = next((f", as one holds wheel '{other}'" for other, found in around.items() if found), "")
            text = f"no joint or member holds its node '{node}'{held}; is a bearing missing?"
            yield ("elements", name), f"{values['elements'][name]['type']} '{name}': {text}"
        elif len(around[name]) == 1 and (text := _other_axis(axis, *around[name][0])):
            yield ("joints", around[name][0][0], "axis"), text.format(wheel=name)


def _beside(values, kinds, wheels):
    """Yield (path, text) on wheels at the held node of their bearing, while nothing else is at the other one."""
    if not wheels:
        return
    body = bodies(values, kinds, turning_together)
    connected: Counter[str] = Counter()
    for section in SECTIONS[:2]:
        for name, d in values[section].items():
            names = own_nodes(kinds[d["type"]], d)
            if name not in wheels and len(ends := body(names) if len(names) > 1 else ()) > 1:
                connected.update(ends)
    for name, (node, axis) in wheels.items():
        (own,) = body([node])
        for joint, d in values["joints"].items():
            if kinds[d["type"]].turns != FREELY or node not in d["nodes"] or not are_parallel(axis, d["axis"], APART):
                continue
            other = d["nodes"][d["nodes"].index(node) - 1]
            held = connected[own] > 1 or body([node]) == body([GROUND])
            taken = any(body([other]) == body([hub]) for hub, _ in wheels.values())
            if held and other != GROUND and connected[next(iter(body([other])))] == 1 and not taken:
                text = f"{d['type']} '{joint}' lets node '{other}' spin, and nothing is on it: is the wheel meant to be"
                yield ("elements", name), f"{values['elements'][name]['type']} '{name}': {text} there, not on '{node}'?"


def _held(values, kinds, wheels):
    """Yield (path, text) on wheels that share the rotation of the ground, unless a joint does nothing but lock them."""
    if not wheels:
        return
    body = bodies(values, kinds, turning_together)
    for name, (node, axis) in wheels.items():
        locked = any(all(slot[0] == "R" for slot in kind.layout) for _, kind, _ in _at_node(values, kinds, node, name))
        if body([node]) == body([GROUND]) and not locked:
            text = f"its node '{node}' cannot turn, so the wheel slides; is a hinge about {listed(axis)} missing?"
            yield ("elements", name), f"{values['elements'][name]['type']} '{name}': {text}"


def _skewed(values, wheels):
    """Yield (path, text) on bodies of revolution that wobble on a wheel, because their node has not its orientation."""
    spinning = {node: (wheel, axis) for wheel, (node, axis) in wheels.items()}
    for name, d in values["elements"].items():
        if d["type"] != "rigid_body" or d["node"] not in spinning:
            continue
        wheel, axis = spinning[d["node"]]
        own = _axis_of_revolution(inertia_matrix(d["inertia"]))
        own = own and exp(Vec3(*values["nodes"][d["node"]]["orientation"])) @ own
        if own is not None and not are_parallel(axis, own, SKEWED):
            axes = f"the body of revolution has the axis {listed(own)}, and wheel '{wheel}' {listed(axis)}: it wobbles"
            remedy = f"'inertia' is in the axes of node '{d['node']}', whose 'orientation' may be that of the wheel"
            yield ("elements", name, "inertia"), f"rigid_body '{name}': {axes} as it spins; {remedy}"


def _axis_of_revolution(inertia):
    """Return the axis about which an inertia (3, 3) is that of a body of revolution; None for others and for balls."""
    moments, axes = np.linalg.eigh(inertia)
    low, high = np.diff(moments) / moments[2]
    return Vec3(*axes[:, 0 if low > high else 2]) if min(low, high) <= ROUND and max(low, high) > FLAT else None


def _wheels(values, kinds):
    """Return {name: (node, axis (3,))} of the elements that roll; a skate has no radius."""
    found = {}
    for name, d in values["elements"].items():
        kind = kinds[d["type"]]
        if "wheels" in kind.display.pictures and ("tire_law" in d or "radius" in d):
            found[name] = own_nodes(kind, d)[-1], np.array(d["axis"])
    return found


def _at_node(values, kinds, node, wheel):
    """Return (name, Kind, deck values) of the joints and members of a node, without the ``wheel`` and point bodies."""
    return [
        (name, kinds[d["type"]], d)
        for section in SECTIONS[:2]
        for name, d in values[section].items()
        for nodes in [own_nodes(kinds[d["type"]], d)]
        if node in nodes and name != wheel and len(nodes) > 1
    ]


def _other_axis(axis, name, kind, d):
    """Return a text if the only joint of a wheel lets it turn about another axis than that of the wheel."""
    if kind.turns != FREELY:
        return ""
    if are_parallel(axis, d["axis"], APART):
        return ""
    return (
        f"{d['type']} '{name}': its axis is not that of the wheel '{{wheel}}' on it, {listed(axis)}: "
        "the wheel cannot spin"
    )
