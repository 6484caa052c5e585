"""Checks of values in combination: the checks of each kind, nodes and names used twice or not at all."""

from collections import Counter
from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from mecano.deck.compose import Node
from mecano.deck.error_location import pointed_at
from mecano.deck.limits import ARITHMETIC, BEYOND_FLOATS
from mecano.deck.scope import Scope
from mecano.deck.wording import quoted
from mecano.element_interface import SECTIONS, Kind
from mecano.model.mesh import divides, place_members
from mecano.model.model import GROUND, Element, beside_ground
from mecano.schema import Values

Poses: TypeAlias = dict[str, tuple[np.ndarray, np.ndarray]]  # of nodes by name: x (3,) [m], R (3, 3)


def own_nodes(kind: Kind, values: Values) -> list[str]:
    """Return the names of the nodes of an element, joint or load that its fields of node types give."""
    names = []
    for field in kind.fields:
        value = values[field.name]
        if field.type.name == "node" and value is not None:
            names.append(value)
        elif field.type.name == "nodes" and value is not None:
            names.extend(value)
    return names


def element_nodes(kind: Kind, values: Values) -> list[str]:
    """Return the names of the nodes of an element, joint or load: its own, then those of the joints that it names."""
    return [*own_nodes(kind, values), *(name for joint in named_joints(kind, values) for name in joint["nodes"])]


def named_joints(kind: Kind, values: Values) -> list[Values]:
    """Return the checked values of the joints that an element, joint or load names."""
    return [joint for field in kind.fields for joint in _joints(field.type, values[field.name])]


def _joints(type_, value):
    """Return the checked values of the joints that a field of this type names."""
    if type_.name == "joint":
        return [] if value is None else [value]
    return value if type_.name == "list" and type_.options[0].name == "joint" else []


def rotations(vectors: np.ndarray) -> np.ndarray:
    """Return the rotation matrices (n, 3, 3) of rotation vectors (n, 3) [rad] by Rodrigues' formula."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    H = np.zeros((len(vectors), 3, 3))
    H[:, 2, 1], H[:, 0, 2], H[:, 1, 0] = vectors.T
    H -= H.transpose(0, 2, 1)
    s, c = np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    return np.eye(3) + s * H + c * H @ H


def poses(nodes: Mapping[str, Values]) -> Poses:
    """Return {name: (x (3,) [m], R (3, 3))} of checked nodes."""
    x = np.array([node["position"] for node in nodes.values()])
    R = rotations(np.array([node["orientation"] for node in nodes.values()]))
    return {name: (x[i], R[i]) for i, name in enumerate(nodes)}


def check_model(values: Values, root: Node, scope: Scope) -> None:
    """Report all inconsistencies in the elements, joints, loads and nodes."""
    at = poses(values["nodes"])
    used: set[str] = set()  # names of nodes
    noted: set[tuple[int, str]] = set()  # reported errors of shared laws and grounds
    sound: set[tuple[str, str]] = set()  # section and name of the elements without errors
    placed, left = _place_members(values["elements"], at, scope.kinds)
    for section in SECTIONS:
        for name, element in values[section].items():
            key, node = root.value[section][1].value[name]
            kind = scope.kinds[element["type"]]
            scope.subject = f"{kind.name} {quoted(name)}"
            names = element_nodes(kind, element)
            if section != "loads" or len(names) > 1:
                used.update(names)
            if name in left:
                scope.refuse(key, "depends on itself, or on members that are wrong or depend on it")
            elif all(node in at for node in names if node != "ground"):
                checked = section == "elements" and name in placed
                if checked or _check_element(kind, element, names, at, (key, node), root, scope, noted):
                    sound.add((section, name))
    if any(ground["profile"] for ground in values["grounds"].values()):
        from mecano.deck.profile_curvature import check_profile_curvature  # few decks have a profile

        check_profile_curvature(values, at, sound, root, scope)
    _check_latches(values["joints"], root, scope)
    _check_unused(values["nodes"], used, root, scope)


def _check_latches(joints, root, scope):
    """Report latches beyond a stop of their joint, which the joint can never reach."""
    for name, d in joints.items():
        if not d.get("latch") or not d.get("stops"):
            continue
        quantity, value = next(iter(d["latch"].items()))
        side, unit = "upper" if value > 0.0 else "lower", "rad" if quantity == "angle" else "m"
        stop = d["stops"][side]
        if abs(value) > abs(stop):
            _, node = root.value["joints"][1].value[name]
            scope.subject = f"{d['type']} {quoted(name)}"
            text = f"'latch.{quantity}' lies at {value:g} {unit}, beyond the {side} stop at {stop:g} {unit}"
            hint = f"move the stop to {value:g} {unit} or beyond, or move the latch before it"
            scope.refuse(node.value["latch"][1].value[quantity][1], f"{text}: the joint would never lock", hint)


def _place_members(elements, at, kinds):
    """Add the nodes of members to ``at``; return the names of the placed members, and of those without end nodes."""
    members = [
        Element(name, kinds[d["type"]], tuple(element_nodes(kinds[d["type"]], d)), d)
        for name, d in elements.items()
        if divides(kinds[d["type"]], d)
    ]
    members = [member for member in members if "ground" not in member.nodes and len(set(member.nodes)) == 2]
    with np.errstate(all="ignore"):
        pieces, left = place_members(members, at)
    return pieces.keys(), {member.name for member in left}


def _check_element(kind, element, names, at, entry, root, scope, noted):
    """Report errors of an element, those of a shared law or ground once (``noted``); return True if there are none."""
    twice = [name for name, count in Counter(own_nodes(kind, element)).items() if count > 1]
    if twice:
        scope.refuse(entry[0], f"node {quoted(twice[0])} is named twice")
        return False
    beside = [names[beside_ground(i, len(names))] if name == GROUND else name for i, name in enumerate(names)]
    given = [at[name] for name in beside]
    texts = _texts(kind, element, given)
    for text in texts:
        place = pointed_at(text, kind, entry, root)
        if (id(place), text) not in noted:
            noted.add((id(place), text))
            scope.refuse(place, text, "" if place is entry[0] else scope.where_given(place))
    return not texts


def _texts(kind, element, nodes):
    """Return the texts of the check of a kind, or a text on numbers beyond the limits of floating point."""
    try:
        with np.errstate(all="ignore"):
            return kind.check(element, nodes)
    except ARITHMETIC:
        return [f"its numbers are {BEYOND_FLOATS}"]


def _check_unused(nodes, used, root, scope):
    for name in nodes:
        if name not in used:
            scope.subject = f"node {quoted(name)}"
            key, _ = root.value["nodes"][1].value[name]
            scope.refuse(key, "no element or joint is connected to it", "connect or delete it")
