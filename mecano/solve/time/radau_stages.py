"""The stages of a step of Radau IIA: increments, states, residuals, and their prediction."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mecano.jit.entry import Indices, Matrices, Matrix, Vector, entry
from mecano.jit.kernel import kernel
from mecano.jit.memory import floats
from mecano.maths.so3 import exp, tangent, tangent_inverse
from mecano.maths.vector import mat, put, put_matrix, vec
from mecano.model import loops
from mecano.model.assembly_driver import Loops, System, assemble_residual, constraint_derivatives
from mecano.model.numbering import ROTATION, Unknowns
from mecano.model.state import Instant, Motion, RadauHistory, State
from mecano.solve.diagnostics.scales import SMALL
from mecano.solve.events.compliance import Compliance, soften
from mecano.solve.time.radau_tableau import NODES, REAL, TO_CUBIC, TO_PARABOLA, A, D

if TYPE_CHECKING:
    from mecano.model.assembly import Assembly

PREDICTIONS = 2  # iterations on the rates of the increments
SECOND = 2  # column of the second rates of the constraints


class Motions(NamedTuple):
    """Motions of several states, such as the stages: those of a State, one after the other."""

    t: Vector  # (m,)
    z: Matrix  # (m, n_all)
    v: Matrix
    a: Matrix
    R: Matrices  # (m n_rotations, 3, 3)


@entry
def predict(A: Matrix, of: Unknowns, h: float, v: Matrix, rate_out: Matrix, theta_out: Matrix):
    """Compute increments (3, n_q) that have the velocities ``v`` (3, n_q) at the stages, and their rates."""
    n_q = of.n_q
    for i in range(3):
        for d in range(n_q):
            rate_out[i, d] = v[i, d]
    for iteration in range(PREDICTIONS + 1):
        for i in range(3):
            for d in range(n_q):
                theta_out[i, d] = h * (A[i, 0] * rate_out[0, d] + A[i, 1] * rate_out[1, d] + A[i, 2] * rate_out[2, d])
        if iteration < PREDICTIONS:
            for i in range(3):
                untangle(of.rotation_dof, n_q, theta_out[i], v[i], rate_out[i])


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
def place(D: Matrix, of: Unknowns, h: float, theta: Matrix, reactions: Matrix, s0: Motion, stages_out: Motions):
    """Compute the motions of the stages."""
    z, v, n_q, n_rotations = stages_out.z, stages_out.v, of.n_q, of.rotation_dof.shape[0]
    for i in range(3):
        for d in range(n_q):
            z[i, d] = theta[i, d] if of.kind[d] == ROTATION else s0.z[d] + theta[i, d]
            v[i, d] = (D[i, 0] * theta[0, d] + D[i, 1] * theta[1, d] + D[i, 2] * theta[2, d]) / h
        for j in range(of.n - n_q):
            z[i, n_q + j] = reactions[i, j]
        for r in range(n_rotations):
            d = of.rotation_dof[r]
            if d < n_q:
                psi = vec(theta[i], d)
                put_matrix(stages_out.R[i * n_rotations + r], mat(s0.R[r]) @ exp(psi))
                put(v[i], d, tangent(psi) @ vec(v[i], d))
    for i in range(3):
        for d in range(n_q):
            x0, x1, x2 = v[0, d] - s0.v[d], v[1, d] - s0.v[d], v[2, d] - s0.v[d]
            stages_out.a[i, d] = (D[i, 0] * x0 + D[i, 1] * x1 + D[i, 2] * x2) / h


@entry
def residual(
    residuals: Loops, constraints: Loops, system: System, s0: Instant, k: float, at: Motions, g: Matrix, F_out: Matrix
):  # fmt: skip
    """Compute the residuals (m, n) of m states: equations of motion, and second rates of the constraints times -k.

    Phases and memory are those of ``s0``; g (n_l, 3) is scratch.
    """
    m, n, equations = at.z.shape[0], F_out.shape[1], floats(system[0].residual, system[0].n_all)
    n_l, n_rotations = g.shape[0], at.R.shape[0] // m
    for i in range(m):
        R = at.R[i * n_rotations : (i + 1) * n_rotations]
        s = Instant(at.t[i], at.z[i], at.v[i], at.a[i], R, s0.phases, s0.memory)
        assemble_residual(residuals, system, s, k, 0.0)
        for d in range(n - n_l):
            F_out[i, d] = equations[d]
        if n_l:
            g[:, :] = 0.0
            constraint_derivatives(constraints, system, s, g)
            for j in range(n_l):
                F_out[i, n - n_l + j] = -k * g[j, SECOND]


class Stages:
    """Increments (3, n_q) and reactions (3, n_l) of the stages of one step, and what follows from them."""

    def __init__(self, system: System, assembly: "Assembly", compliance: Compliance | None, length: float):
        of, n_q = system.numbering, system.n_q
        self.system, self.assembly, self.compliance = system, assembly, compliance
        n_rotations, n_all = len(of.rotation_dof), of.n_all
        self.increments, self.reactions = np.zeros((3, n_q)), np.zeros((3, system.n_l))
        self.velocities = np.zeros((4, n_q))  # at the beginning and at the stages
        self._F = np.zeros((3, system.n))
        self._at = Motions(np.zeros(3), *np.zeros((3, 3, n_all)), np.zeros((3 * n_rotations, 3, 3)))
        self._is_rotation = of.kind[:n_q] == ROTATION
        self.sizes = np.where(self._is_rotation, 1.0, float(length))
        self._predict = predict.bind(A, of)
        self._correct = correct.bind(of.rotation_dof, n_q, self.sizes)
        self._place = place.bind(D, of)
        self._residual = residual.bind(
            system.loops(loops.residual), system.loops(loops.constraint_derivatives), assembly.record
        )
        self._ratio = None
        self._scratch, self._rate, self._g = np.zeros(n_q), np.zeros((3, n_q)), np.zeros((system.n_l, 3))

    def begin(self, s0: State, h: float, history: RadauHistory, duration: float, share: float) -> None:
        """Begin a step of size h from ``s0``: extrapolate velocities and reactions of the last one.

        ``duration`` [s] of the run; ``share`` of the accuracy of the motion that suffices for signals without a rate.
        """
        if self.system.signals.any():
            self._measure_signals(s0, h, duration, share)
        n_q, n, n_rotations = self.system.n_q, self.system.n, len(self.system.numbering.rotation_dof)
        self.s0, self.h = s0, h
        at = self._at
        at.t[:] = s0.t + NODES * h
        at.z[:], at.v[:], at.a[:] = s0.z, s0.v, s0.a
        at.R.reshape(3, n_rotations, 3, 3)[:] = s0.R
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

    def correct(self, correction: np.ndarray, turn: np.ndarray) -> float:
        """Subtract a correction (3, n): material variations at ``turn`` (n_all,), and reactions. Return its size."""
        return self._correct(turn, correction, self._scratch, self.increments, self.reactions)

    def residuals(self, k: float) -> np.ndarray:
        """Return the residuals (3, n) of the stages: equations of motion, and second rates of constraints times -k."""
        self._place(self.h, self.increments, self.reactions, self.s0, self._at)
        return self._residuals(self._at, k, self._F)

    def _residuals(self, at, k, F):
        system, n_q = self.system, self.system.n_q
        self._residual(self.s0, k, at, self._g, F)
        if self.compliance is not None:
            starts, columns, values = self.compliance.rows
            for own, rows in zip(at.z, F, strict=True):
                soften(k * (REAL / self.h) ** 2, starts, columns, values, own[n_q : system.n], rows[n_q:])
        return F

    def states(self) -> list[State]:
        """Return the states at the stages, whose velocities are kept in ``velocities``."""
        s0, n_q, at = self.s0, self.system.n_q, self._at
        self._place(self.h, self.increments, self.reactions, s0, at)
        self.velocities[0], self.velocities[1:] = s0.v[:n_q], at.v[:, :n_q]
        R, found = at.R.reshape(3, -1, 3, 3), []
        for i in range(3):
            s = s0.copy()
            s.t = float(at.t[i])
            s.z[:], s.v[:], s.a[:], s.R[:] = at.z[i], at.v[i], at.a[i], R[i]
            found.append(s)
        return found

    def residual_at(self, s0: State, back: float, a: np.ndarray, k: float) -> np.ndarray:
        """Return the residual (n,) at ``s0`` with velocities less by ``back`` (n_q,) and the accelerations ``a``."""
        n_q, s = self.system.n_q, s0.copy()
        s.z[:n_q][self._is_rotation] = 0.0
        s.v[:n_q] -= back
        s.a[:n_q] = a
        at = Motions(np.array([s.t]), s.z[None], s.v[None], s.a[None], s.R)
        return self._residuals(at, k, np.zeros((1, self.system.n)))[0]

    def gap(self, s: State) -> np.ndarray:
        """Return the violation (n_l,) of the constraints on positions."""
        g = self.system.constraint_derivatives(s)[:, 0]
        g[self.system.numbering.of_rates] = 0.0
        return g
