r"""Paths of equilibria: which parameter to try next, what to do when Newton fails, where to stop.

Every way goes from ``Point`` to ``Point``:

* ``Steps``: the parameter (load factor or time) is given; steps are cut back where Newton fails or leaps.
* ``Relaxation`` (relaxation.py): the state creeps against a drag that fades, down to a stable equilibrium.
* ``ArcLength`` (arc_length.py): the load factor is an unknown, and limit points are passed.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from mecano.errors import ConvergenceError, Failure, NonFiniteError
from mecano.solve.diagnostics.failure import worst_equations
from mecano.solve.statics.stability import Judge, Stability, freedom, words
from mecano.solve.statics.static import Found

GROWTH, SHRINK = 2.0, 0.25
EASY = 12  # iterations up to which the next step grows
LEAP, NOTICEABLE = 4.0, 0.02  # farther off than so many predictions, and than so much of the length, is a leap


@dataclass(slots=True)
class Point:
    """An equilibrium on a path; ``place`` increases along it: the parameter, or the length of the arc."""

    state: object  # State, at rest
    parameter: float  # load factor, or time [s]
    place: float
    step: float  # from the last point
    iterations: int
    rejected: int
    norms: tuple
    stability: Stability
    event_records: tuple = ()


@dataclass
class Follower:
    """Accepts the equilibria of ``statics`` as points of a path; ``observers`` are told of each."""

    statics: object
    observers: tuple = ()
    ended: Callable = lambda state: ""  # text on an element that can go no further in a state, its outputs up to date
    judge: Judge = field(init=False)
    losses: list = field(default_factory=list)  # texts: where stability was lost on the way
    departures: list = field(default_factory=list)  # texts: unstable equilibria that were left on the way
    last: Point | None = None

    def __post_init__(self):
        self.judge = Judge(self.statics.system, self.statics.length, self.statics.compliance is not None)

    def stability(self, s, p, drag=0.0):
        """Stability of ``s`` at the parameter p, from the tangent there, with ``drag`` [N/m] as a further stiffness."""
        self.statics.evaluate(self.statics.begin(s), p, 1.0, 0.0, True)
        return self.judge(self.statics.system.data, drag)

    def accept(self, s, p, place, step, found, rejected=0, critical=None):
        """The Point of a converged state; its outputs stand in the system when the observers are told.

        ``critical``: the parameter at which stability was lost within the step, where it is known.
        """
        statics = self.statics
        s = statics.settled(statics.begin(s))
        stability = self.stability(s, p)
        statics.evaluate(s, p, 1.0, 0.0, False)
        statics.system.observe(s)
        point = Point(s, p, place, step, found.iterations, rejected, found.norms, stability, found.event_records)
        self._watch(point, critical)
        for observer in self.observers:
            observer(point)
        self.refuse(s, p)
        return point

    def refuse(self, s, p):
        """Raise ConvergenceError where an element can go no further in the equilibrium ``s`` at the parameter p."""
        self.statics.system.observe(s)
        if text := self.ended(s):
            raise ConvergenceError(
                f"cannot continue from {self.statics.loading.name} {p:.6g}{self.statics.loading.unit}: {text}"
            )

    def _watch(self, point, critical):
        """Note where the path lost stability; in steps of the parameter, by interpolation of the least stiffness."""
        last, self.last = self.last, point
        if last is None or not 0 <= last.stability.unstable < point.stability.unstable:
            return
        before, after, of = last.stability.stiffness, point.stability.stiffness, self.statics.loading
        text = f"between {of.name} {last.parameter:.6g} and {point.parameter:.6g}{of.unit}"
        if before > 0.0 > after and point.place == point.parameter:
            critical = last.parameter + (point.parameter - last.parameter) * before / (before - after)
        if critical is not None:
            text += f", near {critical:.6g},"
        motion = words(self.statics.system, point.state, point.stability.shape, self.statics.length)
        self.losses.append(f"{text} the equilibrium becomes unstable: {motion}")

    def find(self, s0, p):
        """Equilibrium at the parameter p near ``s0``: (state, Found), where the tangent is singular too."""
        s, found = self.statics.correct(s0, p)
        return (
            self.statics.correct_singular(s0, p) if found.failure is Failure.SINGULAR and not found.ok else (s, found)
        )

    def start(self, s, p):
        """The first Point, at the parameter p: ``s`` or the equilibrium next to it. Raises ConvergenceError."""
        begun = self.statics.begin(s)
        k, _ = self.statics.scales(begun)
        residuals = self.statics.evaluate(begun.copy(), p, k, 0.0, False)
        if max(residuals) <= 1.0:
            return self.accept(begun, p, p, 0.0, Found(True, 0, (*residuals, 0.0)))
        s, found = self.find(begun, p)
        if not found.ok:
            raise self.failure(p, found, begun, p)
        return self.accept(s, p, p, 0.0, found)

    def failure(self, p, found, last, last_p, hint=""):
        """The error that says where and why no equilibrium was found after ``last``, with the motion that is free."""
        statics, system = self.statics, self.statics.system
        of = statics.loading
        head = f"no equilibrium was found at {of.name} {p:.6g}{of.unit}: {found.message}\n"
        statics.evaluate(statics.begin(last), p, 1.0, 0.0, False)
        equations = f"most out of balance after {of.name} {last_p:.6g}{of.unit}:\n{worst_equations(system)}"
        if found.failure is Failure.NOT_FINITE:
            return NonFiniteError(head + equations)
        free = freedom(system, last, self.stability(last, last_p), statics.length)
        return ConvergenceError(f"{head}at {of.name} {last_p:.6g}{of.unit}: {free}\n{equations}\nwhat to try: {hint}")


@dataclass
class Steps:
    """From the first point to ``end`` by ``count`` steps, smaller ones where needed; with ``grow`` longer ones too."""

    end: float
    count: int
    minimum: float
    grow: bool = False
    hint: str = (
        "the units of loads and stiffness (N, N/m, Pa); method: arc_length past a limit point; "
        "method: relaxation, which lets a mechanism fall into place"
    )

    def follow(self, follower, point):
        """(last Point, reason). Raises ConvergenceError, NonFiniteError."""
        start, equal = point.parameter, (self.end - point.parameter) / self.count
        targets = [self.end] if self.grow else [start + i * equal for i in range(1, self.count)] + [self.end]
        h = equal
        for target in targets:
            while point.parameter < target:
                point, h = self._advance(follower, point, h, target)
                h *= GROWTH if point.iterations <= EASY and not point.rejected else 1.0
        return point, "the end was reached"

    def _advance(self, follower, point, h, target):
        """The next Point and the step that led to it."""
        rejected = 0
        while True:
            left = target - point.parameter
            h = left if h >= 0.9999 * left else h
            p = target if h == left else point.parameter + h
            s, found = follower.find(point.state, p)
            if found.ok and found.change > max(NOTICEABLE, LEAP * found.first):
                found.ok = False
                found.message = "the next equilibrium is far from the last one, as beyond a limit point"
            if found.ok:
                return follower.accept(s, p, p, h, found, rejected), h
            if h * SHRINK < self.minimum:
                raise follower.failure(p, found, point.state, point.parameter, self.hint)
            h, rejected = h * SHRINK, rejected + 1
