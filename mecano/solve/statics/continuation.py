r"""Numerical continuation of equilibria: choice of the next parameter, failed steps, end of the path.

Every method goes from ``Point`` to ``Point``:

* ``Steps``: the parameter (load factor or time) is given; steps are cut back if Newton's method fails or jumps.
* ``Relaxation`` (relaxation.py): the state creeps against a vanishing drag to a stable equilibrium.
* ``ArcLength`` (arc_length.py): the load factor is an unknown, so that limit points are passed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from mecano.errors import ConvergenceError, Failure, NonFiniteError, name_list
from mecano.model.assembly import Observation
from mecano.model.state import State
from mecano.solve.diagnostics.failure import of_equations, worst_equations
from mecano.solve.events.events import EventRecord
from mecano.solve.statics.stability import Stability, StabilityTest, freedom_text, motion_text
from mecano.solve.statics.static import Statics, Status
from mecano.solve.time.increments import largest

Observer: TypeAlias = "Callable[[Point], object]"  # called with every equilibrium of a path
GROWTH, SHRINK = 2.0, 0.25
BESIDE = 1e-4  # length scales or rad: if Newton's method moves a balanced state farther, it may have a free motion
ROUNDED = 1e-9  # of the largest force on an unknown: smaller sums of forces may be rounding errors
MOST_NAMED = 4
EASY = 12  # iterations up to which the next step grows
SOFTER = 1.5  # multiple of the predicted change above which the stiffness has fallen on the way
LEAP, NOTICEABLE = 4.0, 0.02  # a jump exceeds this multiple of the predicted change and this part of the length scale


@dataclass(slots=True)
class Point:
    """An equilibrium on a path; ``place`` increases along it: the parameter or the arc length."""

    state: State  # at rest
    parameter: float  # load factor, or time [s]
    place: float
    step: float  # from the last point
    iterations: int
    rejected: int
    norms: tuple[float, ...]
    stability: Stability
    observation: Observation  # of the state
    event_records: tuple[EventRecord, ...] = ()


@dataclass
class Follower:
    """Accepts the equilibria of ``statics`` as points of a path and passes each to the ``observers``."""

    statics: Statics
    observers: Sequence[Observer] = ()
    ended: Callable[[State, Observation], str] = lambda state, observation: ""
    """text on an element that ends the run at an equilibrium, "" if none"""
    stability_test: StabilityTest = field(init=False)
    losses: list[str] = field(default_factory=list)  # points at which stability was lost
    departures: list[str] = field(default_factory=list)  # unstable equilibria that were left
    last: Point | None = None
    resisting: Point | None = None  # the last point before further directions lost their stiffness

    def __post_init__(self):
        statics = self.statics
        self.stability_test = StabilityTest(
            statics.system, statics.length, statics.compliance is not None, statics.linear.analysis
        )

    def stability(self, s: State, p: float, drag: float = 0.0) -> Stability:
        """Return the Stability of ``s`` at the parameter p, from the tangent with ``drag`` [N/m] as added stiffness."""
        self.statics.evaluate(self.statics.begin(s), p, 1.0, 0.0, True)
        return self.stability_test(self.statics.assembly.data, drag)

    def accept(
        self,
        s: State,
        p: float,
        place: float,
        step: float,
        found: Status,
        rejected: int = 0,
        critical: float | None = None,
    ) -> Point:
        """Return the Point of a converged state, after the observers were called with it.

        ``critical``: the parameter at which stability was lost within the step, if known. Raises as ``refuse``.
        """
        statics = self.statics
        s = statics.committed(statics.begin(s))
        stability, observation = self.stability(s, p), self.observe(s, p)
        point = Point(
            s, p, place, step, found.iterations, rejected, found.norms, stability, observation, found.event_records
        )
        self._watch(point, critical)
        for observer in self.observers:
            observer(point)
        self.refuse(s, p, observation)
        return point

    def observe(self, s: State, p: float) -> Observation:
        """Return the Observation of an equilibrium at the parameter p."""
        self.statics.evaluate(s, p, 1.0, 0.0, False)
        return self.statics.system.observe(s, self.statics.assembly.forces)

    def refuse(self, s: State, p: float, observation: Observation) -> None:
        """Raise ConvergenceError if an element cannot continue from the equilibrium ``s`` at the parameter p."""
        if text := self.ended(s, observation):
            raise ConvergenceError(
                f"cannot continue from {self.statics.loading.name} {p:.6g}{self.statics.loading.unit}: {text}"
            )

    def _watch(self, point, critical):
        """Record a loss of stability; in steps of the parameter it is located by interpolating the least stiffness.

        A direction without stiffness that becomes unstable may have been unstable before, within rounding: stability is
        then lost after the last point at which it had a stiffness.
        """
        last, resisting, now = self.last, self.resisting, point.stability
        self.last = point
        if resisting is None or now.neutral <= resisting.stability.neutral:
            self.resisting = point
        if last is None or not 0 <= last.stability.unstable < now.unstable:
            return
        if resisting is not None and now.neutral < last.stability.neutral:
            last = resisting
        before, after, of = last.stability.stiffness, now.stiffness, self.statics.loading
        text = f"between {of.name} {last.parameter:.6g} and {point.parameter:.6g}{of.unit}"
        if before > 0.0 > after and point.place == point.parameter:
            critical = last.parameter + (point.parameter - last.parameter) * before / (before - after)
        if critical is not None:
            text += f", near {critical:.6g},"
        motion = motion_text(self.statics.system, point.state, point.stability.shape, self.statics.length)
        self.losses.append(f"{text} the equilibrium becomes unstable: {motion}")

    def find(self, s0: State, p: float) -> tuple[State, Status]:
        """Return (state, Status) of the equilibrium at the parameter p near ``s0``, also for singular tangents."""
        s, found = self.statics.correct(s0, p)
        neutral = self.last is not None and self.last.stability.neutral > 0
        if found.ok and found.change > BESIDE and neutral and not self._balanced(s0, p):
            beside, slight = self.statics.correct_singular(s0, p)
            if slight.ok and (change := self._apart(beside, s0)) < 0.5 * found.change:
                slight.change, slight.first = change, found.first  # Newton's method had followed a free motion
                return beside, slight
        if found.ok and not (found.change > BESIDE and self._only_rounding(s0, p) and self._free(s0, p)):
            return s, found
        wanders = found.failure is Failure.NOT_CONVERGED and max(found.norms[:2], default=np.inf) <= 1.0
        if found.ok or found.failure is Failure.SINGULAR or wanders or self._balanced(s0, p):
            return self.statics.correct_singular(s0, p)
        return s, found

    def _apart(self, s, s0):
        """Return the largest displacement from ``s0`` to ``s`` over the length, or rotation [rad]."""
        of = self.statics.system.numbering
        moves = np.linalg.norm(s.z[of.x[:, None] + np.arange(3)] - s0.z[of.x[:, None] + np.arange(3)], axis=1)
        cosines = 0.5 * (np.einsum("rij,rij->r", s.R, s0.R) - 1.0)
        turns = np.arccos(np.clip(cosines, -1.0, 1.0))
        return max(moves.max(initial=0.0) / self.statics.length, turns.max(initial=0.0))

    def _only_rounding(self, s, p):
        """Return whether ``s`` is an equilibrium, however soft, whose unbalanced forces are at rounding level."""
        if not self._balanced(s, p):
            return False
        of = np.flatnonzero(self.statics.weight)  # signals have none
        arm, assembly = np.sqrt(self.statics.weight[of]), self.statics.assembly
        largest = np.abs(assembly.residual[of] / arm).max(initial=0.0)
        return largest <= ROUNDED * (assembly.size[of] / arm).max(initial=0.0)

    def _free(self, s, p):
        """Return whether some motion of ``s`` has no stiffness, to rounding."""
        return self.stability(s, p).neutral > 0

    def _balanced(self, s, p):
        """Return whether ``s`` is an equilibrium, which Newton's method leaves if K is regular only by rounding errors.

        It then moves along a free motion by a distance that rounding errors, and so the order of the unknowns,
        determine.
        """
        k, _ = self.statics.scales(self.statics.begin(s))
        return max(self.statics.evaluate(self.statics.begin(s), p, k, 0.0, False)) <= 1.0

    def start(self, s: State, p: float) -> Point:
        """Return the first Point, at the parameter p: ``s`` or an equilibrium near it. Raises ConvergenceError."""
        begun = self.statics.begin(s)
        k, _ = self.statics.scales(begun)
        residuals = self.statics.evaluate(begun.copy(), p, k, 0.0, False)
        if max(residuals) <= 1.0:
            return self.accept(begun, p, p, 0.0, Status(True, 0, (*residuals, 0.0)))
        s, found = self.find(begun, p)
        if not found.ok:
            raise self.failure(p, found, begun, p)
        return self.accept(s, p, p, 0.0, found)

    def failure(
        self, p: float, found: Status, last: State, last_p: float, hint: str = ""
    ) -> ConvergenceError | NonFiniteError:
        """Return the error for a failed search after ``last``: place, cause, free motion, worst equations."""
        statics, system = self.statics, self.statics.system
        of, bad = statics.loading, np.flatnonzero(~np.isfinite(statics.assembly.residual[: system.n]))
        head = f"no equilibrium was found at {of.name} {p:.6g}{of.unit}: {found.message}\n"
        statics.evaluate(statics.begin(last), p, 1.0, 0.0, True)
        growing = statics.idle.growing(statics.assembly)
        worst = worst_equations(system, statics.assembly)
        equations = f"most out of balance after {of.name} {last_p:.6g}{of.unit}:\n{worst}"
        if found.failure is Failure.NOT_FINITE:
            return of_equations(NonFiniteError(head + equations), system, bad)
        stability = self.stability(last, last_p)
        free = f"at {of.name} {last_p:.6g}{of.unit}: {freedom_text(system, last, stability, statics.length)}"
        if growing:
            free += f"\n{name_list(growing, MOST_NAMED)} cannot rest: the rate vanishes at no position"
            hint = f"an input of this state that is zero at rest; {hint}"
        elif stability.neutral > 0 and found.failure is Failure.SINGULAR:
            hint = f"a joint or spring that holds this motion; {hint}"
        return ConvergenceError(f"{head}{free}\n{equations}\nwhat to try: {hint}{of.hint}")


@dataclass
class Steps:
    """Continuation to ``end`` in ``count`` equal steps, smaller if necessary; with ``grow``, also larger ones.

    Steps that grow end at the places ``through``.
    """

    end: float
    count: int
    minimum: float
    grow: bool = False
    through: Sequence[float] = ()
    hint: str = "the units of loads and stiffness (N, N/m, Pa)"

    def follow(self, follower: Follower, point: Point) -> tuple[Point, str]:
        """Return (last Point, reason of the end). Raises ConvergenceError, NonFiniteError."""
        start, equal = point.parameter, (self.end - point.parameter) / self.count
        between = self.through if self.grow else [start + i * equal for i in range(1, self.count)]
        targets = [*(p for p in between if start < p < self.end), self.end]
        h = equal
        for target in targets:
            while point.parameter < target:
                point, h = self._advance(follower, point, h, target)
                h *= GROWTH if point.iterations <= EASY and not point.rejected else 1.0
        return point, "the end was reached"

    def _advance(self, follower, point, h, target):
        """Return the next Point and the step to it."""
        rejected = 0
        while True:
            remaining = target - point.parameter
            h = remaining if h >= 0.9999 * remaining else h
            p = target if h == remaining else point.parameter + h
            s, found = follower.find(point.state, p)
            if found.ok and found.change > NOTICEABLE and self._leaps(follower, point, s, found):
                found.ok = False
                found.message = "the next equilibrium is far from the last one, as beyond a limit point"
            if found.ok:
                return follower.accept(s, p, p, h, found, rejected), h
            if h * SHRINK < self.minimum:
                free = point.stability.neutral > 0 and found.failure is not Failure.SINGULAR
                hint = f"{self.hint}; {follower.statics.loading.beyond}"
                hint = f"a joint or spring that holds motions without stiffness; {hint}" if free else hint
                raise follower.failure(p, found, point.state, point.parameter, hint)
            h, rejected = h * SHRINK, rejected + 1

    def _leaps(self, follower, point, s, found):
        """Return whether the step to ``s`` leads beyond a limit point, from where nothing leads back.

        Newton's method is asked for the way back from a first step, which may be far too long, and where the stiffness
        has fallen on the way. An equilibrium elsewhere, at the parameter of the last one, is beyond a snap, unless a
        free motion leads there.
        """
        if found.change > LEAP * found.first:
            return True
        if point.stability.neutral > 0 or found.change <= SOFTER * found.first and point.step > 0.0:
            return False
        statics, of = follower.statics, follower.statics.system.numbering
        s0, back = statics.correct(statics.begin(s), point.parameter)
        away = statics.displacement(s, point.state) + statics.displacement(s0, s)
        return back.ok and largest(away, of.kind, of.n_q, statics.length) > 0.5 * found.change
