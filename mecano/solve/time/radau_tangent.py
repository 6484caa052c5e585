r"""Tangent of the stages of Radau IIA, frozen within a step: simplified Newton iteration.

A variation :math:`\varphi e^{st}` of the increments varies velocities by :math:`(s + W)\varphi` and accelerations by
:math:`s (s + W) \varphi`, W = hat(Omega)/2 of each rotation, and the equations of motion and second rates of the
constraints by

.. math:: \begin{bmatrix} K + C (s + W) + M s (s + W) & -k B^T \\ -k (G_2 s^2 + G_1 s + G_0)/s^2 & -k^2 c
          \end{bmatrix}

with :math:`G_2 = B`, :math:`G_1 = 2 (\dot B - B W)`, :math:`G_0 = \ddot B - 2 \dot B W` of constraints on positions.
s is an eigenvalue of the method over the step size: the stages decouple into one real and one complex system (Hairer
& Wanner 1996, IV.8).
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mecano.jit.entry import Indices, Matrix, Table, Vector, entry
from mecano.jit.kernel import kernel
from mecano.solve.time.increments import moved
from mecano.solve.time.radau_tableau import COMPLEX, FROM_COMPLEX, FROM_REAL, REAL, TO_COMPLEX, TO_REAL

if TYPE_CHECKING:
    from mecano.model.assembly import Assembly
    from mecano.model.state import State
    from mecano.model.system import System
    from mecano.solve.events.compliance import Compliance

DIFFERENCE = 0.02  # of a step, for the rates of the gradients of the constraints
MOTION, POSITION, RATE = range(3)  # equations of motion, constraints on positions, constraints on velocities
NEXT, LAST = (1, 2, 0), (2, 0, 1)  # components after and before each in the cycle of x, y, z
TO_BOTH = np.stack([TO_COMPLEX.real, TO_COMPLEX.imag], axis=1)
FROM_BOTH = np.stack([FROM_REAL, 2.0 * FROM_COMPLEX.real, -2.0 * FROM_COMPLEX.imag], axis=1)
PARTS = K, C, M, K_LATER, C_LATER, K_BEFORE, C_BEFORE = range(7)


@kernel
def spun(data, turned, i, omega):
    """Return entry i of the matrix of ``data`` times W = hat(omega)/2, with the tables of ``_turned``."""
    if turned[i, 0] < 0:
        return 0.0
    return 0.5 * (data[turned[i, 0]] * omega[turned[i, 2]] - data[turned[i, 1]] * omega[turned[i, 3]])


class Entries(NamedTuple):
    """Row, rotation and place of each entry of the tangent."""

    kind: Indices  # (nnz,) MOTION, POSITION or RATE: of its row
    turned: Table  # (nnz, 4) for rotations (``_turned``)
    place: Indices  # (nnz,) in the matrices


@entry
def weigh(
    entries: Entries, parts: Matrix, omega: Vector, dt: float, s: float, s_real: float, s_imaginary: float,
    real_out: Vector, complex_out: Matrix,
):  # fmt: skip
    """Write the values of the real and of the complex matrix at their places.

    ``parts`` (7, n_data) are K, C, M, and K and C later and before by dt.
    """
    kind, turned, place = entries
    s2 = s_real + 1j * s_imaginary
    for i in range(kind.shape[0]):
        if kind[i] == MOTION:
            c0 = parts[K, i] + spun(parts[C], turned, i, omega)
            c1 = parts[C, i] + spun(parts[M], turned, i, omega)
            c2 = parts[M, i]
            x, y = c0 + s * (c1 + s * c2), c0 + s2 * (c1 + s2 * c2)
        else:
            if kind[i] == POSITION:
                B, B1 = parts[K, i], (parts[K_LATER, i] - parts[K_BEFORE, i]) / (2.0 * dt)
                spin = spun(parts[K], turned, i, omega)
                later, before = spun(parts[K_LATER], turned, i, omega), spun(parts[K_BEFORE], turned, i, omega)
                c2, c1 = B, 2.0 * (B1 - spin)
                c0 = (parts[K_LATER, i] + parts[K_BEFORE, i] - 2.0 * B) / (dt * dt) - (later - before) / dt
            else:
                later, before = spun(parts[C_LATER], turned, i, omega), spun(parts[C_BEFORE], turned, i, omega)
                c2 = parts[C, i]
                c1 = (
                    spun(parts[C], turned, i, omega)
                    + (parts[C_LATER, i] - parts[C_BEFORE, i]) / (2.0 * dt)
                    + parts[K, i]
                )
                c0 = (later - before + parts[K_LATER, i] - parts[K_BEFORE, i]) / (2.0 * dt)
            x, y = c2 + (c1 + c0 / s) / s, c2 + (c1 + c0 / s2) / s2
        real_out[place[i]] = x
        complex_out[place[i], 0] = y.real
        complex_out[place[i], 1] = y.imag


@entry
def split(
    to_real: Vector, to_complex: Matrix, real_scale: Vector, complex_scale: Matrix, F: Matrix,
    real_out: Vector, complex_out: Matrix,
):  # fmt: skip
    """Transform and scale the residuals F (3, n) to the right-hand sides of the real and the complex system."""
    for j in range(F.shape[1]):
        f0, f1, f2 = F[0, j], F[1, j], F[2, j]
        real_out[j] = real_scale[j] * (to_real[0] * f0 + to_real[1] * f1 + to_real[2] * f2)
        x = to_complex[0, 0] * f0 + to_complex[1, 0] * f1 + to_complex[2, 0] * f2
        y = to_complex[0, 1] * f0 + to_complex[1, 1] * f1 + to_complex[2, 1] * f2
        p, q = complex_scale[j, 0], complex_scale[j, 1]
        complex_out[j, 0], complex_out[j, 1] = p * x - q * y, p * y + q * x


@entry
def join(from_both: Matrix, n_q: int, k: float, real: Vector, other: Matrix, correction_out: Matrix):
    """Transform the solutions of the real and the complex system to the corrections (3, n) of the stages."""
    for i in range(3):
        for j in range(real.shape[0]):
            x = from_both[i, 0] * real[j] + from_both[i, 1] * other[j, 0] + from_both[i, 2] * other[j, 1]
            correction_out[i, j] = k * x if j >= n_q else x


class StageTangent:
    """The tangent of the stages in the middle of a step, and its factors."""

    def __init__(self, system: "System", assembly: "Assembly", compliance: "Compliance | None" = None):
        from mecano.solve.linear.lu import factors  # no ordinary run needs it (docs/architecture.md, Start)

        self.system, self.assembly, self.compliance = system, assembly, compliance
        n, n_q, of = system.n, system.n_q, system.numbering
        self._real, self._complex = (factors(n, system.rows, system.cols, dtype) for dtype in (float, complex))
        self._parts = np.zeros((len(PARTS), system.n_data))
        kind = np.full(n, MOTION)
        kind[n_q:] = np.where(of.of_rates, RATE, POSITION)
        self._weigh = weigh.bind(Entries(kind[system.rows], self._turned(), self._real.place), self._parts)
        self._out = self._real.values, self._complex.values.view(float).reshape(-1, 2)
        self._real_scale, self._complex_scale = np.ones(n), np.ones((n, 2)) * [1.0, 0.0]
        self._b, self._c, self._correction = np.zeros(n), np.zeros(n, complex), np.zeros((3, n))
        self._right_hand_sides = self._b, self._c.view(float).reshape(-1, 2)
        if compliance is not None:
            self._soft = compliance.places < system.nnz
            self._soft_place = self._real.place[compliance.places[self._soft]]

    def _turned(self):
        """Return (nnz, 4): in the row of an entry of a rotation, the entries of its two other columns; their unknowns.

        The first is -1 for an entry of another column.
        """
        system, of = self.system, self.system.numbering
        first = np.full(system.n, -1)
        for d in of.rotation_dof[of.rotation_dof < of.n_q]:
            first[d : d + 3] = d
        start = first[system.cols]
        component = np.where(start >= 0, system.cols - start, 0)
        code = system.rows * system.n + system.cols
        later, before = start + np.take(NEXT, component), start + np.take(LAST, component)
        places = [np.searchsorted(code, system.rows * system.n + of_other) for of_other in (later, before)]
        found = np.stack([*places, before, later], axis=1)
        found[start < 0] = -1
        return found

    def prepare(self, s: "State", k: float, h: float) -> bool:
        """Evaluate and factor the tangent at the state ``s`` within a step of size h; return whether it is regular.

        ``s.z`` holds the rotation increments since the beginning of the step, afterwards also ``turn`` (n_all,).
        """
        of, dt = self.system.numbering, DIFFERENCE * h
        self.k, self.turn, real, other = k, s.z.copy(), REAL / h, COMPLEX / h
        for part, weights in zip((K, C, M), np.eye(3), strict=True):
            self._assemble(part, s, *weights)
        if self.system.n_l:
            for part, sign in ((K_LATER, 1.0), (K_BEFORE, -1.0)):
                near = moved(s, sign * dt, of)
                self._assemble(part, near, 1.0, 0.0, 0.0)
                if of.of_rates.any():
                    self._assemble(part + 1, near, 0.0, 1.0, 0.0)
        self._weigh(s.v, dt, real, other.real, other.imag, *self._out)
        if self.compliance is not None:
            self._soften(real, other)
        n_q = self.system.n_q
        self._real_scale[n_q:], self._complex_scale[n_q:] = real**-2, ((other**-2).real, (other**-2).imag)
        return self._factored() or (self._hold_idle() and self._factored())

    def _factored(self):
        return self._real.factor() and self._complex.factor()

    def _hold_idle(self):
        """Let unknowns that nothing resists or moves, with rows and columns of zeros, keep their values; return if any.

        Such is the rotation of a node without inertia on which no moment acts.
        """
        system, of = self.system, self._real
        size = np.abs(of.values[of.place])
        touched = np.bincount(system.rows, size, system.n) + np.bincount(system.cols, size, system.n)
        idle = np.flatnonzero((touched == 0.0) & (self.assembly.residual[: system.n] == 0.0))
        places = of.place[system.diagonal[idle]]
        of.values[places] = self._complex.values[places] = 1.0
        return len(idle) > 0

    @property
    def finite(self) -> bool:
        """True if all values of the last tangent are finite."""
        return bool(np.isfinite(self._parts).all())

    def _assemble(self, part, s, cK, cC, cM):
        self._parts[part] = self.system.assemble(s, self.k, 0.0, cK, cC, cM, into=self.assembly).data

    def _soften(self, real, other):
        """Add the compliances, which count as accelerations of the real system."""
        values = self.compliance.in_tangent(self.k, self.compliance.values)[self._soft]
        np.add.at(self._real.values, self._soft_place, values)
        np.add.at(self._complex.values, self._soft_place, (real / other) ** 2 * values)

    def solve(self, F: np.ndarray) -> np.ndarray:
        """Return the corrections (3, n) of increments and multipliers of the stages for their residuals F (3, n)."""
        split(TO_REAL, TO_BOTH, self._real_scale, self._complex_scale, F, *self._right_hand_sides)
        join(FROM_BOTH, self.system.n_q, self.k, self._real.solve(self._b), self._solved(), self._correction)
        return self._correction

    def _solved(self):
        return self._complex.solve(self._c).view(float).reshape(-1, 2)

    def solve_real(self, f: np.ndarray) -> np.ndarray:
        """Return the solution (n,) for the residual f (n,) of the real system; multipliers over k."""
        return self._real.solve(self._real_scale * f)
