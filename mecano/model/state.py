"""The motion of a model at one instant, as plain arrays.

All unknowns are in one vector z: first the free degrees of freedom (positions 3 [m], rotation increments of the step
3 [rad], scalars), then the multipliers k*lambda [N, N m], last the fixed degrees of freedom. ``v`` and ``a`` have the
same numbering: velocities and accelerations are inertial for positions, material for rotations.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mecano.immutable import mutable
from mecano.jit.entry import Indices, Matrices, Vector


@dataclass(eq=False, repr=False)
class State:
    """Motion, phases and memory at time ``t`` [s]; shares no arrays with the model."""

    t: float
    z: np.ndarray  # (n_all,) positions, rotation increments of the last step, scalars, multipliers
    v: np.ndarray  # (n_all,)
    a: np.ndarray  # (n_all,)
    R: np.ndarray  # (n_rotations, 3, 3) material to inertial
    phases: np.ndarray  # (n_elements,) int64, batch by batch; replaced, never changed in place
    memory: np.ndarray  # (n_memory,) of all elements, batch by batch, then the largest |z| so far of each signal with a
    # rate; replaced, never changed in place
    start_spins: np.ndarray | None = None  # (n_rotations, 3) at the beginning of the step, if within one

    def copy(self) -> "State":
        """Return a copy whose motion may be changed."""
        z, v, a, R = self.z.copy(), self.v.copy(), self.a.copy(), self.R.copy()
        return State(self.t, z, v, a, R, self.phases, self.memory, self.start_spins)

    def unaccelerated(self) -> "State":
        """Return a copy without accelerations."""
        out = self.copy()
        out.a[:] = 0.0
        return out


class Motion(NamedTuple):
    """The motion in a State, as entries read and write it; compiled code may pass an Instant."""

    z: Vector
    v: Vector
    a: Vector
    R: Matrices


class Instant(NamedTuple):
    """A whole State as an argument of compiled code."""

    t: float
    z: Vector
    v: Vector
    a: Vector
    R: Matrices
    phases: Indices
    memory: Vector


@dataclass(eq=False, repr=False)
class History:
    """Variables of generalized-alpha besides the motion."""

    a: np.ndarray  # (n_all,) algorithmic acceleration
    h: float  # step size to which the history belongs [s]
    slope: np.ndarray  # (n,) backward difference of accelerations, multipliers and signals at once over the last step
    bend: np.ndarray  # (n,) second backward difference
    known: int  # number of differences that are known: 0 at a start
    v_shift: np.ndarray  # (n_all,) correction of the velocities after a start or a change of step size
    k: float  # mean stiffness of the effective tangent for this step size [N/m]
    tangent: State | None = None  # where the tangent was evaluated that the next step may reuse, or None
    age: int = 0  # accepted steps since that state
    drift: float = 0.0  # fraction of the residual that an iteration with an old tangent leaves, per step of its age
    taken: float = 0.0  # size of the last step [s]; 0 at a start
    spent: float = 0.0  # iterations since the tangent was factored, with those that its factorization is worth


@mutable
class RadauHistory:
    """Variables of Radau IIA besides the motion."""

    a: np.ndarray  # (n_all,) accelerations at the end of the last step
    h: float  # size of the last step, or of the next one at a start [s]
    v: np.ndarray  # (4, n_q) velocities at the beginning and at the stages of the last step
    reactions: np.ndarray  # (3, n_l) at the stages
    known: int  # 0 at a start
    k: float  # mean stiffness of the tangent of a step [N/m]
    amplified: float = 1.0  # amplification of violated constraints at the end of the last step (singular_position.py)
    least_amplified: float = 1.0  # its least value since the start
