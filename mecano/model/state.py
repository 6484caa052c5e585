"""The motion of a model at one instant, as plain arrays.

All unknowns stand in one vector z: first the free degrees of freedom (positions 3 [m], rotation increments of
the step 3 [rad], scalars), then the multipliers k*lambda [N, N m], last the fixed degrees of freedom. ``v`` and
``a`` are numbered likewise: velocities and accelerations inertial for positions, material for rotations.
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class State:
    """Motion, modes and memory at time ``t`` [s]; nothing here is shared with the model."""

    t: float
    z: np.ndarray  # (n_all,) positions, rotation increments of the last step, scalars, multipliers
    v: np.ndarray  # (n_all,)
    a: np.ndarray  # (n_all,)
    R: np.ndarray  # (n_rotations, 3, 3) material to inertial
    phases: np.ndarray  # (n_elements,) int64, batch by batch; replaced, never changed in place
    memory: np.ndarray  # (n_memory,) of all elements, batch by batch; replaced, never changed in place

    def copy(self):
        """A copy whose motion may be changed."""
        return State(self.t, self.z.copy(), self.v.copy(), self.a.copy(), self.R.copy(), self.phases, self.memory)


@dataclass
class History:
    """What generalized-alpha keeps besides the motion."""

    a: np.ndarray  # (n_all,) algorithmic acceleration
    h: float  # size of the steps it is for [s]
    slope: np.ndarray  # (n,) last change of accelerations and multipliers over a step: their backward difference
    bend: np.ndarray  # (n,) second backward difference
    known: int  # how many of the two differences are known: 0 at a start
    v_shift: np.ndarray  # (n_all,) to be added to the velocities at a start or a change of step
    k: float  # mean stiffness of the effective tangent for steps of this size [N/m]
    tangent: object = None  # State whose tangent the next step may use, or None when it must evaluate a new one
    age: int = 0  # accepted steps since that state
    drift: float = 0.0  # share of the residual that an iteration with an old tangent leaves, per step of its age
