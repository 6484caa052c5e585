"""An element or a part of an element, before the numbering."""

from dataclasses import dataclass


@dataclass(eq=False, repr=False)
class Instance:
    """An element or a part of an element: its kind, its nodes and its parameters."""

    owner: str
    path: str  # section and name of the owner
    kind: object
    nodes: tuple  # node indices
    parameters: dict
    n_parts: int = 0  # number of its parts, which follow it in the list
    coupled_to: tuple = ()  # list indices of the instances to whose multipliers it is coupled
    label: str = ""  # suffix of its outputs
    reads: tuple = ()  # formulas of its inputs
    inputs: tuple = ()  # list indices of the instances whose first scalars are its inputs
    senses: int | None = None  # list index of the instance of which it measures an output
