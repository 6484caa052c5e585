r"""Steady rotation: a motion that is constant in axes that turn with a constant angular velocity about a fixed axis.

Each node that turns, at x with the rotation R, has with the angular velocity w of the axes and a point c of the axis

.. math::
   v = w \times (x - c), \quad a = w \times v, \quad \Omega = R^T w, \quad \dot\Omega = 0,

the other nodes are at rest. The elements then give centrifugal and gyroscopic forces, so the deformation is that of the
turning blade or shaft. With the displacements :math:`\delta x` and material rotations :math:`\delta\Theta` of a step of
Newton's method (steady.py)

.. math::
   \delta v = w \times \delta x, \quad \delta a = w \times (w \times \delta x), \quad
   \delta\Omega = R^T (w \times R\, \delta\Theta), \quad \delta\dot\Omega = 0.

The motion is steady if the forces are in balance, with other reactions, after the nodes have turned on by one radian,
at the same time or after the time that this takes, in which the radial direction of an orbit turns, too.
"""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mecano.maths.so3 import exp
from mecano.maths.vector import Vec3, skew
from mecano.solve.modal.spin_up import spin_up

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.modal.steady import Steady, Tangent

STEADY = 1e-6  # largest change of forces in a turn of one radian, relative
RANK = 1e-12  # of the largest singular value of the columns of reactions


class Rotation:
    """The rotation of a system with the angular velocity ``w`` (3,) [rad/s], inertial; ``steady`` below: a Steady.

    ``about`` (3,) [m]: a point of the axis; ``at_rest``: names of the nodes that do not turn.
    """

    relaxes = True  # a relaxed state is preferred to one of another shape, which may be unstable
    fading = 0.8  # additional factor on the drag in each step of the relaxation: arms may swing far
    name = "steady rotation"
    remedy = (
        "initial positions nearer to it; a drive that balances the moment of loads about the axis (prescribed_angle)"
    )

    remedy_for_constraints = "the same speed in prescribed motions; 'at_rest' with the nodes that do not turn"
    remedy_for_forces = (
        "gravity and other loads along the axis of rotation, or none; supports that are alike in all directions across "
        "it, or, for critical speeds, a rotor without unbalance"
    )

    def __init__(self, system: "System", w: Sequence[float], about: Sequence[float], at_rest: Collection[str] = ()):
        of, self.n_q = system.numbering, system.n_q
        self.about = np.asarray(about, float)
        self.turn(np.asarray(w, float))
        chosen = np.array([node.name not in at_rest for node in system.nodes])
        x = np.unique(of.x[chosen & (of.x < self.n_q)])
        self.rotations = [r for r in np.unique(of.rotation[chosen]) if of.rotation_dof[r] < self.n_q]
        self.at = x[:, None] + np.arange(3)  # positions of the nodes that turn
        self.turns = of.rotation_dof[self.rotations]

    def turn(self, w: np.ndarray) -> None:
        """Set the angular velocity (3,) [rad/s], inertial."""
        self.w, self.hat = w, np.array(skew(tuple(w)))

    def speed(self, length: float) -> float:
        """Return the speed [m/s] at a distance ``length`` from the axis; at rest, one length scale per second."""
        return float(np.linalg.norm(self.w)) * length or length

    def begin(self, s: "State") -> None:
        """Set velocities and accelerations of the state ``s`` in place."""
        s.v[:] = s.a[:] = 0.0
        s.v[self.at] = (s.z[self.at] - self.about) @ self.hat.T
        s.a[self.at] = s.v[self.at] @ self.hat.T
        for r, d in zip(self.rotations, self.turns, strict=True):
            s.v[d : d + 3] = s.R[r].T @ self.w

    def without_drift(self, start: "State", s: "State") -> "State":
        """Return the state unchanged: relaxation does not turn it about the axis."""
        return s

    def drift(self, shift: np.ndarray) -> np.ndarray:
        """Return the translation (3,) [m] that is no change of shape: none, as the axis stays where it is."""
        return np.zeros(3)

    def follow(self, steady: "Steady", start: "State", s: "State") -> "tuple[State, bool]":
        """Return (state, whether it is steady) by continuation from ``start``, where Newton's method ended at ``s``."""
        found, arrived = spin_up(steady, self, start)
        return (found, True) if arrived else (s, False)

    def impose(self, steady: "Steady", s: "State") -> "tuple[State, np.ndarray, Tangent]":
        """Return (state with the velocities that belong to its positions, no free spins (n_q, 0), its Tangent)."""
        s = steady.monitor.settle(s.copy())
        self.begin(s)
        return s, np.zeros((self.n_q, 0)), steady.tangent(s)

    def total_derivatives(self, steady: "Steady", s: "State", K: np.ndarray, C: np.ndarray) -> np.ndarray:
        """Return the derivatives K (n, n) by positions, with velocities and accelerations as functions of them."""
        K, (M, _) = K.copy(), steady.matrix(s, 0.0, 0.0, 1.0)
        for d in self.at[:, 0]:
            K[:, d : d + 3] += (C[:, d : d + 3] + M[:, d : d + 3] @ self.hat) @ self.hat
        for r, d in zip(self.rotations, self.turns, strict=True):
            K[:, d : d + 3] += C[:, d : d + 3] @ (s.R[r].T @ self.hat @ s.R[r])
        return K

    def derivatives_by_spins(self, steady: "Steady", s: "State", C: np.ndarray) -> np.ndarray:
        """Return the derivatives C (n, n) by velocities, unchanged: no part spins in the axes."""
        return C

    @property
    def title(self) -> str:
        """The motion in the words of an error."""
        return f"{self.name} with the angular velocity {np.round(self.w, 9).tolist()} rad/s"

    def cause_of_imbalance(self, steady: "Steady", s: "State", at: "Tangent") -> str:
        """Return an empty text: no cause is known."""
        return ""

    def change_of_forces(self, steady: "Steady", s: "State", at: "Tangent") -> tuple[np.ndarray, np.ndarray]:
        """Return the out-of-balance forces (n_q,) after a turn by 1 rad, moments over the length scale; the largest."""
        speed = float(np.linalg.norm(self.w)) or 1.0
        changes = [self._change(steady, s, s.t + duration, speed) for duration in (0.0, 1.0 / speed)]
        return min(changes, key=np.max) / steady.root, steady.allowed(at.size, at.rounding, STEADY)

    def _change(self, steady, s, t, speed):
        """Return the out-of-balance forces (n_q,) at the time ``t`` [s] after the nodes have turned by one radian.

        Reactions balance theirs; signals may vary and are zero. ``speed`` [rad/s]: that of the rotation.
        """
        later, n, n_q = s.copy(), steady.system.n, self.n_q
        later.t = t
        Q = np.array(exp(Vec3(*(self.w / speed))))
        later.z[self.at] = self.about + (s.z[self.at] - self.about) @ Q.T
        later.v[self.at], later.a[self.at] = s.v[self.at] @ Q.T, s.a[self.at] @ Q.T
        for r in self.rotations:
            later.R[r] = Q @ s.R[r]
        K, assembly = steady.matrix(later, 1.0, 0.0, 0.0)
        f, D = assembly.residual[:n_q].copy(), K[:n_q, n_q:n]
        own = steady.moving
        f[own] -= D[own] @ np.linalg.lstsq(D[own], f[own], rcond=RANK)[0] if D.shape[1] else 0.0
        f[steady.signals] = 0.0
        return np.abs(f)
