"""Physical scales of residuals and errors, and the factors that balance the linear system."""

from typing import NamedTuple

import numpy as np

from mecano.immutable import immutable
from mecano.jit.entry import Vector, entry
from mecano.jit.kernel import kernel
from mecano.model.assembly import Assembly
from mecano.model.numbering import (
    LENGTH_CONSTRAINT,
    MASSLESS,
    RELEASED,
    ROTATION,
    SCALAR,
    SIGNAL,
    STATE,
    TRANSLATION,
    Unknowns,
)
from mecano.model.state import Motion, State
from mecano.model.system import System
from mecano.solve.events.compliance import RELEASED_COMPLIANCE
from mecano.solve.linear.rounding import HUGE, ROUNDING, TINY

SIGNALS = 1e-8  # tolerance of the equation of a signal, relative to its value or rate
NO_STIFFNESS = 1e-15  # N/m: a smaller mean stiffness is the rounding error of reactions
SMALL = 1e-3  # signals that are smaller are judged as if they were of this size
ANGULAR_SHARE = 1e-3  # the scale of moments is at least this share of (largest force) x (length), and vice versa


@immutable
class Tolerances:
    """Convergence criteria of Newton's method, relative to the scales of the mechanism."""

    force: float = 1e-7  # of the largest force (moment) that acts on any node
    constraint: float = 1e-10  # of the length scale [m], or rad
    increment: float = 1e-6  # of the length scale [m], or rad
    max_iterations: int = 15


def constraint_scale(system: System, length: float) -> np.ndarray:
    """Return the scale of each constraint (n_l,): the length scale [m], or 1 rad."""
    return np.where(system.numbering.kind[system.n_q : system.n] == LENGTH_CONSTRAINT, length, 1.0)


def balance(
    system: System, s: State, length: float, cK: float, cC: float, cM: float, into: Assembly | None = None
) -> float:
    """Return k = penalty, the mean stiffness of the tangent cK K + cC C + cM M at ``s`` (theory.md, section 1).

    Stiffnesses of rotations [N m] are divided by the square of the ``length`` scale [m] of the mechanism. Without
    stiffness the mean is 1 N/m: if the stiffness that rounding errors of reactions cause were used to scale the
    reactions, it would decrease by the rounding unit in every step. ``into`` is an Assembly for this tangent, by
    default a new one.
    """
    assembly = system.assemble(s, cK=cK, cC=cC, cM=cM, into=into)
    n_q = system.n_q
    mean = mean_diagonal(assembly.data[system.diagonal[:n_q]], system.numbering.kind[:n_q], length)
    return mean if mean > NO_STIFFNESS else 1.0


def mean_diagonal(diagonal: np.ndarray, kind: np.ndarray, length: float) -> float:
    """Return the mean magnitude of the nonzero entries of a ``diagonal`` (n,); 0 if there are none.

    Entries of rotations, by their ``kind`` (n,), are divided by the square of the ``length`` scale [m].
    """
    sizes = np.abs(diagonal) / np.where(kind == ROTATION, length**2, 1.0)
    sizes = sizes[sizes > 0]
    return float(sizes.mean()) if len(sizes) else 0.0


class Scales(NamedTuple):
    """Scales of the residuals of a mechanism."""

    length: float  # m
    k: float  # of the rows of constraints
    stiffness: float  # mean of the step [N/m]
    duration: float  # of the run [s]
    loudest: float  # largest signal


class Limits(NamedTuple):
    """Largest admissible residuals: a share of the tolerances, or the rounding error if that is larger."""

    force: float  # tolerance
    constraint: float  # tolerance
    share: float  # of the tolerances
    most: float  # largest rounding error allowed, in tolerances
    reach: float  # largest coordinate over the length scale: its rounding error counts


@entry
def norms(
    r: Vector, size: Vector, of: Unknowns, s: Motion, scales: Scales, limits: Limits
) -> (float, float, float):  # fmt: skip
    """Return the largest residuals of (forces and moments, constraints, signals) over their tolerances.

    Each is divided by its scale and tolerance, so 1 just passes. r, size: (n_all,) residual and its scale. The scale of
    forces is the largest force anywhere, including fixed nodes; likewise for moments and for forces on scalars of
    elements (treated as forces). A constraint is measured as a length or an angle, and also as the force that it causes
    with the mean stiffness of the step: in short steps a small displacement is a large force. The row of a released
    constraint, which states that reactions are shared (compliance.py), is measured as the force by which they deviate.

    The equation y - c = 0 of a signal is compared with its value in z, but not below the rounding error of the largest
    signal; the equation of a signal with a rate, in v, with the change of the signal that the residual causes in a run.
    """
    length, k, stiffness, duration, kind = scales.length, scales.k, scales.stiffness, scales.duration, of.kind
    force = moment = scalar = distance = angle = shared = signal = 0.0
    force_size = moment_size = scalar_size = TINY
    for i in range(r.shape[0]):
        x = abs(r[i]) if i < of.n else 0.0
        if not x <= HUGE:
            return np.inf, np.inf, np.inf
        if kind[i] == TRANSLATION:
            force, force_size = max(force, x), max(force_size, size[i])
        elif kind[i] == ROTATION:
            moment, moment_size = max(moment, x), max(moment_size, size[i])
        elif kind[i] == SCALAR or kind[i] == MASSLESS:
            scalar, scalar_size = max(scalar, x), max(scalar_size, size[i])
        elif kind[i] == SIGNAL:
            signal = max(signal, x / max(max(abs(s.z[i]), SMALL), ROUNDING / SIGNALS * scales.loudest))
        elif kind[i] == STATE:
            signal = max(signal, x * duration / state_size(duration, s.z[i], s.v[i]))
        elif kind[i] == LENGTH_CONSTRAINT:
            distance = max(distance, x)
        elif kind[i] == RELEASED:
            shared = max(shared, x)
        else:
            angle = max(angle, x)
    distance, shared, angle = distance / k, shared / k, angle / k
    f = max(force_size, ANGULAR_SHARE * moment_size / length)
    m = max(moment_size, ANGULAR_SHARE * force_size * length)
    g = max(scalar_size, ANGULAR_SHARE * f) * limits.force
    f, m, hidden = f * limits.force, m * limits.force, ROUNDING * limits.reach * stiffness * length
    force = max(force, stiffness * distance, stiffness / RELEASED_COMPLIANCE * shared) / _allowed(f, limits, hidden)
    moment = max(moment, stiffness * length * length * angle) / _allowed(m, limits, hidden * length)
    scalar /= _allowed(g, limits, hidden)
    constraint = max(distance / length, angle) / _allowed(limits.constraint, limits, ROUNDING * limits.reach)
    return max(force, moment, scalar), constraint, signal / SIGNALS


@kernel
def _allowed(tolerance, limits, rounding):
    """Return the admissible residual: the share of a tolerance, or the rounding error if that is larger."""
    return max(tolerance * limits.share, min(tolerance * limits.most, rounding))


@kernel
def state_size(duration, y, rate):
    """Return the size of a signal with a rate: |y|, or its change at that rate over the ``duration`` [s] of a run."""
    return max(abs(y), duration * abs(rate), SMALL)
