"""Static equilibria requested by a deck: a path of equilibria, or the initial state of a dynamic run."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mecano.analyses.prepare import AUTOMATIC, Prepared, or_default
from mecano.deck.build import places_of_laws
from mecano.model.assembly import Assembly
from mecano.model.output_limits import ended, has_end_conditions, watched_outputs
from mecano.model.sampler import Sampler, StaticSample
from mecano.model.state import State
from mecano.schema import Values
from mecano.solve.diagnostics.failure import worst_equations
from mecano.solve.diagnostics.scales import Tolerances
from mecano.solve.events.events import EventMonitor, NoEvents, Searching
from mecano.solve.statics.arc_length import ArcLength, Target
from mecano.solve.statics.continuation import Follower, Observer, Point, Steps
from mecano.solve.statics.loading import Clock, LoadFactor, Loading
from mecano.solve.statics.relaxation import Relaxation
from mecano.solve.statics.stability import freedom_text, is_floating
from mecano.solve.statics.static import CLOSED, Statics

FIRST_STEPS = 10  # of 'steps: automatic'
SMALLEST = 1e-4  # of the first step, for paths that have no 'minimum_step' in the deck
REST_HINT = "a saved time at which the body is not far from a stable equilibrium"
INCREMENT = 1e-8  # tolerance of the last correction, of the length scale, or rad


@dataclass
class Result:
    """The end of a path: the last Point, the reason of the end, warnings, and the loading."""

    point: Point
    reason: str
    warnings: tuple[str, ...]
    loading: Loading

    @property
    def where(self) -> str:
        """Name, value and unit of the parameter at the end."""
        return f"{self.loading.name} {self.point.parameter:.6g}{self.loading.unit}"

    def assemble(self, s: State, *, cK: float = 0.0, cC: float = 0.0, cM: float = 0.0) -> Assembly:
        """Assemble the system under the loads at the end, see ``System.assemble``."""
        return self.loading.assemble(s, self.point.parameter, cK=cK, cC=cC, cM=cM)


def follow(prepared: Prepared, observers: Sequence[Observer] = ()) -> Result:
    """Follow the equilibrium path of a deck with ``static``, and return a Result.

    ``observers`` are called with every Point. Raises ConvergenceError (exit code 3), which names the free motion, and
    NonFiniteError.
    """
    values, system = prepared.deck.values["static"], prepared.system
    path = {"arc_length": _arc, "relaxation": _relaxation, "steps": _steps}[values["method"]]
    if values["over"] == "load_factor":
        return _follow_path(prepared, loaded(prepared, values), path(prepared, values), 0.0, observers)
    first = Relaxation(1.0) if values["method"] == "relaxation" else Steps(1.0, FIRST_STEPS, SMALLEST, grow=True)
    start = _follow_path(prepared, loaded(prepared, values), first, 0.0, ())
    statics = _statics(prepared, values, Clock(system), past=True)
    return _follow_path(prepared, statics, _steps(prepared, values), values["start"], observers, start.point.state)


def start_in_words(prepared: Prepared) -> Iterator[str]:
    """Yield texts on the stability of the start configuration without loads and under all loads."""
    values = prepared.deck.values["static"] or prepared.deck.values["initial"]["static"]
    statics = loaded(prepared, values)
    follower, s = Follower(statics), statics.begin(_settled(prepared))
    for factor, words in ((0.0, "without loads"), (1.0, "under all loads, held in place")):
        stability = follower.stability(s, factor)
        if np.isfinite(statics.assembly.residual).all():
            text = freedom_text(prepared.system, s, stability, prepared.length)
        else:
            text = f"forces are not finite: {worst_equations(prepared.system, statics.assembly).strip()}"
        yield f"the start {words}: {text}"


def equilibrium(prepared: Prepared) -> tuple[str, ...]:
    """Bring ``prepared.state`` into static equilibrium, with the velocities of the deck, and return warnings.

    Residuals are reduced to rounding level, so that a run started there has no initial acceleration. Raises the errors
    of ``follow``.
    """
    values = prepared.deck.values["initial"]["static"]
    statics = loaded(prepared, values)
    relaxed = values["method"] == "relaxation"
    path = Relaxation(1.0) if relaxed else _steps(prepared, {**values, "end": 1.0, "minimum_step": SMALLEST})
    result = _follow_path(prepared, statics, path, 0.0, ())
    state = statics.polish(result.point.state, 1.0)
    state.a[:] = 0.0
    state.v[:] = prepared.state.v
    state.memory[prepared.system.places_of_past] = 0.0
    prepared.state = state
    return result.warnings


def rest(prepared: Prepared, state: State) -> tuple[State, tuple[str, ...]]:
    """Find the equilibrium to which ``state`` relaxes at fixed time, under all loads, with all phases kept.

    Closed latches stay closed; contacts stay closed or open. Returns the State, with reactions and zero velocities,
    and warnings. Raises ConvergenceError if there is no such equilibrium, NonFiniteError.
    """
    system = prepared.system
    statics = Statics(system, prepared.linear, Clock(system), prepared.length, compliance=prepared.compliance,
                      monitor=NoEvents(system))  # fmt: skip
    follower = Follower(statics)
    begun = statics.without_past(statics.begin(state))
    point = Relaxation(state.t, unstable_hint=REST_HINT).find(follower, begun)
    s, monitor = statics.polish(point.state, state.t), EventMonitor(system)
    crossed = monitor.values(s) > CLOSED * prepared.length
    kept = [f"{event.element} ({event.name})" for event in monitor.apply(s, crossed)[1]]
    s.memory = system.commit(s)
    warnings = [f"at rest these events would occur, and were ignored: {', '.join(kept)}"] if kept else []
    return s, (*warnings, *_stability_warnings(prepared, follower, point))


def _follow_path(prepared, statics, path, start, observers, state=None):
    follower = Follower(statics, tuple(observers), _end_of_range_check(prepared))
    first = follower.start(statics.without_past(_settled(prepared)) if state is None else state, start)
    point, reason = path.follow(follower, first)
    point.state.memory = statics.system.commit(point.state)
    missed = path.missed(point) if isinstance(path, ArcLength) else ()
    return Result(point, reason, (*missed, *_stability_warnings(prepared, follower, point)), statics.loading)


def _end_of_range_check(prepared):
    """Return a function (State, Observation) -> text on an element at the end of its range, or ""."""
    if not has_end_conditions(prepared.deck.values):
        return lambda state, observation: ""
    sampler = Sampler(prepared.system)
    ends = watched_outputs(prepared.deck.values, sampler, "end_conditions")
    return lambda state, observation: ended(ends, sampler.take(StaticSample(state), observation))


def _stability_warnings(prepared, follower, point):
    """Yield warnings: where stability was lost, and whether the last equilibrium is unstable or neutral.

    A model that nothing holds may float anywhere: this is not reported.
    """
    yield from follower.losses
    yield from follower.departures
    if not point.stability.stable and not is_floating(prepared.system, point.state, point.stability):
        loading, unstable = follower.statics.loading, point.stability.unstable > 0
        text = freedom_text(prepared.system, point.state, point.stability, prepared.length)
        state = "unstable" if unstable else "neutral: it may lie anywhere along a free motion"
        yield f"the equilibrium at {loading.name} {point.parameter:.6g}{loading.unit} is {state}; {text}"


def loaded(prepared: Prepared, values: Values) -> Statics:
    """Return the Statics with the load factor as parameter."""
    return _statics(prepared, values, LoadFactor(prepared.system, _settled(prepared)))


def _settled(prepared: Prepared) -> State:
    """Return the start at rest, with elements in the phases that its positions imply."""
    s = prepared.state.copy()
    s.v[:] = 0.0
    return _monitor(prepared).settle(s)


def _monitor(prepared: Prepared) -> EventMonitor:
    """Return the monitor of a path over the load factor, or of the search for the start of a motion or a path."""
    over_time = (prepared.deck.values["static"] or {}).get("over") == "time"
    return (Searching if over_time or prepared.deck.values["initial"]["static"] else EventMonitor)(prepared.system)


def _statics(prepared: Prepared, values: Values, loading: Loading, past: bool = False) -> Statics:
    newton, scale = values["newton"], values.get("scale", {})
    tolerances = Tolerances(newton["force_tolerance"], newton["constraint_tolerance"], INCREMENT,
                            newton["maximum_iterations"])  # fmt: skip
    return Statics(
        prepared.system, prepared.linear, loading, prepared.length, tolerances,
        k=or_default(scale.get("k", AUTOMATIC), None), penalty=or_default(scale.get("penalty", AUTOMATIC), None),
        compliance=prepared.compliance, past=past,
        monitor=EventMonitor(prepared.system) if past else _monitor(prepared),
    )  # fmt: skip


def _steps(prepared: Prepared, values: Values) -> Steps:
    count = or_default(values["steps"], FIRST_STEPS)
    over_time = values.get("over") == "time"
    minimum = values["minimum_step"] * (values["end"] - (values["start"] if over_time else 0.0)) / count
    through = places_of_laws(prepared.deck) if over_time else ()
    return Steps(values["end"], count, minimum, grow=values["steps"] == AUTOMATIC, through=through)


def _relaxation(prepared: Prepared, values: Values) -> Relaxation:
    return Relaxation(values["end"])


def _arc(prepared: Prepared, values: Values) -> ArcLength:
    count, until = or_default(values["steps"], FIRST_STEPS), values["until"]
    target = None if until is None else _target(prepared, until)
    return ArcLength(values["end"], count, values["minimum_step"], values["maximum_steps"], values["lowest"], target)


def _target(prepared, until):
    system = prepared.system
    names = [node.name for node in system.nodes]
    place = int(system.numbering.x[names.index(until["node"])])
    direction = np.array(until["direction"]) / np.linalg.norm(until["direction"])
    origin = prepared.state.z[place : place + 3].copy()
    return Target(until["node"], place, direction, origin, until["displacement"])
