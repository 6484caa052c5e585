"""Preparation of a run: from a checked deck to a model with an initial state and a time integration."""

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cached_property
from typing import Any

from mecano.analyses.carry_over import carried_over
from mecano.analyses.failure_text import locating
from mecano.analyses.initial_velocities import changed_velocities
from mecano.analyses.lint import suspicious_model
from mecano.deck.build import build, set_velocities, time_breakpoints, time_landmarks, time_samples
from mecano.deck.deck import Deck
from mecano.deck.run_size import LOOSEST, size_warnings
from mecano.deck.sections import finest_step
from mecano.deck.short_bumps import turn_over_bumps
from mecano.errors import AssemblyError, DeckError, Problem, name_list
from mecano.immutable import mutable
from mecano.model.model import length_scale, title_of
from mecano.model.sampler import row_size
from mecano.model.state import State
from mecano.model.system import System
from mecano.process.interrupt import call_interruptibly
from mecano.results.layout import STEPS
from mecano.schema import Values
from mecano.solve.diagnostics.joint_redundancy import by_same_joints, redundant_groups
from mecano.solve.diagnostics.mobility import Analysis, Group, analyse
from mecano.solve.diagnostics.scales import Tolerances
from mecano.solve.events.compliance import Compliance, compliance
from mecano.solve.linear.sparse import LinearSolver, pattern_of
from mecano.solve.time.coefficients import Coefficients
from mecano.solve.time.generalized_alpha import GeneralizedAlpha
from mecano.solve.time.initial_assembly import assemble_start, most_off
from mecano.solve.time.run_state import Method, RunState
from mecano.solve.time.signals import refuse_circles
from mecano.solve.time.step_control import StepControl
from mecano.solve.time.time_integration import Accepted, TimeIntegrator

METHODS = {
    "generalized_alpha": Coefficients.generalized_alpha,
    "hht": Coefficients.hht,
    "newmark": Coefficients.newmark,
}
ORDERS = {"radau": 5}  # 2 for the others
SMALLEST_STEP = 1e-7  # of the first step, unless given in the deck
RESTART = 10.0  # first steps: longest one behind a corner of a law of time, or a condition, in an adaptive run
OF_DELAY = 0.125  # longest adaptive step, so that the input of a delay is known at enough instants
MOVED = 1e-6  # of the length scale: larger displacements by the assembly are reported
MOST_NAMES = 8  # constraints named in a warning
AUTOMATIC = "automatic"
SHARE_OF_TOLERANCE = 0.01  # of an adaptive run: residual forces relative to those at work


@mutable
class Prepared:
    """A model ready for analysis, with its initial state and diagnostics."""

    deck: Deck
    system: System
    linear: LinearSolver
    length: float  # [m]
    state: State  # positions assembled, velocities of the deck
    displacement: float  # [m] largest correction of the deck's positions by the assembly
    analysis: Analysis  # redundant constraints and mechanisms
    compliance: Compliance | None  # of redundant constraints
    carried: tuple[str, ...] = ()  # values carried over from another run
    off: str = ""  # the constraint that the deck's positions violate most, if the assembly moved them

    @cached_property
    def redundant(self) -> tuple[Group, ...]:
        """Groups of redundant constraints at the state, with all joints involved; one Group for the same joints."""
        return by_same_joints(redundant_groups(self.system, self.state, self.length, self.analysis))

    @cached_property
    def stiff_compliance(self) -> Compliance | None:
        """The compliance for analyses without steps, in which no forces make it stiffer."""
        end = _end_of_loads(self.deck)
        return compliance(self.system, self.state, self.length, self.analysis, end) if self.compliance else None

    def at(self, state: State) -> "Prepared":
        """Return the same model at another state, whose phases may make other constraints redundant."""
        analysis, soft = _redundancy(self.deck, self.system, state, self.length)
        return replace(self, state=state, analysis=analysis, compliance=soft)


def prepare(deck: Deck, compile_ahead: Callable[[System], object] = lambda system: None) -> Prepared:
    """Build the model of a checked deck, assemble its positions, and return a Prepared.

    ``compile_ahead(system)`` may compile code that is needed later. The call can be interrupted by a signal. Raises
    AssemblyError, and DeckError for a model without degrees of freedom.
    """
    with locating(deck):
        return call_interruptibly(_prepare, deck, compile_ahead)


def _prepare(deck: Deck, compile_ahead: Callable[[System], object]) -> Prepared:
    system = System(build(deck))
    _refuse_fixed(deck, system)
    compile_ahead(system)
    linear, values = LinearSolver(pattern_of(system)), deck.values["time"] or deck.values["static"]
    wanted = (values.get("adaptive") or values).get("length_scale", AUTOMATIC)
    length = or_default(wanted, length_scale(system.nodes))
    begin, carried = carried_over(deck, system, system.initial_state(values["start"]), length)
    state, displacement = assemble_start(system, linear, begin, length)
    if problems := system.inadmissible(state):
        raise AssemblyError("the initial positions were assembled the wrong way round:\n  " + "\n  ".join(problems))
    set_velocities(deck, system, state)
    state.v += begin.v
    _refuse_circles(deck, system, state)
    if any(event.shock and event.condition for batch in system.batches for event in batch.kind.events):
        from mecano.analyses.grips_at_start import with_closed_grips  # few models have grips

        state = with_closed_grips(system, state)
    off = most_off(system, begin, length) if displacement > MOVED * length else ""
    analysis, soft = _redundancy(deck, system, state, length)
    return Prepared(deck, system, linear, length, state, displacement, analysis, soft, tuple(carried), off)


def _redundancy(deck, system, state, length):
    """Return the Analysis of the constraints at a state, and the Compliance of the redundant ones, or None."""
    analysis, time, static = analyse(system, state, length), deck.values["time"], deck.values["static"]
    in_statics = static and static["over"] == "time"
    step = time["step"] if time and not in_statics else None
    return analysis, compliance(system, state, length, analysis, _end_of_loads(deck), step)


def _end_of_loads(deck):
    """Return the end [s] of a run or of statics over the time; None without either."""
    time, static = deck.values["time"], deck.values["static"]
    over = static if static and static["over"] == "time" else time
    return over["end"] if over else None


def _refuse_fixed(deck, system):
    """Raise DeckError for a model without degrees of freedom."""
    if not system.n_q:
        text = "nothing can move: every node is fixed, or held by a joint to one that is"
        mark = deck.mark("nodes", system.nodes[0].name)
        raise DeckError([Problem(text, mark, "free a node, or a joint to 'ground'")])


def _refuse_circles(deck, system, state):
    """Raise AssemblyError, with line and column, for signals that depend on one another in a circle."""
    try:
        refuse_circles(system, state)
    except AssemblyError as error:
        signals = deck.values["signals"]
        titles = {title_of(d["type"], name): name for name, d in signals.items()}
        names = [titles[title] for title in error.elements if title in titles]
        marks = [deck.mark("signals", name) for name in names]
        mark = f"{marks[0]}: " if marks and marks[0] else ""
        held = next((name for name in names if signals[name].get("initial", False) is None), None)
        hint = f"; an 'initial' value of '{held}' breaks the loop" if held else ""
        raise AssemblyError(f"{mark}{error}{hint}", error.failure) from None


def integrator_of(prepared: Prepared, observers: Iterable[Callable[[Accepted], object]] = ()) -> TimeIntegrator:
    """Return the TimeIntegrator of a prepared model, with the method and step control of the deck."""
    deck, system, values = prepared.deck, prepared.system, prepared.deck.values["time"]
    newton, scale = values["newton"], values["scale"]
    tolerances = Tolerances(
        force=force_tolerance(values),
        constraint=newton["constraint_tolerance"],
        max_iterations=newton["maximum_iterations"],
    )
    control = _between_delays(control_of(values), deck)
    duration = values["end"] - values["start"]
    k, penalty = or_default(scale["k"], None), or_default(scale["penalty"], None)
    method: Method
    if values["method"] == "radau":
        from mecano.solve.time.radau import Radau  # no ordinary run needs it (docs/architecture.md, Start)

        method = Radau(system, prepared.linear, prepared.length, control, tolerances, k, prepared.compliance)
    else:
        method = GeneralizedAlpha(
            system, prepared.linear, METHODS[values["method"]](values["rho_inf"]), prepared.length, tolerances,
            k=k, penalty=penalty, compliance=prepared.compliance, duration=duration,
            tolerance=control.tolerance,
        )  # fmt: skip
    if control.adaptive:
        method.turn = min(method.turn, turn_over_bumps(deck))
    return TimeIntegrator(
        system, method, control, tuple(observers), time_breakpoints(deck), values["rest_speed"],
        most_located=values["located_events"], landmarks=time_landmarks(deck) if control.adaptive else (),
        longest_restart=RESTART * values["step"] if control.adaptive else math.inf, samples=time_samples(deck),
    )  # fmt: skip


def force_tolerance(time: Values) -> float:
    """Return the tolerance of Newton's iteration for residual forces in the checked section ``time``.

    Residuals of a step are forces like any other, whose effects add up: adaptive ones are at most a share of the
    tolerance of the run.
    """
    own, adaptive = time["newton"]["force_tolerance"], time["adaptive"]
    return min(own, SHARE_OF_TOLERANCE * adaptive["tolerance"]) if adaptive else own


def control_of(values: Values) -> StepControl:
    """Return the step control specified by the checked section ``time``."""
    step, adaptive = values["step"], values["adaptive"]
    smallest = max(SMALLEST_STEP * step, finest_step(values))
    if adaptive is None:
        return StepControl.fixed(step, smallest)
    duration = values["end"] - values["start"]
    return StepControl(
        min(adaptive["tolerance"], LOOSEST), duration,
        minimum=or_default(adaptive["minimum_step"], smallest),
        maximum=or_default(adaptive["maximum_step"], duration / 20),
        order=ORDERS.get(values["method"], 2),
    )  # fmt: skip


def _between_delays(control, deck):
    """Return the step control in which adaptive steps are a part of the shortest delay, or some first steps.

    Errors of steps do not include those of delays, which interpolate between the ends of earlier steps.
    """
    delays = [d["time"] for d in deck.values["signals"].values() if d["type"] == "delay"]
    if not (delays and control.adaptive):
        return control
    first = deck.values["time"]["step"] * (1.0 if deck.values["time"]["method"] == "radau" else RESTART)
    return replace(control, maximum=min(control.maximum, max(OF_DELAY * min(delays), first)))


def or_default(value: Any, otherwise: Any) -> Any:
    """Return ``value``, or ``otherwise`` if the deck says "automatic"."""
    return otherwise if value == AUTOMATIC else value


def startup_warnings(prepared: Prepared, start: RunState | None = None, begun: Prepared | None = None) -> list[str]:
    """Return the warnings about a model before it runs, one text each.

    ``start`` is the initial RunState; ``begun`` is the model in the state of the deck, if ``prepared`` is in another.
    """
    texts = [*prepared.carried]
    if start is not None:
        texts += changed_velocities(prepared.deck, prepared.system, prepared.state, start.motion, prepared.length)
        texts += _released_at_start(prepared, start.motion.phases)
    if prepared.displacement > MOVED * prepared.length:
        texts.append(
            f"the assembly moved the initial positions by up to {prepared.displacement:.3g} m, to the nearest that "
            f"satisfy the constraints: as given, {prepared.off}"
        )
    for group in prepared.redundant:
        joints = name_list(group.by_joint(MOST_NAMES), MOST_NAMES, "; ")
        texts.append(
            f"{group.count} redundant constraint(s) among: {joints}. The motion is not affected; the reactions of "
            "these constraints are not unique"
        )
        texts += _dependent_on_reactions(prepared.system, group)
    texts += warnings_of(begun or prepared)
    return texts + (amount_warnings(prepared) if prepared.deck.values["time"] else [])


def _released_at_start(prepared, phases):
    if not any(event.command for batch in prepared.system.batches for event in batch.kind.events):
        return ()
    from mecano.analyses.unmet_conditions import released_at_start  # few models have commands

    return released_at_start(prepared.deck, prepared.system, phases)


def warnings_of(prepared: Prepared) -> list[str]:
    """Return warnings about legal but suspicious input in deck and assembled model, with line and column."""
    deck = prepared.deck
    problems = [*deck.warnings, *suspicious_model(deck, prepared.system, prepared.state, prepared.length)]
    texts = [f"{p.mark}: {p.message}" if p.mark else p.message for p in problems]
    if deck.values["time"] and _is_immobile(prepared):
        texts.append(
            "nothing can move: the constraints leave no motion, and none is prescribed. Is an axis wrong, or a joint "
            "too many?"
        )
    if deck.values["time"] and not mass_of(prepared.system):
        texts.append("nothing in the model has a mass: is this intended?")
    return texts + [text for group in prepared.redundant for text in _drives_in(deck, prepared.system, group)]


def _is_immobile(prepared):
    """Return whether the constraints hold everything in place, and no event can change that."""
    elements = prepared.system.model.elements
    driven = any(element.kind.drives(element.values) or _drives_an_axis(element.values) for element in elements)
    held = prepared.analysis.mobility == 0
    return held and not driven and prepared.system.n_events == 0


def _drives_an_axis(values):
    """Return whether the values of an element are those of a generic joint that drives an axis."""
    return values.get("driven") or values.get("driven_rates")


def amount_warnings(prepared: Prepared) -> list[str]:
    """Return warnings about implausibly many steps or results."""
    row = 1 + row_size(prepared.system)
    return size_warnings(prepared.deck.values, row, 1 + len(STEPS))


def model_facts(prepared: Prepared) -> dict[str, Any]:
    """Return properties of the model for the results file: mass [kg], unknowns, mobility, redundant constraints."""
    system, analysis = prepared.system, prepared.analysis
    return {
        "mass": mass_of(system), "unknowns": system.n, "degrees_of_freedom": system.n_q, "multipliers": system.n_l,
        "mobility": analysis.mobility, "redundant_constraints": sum(group.count for group in prepared.redundant),
    }  # fmt: skip


def mass_of(system: System) -> float:
    """Return the total mass [kg] of all elements whose record has a field "mass"; a load acts on a mass of others."""
    elements = (batch for batch in system.batches if batch.kind.section != "loads")
    return sum(float(batch.p["mass"].sum()) for batch in elements if "mass" in (batch.p.dtype.names or ()))


def _drives_in(deck, system, group):
    """Yield a warning for each drive of a redundant group, whose motion the others of the group hold or prescribe."""
    places = {name.place for name in group.names}
    for joint in system.model.elements:
        title = title_of(joint.kind.name, joint.name)
        if title in places and any(map(_moves, joint.kind.drives(joint.values))):
            yield (
                f"{deck.mark('joints', joint.name)}: {title} repeats other constraints at the start: either they "
                "hold or prescribe the same motion, or it acts across the motion that it should drive; a "
                "prescribed_length acts along the line of its nodes, a generic joint with 'driven' along an axis"
            )


def _moves(motion):
    """Return whether a prescribed motion, a formula or the terms of a law, is not a constant."""
    return isinstance(motion, str) or any(term != "constant" for term, _ in motion)


def _dependent_on_reactions(system, group):
    """Yield warnings if friction or signals depend on the reactions of a redundant group."""
    if owners := _owners(system, system.coupled_multipliers, group):
        yield (
            f"the friction of {', '.join(owners)} depends on reactions that are not unique: friction and motion depend "
            "on how equal compliances of the redundant constraints distribute the reactions; release redundant "
            "constraints, or give other joints of the group a 'compliance'"
        )
    if owners := _owners(system, system.sensed_multipliers, group):
        yield (
            f"signals read reactions of {', '.join(owners)} that are not unique: they depend on how equal compliances "
            "of the redundant constraints distribute the reactions"
        )


def _owners(system, multipliers, group):
    """Return the elements of a redundant group to which some of the ``multipliers`` belong."""
    names = {system.numbering.name[system.n_q + i] for i in multipliers}
    return sorted({name.place for name in names & set(group.names)})


def chosen_values(prepared: Prepared, integrator: TimeIntegrator, start: RunState) -> dict[str, float]:
    """Return the values chosen where the deck says "automatic", by name, for the results file."""
    method, control = integrator.method, integrator.control
    chosen = {
        "length_scale": prepared.length,
        "minimum_step": control.minimum,
        "maximum_step": control.maximum,
        "k": method.k or start.history.k,
    }
    if prepared.deck.values["time"]["method"] == "radau":  # has no penalty, and limits errors instead of residuals
        return chosen
    return chosen | {
        "penalty": method.penalty_share * start.history.k if method.penalty is None else method.penalty,
        "increment_tolerance": method.tolerances.increment,
        "force_tolerance": method.tolerances.force,
    }
