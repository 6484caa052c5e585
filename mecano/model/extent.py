"""Size of a mechanism, the scale of its lengths."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from mecano.model.model import Node


def extent(nodes: "Iterable[Node]") -> float:
    """Return the diagonal of the box around nodes [m]; 0 for a single point or none."""
    x = np.array([node.x for node in nodes])
    return float(np.linalg.norm(np.ptp(x, axis=0))) if len(x) else 0.0


def length_scale(nodes: "Iterable[Node]") -> float:
    """Return the size of the mechanism [m], the diagonal of the box around its nodes; 1 m for a single point."""
    return extent(nodes) or 1.0
