r"""Lie-group generalized-alpha: steps, and consistent histories at starts and changes of step size.

Chung & Hulbert 1993; Arnold & Bruels 2007; Bruels, Cardona & Arnold 2012; theory.md section 2:

.. math::
    (1-\alpha_m) a_{n+1} + \alpha_m a_n = (1-\alpha_f) \ddot q_{n+1} + \alpha_f \ddot q_n, \quad
    \Delta q = h v_n + h^2 [(\tfrac12 - \beta) a_n + \beta a_{n+1}], \quad
    v_{n+1} = v_n + h [(1-\gamma) a_n + \gamma a_{n+1}]

with residual and constraints satisfied at the end of the step. HHT and Newmark are choices of the coefficients.
"""

import ctypes
import time as clock
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from mecano.errors import Failure
from mecano.model.assembly import Assembly
from mecano.model.numbering import MASSLESS, RELEASED, SIGNAL
from mecano.model.state import History, State
from mecano.solve.diagnostics.scales import Tolerances
from mecano.solve.events.compliance import NO_ROWS, SHARING, SOFTNESS, Compliance, compliances_of_a_step, soften
from mecano.solve.linear import multifrontal
from mecano.solve.linear.newton import (
    CONVERGED,
    FAILURES,
    FORCES,
    INCREMENT,
    ITERATIONS,
    MESSAGES,
    NOT_FINITE,
    OTHERWISE,
    PAUSE,
    SINGULAR,
    STALE,
)
from mecano.solve.time.coefficients import Coefficients
from mecano.solve.time.consistent import Consistent, consistent_state
from mecano.solve.time.contradictions import Contradictions
from mecano.solve.time.error_bound import ErrorBound, bound_error
from mecano.solve.time.increments import Weights, motion_tangents
from mecano.solve.time.massless import LightUnknowns
from mecano.solve.time.ordinary_steps import OrdinarySteps
from mecano.solve.time.repeated_steps import LARGER, RepeatedSteps
from mecano.solve.time.step import attempt
from mecano.solve.time.step_change import change_step
from mecano.solve.time.step_info import MOST_TURN, PATIENCE, TURNS_TOO_FAR, StepInfo, Trial
from mecano.solve.time.workspace import BEGIN, RENEWED, TANGENT, TRIAL, Workspace

if TYPE_CHECKING:
    from mecano.jit.entry import PackedCall
    from mecano.model.assembly import Observation
    from mecano.model.system import System
    from mecano.solve.events.shocks import Shocks
    from mecano.solve.linear.sparse import LinearSolver
    from mecano.solve.time.output import Output
    from mecano.solve.time.restart import Restart
    from mecano.solve.time.step_control import StepControl
    from mecano.solve.time.stride_arrays import Recorder

Substitution = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)


class GeneralizedAlpha:
    """The method for one system: coefficients, tolerances, linear solver. Holds no motion."""

    order: Literal[2] = 2
    turn = 0.8 * MOST_TURN  # rad: a step that is planned to turn a body by more would often fail

    def __init__(
        self,
        system: "System",
        linear: "LinearSolver",
        coefficients: Coefficients,
        length: float,
        tolerances: Tolerances,
        *,
        k: float | None,
        penalty: float | None,
        compliance: Compliance | None,
        duration: float,
        tolerance: float,
    ):
        self.system, self.linear, self.coefficients = system, linear, coefficients
        self.length, self.tolerances = length, tolerances
        self.k, self.penalty, self.duration, self.tolerance = k, penalty, duration, tolerance
        self.penalty_share, self.patience = system.penalty_share, PATIENCE
        self.compiled_restart: Restart | None = None
        # called in a step as often as the program may be late for a signal; may raise
        self.pause: Callable[[], object] = lambda: None
        self._massless = np.flatnonzero(system.massless)
        self.light = LightUnknowns(system, length)
        self._kind = system.numbering.kind.copy()
        self._kind[self._massless] = MASSLESS
        self.assembly = Assembly(system)
        self.equations, self.increment = self.assembly.residual[: system.n], np.zeros(system.n)
        self._no_shift = np.zeros(system.numbering.n_all)
        self._tangents = motion_tangents.bind(system.numbering.rotation_dof, system.numbering.n_q)
        self.workspace = Workspace(system, self.assembly, added=np.zeros((5, system.numbering.n_all)))
        self.use(compliance)

    def use(self, compliance: Compliance | None) -> None:
        """Give redundant constraints these compliances, or none (None), from now on."""
        self.compliance, of = compliance, self.system.numbering
        self.contradictions = Contradictions(self.system, self.length, compliance)
        self._rows = NO_ROWS if compliance is None else compliance.rows
        self.released = self.contradictions.released
        self._kind[of.n_q : of.n] = of.kind[of.n_q : of.n]
        self._kind[of.n_q + self.released] = RELEASED
        self._bind()

    def _bind(self):
        """Enter the constants of all steps into the workspace of the compiled step."""
        of, c, to = self.system.numbering, self.coefficients, self.tolerances
        new, kept = self.linear.calls(self.assembly.data, self.equations, self.increment)
        exact_rates = of.of_rates.astype(np.int64)
        exact_rates[self.released] = 0  # constraints on velocities hold exactly at the end of a step, except these
        self.workspace.point_to(**compliances_of_a_step(self.compliance))
        self.workspace.point_to(
            am=c.am, af=c.af, beta=c.beta, gamma=c.gamma, error=c.error, length=self.length, duration=self.duration,
            tolerance=self.tolerance, farthest_fixed=self.workspace.farthest_fixed / self.length,
            force_tolerance=to.force, constraint_tolerance=self._constraint_tolerance(),
            increment_tolerance=to.increment, most=to.max_iterations, increment=self.increment, kind=self._kind,
            n_massless=len(self._massless), massless=self._massless,
            fixed_k=self.k or 0.0, fixed_penalty=-1.0 if self.penalty is None else self.penalty,
            penalty_share=self.penalty_share, exact_rates=exact_rates,
            n_feedback=len(self.system.feedback), feedback=self.system.feedback,
            solve=new.function, solve_words=new.words,
            solve_results=np.zeros(len(multifrontal.solve.returns)), substitute=kept.function,
            substitute_words=kept.words,
        )  # fmt: skip
        self._packed = new, kept
        self.light.forget(self.workspace)

    def _constraint_tolerance(self):
        """Return the tolerance of the constraints, with which the reactions of redundant ones are accurate as well."""
        soft = self.compliance is not None and len(self.compliance.soft) > 0
        return min(self.tolerances.constraint, SHARING * SOFTNESS) if soft else self.tolerances.constraint

    def consistent(self, s: State, h: float, consistent: Consistent | None = None) -> tuple[State, Consistent]:
        """Return a consistent state for steps of size h, and its Consistent.

        Its positions have the deflection of the compliances, which they would otherwise oscillate about.
        """
        s, used = consistent_state(self.system, self.linear, s, h, self.contradictions, self.compliance, consistent)
        return (s if self.compliance is None else used.apply_compliance(s, self.compliance)), used

    def start(self, s: State, h: float, consistent: Consistent | None = None) -> tuple[State, History]:
        """Return a consistent state and history for steps of size h, at the start and after events.

        Projects the velocities, solves for accelerations and multipliers, and shifts both so that the multipliers
        are of second order from the first step (Arnold, Bruels & Cardona 2015): the constrained part of
        a_0 = q''_0 + (am - af) h q'''_0 and of v_0 - Ce h^2 q'''_0. Returns (state at t, history); the state
        returned has exact velocities, the history carries the shifts. ``consistent``, if given, is factored for s.
        Raises AssemblyError where constraints contradict one another.

        The accelerations of the history are those that a step of h resolves (modal_filter.py): those of a member that
        oscillates much faster would give it the velocity h q''_0 in the first step, with (omega h)^2 times its energy.
        """
        if self.compiled_restart is not None and consistent is None and (found := self.compiled_restart.start(s, h)):
            return found
        s, _ = self.consistent(s, h, consistent)
        none, at_once = np.zeros(self.system.n), self.system.numbering.kind[: self.system.n] == SIGNAL
        slope = np.where(at_once, h * s.v[: self.system.n], none)
        return s, self.restart(s, History(s.a, h, slope, none, 0, self._no_shift, 1.0), h)

    @cached_property
    def change_step(self) -> "PackedCall":
        """The PackedCall with which compiled code changes the step size in the workspace."""
        return change_step.call_from_compiled_code(self.workspace.record)

    def restart(self, s: State, history: History, h: float) -> History:
        """Return the history for a new step size h at an accepted state (step_change.py).

        Where the tangent is singular the history stays as it is; the next step fails with the reason.
        """
        w = self.workspace
        w.held = None
        self.light.begin(w, s)
        w.put_history(history)
        w.point_to(next_h=h, factored=0)
        change_step(w.record)
        tangent = w.state(TANGENT, s.phases)
        self.linear.solved(tangent)
        if w.record["code"][0] == CONVERGED:
            return w.new_history(BEGIN, w.v_shift.copy(), tangent)
        if not self._change_with_superlu(tangent):
            return replace(history, h=h, tangent=None)
        return w.new_history(BEGIN, w.v_shift.copy(), None)  # as after compiled code has failed, which keeps no tangent

    def repeated(self, s0: State, history: History, last: State) -> Callable[[float], Trial]:
        """Return a function of h that makes steps from ``s0`` like ``step``; ``last``: the end of one already made."""
        if self.system.n < LARGER:
            return lambda h: self.step(s0, history if h == history.h else self.restart(s0, history, h), h)
        return self._repeated_steps.begin(s0, history, last)

    @cached_property
    def _repeated_steps(self):
        return RepeatedSteps(self)

    def change_step_with(self, solve: Callable[[int], bool], substitute: Callable[[], object]) -> bool:
        """Finish a change of step size with matrices that Python solves; return whether all are regular.

        ``solve(stage)`` solves the assembled ``equations`` for the ``increment``, of the velocities (stage 0) or of the
        filter (1), and returns whether the matrix is regular; ``substitute()`` solves with that of the first again.
        """
        w = self.workspace
        own, of_python = w.record["substitute"][0], Substitution(lambda words, results: substitute())
        w.point_to(substitute=ctypes.cast(of_python, ctypes.c_void_p).value)
        regular = True
        try:
            while regular and w.record["code"][0] != CONVERGED:
                regular = solve(int(w.record["factored"][0]))
                w.record["factored"] += 1
                change_step(w.record)
        finally:
            w.point_to(substitute=own)  # the function of Python exists until here
        return regular

    def _change_with_superlu(self, tangent):
        """Change the step size with the factors of SuperLU; return whether the tangent is regular."""

        def solve(stage):
            return self.linear.solve(self.assembly.data, self.equations, self.increment, tangent).ok

        return self.change_step_with(solve, lambda: self.linear.solve_again(self.equations, self.increment))

    def bounded_error(self, s: State, history: History, info: StepInfo) -> float:
        """Return the local error of the step to ``s`` and ``history`` as error_bound.py bounds it."""
        w = self.workspace
        self._enter(info.began, history.h)
        w.put_state(TRIAL, s)
        w.history[TRIAL, : len(history.a)] = history.a
        bound_error(self.error_bound.record, w.record)
        return float(self.error_bound.record["bounded"][0])

    @cached_property
    def error_bound(self) -> ErrorBound:
        """The ErrorBound of the steps in the workspace."""
        return ErrorBound(self)

    def insist(self, strictly: bool) -> None:
        """Choose whether an iteration whose correction is rounding converges only if its residual is rounding, too.

        If so, corrections of massless unknowns that overshoot are shortened (newton.py).
        """
        self.workspace.record["strict"] = strictly
        if strictly:
            self.light.enter(self.workspace)
        else:
            self.light.search(self.workspace)

    def ordinary_steps(
        self, control: "StepControl", shocks: "Shocks", observation: "Observation", recorder: "Recorder | None"
    ) -> OrdinarySteps:
        """Return the OrdinarySteps of a time integration."""
        return OrdinarySteps(self, control, shocks, observation, recorder)

    def use_compiled_restarts(self) -> None:
        """Restart in compiled code from now on, where the model admits it."""
        from mecano.solve.time.restart import Restart  # not needed without sampled signals

        self.compiled_restart = Restart(self)

    def restarts_in_compiled_code(self) -> bool:
        """Return whether compiled code restarts at sampling times in the present phases."""
        return self.compiled_restart is not None and self.compiled_restart.prepare()

    def use_output(self, output: "Output") -> None:
        """Do nothing: the ``output`` of steps interpolates between their ends."""

    def _weights(self, history, h):
        """Return (Weights, penalty) of a step, of the deck or by the mean stiffness in the history."""
        c, penalty = self.coefficients, self.penalty_share * history.k if self.penalty is None else self.penalty
        cC, cM = c.gamma / (c.beta * h), (1 - c.am) / (1 - c.af) / (c.beta * h * h)
        if self.compliance is not None:
            penalty = min(penalty, self.compliance.largest_penalty(history.k))
            self.compliance.set_step(1.0 / cC, history.k)
        return Weights(self.k or history.k, cC, cM, h), penalty

    def step(self, s0: State, history: History, h: float) -> Trial:
        """Make a step of size h from ``s0`` with its ``history``; return (state, history, StepInfo). Pure."""
        self.prepare(s0, history, h)
        iterations = 0
        for by_velocity in (False, True):
            code = self._attempt(by_velocity)
            iterations += int(self.workspace.report[ITERATIONS])
            if code in (CONVERGED, NOT_FINITE):
                break
        return self.trial(s0, history, iterations)

    def prepare(self, s0: State, history: History, h: float) -> None:
        """Enter a state and its history into the workspace, for steps of size h."""
        if history.tangent is not None and self.linear.label is not history.tangent:
            self._factor(history.tangent, *self._weights(history, h))
        self.workspace.put_state(BEGIN, s0)
        if self.tolerance < np.inf and not self.workspace.record["knows_light"][0]:
            self.light.enter(self.workspace)
        self._enter(history, h)

    def _enter(self, history, h):
        """Enter a history into the workspace, for steps of size h."""
        (by, penalty), w = self._weights(history, h), self.workspace
        w.held = None
        w.put_history(history)
        w.point_to(h=h, k=by.k, penalty=penalty, cC=by.cC, cM=by.cM, usable=self.linear.kept, renewed=False)
        if self.compliance is not None:
            w.array("entry_values")[:] = self.compliance.in_tangent(by.k)

    def trial(self, s0: State, history: History, iterations: int) -> Trial:
        """Return the step in the workspace, from ``s0`` with ``history``, as (state, history, StepInfo)."""
        w, h, report = self.workspace, self.workspace.record["h"][0], self.workspace.report
        code, reached = int(w.record["code"][0]), tuple(report[FORCES : INCREMENT + 1].tolist())
        s = w.state(TRIAL, s0.phases, s0.memory)
        if code != CONVERGED:
            message = MESSAGES[code].format(int(report[ITERATIONS]))
            return s, history, StepInfo(False, iterations, reached, np.nan, history, message, FAILURES[code])
        change, turn, signalled, lag = [float(w.record[name][0]) for name in ("change", "turn", "signalled", "lag")]
        if turn > MOST_TURN:
            return s, history, StepInfo(False, iterations, reached, np.nan, history, TURNS_TOO_FAR)
        slips = np.zeros(self.system.n_l)  # rates of the deactivated rows, without the equations in their place
        if len(self.released):
            soften(float(w.record["cC"][0]), *self._rows, s.z[self.system.n_q : self.system.n], slips)
        if text := self.contradictions.at_the_end(s, h, slips):
            return s, history, StepInfo(False, iterations, reached, np.nan, history, text, Failure.CONTRADICTION)
        new = w.new_history(TRIAL, self._no_shift, self.linear.label)
        error = self.coefficients.error * h * h * change
        info = StepInfo(True, iterations, reached, error, history, lag=lag, signalled=signalled, plain=error)
        info.forces = self.assembly.forces.copy()
        return s, new, info

    def _attempt(self, by_velocity):
        """Run Newton's iteration from one guess, with the decisions left to Python; return a code of newton.py."""
        w, r = self.workspace, self.workspace.record
        r["begun"], r["by_velocity"] = False, by_velocity
        while True:
            self.pause()
            r["due"] = clock.monotonic() + self.patience
            renewed = bool(r["renewed"][0])
            attempt(r)
            if r["renewed"][0] and not renewed:
                self.linear.solved(w.state(RENEWED, w.phases.copy()))
            code = int(r["code"][0])
            if code == OTHERWISE:
                code = self._solve_with_superlu()
            if code not in (PAUSE, STALE):
                return code

    def _solve_with_superlu(self):
        """Solve the assembled equations by SuperLU, with row exchanges everywhere; return STALE or SINGULAR."""
        r = self.workspace.record
        solved = self.linear.solve(self.assembly.data, self.equations, self.increment, self.linear.label)
        r["code"] = STALE if solved.ok else SINGULAR
        r["usable"], r["pending"], r["stale"] = self.linear.kept, True, False
        return int(r["code"][0])

    def _assemble(self, s, by, penalty):
        """Assemble residual and tangent at ``s`` for the Weights ``by``, with the compliance."""
        T = self.workspace.array("T")
        self._tangents(s.start_spins, s, by, T)
        self.system.assemble(s, by.k, penalty, cK=1.0, cC=by.cC, cM=by.cM, T=T, into=self.assembly)
        if self.compliance is not None:
            n_q, n = self.system.n_q, self.system.n
            soften(by.k, *self._rows, s.z[n_q:n], self.equations[n_q:])
            self.compliance.soften_tangent(by.k, self.assembly.data)

    def _factor(self, tangent, by, penalty):
        """Factor the tangent at an earlier state."""
        self._assemble(tangent, by, penalty)
        self.linear.solve(self.assembly.data, np.zeros(self.system.n), self.increment, tangent)
