r"""Equilibrium at one point of a path: Newton's method on the residual at rest, with consistent phases of the elements.

The residual is :math:`r(q, \mu)` of loading.py, the tangent K alone, bordered by the constraints as in a step of time;
velocity constraints restrain the displacement from the start of the search (velocity_constraints.py).
A *drag* D makes a state creep towards equilibrium, :math:`r(q) + D (q - q_n) = 0`: implicit Euler of
:math:`D \dot q = -r`, pseudo-transient continuation (Kelley & Keyes, SIAM J. Numer. Anal. 35 (1998) 508-523).
"""

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from mecano.element_interface import BY_COMMAND
from mecano.errors import Failure
from mecano.model.assembly import Assembly
from mecano.model.numbering import ROTATION
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.diagnostics.scales import SMALL, Limits, Scales, Tolerances, balance, norms
from mecano.solve.events.compliance import Compliance, soften
from mecano.solve.events.events import EventMonitor, EventRecord
from mecano.solve.linear.iteration import SINGULAR, Exhausted, Iterated, iterate
from mecano.solve.linear.rounding import ROUNDING, at_rounding
from mecano.solve.linear.sparse import LinearSolver
from mecano.solve.statics.idle_states import IdleStates
from mecano.solve.statics.loading import Loading
from mecano.solve.statics.passed_events import apply_events
from mecano.solve.statics.velocity_constraints import NONE, Held, VelocityConstraints
from mecano.solve.time.increments import Weights, correct, largest, reach_of, tangents

MOST_TURN = 2.4  # rad in one step, so that angles of joints are followed
PHASE_CHANGES = 10  # rounds of phase changes at one point
CLOSED = 1e-9  # of the length scale, or rad: an event value below it does not count as crossed
POLISH = 4  # iterations beyond the tolerance while the residual falls
FARTHEST = 1e3  # length scales in one step: a greater change is a free motion driven by rounding errors
SLIGHT_DRAGS = 1e-7, 1e-5  # over the mean stiffness
SLIGHT_STEPS = 8  # steps with slight drag towards an equilibrium with a singular tangent
FARTHEST_SLIGHT = 0.3  # of the length scale, or rad: largest displacement of such a step
TOLERANCES = Tolerances(force=1e-9, constraint=1e-11, increment=1e-8)


Step: TypeAlias = "tuple[State, Held | None]"  # the beginning of a step, and the constraints on velocities there


@dataclass(slots=True)
class Status:
    """Status of the search for one equilibrium; ``ok`` if it was found."""

    ok: bool
    iterations: int
    norms: tuple[float, ...]  # force, constraint, increment over their tolerances
    change: float = 0.0  # largest displacement over the length, or rotation [rad]
    first: float = np.inf  # the same in the first iteration: the prediction of the tangent
    message: str = ""
    event_records: tuple[EventRecord, ...] = ()
    failure: Failure = Failure.NOT_CONVERGED  # if not ok


class Statics:
    """Solver of one equilibrium under a ``loading``; its only state is the ``assembly`` of the last evaluation."""

    def __init__(
        self,
        system: System,
        linear: LinearSolver,
        loading: "Loading",
        length: float,
        tolerances: Tolerances = TOLERANCES,
        *,
        k: float | None = None,
        penalty: float | None = None,
        compliance: Compliance | None,
        monitor: EventMonitor | None = None,
        past: bool = False,
    ):
        self.system, self.linear, self.loading, self.length = system, linear, loading, length
        self.tolerances, self.given_k, self.given_penalty, self.compliance = tolerances, k, penalty, compliance
        self.monitor = monitor or EventMonitor(system)
        self.rolling = VelocityConstraints(system, NONE if compliance is None else compliance.released)
        turns = system.numbering.kind[: system.n_q] == ROTATION
        self.weight = np.where(turns, length**2, np.where(system.signals, 0.0, 1.0))  # signals follow at once
        self.idle = IdleStates(system)
        self.assembly, self._increment = Assembly(system), np.zeros(system.n)
        self._T = np.tile(np.eye(3), (3 * len(system.numbering.rotation_dof), 1, 1))
        self._rotations = np.flatnonzero(system.numbering.kind[: system.n_q] == ROTATION)
        self._angles = _prescribed_angles(system)
        self._past = np.zeros(0, int) if past else system.places_of_past

    def scales(self, s: State) -> tuple[float, float]:
        """Return k and penalty of the constraints [N/m] at ``s``: as given, or the mean stiffness of the tangent."""
        mean = balance(self.system, s, self.length, 1.0, 0.0, 0.0, self.assembly)
        k = self.given_k or mean
        penalty = mean if self.given_penalty is None else self.given_penalty
        if self.compliance is None:
            return k, penalty
        self.compliance.set_step(1.0, mean)
        return k, min(penalty, self.compliance.largest_penalty(mean))

    def begin(self, s0: State) -> State:
        """Return a copy of ``s0`` at rest with zero rotation increments."""
        s = s0.copy()
        s.z[self._rotations] = 0.0
        s.v[:] = 0.0
        return s

    def evaluate(
        self, s: State, p: float, k: float, penalty: float, tangent: bool, step: "Step | None" = None
    ) -> tuple[float, float]:
        """Assemble residual (and tangent) at the parameter p; return the norms over their tolerances.

        ``step`` (see ``step``) is the start of the displacement that velocity constraints restrain; ``s`` by default.
        """
        system, of, assembly = self.system, self.system.numbering, self.assembly
        s0, held = step or self.step(s, s.phases)
        if tangent:
            tangents(of.rotation_dof, of.n_q, s.z, self._T)
        self.loading.assemble(s, p, k, penalty, cK=float(tangent), T=self._T, into=assembly)
        if tangent:
            self.idle.keep(assembly)
        if held is not None:
            moved = np.zeros(system.n_q) if s0 is s else self.displacement(s, s0)
            self.rolling.add(assembly, held, moved, k, penalty, tangent)
        if self.compliance is not None:
            n_q, n = system.n_q, system.n
            soften(k, *self.compliance.rows, s.z[n_q:n], assembly.residual[n_q:n])
            if tangent:
                self.compliance.soften_tangent(k, assembly.data)
        return self.norms(s, k)

    def step(self, s0: State, phases: np.ndarray) -> Step:
        """Return the beginning ``s0`` of a step, and its Held for elements in these ``phases`` (n_elements,)."""
        return s0, self.rolling.at(replace(s0, phases=phases))

    def norms(self, s: State, k: float) -> tuple[float, float]:
        """Return the norms (forces, constraints) of the assembled residual over their tolerances."""
        of, to = self.system.numbering, self.tolerances
        # there is no step size with which rounding errors become large forces: states that only they move are at rest
        limits = Limits(to.force, to.constraint, 1.0, np.inf, reach_of(s.z, of, self.length))
        scales = Scales(self.length, k, k, 1.0, 0.0)
        return norms(self.assembly.residual, self.assembly.size, of, s, scales, limits)[:2]

    def exhausted(self, s: State) -> Exhausted:
        """Return the function with which Newton's method decides if its corrections of ``s`` are at rounding."""
        of, limit = self.system.numbering, self.tolerances.increment

        def is_exhausted(increment, reduction, fresh):
            return at_rounding(increment * limit, reduction, fresh, reach_of(s.z, of, self.length), ROUNDING)

        return is_exhausted

    def move(self, s: State, s0: State, dz: np.ndarray, k: float) -> float:
        """Add the correction dz (n,) to ``s``, rotations relative to ``s0``; return its size over the tolerance."""
        system, of = self.system, self.system.numbering
        largest = correct(of, self.length, -dz, Weights(k, 0.0, 0.0, 0.0), s0, s)
        own = system.signals
        signals = np.abs(dz[: system.n_q][own]) / np.maximum(np.abs(s.z[: system.n_q][own]), SMALL)
        return max(largest, signals.max(initial=0.0)) / self.tolerances.increment

    def factor(self, b: np.ndarray) -> np.ndarray | None:
        """Return the solution (n,) with the assembled tangent and right-hand side b, or None if singular."""
        return self._increment if self.linear.solve(self.assembly.data, b, self._increment).ok else None

    def correct(self, s0: State, p: float, drag: float = 0.0) -> tuple[State, Status]:
        """Return (state, Status) of the equilibrium at p near ``s0``; with ``drag`` [N/m], of one step of creep.

        Elements whose event values cross zero change their phase, and the search continues from there. A wheel that
        starts to roll in this way rolls from ``s0`` on.
        """
        s, iterations, first = s0, 0, None
        reported: list[EventRecord] = []
        for _ in range(PHASE_CHANGES):
            s, found = self._newton(s, s0, p, drag)
            iterations += found.iterations
            first = found.first if first is None else first
            if not found.ok:
                break
            hit = self.monitor.values(s) > CLOSED * self.length
            if not hit.any():
                break
            s, event_records = apply_events(self, s, s0, hit)
            reported += event_records
        else:
            names = ", ".join(dict.fromkeys(f"{h.element} ({h.name})" for h in event_records))
            return s, Status(False, iterations, found.norms, message=f"contacts do not settle: {names}")
        ok, message, failure = found.ok, found.message, found.failure
        if ok and found.change > FARTHEST:
            ok, failure = False, Failure.NOT_CONVERGED
            message = f"a node moves by more than {FARTHEST:g} times the size of the mechanism in one step"
        if failure is Failure.NOT_CONVERGED and first > FARTHEST:  # the tangent is regular only by rounding errors
            message, failure = SINGULAR, Failure.SINGULAR
        return s, Status(ok, iterations, found.norms, found.change, first, message, tuple(reported), failure)

    def correct_singular(self, s0: State, p: float) -> tuple[State, Status]:
        """Return (state, Status) of an equilibrium near ``s0`` with a singular tangent, by steps with negligible drag.

        It exists if no force acts along the free motions. Forces that fade along a path may make these motions slightly
        unstable, which a greater drag prevents from growing out of rounding errors.
        """
        iterations = 0
        for drag in SLIGHT_DRAGS:
            s, found = self._creep(s0, p, drag)
            iterations += found.iterations
            if found.ok:
                break
        return s, replace(found, iterations=iterations)

    def _creep(self, s0, p, drag):
        """Return (state, Status) after steps with ``drag``, over the mean stiffness."""
        s, iterations = s0, 0
        reported: list[EventRecord] = []
        for _ in range(SLIGHT_STEPS):
            k, _ = self.scales(self.begin(s))
            s, found = self.correct(s, p, drag * k)
            iterations += found.iterations
            reported += found.event_records
            if not found.ok or found.change > FARTHEST_SLIGHT:
                break
            norms_ = self.evaluate(s.copy(), p, k, 0.0, False)
            if max(norms_) <= 1.0:
                return s, Status(True, iterations, (*norms_, found.norms[2]), found.change, np.inf, "", tuple(reported))
        text = "the tangent is singular, and forces act along a free motion"
        return s, Status(False, iterations, found.norms, found.change, message=text, failure=Failure.SINGULAR)

    def _newton(self, guess: State, s0: State, p: float, drag: float) -> tuple[State, Status]:
        """Iterate from ``guess``: (state, Status); rotation increments, drag and rolling are relative to ``s0``."""
        system, assembly, n, n_q = self.system, self.assembly, self.system.n, self.system.n_q
        s = self.begin(guess) if guess is s0 else guess.copy()
        k, penalty = self.scales(s)
        creep, steps, step = drag * self.weight, [], self.step(s0, s.phases)

        def evaluate(tangent):
            self.evaluate(s, p, k, penalty, tangent, step)
            if drag:
                assembly.residual[:n_q] += creep * self.displacement(s, s0)
                if tangent:
                    assembly.data[system.diagonal[:n_q]] += creep
            return self.norms(s, k)

        def solve(fresh):
            b, x = -assembly.residual[:n], self._increment
            if fresh:
                return self.factor(b)
            self.linear.solve_again(b, x)
            return x

        def move(dz):
            steps.append(self.move(s, s0, dz, k))
            return steps[-1]

        result = iterate(evaluate, solve, move, most=self.tolerances.max_iterations, exhausted=self.exhausted(s))
        first = steps[0] * self.tolerances.increment if steps else np.inf
        return s, self.status_of(result, s, s0, first)

    def status_of(self, result: Iterated, s: State, s0: State, first: float = np.inf) -> Status:
        """Return the Status of a Newton iteration from ``s0`` to ``s``; it fails if a rotation is too large."""
        of = self.system.numbering
        change = largest(self.displacement(s, s0), of.kind, of.n_q, self.length)
        ok, message, failure = result.ok, result.message, result.failure
        if ok and np.abs(s.z[self._rotations]).max(initial=0.0) > MOST_TURN:
            ok, failure = False, Failure.NOT_CONVERGED
            message = f"a body turns by more than {MOST_TURN} rad in one step"
        if ok and np.abs(self._angles_at(s) - self._angles_at(s0)).max(initial=0.0) > MOST_TURN:
            ok, failure = False, Failure.NOT_CONVERGED
            message = f"a prescribed angle changes by more than {MOST_TURN} rad in one step"
        return Status(ok, result.iterations, result.norms, change, first, message, (), failure)

    def _angles_at(self, s):
        """Return the prescribed angles [rad] at the time of ``s``; rotations do not contain their whole turns."""
        return self.system.observe(s).outputs[self._angles] if len(self._angles) else self._angles

    def displacement(self, s: State, s0: State) -> np.ndarray:
        """Return the displacements (n_q,) from ``s0``, to which the rotation increments of ``s`` are relative."""
        moved = s.z[: self.system.n_q] - s0.z[: self.system.n_q]
        moved[self._rotations] = s.z[self._rotations]
        return moved

    def polish(self, s: State, p: float) -> State:
        """Return the equilibrium ``s`` after further iterations, as long as they reduce the residual."""
        best, s0 = s, s
        k, penalty = self.scales(self.begin(s))
        trial, step = self.begin(s), self.step(s, s.phases)
        least = max(self.evaluate(trial, p, k, penalty, True, step))
        for _ in range(POLISH):
            x = self.factor(-self.assembly.residual[: self.system.n])
            if x is None:
                break
            far = self.move(trial, s0, x, k) * self.tolerances.increment > FARTHEST_SLIGHT  # along a free motion
            size = max(self.evaluate(trial, p, k, penalty, True, step))
            if far or not size < least:
                break
            least, best = size, trial.copy()
        return best

    def committed(self, s: State) -> State:
        """Commit the memories of ``s`` in place, as of an accepted point, and return it."""
        s.memory = self.system.commit(s)
        return self.without_past(s)

    def without_past(self, s: State) -> State:
        """Remove earlier inputs of signals from ``s`` in place, unless the path has a past, and return it."""
        s.memory[self._past] = 0.0
        return s


def _prescribed_angles(system):
    """Return the indices (n,) of the angles that joints prescribe among the outputs of the system."""
    places = np.arange(system.n_outputs)
    found = [b.outputs(places)[:, 0] for b in system.batches if b.kind.turns == BY_COMMAND]
    return np.concatenate([np.zeros(0, np.int64), *found])
