"""A model as it is handed over by a deck or a script: nodes and elements by name, before any numbering."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Node:
    """A named frame at the start."""

    name: str
    x: np.ndarray  # (3,) [m], inertial
    R: np.ndarray = field(default_factory=lambda: np.eye(3))  # (3, 3) material to inertial
    fixed: bool = False
    internal: bool = False  # stands in no deck, so its motion is no output


@dataclass
class Element:
    """A named element: its kind, the names of its nodes, its checked deck values."""

    name: str
    kind: object  # contract.Kind
    nodes: tuple
    values: dict = field(default_factory=dict)


@dataclass
class Model:
    """Nodes, elements, laws and gravity; ``GROUND`` as a node name means a fixed node where the other one is."""

    nodes: list
    elements: list
    laws: object  # laws.LawTable
    gravity: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))


GROUND = "ground"


def with_ground(model):
    """The same model with every ``GROUND`` replaced by a fixed node of its own."""
    nodes, elements = list(model.nodes), []
    by_name = {node.name: node for node in nodes}
    for element in model.elements:
        names = list(element.nodes)
        if GROUND in names:
            other = by_name[names[1 - names.index(GROUND)]]
            title = f"{GROUND} of {element.kind.name} {element.name}"
            ground = Node(title, other.x.copy(), other.R.copy(), fixed=True, internal=True)
            nodes.append(ground)
            names[names.index(GROUND)] = ground.name
        elements.append(Element(element.name, element.kind, tuple(names), element.values))
    return Model(nodes, elements, model.laws, model.gravity)
