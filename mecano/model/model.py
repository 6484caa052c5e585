"""A model as defined by a deck or a script: nodes and elements by name, before the numbering."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.immutable import mutable

if TYPE_CHECKING:
    from mecano.element_interface import Kind
    from mecano.laws.law_table import LawTable
    from mecano.schema import Values


@dataclass(eq=False, repr=False)
class Node:
    """A named frame in the initial configuration."""

    name: str
    x: np.ndarray  # (3,) [m], inertial
    R: np.ndarray = field(default_factory=lambda: np.eye(3))  # (3, 3) material to inertial
    fixed: bool = False
    internal: bool = False  # not part of the deck: its motion is not an output


@dataclass(eq=False, repr=False)
class Element:
    """A named element: its kind, the names of its nodes, its checked deck values."""

    name: str
    kind: "Kind"  # element_interface.Kind
    nodes: tuple[str, ...]
    values: "Values" = field(default_factory=dict)


@mutable
class Model:
    """Nodes, elements, laws and gravity; the node name ``GROUND`` denotes a fixed node at the element's other node."""

    nodes: list[Node]
    elements: list[Element]
    laws: "LawTable"  # laws.LawTable
    gravity: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))
    units_in_formulas: dict[str, dict[int, str]] = field(default_factory=dict)  # of operands; see deck.Deck


GROUND = "ground"


def extent(nodes: Iterable[Node]) -> float:
    """Return the diagonal of the box around nodes [m]; 0 for a single point or none."""
    x = np.array([node.x for node in nodes])
    return float(np.linalg.norm(np.ptp(x, axis=0))) if len(x) else 0.0


def length_scale(nodes: Iterable[Node]) -> float:
    """Return the size of the mechanism [m], the diagonal of the box around its nodes; 1 m for a single point."""
    return extent(nodes) or 1.0


def title_of(kind: str, name: str) -> str:
    """Return the title of an element in messages, events and names of equations, from the names of both."""
    return f"{kind} '{name}'"


def with_ground(model: Model) -> Model:
    """Return the model with every ``GROUND`` replaced by a fixed node of its own, at the position of its neighbour."""
    nodes, elements = list(model.nodes), []
    by_name = {node.name: node for node in nodes}
    for element in model.elements:
        names = list(element.nodes)
        grounds = [i for i, name in enumerate(names) if name == GROUND]
        for number, i in enumerate(grounds, start=1):
            title = f"{GROUND}{number if len(grounds) > 1 else ''} of {element.kind.name} {element.name}"
            other = by_name[names[beside_ground(i, len(names))]]
            nodes.append(Node(title, other.x.copy(), other.R.copy(), fixed=True, internal=True))
            names[i] = title
        elements.append(Element(element.name, element.kind, tuple(names), element.values))
    return replace(model, nodes=nodes, elements=elements)


def beside_ground(i: int, n: int) -> int:
    """Return the index of the node whose position the ground takes as node ``i`` of ``n``.

    It is the other node of the pair; a gear on the ground, the last of three nodes, has its centre at the carrier.
    """
    if i % 2:
        return i - 1
    return i + 1 if i + 1 < n else 0
