r"""Steady turn: a steady rotation of a vehicle about a vertical axis, in which its wheels roll.

All nodes turn as in steady_rotation.py with the angular velocity w of the axes; wheels also spin at constant rates
along the directions N of free_spins.py. The angular acceleration of a part that spins comes from the turn of its axle,
with :math:`u = R^T w`:

.. math::
   \Omega = u + N \sigma, \qquad \dot\Omega = u \times \Omega, \qquad
   \delta\Omega = u \times \delta\Theta + N\, \delta\sigma, \qquad
   \delta\dot\Omega = (u \times \delta\Theta) \times \Omega + u \times \delta\Omega.

The vehicle finds its distance from the axis, its slip angles and its roll; its speed is |w| times this distance.
"""

from typing import TYPE_CHECKING

import numpy as np

from mecano.maths.vector import skew
from mecano.solve.modal.free_spins import roll, turning, unturned
from mecano.solve.modal.steady_rotation import Rotation
from mecano.solve.modal.straight_running import Straight

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.solve.modal.steady import Steady, Tangent


class Turn(Rotation):
    """The turn of a vehicle with the angular velocity ``w`` (3,) [rad/s], inertial; ``steady`` below: a Steady."""

    relaxes = False  # a relaxed state of another shape is used only if it is nearer than that of Newton's method
    fading = 0.8  # additional factor on the drag in each step of the relaxation: wheels and arms may move far
    name = "steady turn"
    remedy = (
        "initial positions nearer to it; a drive that balances the drag in a turn, which has an integrator as in "
        "docs/tyres.md; a speed at which the tyres hold"
    )

    drift, follow = Straight.drift, Straight.follow
    axles = None  # (n_q, spins) free spins of the last state, which hardly change

    def impose(self, steady: "Steady", s: "State") -> "tuple[State, np.ndarray, Tangent]":
        """Return (state with the velocities that belong to its positions and rolling wheels, N, its Tangent)."""
        s = steady.monitor.settle(s.copy())
        before = s.v.copy()
        self.begin(s)
        carried = s.v[: self.n_q].copy()
        if self.axles is not None:
            s.v[: self.n_q] += _along(self.axles, before[: self.n_q] - carried)
        at = self._tangent(steady, s)
        if not np.all(np.isfinite(at.K)):  # a formula outside its domain: no spins follow, and its merit is not finite
            return s, np.zeros((self.n_q, 0)), at
        N = turning(steady, at, unturned(steady, at)).N
        self.axles = N
        s.v[: self.n_q] = carried + _along(N, before[: self.n_q] - carried)
        at = self._tangent(steady, s)
        if N.shape[1]:
            roll(steady, s, N, at)
            at = self._tangent(steady, s)
        return s, N, at

    def _tangent(self, steady, s):
        """Return the Tangent of the state ``s`` with the angular accelerations of its spins, set in place."""
        for r, d in zip(self.rotations, self.turns, strict=True):
            s.a[d : d + 3] = np.cross(s.R[r].T @ self.w, s.v[d : d + 3])
        return steady.tangent(s)

    def total_derivatives(self, steady: "Steady", s: "State", K: np.ndarray, C: np.ndarray) -> np.ndarray:
        """Return the derivatives K (n, n) by positions, with velocities and accelerations as functions of them."""
        K, (M, _) = super().total_derivatives(steady, s, K, C), steady.matrix(s, 0.0, 0.0, 1.0)
        for r, d in zip(self.rotations, self.turns, strict=True):
            u = np.array(skew(tuple(s.R[r].T @ self.w)))
            spin = np.array(skew(tuple(s.v[d : d + 3])))
            K[:, d : d + 3] += M[:, d : d + 3] @ (u @ u - spin @ u)
        return K

    def derivatives_by_spins(self, steady: "Steady", s: "State", C: np.ndarray) -> np.ndarray:
        """Return the derivatives C (n, n) by velocities, with the angular accelerations that follow from them."""
        C, (M, _) = C.copy(), steady.matrix(s, 0.0, 0.0, 1.0)
        for r, d in zip(self.rotations, self.turns, strict=True):
            C[:, d : d + 3] += M[:, d : d + 3] @ np.array(skew(tuple(s.R[r].T @ self.w)))
        return C


def _along(N, v):
    """Return the projection (n_q,) of velocities on the free spins N."""
    return N @ (np.linalg.pinv(N) @ v)
