"""Physical scales of residuals and errors, and the factors that balance the linear system."""

from dataclasses import dataclass

import numpy as np

from mecano.jit.entry import Indices, Vector, entry
from mecano.model.numbering import LENGTH_CONSTRAINT, MASSLESS, RELEASED, ROTATION, SCALAR, SIGNAL, TRANSLATION
from mecano.solve.events.compliance import RELEASED_COMPLIANCE

HUGE = 1e300  # larger numbers count as infinite
TINY = 1e-300
ROUNDING = 16 * 2.2e-16  # relative rounding error of a sum of a few numbers
MASSLESS_SHARE = 1e-4  # of the largest force on a scalar: bound of the rounding allowed for a massless one
ANGULAR_SHARE = 1e-3  # the scale of moments is at least this share of (largest force) x (length), and vice versa


@dataclass(frozen=True)
class Tolerances:
    """Convergence criteria of Newton's method, relative to the scales of the mechanism."""

    force: float = 1e-7  # of the largest force (moment) that acts on any node
    constraint: float = 1e-10  # of the length scale [m], or rad
    increment: float = 1e-6  # of the length scale [m], or rad
    max_iterations: int = 15


def length_scale(nodes):
    """Return the size of the mechanism [m], the diagonal of the box around its nodes; 1 m for a single point."""
    x = np.array([node.x for node in nodes])
    size = float(np.linalg.norm(np.ptp(x, axis=0))) if len(x) else 0.0
    return size if size > 0 else 1.0


def balance(system, s, cK, cC, cM, into=None):
    """Return k = penalty, the mean stiffness of the tangent cK K + cC C + cM M at ``s`` (theory.md, section 1).

    ``into`` is an Assembly for this tangent, by default a new one.
    """
    assembly = system.assemble(s, 1.0, 0.0, cK, cC, cM, into=into)
    diagonal = np.abs(assembly.data[system.diagonal[: system.n_q]])
    diagonal = diagonal[diagonal > 0]
    return float(diagonal.mean()) if len(diagonal) else 1.0


@entry
def norms(
    r: Vector, size: Vector, kind: Indices, n: int, length: float, force_tolerance: float, constraint_tolerance: float,
    share: float, k: float, stiffness: float, reach: float,
) -> (float, float):  # fmt: skip
    """Return (largest force or moment residual, largest constraint), each over its scale and tolerance: 1 just passes.

    r, size: (n_all,) residual and its scale; kind: (n_all,) see numbering.py; k: scale of the constraint rows. The
    scale of forces is the largest force anywhere, including fixed nodes; likewise for moments and for forces on scalars
    of elements (treated as forces). A constraint is measured as a length or an angle, and also as the force that it
    causes with the mean ``stiffness`` [N/m] of the step: in short steps a small displacement is a large force. The row
    of a released constraint, which states that reactions are shared (compliance.py), is measured as the force by which
    they deviate. The tolerance of a force is at least the rounding error due to positions as large as ``reach`` [m],
    or as the mechanism if that is larger, since arms are rounded even if no position is free;
    for massless scalars this bound is at most MASSLESS_SHARE, since in short steps the stiffness is that of the masses.
    ``share`` multiplies all tolerances except this bound. Signals are checked by their increments (increments.py),
    since no scale of their residuals is known.
    """
    force = moment = scalar = massless = distance = angle = shared = 0.0
    force_size = moment_size = scalar_size = TINY
    for i in range(r.shape[0]):
        x = abs(r[i]) if i < n else 0.0
        if not x <= HUGE:
            return np.inf, np.inf
        if kind[i] == TRANSLATION:
            force, force_size = max(force, x), max(force_size, size[i])
        elif kind[i] == ROTATION:
            moment, moment_size = max(moment, x), max(moment_size, size[i])
        elif kind[i] == SCALAR:
            scalar, scalar_size = max(scalar, x), max(scalar_size, size[i])
        elif kind[i] == MASSLESS:
            massless, scalar_size = max(massless, x), max(scalar_size, size[i])
        elif kind[i] == SIGNAL:
            continue
        elif kind[i] == LENGTH_CONSTRAINT:
            distance = max(distance, x / k)
        elif kind[i] == RELEASED:
            shared = max(shared, x / k)
        else:
            angle = max(angle, x / k)
    f = max(force_size, ANGULAR_SHARE * moment_size / length)
    m = max(moment_size, ANGULAR_SHARE * force_size * length)
    g = max(scalar_size, ANGULAR_SHARE * f)
    reach = max(reach, length)
    hidden = ROUNDING * stiffness * reach
    force_tolerance *= share
    f = max(f * force_tolerance, hidden)
    m = max(m * force_tolerance, ROUNDING * stiffness * max(reach * length, 1.0))
    light, g = max(g * force_tolerance, min(hidden, MASSLESS_SHARE * g)), max(g * force_tolerance, hidden)
    force = max(force, stiffness * distance, stiffness / RELEASED_COMPLIANCE * shared) / f
    moment = max(moment, stiffness * length * length * angle) / m
    constraint = max(distance / length, angle) / max(constraint_tolerance * share, ROUNDING * reach / length)
    return max(force, moment, scalar / g, massless / light), constraint
