"""One element or part of an element, before it is numbered."""

from dataclasses import dataclass


@dataclass
class Instance:
    """An element or a part, on which nodes, with which values of its record."""

    owner: str
    path: str  # section and name of the owner
    kind: object
    nodes: tuple  # indices
    parameters: dict
    n_parts: int = 0  # parts that follow it in the list
    coupled_to: tuple = ()  # numbers, in the list, of the instances whose multipliers it borrows
    label: str = ""  # of its outputs
    reads: tuple = ()  # formulas of its inputs
    inputs: tuple = ()  # numbers, in the list, of the instances whose first scalars its inputs are
