"""Division of members into elements: leg -> elements leg.1 ... leg.n between nodes leg.1 ... leg.(n-1).

User-defined names contain no dot, so these names are always free.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from mecano.element_interface import Kind
from mecano.model.model import Element, Model, Node
from mecano.schema import Values

Frame: TypeAlias = tuple[np.ndarray, np.ndarray]  # position (3,) [m] and orientation (3, 3) of a node


def divides(kind: Kind, values: Values) -> bool:
    """Return True if an element of this kind with these values is divided into several."""
    return kind.divide is not None and values["mesh"] > 1


def inner_names(name: str, values: Values) -> list[str]:
    """Return the names of the intermediate nodes of the member ``name``; ``values`` are its deck values."""
    return [f"{name}.{i}" for i in range(1, values.get("mesh", 1))]


def divided_nodes(name: str, values: Values) -> list[str]:
    """Return the names of all nodes of the member ``name`` from its start to its end."""
    first, second = values["nodes"]
    return [first, *inner_names(name, values), second]


def piece_names(name: str, values: Values) -> list[str]:
    """Return the names of the elements of the member ``name``."""
    return [f"{name}.{i}" for i in range(1, values["mesh"] + 1)] if values.get("mesh", 1) > 1 else [name]


def place_members(members: Iterable[Element], at: dict[str, Frame]) -> tuple[dict[str, list[Values]], list[Element]]:
    """Divide ``members``, a list of Elements; add the intermediate nodes, name -> (x, R), to ``at``.

    A member may end at a node of another one. Returns {name: [values of each element]}, without members that the check
    of their kind rejects, and the list of members with an end node that does not exist.
    """
    pieces, waiting = {}, list(members)
    while ready := [member for member in waiting if _is_placed(member, at)]:
        waiting = [member for member in waiting if not _is_placed(member, at)]
        for member in ready:
            ends = [at[node] for node in member.nodes]
            assert member.kind.divide is not None, "a member with a mesh has a kind that divides it"
            if not member.kind.check(member.values, ends):
                inner, pieces[member.name] = member.kind.divide(member.values, ends)
                at.update(zip(inner_names(member.name, member.values), inner, strict=True))
    return pieces, waiting


def _is_placed(member, at):
    return all(node in at for node in member.nodes)


def divided(model: Model) -> Model:
    """Return the Model with every member divided. Raises ValueError for members that cannot be."""
    members = [element for element in model.elements if divides(element.kind, element.values)]
    at = {node.name: (node.x, node.R) for node in model.nodes}
    pieces, _ = place_members(members, at)
    if len(pieces) < len(members):
        wrong = ", ".join(member.name for member in members if member.name not in pieces)
        raise ValueError(f"members that cannot be divided: {wrong}")
    known = {node.name for node in model.nodes}
    elements: list[Element] = []
    for element in model.elements:
        elements += _pieces(element, pieces[element.name]) if element.name in pieces else [element]
    nodes = [*model.nodes, *(Node(name, x, R) for name, (x, R) in at.items() if name not in known)]
    return replace(model, nodes=nodes, elements=elements)


def _pieces(member, values):
    ends = divided_nodes(member.name, {**member.values, "nodes": member.nodes})
    names = piece_names(member.name, member.values)
    pairs = zip(ends[:-1], ends[1:], strict=True)
    return [Element(name, member.kind, pair, d) for name, pair, d in zip(names, pairs, values, strict=True)]
