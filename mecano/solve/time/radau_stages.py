"""The stages of a step of Radau IIA: increments, states, residuals, and their prediction."""

import numpy as np

from mecano.jit.entry import Indices, Matrices, Matrix, Vector, entry
from mecano.jit.kernel import kernel
from mecano.maths.so3 import exp, tangent, tangent_inverse
from mecano.maths.vector import mat, put, vec
from mecano.model import assembly_driver, loops
from mecano.model.assembly_driver import Batches, System
from mecano.model.numbering import ROTATION
from mecano.solve.diagnostics.scales import SMALL
from mecano.solve.events.compliance import soften
from mecano.solve.time.increments import put_matrix
from mecano.solve.time.radau_tableau import NODES, REAL, TO_CUBIC, TO_PARABOLA, A, D

PREDICTIONS = 2  # iterations on the rates of the increments
SECOND = 2  # column of the second rates of the constraints


@entry
def predict(
    A: Matrix, kind: Indices, rotation_dof: Indices, n_q: int, h: float, v: Matrix,
    rate_out: Matrix, theta_out: Matrix,
):  # fmt: skip
    """Compute increments (3, n_q) that have the velocities ``v`` (3, n_q) at the stages, and their rates."""
    for i in range(3):
        for d in range(n_q):
            rate_out[i, d] = v[i, d]
    for iteration in range(PREDICTIONS + 1):
        for i in range(3):
            for d in range(n_q):
                theta_out[i, d] = h * (A[i, 0] * rate_out[0, d] + A[i, 1] * rate_out[1, d] + A[i, 2] * rate_out[2, d])
        if iteration < PREDICTIONS:
            for i in range(3):
                untangle(rotation_dof, n_q, theta_out[i], v[i], rate_out[i])


@kernel
def untangle(rotation_dof, n_q, theta, v, rate_out):
    """Compute T(theta)^-1 v of all free rotations."""
    for r in range(rotation_dof.shape[0]):
        d = rotation_dof[r]
        if d < n_q:
            put(rate_out, d, tangent_inverse(vec(theta, d)) @ vec(v, d))


@entry
def correct(
    rotation_dof: Indices, n_q: int, size: Vector, turn: Vector, correction: Matrix,
    scratch: Vector, theta_out: Matrix, reactions_out: Matrix,
) -> float:  # fmt: skip
    """Subtract a correction (3, n) of material variations at ``turn`` and of reactions.

    Return its largest component over the ``size`` (n_q,) of the unknown; inf if not finite.
    """
    worst = 0.0
    for i in range(3):
        for d in range(n_q):
            scratch[d] = correction[i, d]
        untangle(rotation_dof, n_q, turn, correction[i], scratch)
        for d in range(n_q):
            theta_out[i, d] -= scratch[d]
            x = abs(scratch[d]) / size[d]
            if not x <= 1e300:
                return np.inf
            worst = max(worst, x)
        for j in range(reactions_out.shape[1]):
            reactions_out[i, j] -= correction[i, n_q + j]
    return worst


@entry
def place(
    D: Matrix, kind: Indices, rotation_dof: Indices, n_q: int, n: int, h: float,
    theta: Matrix, reactions: Matrix, z0: Vector, v0: Vector, R0: Matrices,
    z_out: Matrix, v_out: Matrix, a_out: Matrix, R_out: Matrices,
):  # fmt: skip
    """Compute the states of the stages: rows of z, v, a (3, n_all), and R (3 n_rotations, 3, 3) one after the other."""
    n_rotations = rotation_dof.shape[0]
    for i in range(3):
        for d in range(n_q):
            z_out[i, d] = theta[i, d] if kind[d] == ROTATION else z0[d] + theta[i, d]
            v_out[i, d] = (D[i, 0] * theta[0, d] + D[i, 1] * theta[1, d] + D[i, 2] * theta[2, d]) / h
        for j in range(n - n_q):
            z_out[i, n_q + j] = reactions[i, j]
        for r in range(n_rotations):
            d = rotation_dof[r]
            if d < n_q:
                psi = vec(theta[i], d)
                put_matrix(mat(R0[r]) @ exp(psi), R_out[i * n_rotations + r])
                put(v_out[i], d, tangent(psi) @ vec(v_out[i], d))
    for i in range(3):
        for d in range(n_q):
            x0, x1, x2 = v_out[0, d] - v0[d], v_out[1, d] - v0[d], v_out[2, d] - v0[d]
            a_out[i, d] = (D[i, 0] * x0 + D[i, 1] * x1 + D[i, 2] * x2) / h


@entry
def residual(
    residuals: Indices, residual_batches: Batches, constraints: Indices, constraint_batches: Batches, system: System,
    phases: Indices, memory: Vector, n_q: int, n: int, n_rotations: int, k: float,
    times: Vector, z: Matrix, v: Matrix, a: Matrix, R: Matrices, equations: Vector, g: Matrix, F_out: Matrix,
):  # fmt: skip
    """Compute the residuals (m, n) of m states: equations of motion, and second rates of the constraints times -k.

    ``equations`` (n_all,) are those of ``system``, g (n_l, 3) is scratch.
    """
    for i in range(z.shape[0]):
        own = R[i * n_rotations : (i + 1) * n_rotations]
        assembly_driver.assemble_residual(
            residuals, residual_batches, system, times[i], z[i], v[i], a[i], own, phases, memory, k, 0.0
        )
        for d in range(n_q):
            F_out[i, d] = equations[d]
        if n > n_q:
            g[:, :] = 0.0
            assembly_driver.constraint_derivatives(
                constraints, constraint_batches, system, times[i], z[i], v[i], a[i], own, phases, memory, g
            )
            for j in range(n - n_q):
                F_out[i, n_q + j] = -k * g[j, SECOND]


class Stages:
    """Increments (3, n_q) and reactions (3, n_l) of the stages of one step, and what follows from them."""

    def __init__(self, system, assembly, compliance, length):
        of, n_q = system.numbering, system.n_q
        self.system, self.assembly, self.compliance = system, assembly, compliance
        n_rotations, n_all = len(of.rotation_dof), of.n_all
        self.increments, self.reactions = np.zeros((3, n_q)), np.zeros((3, system.n_l))
        self.velocities = np.zeros((4, n_q))  # at the beginning and at the stages
        self._times, self._F = np.zeros(3), np.zeros((3, system.n))
        self._z, self._v, self._a = np.zeros((3, 3, n_all))
        self._R = np.zeros((3 * n_rotations, 3, 3))
        self._is_rotation = of.kind[:n_q] == ROTATION
        self.sizes = np.where(self._is_rotation, 1.0, float(length))
        about = of.kind, of.rotation_dof, n_q
        self._predict = predict.bind(A, *about)
        self._correct = correct.bind(of.rotation_dof, n_q, self.sizes)
        self._place = place.bind(D, *about, system.n)
        self._residual = residual.bind(
            *system.loops(loops.residual), *system.loops(loops.constraint_derivatives), assembly.record
        )
        self._ratio = None
        self._scratch, self._rate, self._g = np.zeros(n_q), np.zeros((3, n_q)), np.zeros((system.n_l, 3))

    def begin(self, s0, h, history, duration, share):
        """Begin a step of size h from ``s0``: extrapolate velocities and reactions of the last one.

        ``duration`` [s] of the run; ``share`` of the accuracy of the motion that suffices for signals without a rate.
        """
        if self.system.signals.any():
            self._measure_signals(s0, h, duration, share)
        n_q, n, n_rotations = self.system.n_q, self.system.n, len(self.system.numbering.rotation_dof)
        self.s0, self.h = s0, h
        self._times[:] = s0.t + NODES * h
        self._z[:], self._v[:], self._a[:] = s0.z, s0.v, s0.a
        self._R.reshape(3, n_rotations, 3, 3)[:] = s0.R
        if history.known:
            cubic, parabola = self._extrapolation(h / history.h)
            v = cubic @ history.v
            self.reactions[:] = parabola @ history.reactions
        else:
            v = s0.v[:n_q] + (NODES * h)[:, None] * s0.a[:n_q]
            self.reactions[:] = s0.z[n_q:n]
        self._predict(h, v, self._rate, self.increments)

    def _measure_signals(self, s0, h, duration, share):
        """Set the sizes of signals."""
        at_once, states = self.system.signals & ~self.system.states, self.system.states
        y, rate = np.abs(s0.z[: self.system.n_q]), np.abs(s0.v[: self.system.n_q])
        self.sizes[at_once] = np.maximum(y + h * rate, SMALL)[at_once] / share
        largest = np.maximum(y, duration * rate)[states]
        self.sizes[states] = np.maximum(np.maximum(largest, s0.memory[len(s0.memory) - len(largest) :]), SMALL)

    def _extrapolation(self, ratio):
        """Return the matrices (3, 4), (3, 3) from a step to the stages of the next, longer by ``ratio``."""
        if ratio != self._ratio:
            self._ratio, later = ratio, 1.0 + NODES * ratio
            self._matrices = tuple(
                np.vander(later, len(back), increasing=True) @ back for back in (TO_CUBIC, TO_PARABOLA)
            )
        return self._matrices

    def correct(self, correction, turn):
        """Subtract a correction (3, n): material variations at ``turn`` (n_all,), and reactions. Return its size."""
        return self._correct(turn, correction, self._scratch, self.increments, self.reactions)

    def residuals(self, k):
        """Return the residuals (3, n) of the stages: equations of motion, and second rates of constraints times -k."""
        s0, at = self.s0, (self._z, self._v, self._a, self._R)
        self._place(self.h, self.increments, self.reactions, s0.z, s0.v, s0.R, *at)
        return self._residuals(self._times, *at, k, self._F)

    def _residuals(self, times, z, v, a, R, k, F):
        system, s0, n_q = self.system, self.s0, self.system.n_q
        n_rotations = len(system.numbering.rotation_dof)
        self._residual(
            s0.phases, s0.memory, n_q, system.n, n_rotations, k, times, z, v, a, R, self.assembly.residual, self._g, F
        )
        if self.compliance is not None:
            starts, columns, values = self.compliance.rows
            for own, rows in zip(z, F, strict=True):
                soften(k * (REAL / self.h) ** 2, starts, columns, values, own[n_q : system.n], rows[n_q:])
        return F

    def states(self):
        """Return the states at the stages, whose velocities are kept in ``velocities``."""
        s0, n_q = self.s0, self.system.n_q
        self._place(self.h, self.increments, self.reactions, s0.z, s0.v, s0.R, self._z, self._v, self._a, self._R)
        self.velocities[0], self.velocities[1:] = s0.v[:n_q], self._v[:, :n_q]
        R, found = self._R.reshape(3, -1, 3, 3), []
        for i in range(3):
            s = s0.copy()
            s.t = float(self._times[i])
            s.z[:], s.v[:], s.a[:], s.R[:] = self._z[i], self._v[i], self._a[i], R[i]
            found.append(s)
        return found

    def residual_at(self, s0, back, a, k):
        """Return the residual (n,) at ``s0`` with velocities less by ``back`` (n_q,) and the accelerations ``a``."""
        n_q, s = self.system.n_q, s0.copy()
        s.z[:n_q][self._is_rotation] = 0.0
        s.v[:n_q] -= back
        s.a[:n_q] = a
        rows = (part[None] for part in (s.z, s.v, s.a))
        return self._residuals(np.array([s.t]), *rows, s.R, k, np.zeros((1, self.system.n)))[0]

    def gap(self, s):
        """Return the violation (n_l,) of the constraints on positions."""
        g = self.system.constraint_derivatives(s)[:, 0]
        g[self.system.numbering.of_rates] = 0.0
        return g
