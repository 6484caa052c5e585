r"""Radau IIA of order 5 on the Lie group, for smooth motion and tight tolerances (theory.md, section 2.6).

Within a step :math:`R = R_0 \exp(\hat\theta)`, :math:`x = x_0 + \theta` and :math:`\dot\theta = T^{-1}(\theta) v`
(Munthe-Kaas 1999). Increments and velocities are collocated at the three stages, where the equations of motion hold
together with the second rates of all constraints: with index 1 all components have order 5. At the end of the step
positions and velocities are projected on the constraints, in the metric of the mass, and accelerations and multipliers
follow from them (Hairer & Wanner 1996, IV.8 and VII.2).
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

import numpy as np

from mecano.errors import Failure
from mecano.model.assembly import Assembly
from mecano.model.numbering import ROTATION
from mecano.model.state import RadauHistory, State
from mecano.solve.diagnostics.scales import SIGNALS, SMALL, Tolerances, balance
from mecano.solve.linear.newton import FAILURES, MESSAGES, NOT_FINITE, SINGULAR, TOO_MANY
from mecano.solve.linear.rounding import at_rounding
from mecano.solve.time.consistent import Consistent, consistent_state
from mecano.solve.time.contradictions import Contradictions
from mecano.solve.time.increments import displaced, largest, moved, reach_of
from mecano.solve.time.radau_stages import Stages
from mecano.solve.time.radau_tableau import ERROR, REAL, TO_CUBIC, A
from mecano.solve.time.radau_tangent import StageTangent
from mecano.solve.time.singular_position import LOST, ROUNDED, Amplification, cannot_pass
from mecano.solve.time.step_control import SUDDEN, StepControl, counted
from mecano.solve.time.step_info import MOST_TURN, PATIENCE, TURNS_TOO_FAR, StepInfo, Trial
from mecano.solve.time.workspace import Workspace

if TYPE_CHECKING:
    from mecano.model.system import System
    from mecano.solve.events.compliance import Compliance
    from mecano.solve.linear.sparse import LinearSolver

SHARE = 0.01  # of the allowed error of a step: a correction that leaves less ends Newton's iteration
LEAST = 1e-17  # of the length scale, or rad: increments are known to more digits than positions
CAUTION = 8.0  # times the estimate: errors of velocities add up to more than themselves
TURN = 1.0  # rad in a step: with more, the frozen tangent converges slowly
SLOW = 0.9  # ratio of two corrections above which the last one is not made, and the tangent is renewed
MIDDLE = 1  # stage at which it is then evaluated


class Radau:
    """Radau IIA for one system: its tolerances and linear systems, but no motion.

    Has the same methods as GeneralizedAlpha.
    """

    in_compiled_code: Literal[False] = False

    def __init__(
        self,
        system: "System",
        linear: "LinearSolver",
        length: float,
        control: StepControl,
        tolerances: Tolerances | None = None,
        k: float | None = None,
        compliance: "Compliance | None" = None,
    ):
        self.system, self.linear, self.length, self.control = system, linear, length, control
        self.tolerances, self.k, self.penalty = tolerances or Tolerances(), k, 0.0
        self.patience = PATIENCE
        # called in a step as often as the program may be late for a signal; may raise
        self.pause: Callable[[], object] = lambda: None
        of, self.assembly = system.numbering, Assembly(system)
        self.workspace = Workspace(system, self.assembly)
        self.workspace.point_to(kind=of.kind.copy(), rotation_dof=of.rotation_dof)  # for the recorder
        self.use(compliance)

    def use(self, compliance: "Compliance | None") -> None:
        """Give redundant constraints these compliances, or none (None), from now on."""
        self.compliance = compliance
        self.contradictions = Contradictions(self.system, self.length, compliance)
        self.stages = Stages(self.system, self.assembly, compliance, self.length)
        self.tangent = StageTangent(self.system, self.assembly, compliance)
        self.amplification = Amplification(self.system, self.length)

    def start(self, s: State, h: float, consistent: Consistent | None = None) -> tuple[State, RadauHistory]:
        """Return a consistent state and the history for a first step of size h, at the start and after events.

        ``consistent``, if given, is factored for ``s``. Raises AssemblyError where constraints contradict one another.
        """
        s, used = consistent_state(self.system, self.linear, s, h, self.contradictions, self.compliance, consistent)
        none, amplified = (np.zeros((4, self.system.n_q)), np.zeros((3, self.system.n_l))), self.amplification.at(used)
        return s, RadauHistory(s.a, h, *none, 0, self._stiffness(s, h), amplified, amplified)

    def restart(self, s: State, history: RadauHistory, h: float) -> RadauHistory:
        """Return the history for a new step size: the same, because steps do not depend on earlier ones."""
        return history

    def repeated(self, s0: State, history: RadauHistory, last: State) -> Callable[[float], Trial]:
        """Return a function of h that makes steps from ``s0`` like ``step``; ``last``: the end of one already made."""
        return lambda h: self.step(s0, history, h)

    def insist(self, strictly: bool) -> None:
        """Do nothing: iterations are judged by their corrections in any case."""

    def longest(self, s: State) -> float:
        """Return the longest step [s] for the velocities of the state ``s``."""
        of = self.system.numbering
        fastest = np.abs(s.v[of.rotation_dof[of.rotation_dof < of.n_q][:, None] + np.arange(3)]).max(initial=0.0)
        return TURN / fastest if fastest > 0.0 else np.inf

    def bounded_error(self, s: State, history: RadauHistory, info: StepInfo) -> float:
        """Return the local error of a step: oscillations need no second estimate, as stages resolve or damp them."""
        return info.plain

    def _stiffness(self, s, h):
        return self.k or balance(self.system, s, self.length, 1.0, REAL / h, (REAL / h) ** 2)

    def step(self, s0: State, history: RadauHistory, h: float) -> Trial:
        """Make a step of size h from ``s0`` with its ``history``; return (state, history, StepInfo). Pure."""
        stages = self.stages
        code, iterations, size, most = SINGULAR, 0, np.inf, self.tolerances.max_iterations
        goal, reach = self._goal(h), reach_of(s0.z, self.system.numbering, self.length)
        stages.begin(s0, h, history, self.control.duration, min(goal / self._accuracy(), 1.0))
        if self.tangent.prepare(moved(s0, 0.5 * h, self.system.numbering), history.k, h):
            code = TOO_MANY
        elif not self.tangent.finite:
            code = NOT_FINITE
        while code == TOO_MANY and iterations < most:
            self.pause()
            correction = self.tangent.solve(stages.residuals(history.k))
            before = stages.increments.copy(), stages.reactions.copy()
            last, size = size, stages.correct(correction, self.tangent.turn)
            iterations += 1
            ratio = size / last if iterations > 1 else 1.0
            if not size < np.inf:
                code = NOT_FINITE
            elif (
                size < goal or size * ratio < goal * (1.0 - ratio) or at_rounding(size, ratio, ratio != 1.0, reach, 0.0)
            ):
                return self._finished(s0, history, h, iterations, size / goal)
            elif iterations > 1 and (ratio > SLOW or size * ratio ** (most - iterations) > goal):
                if ratio > SLOW:
                    (stages.increments[:], stages.reactions[:]), size = before, last
                if not self.tangent.prepare(stages.states()[MIDDLE], history.k, h):
                    code = SINGULAR
        message = MESSAGES[code].format(iterations)
        info = StepInfo(False, iterations, (0.0, 0.0, size / goal), np.nan, history, message, FAILURES[code])
        return s0, history, info

    def _goal(self, h):
        """Return the error of the increments that ends Newton's iteration, relative to the length scale, or rad.

        Velocities have this error over h, and accumulate it until the end of the run.
        """
        allowed = self.control.allowed(h)
        if allowed == np.inf:
            return self.tolerances.constraint
        return max(SHARE * allowed * h / self.control.duration, LEAST)

    def _accuracy(self):
        """Return the relative error of signals without a rate, to which Newton's iteration solves their equations."""
        return min(SHARE * self.control.tolerance, SIGNALS)

    def _finished(self, s0, history, h, iterations, increment):
        """Return the step whose stages have converged."""
        stages, k = self.stages, history.k
        within = stages.states()
        error = self._error(s0, k, h)
        work = h * A @ np.array([self.system.observe(s).powers for s in within])
        s, drift, amplified = self._projected(within[2], h, history)
        of = self.system.numbering
        turn = np.abs(stages.increments[-1][of.kind[: of.n_q] == ROTATION]).max(initial=0.0)
        text, failure = TURNS_TOO_FAR if turn > MOST_TURN else "", Failure.NOT_CONVERGED
        if not text:
            text, failure = self.contradictions.at_the_end(s, h, np.zeros(of.n_l)), Failure.CONTRADICTION
        norms = 0.0, drift, increment
        if text:
            return s, history, StepInfo(False, iterations, norms, np.nan, history, text, failure)
        least = min(amplified, history.least_amplified)
        new = RadauHistory(s.a, h, stages.velocities.copy(), stages.reactions.copy(), 1, k, amplified, least)
        info = StepInfo(
            True, iterations, norms, error, history, plain=error,
            stages=tuple(within[:2]), work=work,
        )  # fmt: skip
        return s, new, info

    def _projected(self, stage, h, history):
        """Return the last ``stage`` projected on the constraints, the way there, and the amplification there.

        The state has its accelerations and multipliers. Near a singular position it is the stage itself.
        """
        of, n_q = self.system.numbering, self.system.n_q
        consistent = Consistent(self.system, self.linear, stage, self.length, self.compliance)
        amplified = self.amplification.at(consistent)
        before, now = history.amplified / history.least_amplified, amplified / history.least_amplified
        if min(before, now) > LOST:
            raise cannot_pass(self.amplification.dependent(consistent), stage.t, h)
        if now > max(before, ROUNDED):
            return displaced(stage, np.zeros(n_q), of), 0.0, amplified
        change = consistent.change(-self.stages.gap(stage))
        s = displaced(stage, change, of)
        consistent.project_velocity(s)
        consistent.accelerate(s)
        return s, largest(change, of.kind, n_q, self.length), amplified

    def _error(self, s0, k, h):
        r"""Return the local error of a step.

        Hairer and Wanner's embedded formula (IV.8, 8.19) is of order 3; its error, of order 4 in h, times
        :math:`(\omega h)^2` estimates that of order 6. omega follows from the accelerations in the step.
        """
        stages, of = self.stages, self.system.numbering
        V = stages.velocities - stages.velocities[0]
        x = s0.v[: of.n_q] + ERROR @ stages.increments / h
        e = self.tangent.solve_real(stages.residual_at(s0, x, -ERROR @ V[1:] / h - REAL / h * x, k))
        cubic, states = (TO_CUBIC @ V)[1:], self.system.states
        error = _error_of_order_six(*(largest(c, of.kind, of.n_q, self.length) for c in (e, *cubic)))
        if states.any():
            sizes, duration = stages.sizes[states], self.control.duration
            begun = np.maximum(duration * np.abs(V[:, states]).max(axis=0), SMALL)  # at rest before
            e, *cubic = np.abs([e[: of.n_q], *cubic])[:, states] / np.where(sizes > SMALL, sizes, begun)
            worst = max(map(_error_of_order_six, e, *cubic))
            error = max(error, worst * counted(1.0, SUDDEN, duration, h) ** 2)
        return error


def _error_of_order_six(e, first, second, third):
    """Return the error estimate from that of order 3 and the coefficients of the velocities in the step."""
    fast = 6.0 * third / (first + 2.0 * second) if third else 0.0
    return CAUTION * e * min(fast, 1.0)
