"""Elements and their parts as one list, before the numbering."""

import numpy as np

from mecano.model.instance import Instance
from mecano.model.model import title_of
from mecano.model.wiring import wire


def expand(model, context):
    """Return (instances of elements and parts, shared unknowns (what, i, j, owner's index), unknowns in use)."""
    index = {node.name: i for i, node in enumerate(model.nodes)}
    instances, shared, used = [], [], set()
    for element in model.elements:
        kind, nodes = element.kind.chosen(element.values), tuple(index[name] for name in element.nodes)
        frames = [(np.asarray(model.nodes[i].x, float), model.nodes[i].R) for i in nodes]
        title, path = title_of(element.kind.name, element.name), f"{kind.section}/{element.name}"
        record = kind.record_values(element.values, frames, context)
        parts = kind.parts(element.values, frames, context)
        reads = kind.read(element.values) if kind.inputs else ()
        instances.append(Instance(title, path, kind, nodes, record, len(parts), reads=reads))
        first = len(instances)
        for part in parts:
            on, lenders = tuple(nodes[i] for i in part.nodes), tuple(first + i for i in part.coupled_to)
            instances.append(Instance(title, path, part.kind, on, part.parameters, 0, lenders, part.label, part.reads))
        for what, i, j in kind.shares(element.values, frames):
            shared.append((what, nodes[i], nodes[j], len(instances) - len(parts) - 1))
    if any(item.reads for item in instances):
        wire(instances, model, context)
    for item in instances:
        if item.kind.acts and not item.kind.of_signals:
            used |= {(slot[0], item.nodes[int(slot[1:])]) for slot in item.kind.layout}
    return instances, shared, used
