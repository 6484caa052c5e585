"""Elements and their parts as one list, before the numbering."""

from dataclasses import dataclass

import numpy as np


@dataclass
class Instance:
    """An element or a part of an element, before the numbering."""

    owner: str
    path: str  # section and name of the owner
    kind: object
    nodes: tuple  # node indices
    parameters: dict
    n_parts: int = 0  # number of its parts, which follow it in the list
    borrows: tuple = ()  # list indices of the instances to whose multipliers it is coupled
    label: str = ""  # suffix of its outputs


def expand(model, context):
    """Return (instances of elements and parts, shared unknowns (what, i, j, owner's index), unknowns in use)."""
    index = {node.name: i for i, node in enumerate(model.nodes)}
    instances, shared, used = [], [], set()
    for element in model.elements:
        kind, nodes = element.kind.chosen(element.values), tuple(index[name] for name in element.nodes)
        frames = [(np.asarray(model.nodes[i].x, float), model.nodes[i].R) for i in nodes]
        title, path = f"{element.kind.name} '{element.name}'", f"{kind.section}/{element.name}"
        record = kind.prepare(element.values, frames, context)
        parts = kind.parts(element.values, frames, context)
        instances.append(Instance(title, path, kind, nodes, record, len(parts)))
        first = len(instances)
        for part in parts:
            on, lenders = tuple(nodes[i] for i in part.nodes), tuple(first + i for i in part.borrows)
            instances.append(Instance(title, path, part.kind, on, part.parameters, 0, lenders, part.label))
        for what, i, j in kind.shares(element.values, frames):
            shared.append((what, nodes[i], nodes[j], len(instances) - len(parts) - 1))
    for item in instances:
        if item.kind.acts:
            used |= {(slot[0], item.nodes[int(slot[1:])]) for slot in item.kind.layout}
    return instances, shared, used
