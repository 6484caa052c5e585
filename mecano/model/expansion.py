"""Elements and their parts as one list, before the numbering."""

from collections.abc import Container, Sequence

import numpy as np

from mecano.element_interface import Context, Kind
from mecano.model.instance import Instance, Shared
from mecano.model.mesh import Frame
from mecano.model.model import Element, Model, title_of
from mecano.model.wiring import wire


def expand(model: Model, context: Context) -> tuple[list[Instance], list[Shared], set[tuple[str, int]]]:
    """Return (instances of elements and parts, shared unknowns (what, i, j, owner's index), unknowns in use).

    Elements whose hidden outputs signals read are replaced by variants that reveal them.
    """
    revealed: set[str] | None = None
    wanted: set[str] = set()
    while revealed != wanted:
        revealed = set(wanted)
        instances, shared = _listed(model, context, revealed)
        if any(item.reads for item in instances):
            wanted |= wire(instances, model, context)
    used = set()
    for item in instances:
        if item.kind.acts and not item.kind.of_signals:
            used |= {(slot[0], item.nodes[int(slot[1:])]) for slot in item.kind.layout}
    return instances, shared, used


def _kind_of(element: Element, frames: Sequence[Frame], revealed: Container[str]) -> Kind:
    """Return the Kind of an element between nodes with ``frames`` at the start.

    It has no hidden outputs if its path is in ``revealed``.
    """
    kind = element.kind.placed(element.values, frames)
    return kind.revealed if path_of(element) in revealed and kind.revealed else kind


def path_of(element: Element) -> str:
    """Return the section and name of an element."""
    return f"{element.kind.section}/{element.name}"


def _listed(model: Model, context: Context, revealed: Container[str]) -> tuple[list[Instance], list[Shared]]:
    """Return (instances of elements and parts, shared unknowns); see ``expand``."""
    index = {node.name: i for i, node in enumerate(model.nodes)}
    instances, shared = [], []
    for element in model.elements:
        nodes = tuple(index[name] for name in element.nodes)
        frames = [(np.asarray(model.nodes[i].x, float), model.nodes[i].R) for i in nodes]
        kind = _kind_of(element, frames, revealed)
        title, path = title_of(element.kind.name, element.name), path_of(element)
        record = kind.record_values(element.values, frames, context)
        parts = kind.parts(element.values, frames, context)
        reads = kind.read(element.values) if kind.inputs else ()
        instances.append(Instance(title, path, kind, nodes, record, len(parts), reads=reads))
        first = len(instances)
        for part in parts:
            on, coupled = tuple(nodes[i] for i in part.nodes), tuple(first + i for i in part.coupled_to)
            instances.append(Instance(title, path, part.kind, on, part.parameters, 0, coupled, part.label, part.reads))
        for what, i, j in kind.shares(element.values, frames):
            shared.append((what, nodes[i], nodes[j], len(instances) - len(parts) - 1))
    return instances, shared
