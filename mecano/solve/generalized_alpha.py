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

from mecano.model.loops import direct
from mecano.model.numbering import ROTATION
from mecano.model.state import History
from mecano.solve.consistent import Consistent
from mecano.solve.increments import correct, finish, predict
from mecano.solve.newton import newton
from mecano.solve.scales import Tolerances, balance, norms

MOST_TURN = 2.4  # rad about one axis in a step: angles of joints are followed by less than half a turn
TURNS_TOO_FAR = f"a body turns by more than {MOST_TURN} rad in one step"
KEPT = 0.001  # tolerances are that much smaller with an old tangent: what it leaves is not squared by the last iteration
TRUST = 0.5  # an old tangent is used where two iterations are expected to leave less than this of the residual norm
FORGET = 0.9  # the experience with old tangents, at every step that does without


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
        self._equations, self._increment = system.residual[: system.n], np.zeros(system.n)
        self._rotations = np.flatnonzero(system.numbering.kind[: system.n_q] == ROTATION)
        self._no_shift = np.zeros(system.numbering.n_all)
        self._bind()

    def _bind(self):
        """The kernels of a step with the arguments that never change."""
        system, of, c, length = self.system, self.system.numbering, self.coefficients, self.length
        s, a, increment = system.initial_state(), self._no_shift, self._increment
        moving, motion = (of.kind, of.rotation_dof, of.n_q, of.n), (s.z, s.v, s.a, s.R, s.T)
        self._predict = direct(
            predict, (c.am, c.af, c.beta, c.gamma, *moving), (1.0, a, a, increment, increment, a, s.R, *motion)
        )
        self._correct = direct(correct, (length, *moving), (increment, 1.0, 1.0, 1.0, s.R, *motion))
        self._finish = direct(
            finish, (c.am, c.af, length, of.kind, of.n_q, of.n), (a, increment, 0, *(a,) * 4, a, increment, increment)
        )
        limits = self.tolerances.force, self.tolerances.constraint
        self._norms = direct(norms, (system.residual, system.size, of.kind, of.n, length, *limits), (1.0,) * 4)

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
        nothing = np.zeros(self.system.n)
        return s, self._history(consistent, s, s.a.copy(), h, nothing, nothing, 0)

    def restart(self, s, history, h):
        """History for a new step size h at an accepted state; the motion goes on (second order for the multipliers)."""
        c = self.coefficients
        consistent = Consistent(self.system, self.linear, s, self.compliance)
        ratio, n_q = h / history.h, self.system.n_q
        a = history.a.copy()
        a[:n_q] += (c.am - c.af) * (ratio - 1.0) * history.slope[:n_q]
        bend = ratio**2 * history.bend
        slope = ratio * (history.slope + 0.5 * history.bend) - 0.5 * bend
        return self._history(consistent, s, a, h, slope, bend, history.known)

    def _history(self, consistent, s, a, h, slope, bend, known):
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
        return History(a, h, slope, bend, known, v_shift, balance(self.system, s, 1.0, cC, cM))

    def _weights(self, h):
        """Derivatives of velocities and accelerations by displacements within a step of size h."""
        c = self.coefficients
        return c.gamma / (c.beta * h), (1 - c.am) / (1 - c.af) / (c.beta * h * h)

    def step(self, s0, history, h):
        """One step of size h from ``s0``, for which ``history`` was made: (state, history, StepInfo); pure.

        k and penalty are those of the deck, or the mean stiffness in the history.
        """
        system = self.system
        cC, cM = self._weights(h)
        k, penalty = self.k or history.k, history.k if self.penalty is None else self.penalty
        if self.compliance is not None:
            penalty = min(penalty, self.compliance.largest_penalty)
        scales = (k, penalty, 1.0, cC, cM)
        tangent = history.tangent
        if tangent is not None and self.linear.label is not tangent:
            self._factor(tangent, scales)
        s = s0.copy()
        s.t = s0.t + h
        reach = self._predict(
            h, history.a, s0.a, history.slope, history.bend, history.v_shift, s0.R, s.z, s.v, s.a, s.R, s.T
        )

        share = KEPT if tangent else 1.0

        def evaluate(fresh):
            nonlocal share
            if fresh:
                share = 1.0
                self._assemble(s, scales)
            else:
                self._assemble(s, (k, penalty, 0.0, 0.0, 0.0))
            return self._norms(share, k, history.k, reach)

        def solve(fresh):
            r, x = self._equations, self._increment
            if not fresh:
                self.linear.resolve(r, x)
                return x
            return x if self.linear.solve(system.data, r, x, s.copy()).ok else None

        def move(dz):
            largest = self._correct(dz, k, cC, cM, s0.R, s.z, s.v, s.a, s.R, s.T)
            return largest / self.tolerances.increment

        result = newton(
            evaluate, solve, move, kept=tangent is not None, max_iterations=self.tolerances.max_iterations
        )
        if not result.ok:
            return s, history, StepInfo(False, result.iterations, result.norms, np.nan, result.message)
        if np.abs(s.z[self._rotations]).max(initial=0.0) > MOST_TURN:
            return s, history, StepInfo(False, result.iterations, result.norms, np.nan, TURNS_TOO_FAR)
        new, error = self._after(s0, s, history, h, result)
        return s, new, StepInfo(True, result.iterations, result.norms, error)

    def _assemble(self, s, scales):
        """Residual and, where the scales of the tangent are not zero, tangent; with the compliance."""
        system = self.system
        system.assemble(s, *scales)
        if self.compliance is not None:
            n_q, n, k = system.n_q, system.n, scales[0]
            self.compliance.soften(k, s.z[n_q:n], self._equations[n_q:])
            if scales[2]:
                self.compliance.soften_tangent(k, system.data)

    def _factor(self, tangent, scales):
        """Factor the tangent of an earlier state again, as it was."""
        self._assemble(tangent, scales)
        self.linear.solve(self.system.data, np.zeros(self.system.n), self._increment, tangent)

    def _after(self, s0, s, history, h, result):
        """History after a step from ``s0`` to ``s``, and the local error."""
        a, slope, bend = np.zeros(len(s.a)), np.empty(self.system.n), np.empty(self.system.n)
        change = self._finish(
            history.a, history.slope, history.known, s0.a, s0.z, s.a, s.z, a, slope, bend
        )  # fmt: skip
        tangent, age, drift, first = history.tangent, history.age + 1, history.drift * FORGET, result.first
        if tangent is None:
            first /= KEPT
        elif first > 0.0:
            drift = result.second / first / history.age
        if tangent is not self.linear.label:  # a new one was evaluated in this step; is it worth keeping?
            tangent, age = (self.linear.label, 1) if result.iterations <= (1 if tangent is None else 2) else (None, 0)
        if not first * (drift * age) ** 2 <= TRUST:
            tangent = None
        new = History(
            a, h, slope, bend, min(history.known + 1, 2), self._no_shift, history.k, tangent, age, drift
        )  # fmt: skip
        return new, self.coefficients.error * h * h * change
