"""Physical scales on which residuals and errors are judged, and the factors that balance the linear system."""

from dataclasses import dataclass

import numpy as np
from numba import njit

ANGULAR_SHARE = 1e-3  # moments count against at least this share of (largest force) x (length), and vice versa


@dataclass(frozen=True)
class Tolerances:
    """When Newton is done: residuals and increments relative to the scales of the mechanism."""

    force: float = 1e-7  # of the largest force (moment) that acts on any node
    constraint: float = 1e-10  # of the length scale [m], or rad
    increment: float = 1e-6  # of the length scale [m], or rad
    max_iterations: int = 15


def length_scale(nodes):
    """Size of the mechanism [m]: the diagonal of the box around its nodes; 1 m for a single point."""
    x = np.array([node.x for node in nodes])
    size = float(np.linalg.norm(np.ptp(x, axis=0))) if len(x) else 0.0
    return size if size > 0 else 1.0


def balance(system, s, cK, cC, cM):
    """k = penalty: the mean stiffness of the effective tangent cK K + cC C + cM M at ``s`` (theory.md section 1)."""
    system.assemble(s, 1.0, 0.0, cK, cC, cM)
    diagonal = np.abs(system.data[system.diagonal[: system.n_q]])
    diagonal = diagonal[diagonal > 0]
    return float(diagonal.mean()) if len(diagonal) else 1.0


@njit(cache=True)
def norms(r, size, kind, n, k, length, force_tolerance, constraint_tolerance):
    """Largest force and moment residual and largest constraint, over their scales and tolerances: 1 is just met.

    r, size (n_all,) residual and its scale; kind (n_all,) see numbering.py; k scale of the constraint rows.
    """
    force = moment = scalar = constraint = 0.0
    force_size = moment_size = scalar_size = 0.0
    for i in range(n):
        x = abs(r[i])
        if not x <= 1e300:
            return np.inf, np.inf
        if kind[i] == 0:
            force = max(force, x)
            force_size = max(force_size, size[i])
        elif kind[i] == 1:
            moment = max(moment, x)
            moment_size = max(moment_size, size[i])
        elif kind[i] == 2:
            scalar = max(scalar, x)
            scalar_size = max(scalar_size, size[i])
        elif kind[i] == 3:
            constraint = max(constraint, x / (k * length))
        else:
            constraint = max(constraint, x / k)
    f = max(force_size, ANGULAR_SHARE * moment_size / length)
    m = max(moment_size, ANGULAR_SHARE * force_size * length)
    tiny = 1e-300
    worst = max(force / (f + tiny), moment / (m + tiny), scalar / (scalar_size + tiny))
    return worst / force_tolerance, constraint / constraint_tolerance
