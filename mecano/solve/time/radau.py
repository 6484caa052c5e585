r"""Radau IIA of order 5 on the Lie group, for smooth motion and tight tolerances (theory.md, section 2.6).

Within a step :math:`R = R_0 \exp(\hat\theta)`, :math:`x = x_0 + \theta` and :math:`\dot\theta = T^{-1}(\theta) v`
(Munthe-Kaas 1999). Increments and velocities are collocated at the three stages, where the equations of motion hold
together with the second rates of all constraints: with index 1 all components have order 5. At the end of the step
positions and velocities are projected on the constraints, in the metric of the mass, and accelerations and multipliers
follow from them (Hairer & Wanner 1996, IV.8 and VII.2).
"""

import time as clock
from collections.abc import Callable
from typing import Literal

import numpy as np

from mecano.errors import Failure
from mecano.model.assembly import Assembly, Observation
from mecano.model.numbering import MASSLESS
from mecano.model.state import RadauHistory, State
from mecano.model.system import System
from mecano.solve.diagnostics.scales import Tolerances, balance
from mecano.solve.events.compliance import Compliance, compliances_of_a_step
from mecano.solve.events.shocks import Shocks
from mecano.solve.linear.newton import CONVERGED, FAILURES, MESSAGES, PAUSE
from mecano.solve.linear.sparse import LinearSolver
from mecano.solve.time.consistent import Consistent, consistent_state
from mecano.solve.time.contradictions import Contradictions
from mecano.solve.time.increments import displaced, largest
from mecano.solve.time.output import Output
from mecano.solve.time.radau_output import interpolate_stages, sample_stages
from mecano.solve.time.radau_step import attempt
from mecano.solve.time.radau_steps import RadauSteps
from mecano.solve.time.radau_tableau import REAL
from mecano.solve.time.radau_tangent import tables_of
from mecano.solve.time.radau_workspace import RadauWorkspace
from mecano.solve.time.singular_position import LOST, ROUNDED, TAKE_PART, Amplification, cannot_pass
from mecano.solve.time.step_control import StepControl
from mecano.solve.time.step_info import MOST_TURN, PATIENCE, TURNS_TOO_FAR, StepInfo, Trial
from mecano.solve.time.stride_arrays import Recorder
from mecano.solve.time.workspace import BEGIN, TRIAL, Workspace


class Radau:
    """Radau IIA for one system: its tolerances and linear systems; it holds no motion.

    Has the same methods as GeneralizedAlpha.
    """

    order: Literal[5] = 5
    turn = 1.0  # rad in a step: with more, the frozen tangent converges slowly

    def __init__(
        self,
        system: System,
        linear: LinearSolver,
        length: float,
        control: StepControl,
        tolerances: Tolerances,
        k: float | None,
        compliance: Compliance | None,
    ):
        self.system, self.linear, self.length, self.control = system, linear, length, control
        self.tolerances, self.k, self.penalty = tolerances, k, 0.0
        self.patience = PATIENCE
        # called in a step as often as the program may be late for a signal; may raise
        self.pause: Callable[[], object] = lambda: None
        self.assembly, self.amplification = Assembly(system), Amplification(system, length)
        self.workspace = Workspace(system, self.assembly)
        self.workspace.array("kind")[np.flatnonzero(system.massless)] = MASSLESS
        self.stages = RadauWorkspace(
            system, length, violation=self.amplification.violation, tolerance=control.tolerance,
            constraint_tolerance=self.tolerances.constraint, **tables_of(system),
        )  # fmt: skip
        self.stages.mass.solve_by(linear)
        self.workspace.point_to(length=self.length, duration=control.duration, most=self.tolerances.max_iterations)
        self.use(compliance)

    def use(self, compliance: Compliance | None) -> None:
        """Set the compliances of redundant constraints; None for none."""
        self.compliance, system = compliance, self.system
        self.contradictions = Contradictions(system, self.length, compliance)
        self.workspace.point_to(**compliances_of_a_step(compliance))
        self.stages.mass.use(compliance)
        places = self.workspace.array("entry_places")
        entries = np.flatnonzero(places < system.nnz)
        by_multipliers = len(system.coupled_multipliers) or len(system.sensed_multipliers)
        self.stages.point_to(
            n_soft=len(entries), soft_entries=entries, soft_places=places[entries],
            projects=not (by_multipliers or len(self.contradictions.released)),
        )  # fmt: skip

    def consistent(self, s: State, h: float, consistent: Consistent | None = None) -> tuple[State, Consistent]:
        """Return a consistent state for steps of size h, and its Consistent."""
        return consistent_state(self.system, self.linear, s, h, self.contradictions, self.compliance, consistent)

    def start(self, s: State, h: float, consistent: Consistent | None = None) -> tuple[State, RadauHistory]:
        """Return a consistent state and the history for a first step of size h, at the start and after events.

        ``consistent``, if given, is factored for ``s``. Raises AssemblyError where constraints contradict one another.
        """
        s, used = self.consistent(s, h, consistent)
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

    def bounded_error(self, s: State, history: RadauHistory, info: StepInfo) -> float:
        """Return the local error of a step; stages resolve or damp oscillations, so no second estimate is needed."""
        return info.plain

    def _stiffness(self, s, h):
        return self.k or balance(self.system, s, self.length, 1.0, REAL / h, (REAL / h) ** 2)

    def step(self, s0: State, history: RadauHistory, h: float) -> Trial:
        """Make a step of size h from ``s0`` with its ``history``; return (state, history, StepInfo). Pure."""
        self.prepare(s0, history, h)
        self._attempt()
        return self.trial(s0, history)

    def prepare(self, s0: State, history: RadauHistory, h: float) -> None:
        """Enter a state and its history into the workspace, for steps of size h."""
        self.workspace.held = None
        self.workspace.put_state(BEGIN, s0)
        self.workspace.point_to(h=h, k=history.k)
        self.stages.put_history(history)
        self.stages.mass.use(self.compliance)

    def _attempt(self):
        """Make the step in the workspace, checking for signals of the process in between."""
        r = self.workspace.record
        r["begun"], r["code"] = False, PAUSE
        while r["code"][0] == PAUSE:
            self.pause()
            r["due"] = clock.monotonic() + self.patience
            attempt(r, self.stages.record)
            self.factored()

    def factored(self) -> None:
        """Note that compiled code has factored other matrices; raise the error of a factorization in Python."""
        self.linear.solved(None)
        self.stages.raise_error()

    def ordinary_steps(
        self, control: StepControl, shocks: Shocks, observation: Observation, recorder: Recorder | None
    ) -> RadauSteps:
        """Return the RadauSteps of a time integration."""
        return RadauSteps(self, shocks, observation, recorder)

    def use_compiled_restarts(self) -> None:
        """Do nothing: Python restarts."""

    def restarts_in_compiled_code(self) -> bool:
        """Return False, as ``use_compiled_restarts`` says."""
        return False

    def use_output(self, output: Output) -> None:
        """Let the ``output`` of steps interpolate between the stages."""
        own = output.record, self.workspace.record, self.stages.record
        sample, within = (entry.call_from_compiled_code(*own) for entry in (sample_stages, interpolate_stages))
        output.use_stages(sample, within, self._enter_stages)

    def _enter_stages(self, info):
        """Enter the stages of a step that Python made, for its output."""
        self.stages.put(info.stages, [self.system.observe(s) for s in info.stages], info.work)

    def trial(self, s0: State, history: RadauHistory) -> Trial:
        """Return the step in the workspace, from ``s0`` with ``history``, as (state, history, StepInfo)."""
        w, r = self.workspace.record[0], self.stages.record[0]
        code, iterations, increment = int(w["code"]), int(r["iterations"]), float(r["size"] / r["goal"])
        if code != CONVERGED:
            text, norms = MESSAGES[code].format(iterations), (0.0, 0.0, increment)
            return s0, history, StepInfo(False, iterations, norms, np.nan, history, text, FAILURES[code])
        h, stages = float(w["h"]), tuple(self.stages.stage(i, s0) for i in range(3))
        if r["projected"]:
            s = self.workspace.state(TRIAL, s0.phases, s0.memory)
            drift, amplified = float(r["drift"]), float(r["amplified"])
        else:
            s, drift, amplified = self._projected(stages[-1], h, history)
        text, failure = TURNS_TOO_FAR if w["turn"] > MOST_TURN else "", Failure.NOT_CONVERGED
        if not text:
            text, failure = self.contradictions.at_the_end(s, h, np.zeros(self.system.n_l)), Failure.CONTRADICTION
        norms = 0.0, drift, increment
        if text:
            return s, history, StepInfo(False, iterations, norms, np.nan, history, text, failure)
        least = min(amplified, history.least_amplified)
        own, error = self.stages, float(r["error"])
        new = RadauHistory(s.a, h, own.velocities.copy(), own.reactions.copy(), 1, history.k, amplified, least)
        info = StepInfo(
            True, iterations, norms, error, history, plain=error, stages=stages[:2], work=own.work.copy(),
        )  # fmt: skip
        return s, new, info

    def _projected(self, stage, h, history):
        """Return the last ``stage`` projected on the constraints, the size of that correction, and the amplification.

        The state has its accelerations and multipliers. Near a singular position it is the stage itself. Used for a
        step in which friction depends on reactions, or for which the fixed order of elimination does not suffice.
        """
        of, n_q = self.system.numbering, self.system.n_q
        consistent = Consistent(self.system, self.linear, stage, self.length, self.compliance)
        amplified = self.amplification.at(consistent)
        before, now = history.amplified / history.least_amplified, amplified / history.least_amplified
        if min(before, now) > LOST:
            places, drives = self.amplification.places(consistent, TAKE_PART), self.amplification.drives(consistent)
            raise cannot_pass(places, drives, stage.t, h)
        if now > max(before, ROUNDED):
            return displaced(stage, np.zeros(n_q), of), 0.0, amplified
        gap = self.system.constraint_derivatives(stage)[:, 0]
        gap[of.of_rates] = 0.0
        change = consistent.change(-gap)
        s = displaced(stage, change, of)
        consistent.project_velocity(s)
        consistent.accelerate(s)
        return s, largest(change, of.kind, n_q, self.length), amplified
