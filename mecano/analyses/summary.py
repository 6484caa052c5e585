"""The summary of `mecano check`: bodies, mass, unknowns, mobility, redundant constraints, mechanisms."""

from collections import Counter
from collections.abc import Callable
from copy import copy
from textwrap import wrap

import numpy as np

from mecano.analyses.failure_text import locating
from mecano.analyses.initial_state import describe, set_initial_state
from mecano.analyses.initial_velocities import NOTICED, changed_velocities, set_in_motion
from mecano.analyses.memory_estimate import memory_of_run, memory_text
from mecano.analyses.prepare import Prepared, amount_warnings, mass_of, prepare, warnings_of
from mecano.deck.deck import Deck
from mecano.deck.run_size import saved_times, steps
from mecano.element_interface import SECTIONS
from mecano.errors import AssemblyError, name_list
from mecano.model.numbering import EquationName
from mecano.process.interrupt import call_interruptibly
from mecano.solve.diagnostics.mobility import MANY
from mecano.solve.diagnostics.rigidity import stiff_mechanisms
from mecano.solve.time.consistent import Consistent
from mecano.solve.time.contradictions import Contradictions
from mecano.solve.time.signals import refuse_undetermined

MOST_NAMES, MOST_MECHANISMS = 6, 4  # names printed of one mechanism, and mechanisms
MOST_ALIKE = 8  # lines printed of one group of redundant constraints
MOST_SHARING = 3  # names of nodes that share an unknown
WIDTH = 110
INDENT = " " * 17


def summary(deck: "Deck", every: bool = False, announce: Callable[[str], object] = lambda text: None) -> str:
    """Return the summary of a checked deck as text; a long search for steady motion at the start is announced.

    Raises AssemblyError if constraints cannot be met at the start, or signals have no unique values, NonFiniteError if
    these are not finite, ConvergenceError if there is no steady motion.

    Only the first of many free unknowns, mechanisms and redundant constraints are listed, unless ``every`` is True.
    """
    return summary_of(prepare(deck), every, announce)[0]


def summary_of(
    prepared: Prepared, every: bool = False, announce: Callable[[str], object] = lambda text: None
) -> tuple[str, list[str]]:
    """Return the summary of a Prepared model as text, see ``summary``, and the warnings in it."""
    system, deck = prepared.system, prepared.deck
    values = deck.values
    warnings: list[str] = []
    lines = [
        f"{deck.file}: {values['title'] or 'no title'}",
        f"nodes            {len(values['nodes'])}",
        *_counts(values),
        f"mass             {mass_of(system):.6g} kg",
        _gravity(values["gravity"]),
        f"unknowns         {system.n}: {system.n_q} degrees of freedom, {system.n_l} multipliers",
        f"length scale     {prepared.length:.6g} m",
        f"memory           about {memory_text(memory_of_run(prepared))} in a run",
        *(_statics(prepared) if values["static"] else _run_size_lines(prepared, announce, warnings)),
        *(line for text in _tyres(values["tire_laws"]) for line in _labelled("tyre", text)),
        *(line for text in prepared.carried for line in _labelled("start", text)),
    ]
    warnings += warnings_of(prepared)
    lines += [line for text in warnings for line in _labelled("warning", text)]
    lines += call_interruptibly(lambda: list(_mobility(prepared, every)))
    redundant = sum(group.count for group in prepared.redundant)
    lines.append(f"redundant        {redundant} constraint(s)")
    for group in prepared.redundant:
        lines += _redundant(group, every)
    if prepared.displacement > 1e-9 * prepared.length:
        lines.append(f"assembly         moves the positions of the deck by up to {prepared.displacement:.3g} m")
    return "\n".join(lines), warnings


def _redundant(group, every):
    """Yield the lines on a Group of redundant constraints, by joint."""
    found = group.by_joint(10**9 if every else MOST_NAMES)
    shown = found if every else found[:MOST_ALIKE]
    yield f"  {group.count} redundant among these {len(group.names)}, whose reactions are therefore not unique:"
    for text in shown:
        yield from wrap(text, WIDTH, initial_indent="    ", subsequent_indent="      ")
    if more := len(found) - len(shown):
        yield f"    and {more} more kinds of joints and directions: mecano check DECK --all"


def _mobility(prepared, every):
    """Yield the lines on mobility and free motions; for flexible structures, with flexible members held rigid."""
    system, analysis = prepared.system, prepared.analysis
    stiff = stiff_mechanisms(system, prepared.state, prepared.length, analysis)
    text = f"mobility         {analysis.mobility}"
    rigid = analysis.mobility if stiff is None else sum(group.count for group in stiff)
    if rigid < analysis.mobility:
        what = "flexible members and tyres" if system.massless.any() else "flexible members"
        text += f": {rigid} with {what} held rigid, {analysis.mobility - rigid} by their deformation"
    yield text
    found = analysis.mechanisms if stiff is None else stiff
    if found is None:
        yield f"  free motions are not listed for more than {MANY} degrees of freedom"
    for text in _free(found or (), every):
        yield from wrap(text, WIDTH, initial_indent="  ", subsequent_indent="    ")


def _free(mechanisms, every):
    """Yield texts on free motions: single unknowns, and mechanisms."""
    most, shown = (10**9, len(mechanisms)) if every else (MOST_NAMES, MOST_MECHANISMS)
    alone = [name for group in mechanisms for name in group.names if len(group.names) == 1]
    if alone:
        yield f"{len(alone)} independent motion(s): {name_list(_by_nodes(alone), most, '; ')}"
    groups = [group for group in mechanisms if len(group.names) > 1]
    for group in groups[:shown]:
        yield f"mechanism of {group.count} degree(s) of freedom: {name_list(_by_nodes(group.names), most, '; ')}"
    if more := groups[shown:]:
        degrees = sum(group.count for group in more)
        yield f"and {len(more)} more mechanism(s) of {degrees} degree(s) of freedom together: mecano check DECK --all"


def _by_nodes(names):
    """Return names of unknowns ("node a: displacement x"), with those of a whole node or member merged into one."""
    places: dict[str, list[EquationName]] = {}
    found: list[str] = []
    inside: Counter[str] = Counter()
    for name in names:
        places.setdefault(name.place, []).append(name)
    for own in places.values():
        inner = next((node for node in own[0].nodes if "." in node), None)
        if len(own) < 6:
            found += _by_sort(own)
        elif inner:
            inside[inner.rpartition(".")[0]] += 1
        else:
            found.append(f"{_shortened(own[0])}: all")
    return found + [f"all of the {count} node(s) inside '{member}'" for member, count in inside.items()]


def _by_sort(names):
    """Yield names of unknowns of one place, with three displacements or rotations merged into one."""
    sorts: dict[str, list[str]] = {}
    for name in names:
        sorts.setdefault(name.what.rpartition(" ")[0], []).append(name.what)
    for sort, own in sorts.items():
        shown = [sort.removesuffix(" about material")] if len(own) == 3 else own
        yield from (f"{_shortened(names[0])}: {what}" for what in shown)


def _shortened(name):
    """Return the place of a name, with the number of further nodes where many share it."""
    nodes = name.nodes
    return name.place if len(nodes) <= MOST_SHARING else f"node {', '.join(nodes[:2])} and {len(nodes) - 2} more"


def _statics(prepared):
    """Yield the lines on the method of statics and on the stability of the start."""
    static = prepared.deck.values["static"]
    what = "load factor" if static["over"] == "load_factor" else "time"
    yield f"equilibrium      {what} up to {static['end']:g} by {static['method']}"
    yield from _start(prepared)


def _start(prepared):
    """Yield the lines on the stability of the start."""
    from mecano.analyses.equilibria import start_in_words  # imports SciPy, a third of the time of a small check

    for text in start_in_words(prepared):
        yield from wrap(text, WIDTH, initial_indent="  ", subsequent_indent="    ")


def _counts(values):
    for section in SECTIONS:
        kinds = [d["type"] for d in values[section].values()]
        counted = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
        yield f"{section:<16} {len(kinds)}{': ' if kinds else ''}{counted}"


def _gravity(vector):
    """Return the line on gravity."""
    shown = ", ".join(f"{component + 0.0:.6g}" for component in vector)
    return f"gravity          {f'[{shown}] m/s2' if any(vector) else 'none'}"


def _tyres(tire_laws):
    """Yield texts on the tyres given by size and pressure, with the derived values."""
    for name, law in tire_laws.items():
        if law["smiley_horne"]:
            from mecano.elements.wheels.smiley_horne import text_under_load  # with the slip laws, which few decks need

            yield f"{name}: {text_under_load(law['smiley_horne'])}"


def _run_size_lines(prepared, announce, warnings):
    """Yield the lines on steps, saved times and the initial state; append the warnings about these."""
    values = prepared.deck.values
    time, count, saved = values["time"], steps(values), saved_times(values)
    kind = f"{count} of {time['step']:g} s" if count is not None else f"adaptive, the first of {time['step']:g} s"
    until = f", or until {time['until']}" if time["until"] else ""
    yield f"steps            {kind}, from {time['start']:g} to {time['end']:g} s{until}"
    yield f"saved times      {'every step' if saved is None else saved}"
    if first := values["initial"]["static"]:
        yield f"initial          the static equilibrium, found by {first['method']}"
        yield from _start(prepared)
    if values["initial"]["steady"]:
        with locating(prepared.deck):  # for a copy of the model
            warnings += call_interruptibly(set_initial_state, copy(prepared), True, announce)
        yield f"initial          {describe(prepared.deck)}, found"
    elif start := _consistent_start(prepared):
        states = prepared.deck, prepared.system, prepared.state, start, prepared.length
        warnings += changed_velocities(*states)
        if moved := set_in_motion(*states):
            text = f"the constraints set nodes in motion that the deck leaves at rest: {moved}"
            yield from _labelled("at start", text)
        if not first:
            _refuse_start(prepared, start)
    warnings += amount_warnings(prepared)


def _consistent_start(prepared):
    """Return the State at the start with velocities that satisfy the constraints; None if there are none.

    If the velocities of the deck satisfy them, nothing is computed or compiled.
    """
    start = prepared.state.copy()
    rates = np.abs(prepared.system.constraint_derivatives(start)[:, 1])
    if rates.max(initial=0.0) <= NOTICED * np.abs(start.v).max():
        return start
    try:
        consistent = Consistent(prepared.system, prepared.linear, start, prepared.length, prepared.compliance)
    except AssemblyError:
        return None
    consistent.project_velocity(start)
    return start


def _refuse_start(prepared, start):
    """Raise the errors of a run that begins with the State ``start``: of constraints and signals, see ``summary``."""
    with locating(prepared.deck):
        contradictions = Contradictions(prepared.system, prepared.length, prepared.compliance)
        contradictions.refuse(start, prepared.deck.values["time"]["step"])
        refuse_undetermined(prepared.system, start)


def _labelled(label, text):
    return wrap(text, WIDTH, initial_indent=f"{label:<17}", subsequent_indent=INDENT)
