"""Checks that joints which count an angle count it about the axis about which their bodies can turn."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from mecano.deck.compose import Node
from mecano.deck.physics import Poses, own_nodes, poses
from mecano.deck.scope import Scope, place_of
from mecano.deck.wording import quoted
from mecano.element_interface import FREELY, SECTIONS, Kind
from mecano.model.model import GROUND, beside_ground
from mecano.schema import Values

OTHER_AXIS = 1e-3  # rad


def check_axes(values: Values, root: Node, scope: Scope) -> None:
    """Report angles, prescribed or of gears, about another axis than that of the bearing between the same bodies."""
    joints, kinds = values["joints"], scope.kinds
    counted = [(name, *angle) for name, d in joints.items() for angle in kinds[d["type"]].counts_angles(d)]
    if not counted:
        return
    body = bodies(values, kinds, turning_together)
    bearings = {body(d["nodes"]): name for name, d in joints.items() if kinds[d["type"]].turns == FREELY}
    for name, field, axis, pair in counted:
        bearing = bearings.get(body(pair))
        if bearing is None or are_parallel(axis, joints[bearing]["axis"], OTHER_AXIS):
            continue
        key, node = root.value["joints"][1].value[name]
        scope.subject = f"{joints[name]['type']} {quoted(name)}"
        text = f"{_named(field, axis, joints[name])} is not that of {_described(bearing, joints[bearing], pair)}"
        scope.refuse(place_of(text, node, key), f"{text}, the only axis about which they can turn")


def _named(field, axis, d):
    """Return the words for the axis of a field, which may be absent."""
    return quoted(field) if d[field] is not None else f"its axis {listed(axis)}, without {quoted(field)} that of a,"


def _described(name, d, pair):
    """Return the words for a joint, the nodes between which it lies, and its axis."""
    bodies = "the same nodes" if set(d["nodes"]) == set(pair) else f"the bodies of {' and '.join(map(quoted, pair))}"
    return f"{d['type']} {quoted(name)} between {bodies}, {listed(d['axis'])}"


def listed(axis: Sequence[float]) -> str:
    """Return the components of a vector (3,) as in a deck."""
    return f"[{', '.join(f'{c:g}' for c in axis)}]"


def are_parallel(a: Sequence[float], b: Sequence[float], sine: float) -> bool:
    """Return whether two vectors (3,) have the same direction or opposite ones, to an angle with this ``sine``."""
    return bool(np.linalg.norm(np.cross(a, b)) <= sine * np.linalg.norm(a) * np.linalg.norm(b))


def bodies(
    values: Values, kinds: Mapping[str, Kind], together: Callable[[Kind, Values, Poses], list[tuple[str, str]]]
) -> Callable[[Sequence[str]], frozenset[str]]:
    """Return a function of names of nodes that returns the set of the bodies to which they belong.

    ``together`` returns the pairs of nodes of an element or joint that belong to one body.
    """
    leader = {name: GROUND for name, node in values["nodes"].items() if node["fixed"]}

    def body(name):
        while name in leader:
            leader[name] = leader.get(leader[name], leader[name])
            name = leader[name]
        return name

    at = poses(values["nodes"])
    for section in SECTIONS:
        for d in values[section].values():
            for a, b in together(kinds[d["type"]], d, at):
                if body(a) != body(b):
                    leader[body(a)] = body(b)
    return lambda names: frozenset(body(name) for name in names)


def turning_together(kind: Kind, d: Values, at: Poses) -> list[tuple[str, str]]:
    """Return the pairs of nodes of an element or joint that have one rotation, or a constant relative one."""
    names = own_nodes(kind, d)
    if "attached" in d:  # also nodes with an orientation of their own
        return [(names[0], name) for name in names[1:]]
    beside = [names[beside_ground(i, len(names))] if name == GROUND else name for i, name in enumerate(names)]
    if not all(name in at for name in beside):
        return []  # inner nodes of beams
    return [(names[i], names[j]) for what, i, j in kind.shares(d, [at[name] for name in beside]) if what == "R"]
