"""An element or a part of an element, before the numbering."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

from mecano.element_interface import Kind, OwnOutput

Shared: TypeAlias = tuple[str, int, int, int]
"""An unknown that two nodes share: "x" or "R", indices of both, list index of the instance that joins them"""


@dataclass(eq=False, repr=False)
class Instance:
    """An element or a part of an element: its kind, its nodes and its parameters."""

    owner: str
    path: str  # section and name of the owner
    kind: Kind
    nodes: tuple[int, ...]  # node indices
    parameters: Mapping[str, Any]
    n_parts: int = 0  # number of its parts, which follow it in the list
    coupled_to: tuple[int, ...] = ()  # list indices of the instances to whose multipliers it is coupled
    label: str = ""  # suffix of its outputs
    reads: tuple[str | OwnOutput, ...] = ()  # its inputs
    inputs: tuple[int, ...] = ()  # list indices of the instances whose first scalars are its inputs
    senses: int | None = None  # list index of the instance whose output it measures
