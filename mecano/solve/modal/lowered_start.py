r"""Level a vehicle and lower it onto its wheels: a start from which Newton's method finds steady running.

A wheel in the air, or one that just touches its ground, has no stiffness, so that the tangent does not show what will
carry the vehicle; Newton's method may lift it off one of its wheels instead. The vehicle is therefore displaced along
the direction :math:`\hat g` of gravity, without a change of shape, until its forces, with f of steady.py, balance along
this direction,

.. math::
   \hat g \cdot \sum_i f_i(q + d\, \hat g) = 0 .

It is first turned about horizontal axes, as far as its joints with the ground let it, so that all treads are at the
same depth, in the sense of least squares. This leaves the lean of a motorcycle, in which its weight is balanced.
"""

from typing import TYPE_CHECKING

import numpy as np

from mecano.maths.root import root
from mecano.maths.so3 import exp
from mecano.maths.vector import Vec3

if TYPE_CHECKING:
    from mecano.model.state import State
    from mecano.solve.modal.steady import Steady

STRIDE, FARTHEST = 0.01, 1.0  # of the length scale: interval of the search for the balance, largest displacement
HELD = 1e-6  # of the displacement: a larger change of a constraint holds the vehicle at its height
TOUCH_DOWN, AIR = "touch_down", "air"  # event and phase of a wheel
TILT = 1e-4  # [rad] for differences
MOST_TILT, TILTED = 0.5, 1e-6  # [rad] largest step of a turn onto the wheels, and smallest one that matters
LEVELLINGS = 10  # iterations
ALIKE = 0.03  # of the length scale per rad: turns that change the depths less, such as a lean, do not level


def lowered_starts(steady: "Steady", start: "State") -> "list[State]":
    """Return ``start`` levelled and lowered onto its wheels, and only lowered, with velocities of steady motion.

    The first is left out if it is level. Empty without gravity, if constraints hold the vehicle at its height, or if
    nothing carries it.
    """
    if not steady.system.context.gravity.any():
        return []
    vehicle = _Vehicle(steady, start)
    turns = vehicle.turn_onto_wheels(), np.eye(3)
    found = (vehicle.lowered(Q) for Q in turns if Q is not None)
    return [s for s in found if s is not None]


def rotation(vector: np.ndarray) -> np.ndarray:
    """Return the rotation (3, 3) of a rotation vector (3,) [rad]."""
    return np.array(exp(Vec3(*map(float, vector))))


class _Vehicle:
    """A mechanism in steady motion that is moved without a change of shape."""

    def __init__(self, steady, start):
        system, of = steady.system, steady.system.numbering
        self.steady, self.start, self.system = steady, start, system
        self.free = np.unique(of.x[of.x < steady.n_q])[:, None] + np.arange(3)
        self.rotations = [r for r, d in enumerate(of.rotation_dof) if d < steady.n_q]
        self.centre = start.z[self.free].mean(axis=0) if self.free.size else np.zeros(3)
        self.down = system.context.gravity / np.linalg.norm(system.context.gravity)
        across = np.eye(3)[np.argmin(np.abs(self.down))]
        self.axes = np.linalg.qr(np.column_stack([self.down, across, np.cross(self.down, across)]))[0][:, 1:].T
        self.wheels = [b for b in system.batches if any(event.name == TOUCH_DOWN for event in b.kind.events)]
        self.at_start = self.gaps(0.0, np.eye(3))

    def moved(self, d, Q):
        """Return the State displaced by ``d`` [m] along gravity and turned by the rotation ``Q`` (3, 3)."""
        s = self.start.copy()
        s.z[self.free] = self.centre + (s.z[self.free] - self.centre) @ Q.T + d * self.down
        for r in self.rotations:
            s.R[r] = Q @ s.R[r]
        return self.steady.monitor.settle(self.steady.in_motion(s))

    def gaps(self, d, Q):
        """Return the values of the constraints on positions [m]."""
        return self.system.constraint_derivatives(self.moved(d, Q))[~self.steady.of_rates, 0]

    def is_free(self, d, Q, size):
        """Return True if no constraint holds the vehicle against ``d`` and ``Q``, which move it by ``size`` [m]."""
        return np.abs(self.gaps(d, Q) - self.at_start).max(initial=0.0) <= HELD * size

    def lowered(self, Q):
        """Return the State turned by ``Q`` and displaced along gravity until the forces balance, or None."""
        stride = STRIDE * self.steady.length
        if not self.is_free(stride, np.eye(3), stride):
            return None

        def weight(d):
            return float(self.system.assemble(self.moved(d, Q)).residual[self.free].sum(axis=0) @ self.down)

        sign = np.sign(weight(0.0))
        way = stride if sign == np.sign(weight(-FARTHEST * self.steady.length)) else -stride
        for i in range(round(FARTHEST / STRIDE)):
            near, far = i * way, (i + 1) * way
            if np.sign(weight(far)) != sign:
                return self.moved(root(weight, min(near, far), max(near, far)), Q)
        return None

    def depths(self, Q):
        """Return the depths of the treads of all wheels below the ground [m]."""
        s, found = self.moved(0.0, Q), []
        for batch in self.wheels:
            s.phases[batch.phases] = batch.kind.phases.index(AIR)  # in which the depth is monitored
        values = self.system.event_values(s)
        for batch in self.wheels:
            number = [event.name for event in batch.kind.events].index(TOUCH_DOWN)
            found += list(batch.events(values)[:, number])
        return np.array(found)

    def turn_onto_wheels(self):
        """Return the rotation (3, 3) that brings all treads to the same depth, or None if none is needed or found.

        If this leaves one direction, as the lean of a motorcycle, the weight balances in it.
        """
        Q, size = np.eye(3), TILT * self.steady.length
        axes = np.array([axis for axis in self.axes if self.is_free(0.0, rotation(TILT * axis), size)])
        if not (len(axes) and self.wheels):
            return None
        for _ in range(LEVELLINGS):
            step = self._levelling(Q, axes)
            if not np.linalg.norm(step) <= MOST_TILT:
                return None
            Q = rotation(step) @ Q
            if np.abs(step).max() < TILTED:
                return Q if np.linalg.norm(Q - np.eye(3)) > TILTED else None
        return None

    def _levelling(self, Q, axes):
        """Return the rotation vector (3,) of a step of Newton's method for ``turn_onto_wheels``, or nan."""
        here = self.depths(Q)
        J = np.column_stack([(self.depths(rotation(TILT * axis) @ Q) - here) / TILT for axis in axes])
        U, sigma, Vt = np.linalg.svd(J - J.mean(axis=0))
        rank = int(np.sum(sigma > ALIKE * self.steady.length))
        step = -Vt[:rank].T @ ((U[:, :rank].T @ (here - here.mean())) / sigma[:rank]) @ axes
        if len(here) > 1 and len(axes) == rank + 1:
            step = step + self._balancing(Q, Vt[rank] @ axes)
        return step

    def _balancing(self, Q, axis):
        """Return the step of Newton's method about ``axis`` (3,) for the moment of a vehicle that its wheels carry."""
        moments = []
        for turn in (Q, rotation(TILT * axis) @ Q):
            s = self.lowered(turn)
            moments.append(np.nan if s is None else axis @ self.moment(s))
        return -moments[0] * TILT / (moments[1] - moments[0]) * axis

    def moment(self, s):
        """Return the moment (3,) of all forces about the centre at the start [N m]."""
        f, of = self.system.assemble(s).residual, self.system.numbering
        found = np.cross(s.z[self.free] - self.centre, f[self.free]).sum(axis=0)
        return found + sum(s.R[r] @ f[of.rotation_dof[r] + np.arange(3)] for r in self.rotations)
