r"""Lie-group generalized-alpha: one step, and the care for the multipliers at a start or a change of step.

Chung & Hulbert 1993; Arnold & Bruels 2007; Bruels, Cardona & Arnold 2012; theory.md section 2:

.. math::
    (1-\alpha_m) a_{n+1} + \alpha_m a_n = (1-\alpha_f) \ddot q_{n+1} + \alpha_f \ddot q_n, \quad
    \Delta q = h v_n + h^2 [(\tfrac12 - \beta) a_n + \beta a_{n+1}], \quad
    v_{n+1} = v_n + h [(1-\gamma) a_n + \gamma a_{n+1}]

with residual and constraints satisfied at the end of the step. HHT and Newmark are choices of the coefficients.
"""

from dataclasses import dataclass

import numpy as np

from mecano.model.numbering import ROTATION
from mecano.model.state import History
from mecano.solve.consistent import Consistent
from mecano.solve.increments import correct, finish, predict
from mecano.solve.newton import newton
from mecano.solve.scales import Tolerances, balance, norms

MOST_TURN = 2.4  # rad about one axis in a step: angles of joints are followed by less than half a turn
TURNS_TOO_FAR = f"a body turns by more than {MOST_TURN} rad in one step"


@dataclass(frozen=True)
class Coefficients:
    """am, af, beta, gamma of the family, and the constant Ce of its local displacement error."""

    am: float
    af: float
    beta: float
    gamma: float

    @classmethod
    def generalized_alpha(cls, rho):
        """Chung & Hulbert 1993, spectral radius rho at infinity in [0, 1]."""
        am, af = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
        gamma = 0.5 + af - am
        return cls(am, af, 0.25 * (gamma + 0.5) ** 2, gamma)

    @classmethod
    def hht(cls, rho):
        """Hilber, Hughes & Taylor 1977; rho in [1/2, 1]."""
        af = (1.0 - rho) / (1.0 + rho)
        return cls(0.0, af, 0.25 * (1.0 + af) ** 2, 0.5 + af)

    @classmethod
    def newmark(cls, rho):
        """Newmark 1959 with damping: gamma = 1/2 + delta, beta = (gamma + 1/2)^2/4; first order for rho < 1."""
        delta = (1.0 - rho) / (1.0 + rho)
        gamma = 0.5 + delta
        return cls(0.0, 0.0, 0.25 * (gamma + 0.5) ** 2, gamma)

    @property
    def error(self):
        """Ce of the local error Ce h^2 |a_{n+1} - a_n| of the displacement."""
        return self.beta + 0.5 * (self.am - self.af) - 1.0 / 6.0


@dataclass(slots=True)
class StepInfo:
    """How a step went."""

    ok: bool
    iterations: int
    norms: tuple  # force, constraint, increment over their tolerances
    error: float  # local error, relative to the length scale (or rad); nan if not ok
    message: str = ""


class GeneralizedAlpha:
    """The method for one system: coefficients, tolerances, linear solver. Holds no motion."""

    def __init__(self, system, linear, coefficients, length, tolerances=None, k=None, penalty=None, compliance=None):
        self.system, self.linear, self.coefficients = system, linear, coefficients
        self.length, self.tolerances = length, tolerances or Tolerances()
        self.k, self.penalty, self.compliance = k, penalty, compliance
        self.limits = (self.tolerances.force, self.tolerances.constraint)
        self._increment = np.zeros(system.n)
        self._rotations = np.flatnonzero(system.numbering.kind[: system.n_q] == ROTATION)
        self._no_shift = np.zeros(system.numbering.n_all)

    def start(self, s, h):
        """Consistent state and history for steps of size h: from rest, after an event.

        Projects the velocities, solves for accelerations and multipliers, and shifts both so that the multipliers
        are of second order from the first step (Arnold, Bruels & Cardona 2015): the constrained part of
        a_0 = q''_0 + (am - af) h q'''_0 and of v_0 - Ce h^2 q'''_0. Returns (state at t, history); the state
        returned has exact velocities, the history carries the shifts.
        """
        s = s.copy()
        consistent = Consistent(self.system, self.linear, s, self.compliance)
        consistent.project_velocity(s)
        consistent.accelerate(s)
        if self.compliance is not None:
            s = consistent.give_way(s, self.compliance)
        return s, self._history(consistent, s, s.a.copy(), h, np.zeros(self.system.n_l))

    def restart(self, s, history, h):
        """History for a new step size h at an accepted state; the motion goes on (second order for the multipliers)."""
        c = self.coefficients
        consistent = Consistent(self.system, self.linear, s, self.compliance)
        a = history.a + (c.am - c.af) * (h - history.h) / history.h * (s.a - history.previous)
        return self._history(consistent, s, a, h, history.multiplier_rate)

    def _history(self, consistent, s, a, h, multiplier_rate):
        """Shift the constrained parts of a and v to where the method keeps them."""
        c, n_q = self.coefficients, self.system.n_q
        v_shift = np.zeros_like(a)
        if self.system.n_l:
            rate = consistent.jerk_rate(s, h)
            consistent.project_acceleration(s, a, -(c.am - c.af) * h * rate)
            shifted = s.copy()
            consistent.project_velocity(shifted, c.error * h * h * rate)
            v_shift[:n_q] = shifted.v[:n_q] - s.v[:n_q]
        cC, cM = self._weights(h)
        return History(a, h, s.a.copy(), multiplier_rate, v_shift, balance(self.system, s, 1.0, cC, cM))

    def _weights(self, h):
        """Derivatives of velocities and accelerations by displacements within a step of size h."""
        c = self.coefficients
        return c.gamma / (c.beta * h), (1 - c.am) / (1 - c.af) / (c.beta * h * h)

    def step(self, s0, history, h):
        """One step of size h from ``s0``, for which ``history`` was made: (state, history, StepInfo); pure.

        k and penalty are those of the deck, or the mean stiffness in the history.
        """
        c, system, of, length = self.coefficients, self.system, self.system.numbering, self.length
        cC, cM = self._weights(h)
        k = self.k or history.k
        penalty = history.k if self.penalty is None else self.penalty
        if self.compliance is not None:
            penalty = min(penalty, self.compliance.largest_penalty)
        s, n_q, n, rotations = s0.copy(), system.n_q, system.n, of.rotation_dof
        s.t = s0.t + h
        reach = predict(
            h, c.am, c.af, c.beta, c.gamma,
            history.a, s0.a, history.previous, history.v_shift, history.multiplier_rate, s0.R,
            of.kind, rotations, n_q, n, s.z, s.v, s.a, s.R, s.T,
        )  # fmt: skip
        reach *= max(history.k / k, 1.0)  # rounding is that of the stiffness, whatever k a deck gives

        def evaluate(tangent):
            system.assemble(s, k, penalty, *((1.0, cC, cM) if tangent else (0.0, 0.0, 0.0)))
            if self.compliance is not None:
                self.compliance.soften(k, s.z[n_q:n], system.residual[n_q:n])
                if tangent:
                    self.compliance.soften_tangent(k, system.data)
            return norms(system.residual, system.size, of.kind, n, k, length, reach, *self.limits)

        def solve(fresh):
            b, x = -system.residual[:n], self._increment
            if not fresh:
                self.linear.resolve(b, x)
                return x
            return x if self.linear.solve(system.data, b, x).ok else None

        def move(dz):
            largest = correct(
                dz, k, cC, cM, length, s0.R, of.kind, rotations, n_q, n, s.z, s.v, s.a, s.R, s.T
            )  # fmt: skip
            return largest / self.tolerances.increment

        result = newton(evaluate, solve, move, max_iterations=self.tolerances.max_iterations)
        if not result.ok:
            return s, history, StepInfo(False, result.iterations, result.norms, np.nan, result.message)
        if np.abs(s.z[self._rotations]).max(initial=0.0) > MOST_TURN:
            return s, history, StepInfo(False, result.iterations, result.norms, np.nan, TURNS_TOO_FAR)
        a, rate = np.zeros_like(s.a), np.empty(system.n_l)
        change = finish(h, c.am, c.af, history.a, s0.a, s.a, s0.z, s.z, of.kind, n_q, n, length, a, rate)
        error = c.error * h * h * change
        new = History(a, h, s0.a, rate, self._no_shift, history.k)
        return s, new, StepInfo(True, result.iterations, result.norms, error)
