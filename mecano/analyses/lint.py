"""Detect legal but suspicious input in the assembled model: massless nodes, strains, states at the start."""

import re
from collections import Counter
from functools import partial

import numpy as np

from mecano.constraints.along_coordinate.demand import is_formula
from mecano.deck.deck import Deck
from mecano.deck.limits import AUTOMATIC
from mecano.deck.physics import element_nodes
from mecano.deck.units import UnitError, alike, factor_of
from mecano.element_interface import BY_COMMAND, FREELY, NodeAtStart, nothing
from mecano.elements import KINDS
from mecano.errors import Problem, name_list
from mecano.laws.probe import curve_at
from mecano.maths.inertia import inertia_matrix
from mecano.model.model import extent, title_of
from mecano.model.numbering import ROTATION
from mecano.model.signal_units import drives_with_units, unlike_sums
from mecano.model.state import State
from mecano.model.system import System
from mecano.solve.time.massless import loose_knots, massless_unknowns

WIDE = 20.0  # sizes of the model: a ship whose deck carries a wheel has 10, and kg mm2 for kg m2 give 300 and more
PAID_OUT = 2.0  # factor by which a natural length may change before its constant mass is reported
MOST_NAMED = 10  # warnings of one type
NAMES_AND_NUMBERS = r"'[^']*'|\bnode [^:]*:|\d"  # in which the warnings about copies of one entry differ
FAR = 1e5  # length scales from the origin, where a double pendulum has errors of 1e-6 in angles, 1 % in its forces


def suspicious_model(deck: Deck, system: System, s: State, length: float) -> list[Problem]:
    """Return the warnings (list of Problem) about a model at its start ``s``; ``length`` [m] is its length scale."""
    strained, started = [*_strain_warnings(deck, system, s)], [*_start_warnings(deck, system, s)]
    massless = [*_massless(deck, system, s, length), *_twists_without_inertia(deck)]
    size = extent(system.nodes)
    placed = [*_far(deck, system, s, length), *_one_point(deck, system), *_wide(deck, size), *_bearings(deck, size)]
    firsts = [*_first(strained, "elements"), *_first(massless, "nodes"), *_first(started, "elements")]
    units = [*_other_units(deck, system.model), *_unit_warnings(deck, system.model)]
    turned = _first([*_turned(deck, system, s)], "joints")
    paid_out = _first([*_paid_out(deck)], "elements")
    return [*firsts, *_first(units, "formulas"), *placed, *turned, *paid_out]


def _other_units(deck, model):
    """Yield warnings about formulas in other units than the fields that take them."""
    for element, field, text, unit in drives_with_units(model):
        try:
            factor_of(unit, field.unit)
        except UnitError as error:
            where = f"{title_of(element.kind.name, element.name)}: '{field.name}' is the formula '{text}'"
            mark = deck.formulas.get(text) or deck.mark(element.kind.section, element.name)
            yield Problem(f"{where}; {error}", mark)


def _unit_warnings(deck, model):
    """Yield warnings about formulas that add or compare different quantities, or angles with degrees."""
    unlike, degrees = unlike_sums(model, deck.formulas)
    for text, number in degrees:
        yield Problem(
            f"the formula '{text}' adds {number:g} to an angle or compares both: it is {number:g} rad, more than a "
            f"turn; is this intended? Degrees are written as {number:g}*pi/180, or as a parameter with the unit deg",
            deck.formulas[text],
        )
    for text, first, second in unlike:
        if "-" not in (first, second) and not alike(f"1 {first}", f"1 {second}"):
            yield Problem(f"the formula '{text}' adds or compares {first} and {second}", deck.formulas[text])


def _first(problems, what):
    """Return the first ``MOST_NAMED`` problems without copies; the last of them gives the number of further ones."""
    problems = _without_copies(problems)
    *shown, last = problems[:MOST_NAMED] or [None]
    more = len(problems) - MOST_NAMED
    if more > 0:
        last = Problem(f"{last.message} (and {more} more {what})", last.mark)
    return [*shown, last] if last else []


def _without_copies(problems):
    """Return the first of the problems that are alike at each place in the deck, with the number of their copies."""
    places: dict[tuple[str, str], list[Problem]] = {}
    for problem in problems:
        places.setdefault((str(problem.mark), re.sub(NAMES_AND_NUMBERS, "", problem.message)), []).append(problem)
    others = [(first, len(alike)) for first, *alike in places.values()]
    return [
        Problem(one.message + (f" (and {n} more {'copy' if n == 1 else 'copies'} of it)" if n else ""), one.mark)
        for one, n in others
    ]


def _strain_warnings(deck, system, s):
    """Yield warnings about elements whose length at the start differs much from their length without force.

    A start that is solved for is strained by its loads: the positions in the deck are judged.
    """
    before = {node.name: node.x for node in system.nodes}
    solved = any(deck.values["initial"][key] for key in ("static", "steady", "from"))
    places = zip(system.nodes, system.numbering.x, strict=True)
    at = before if solved else {node.name: s.z[x : x + 3] for node, x in places}
    for name, d in deck.values["elements"].items():
        usual = KINDS[d["type"]].strains
        if not usual or d.get("via") is not None or "ground" in d["nodes"]:
            continue
        natural = _natural_length(d, before, s.t)
        if not natural > 0.0:  # strain is undefined for a spring of natural length zero
            continue
        strain = float(np.linalg.norm(np.subtract(*(at[node] for node in d["nodes"])))) / natural - 1.0
        if not usual[0] <= strain <= usual[1]:
            text = (
                f"{d['type']} '{name}' is strained by {100.0 * strain:.3g} % at the start: its nodes are "
                f"{natural * (1.0 + strain):.6g} m apart, its unstressed length is {natural:.6g} m"
            )
            yield Problem(text, deck.mark("elements", name))


def _far(deck, system, s, length):
    """Yield a warning if the mechanism is so far from the origin that rounding errors of positions spoil its motion."""
    distance = np.linalg.norm(s.z[system.numbering.x[:, None] + np.arange(3)], axis=1)
    i = int(np.argmin(distance))
    if distance[i] > FAR * length:
        text = (
            f"the nearest node, '{system.nodes[i].name}', is {distance[i]:.3g} m from the origin, "
            f"{distance[i] / length:.2g} times the length scale: positions have 16 digits, so few are left for forces "
            "and accelerations; place the origin near the mechanism"
        )
        yield Problem(text, deck.mark("nodes", system.nodes[i].name))


def _wide(deck, size):
    """Yield warnings about bodies with the inertia of something much larger than the model, of the ``size`` [m]."""
    for name, d in deck.values["elements"].items() if size else ():
        if "inertia" in d and "mass" in d:
            radius = float(np.sqrt(np.linalg.eigvalsh(inertia_matrix(d["inertia"]))[-1] / d["mass"]))
            if radius > WIDE * size:
                text = (
                    f"{title_of(d['type'], name)}: mass and inertia are those of a body with a radius of gyration of "
                    f"{radius:.3g} m, and the model has a size of {size:.3g} m; are they in kg and kg m2?"
                )
                yield Problem(text, deck.mark("elements", name))


def _bearings(deck, size):
    """Yield warnings about friction in bearings that are larger than the model, of the ``size`` [m]."""
    for name, d in deck.values["joints"].items() if size else ():
        radius = (d.get("friction") or {}).get("radius") or 0.0
        if radius > size:
            text = (
                f"{title_of(d['type'], name)}: 'friction.radius' is {radius:g} m, and the model has a size of "
                f"{size:.3g} m; is it in mm?"
            )
            yield Problem(text, deck.mark("joints", name))


def _turned(deck, system, s):
    """Yield warnings about motors whose initial angle differs by full turns from that of their hinge."""
    motors, hinges = (_angles(system, s, turns) for turns in (BY_COMMAND, FREELY))
    of_pair = {frozenset(deck.values["joints"][name]["nodes"]): name for name in hinges}
    for name, wanted in motors.items():
        d = deck.values["joints"][name]
        if (hinge := of_pair.get(frozenset(d["nodes"]))) is None:
            continue
        other = deck.values["joints"][hinge]
        sense = np.sign(np.dot(d["axis"], other["axis"])) * (1.0 if d["nodes"] == other["nodes"] else -1.0)
        if round((wanted - sense * hinges[hinge]) / (2.0 * np.pi)):
            text = f"{title_of(d['type'], name)} begins at {wanted:.6g} rad, but {title_of(other['type'], hinge)} at "
            text += f"{hinges[hinge]:.6g} rad: positions do not show whole turns. Springs, gears and stops count from "
            text += "the latter; let the motor begin within half a turn of the angle in the deck, which is zero"
            yield Problem(text, deck.mark("joints", name))


def _angles(system, s, turns):
    """Return {name: angle [rad]} of the joints of kinds that declare ``turns``."""
    kinds = [b for b in system.batches if b.kind.turns == turns]
    outputs = system.observe(s).outputs if kinds else None
    found = {}
    for b in kinds:
        column = [output.name for output in b.kind.outputs].index("angle")
        for (path, _), y in zip(b.paths, b.outputs(outputs), strict=True):
            found[path.partition("/")[2]] = float(y[column])
    return found


def _one_point(deck, system):
    """Yield a warning if the errors of steps are relative to 1 m because all nodes are at one point."""
    adaptive = (deck.values["time"] or {}).get("adaptive")
    if adaptive and adaptive["length_scale"] == AUTOMATIC and not extent(system.nodes):
        text = (
            "all nodes are at one point, so 'time.adaptive.tolerance' is relative to 1 m; give "
            "'time.adaptive.length_scale', the size of the motion"
        )
        yield Problem(text, deck.mark("nodes", system.nodes[0].name))


def _paid_out(deck):
    """Yield warnings about lines that are paid out or hauled in while their mass stays that of the start."""
    time = deck.values["time"]
    for name, d in deck.values["elements"].items() if time else ():
        length = d.get("natural_length")
        if length is None or isinstance(length, float) or is_formula(length) or not d.get("mass_per_length"):
            continue
        first, last = (curve_at(length, t)[0] for t in (time["start"], time["end"]))
        if max(first, last) > PAID_OUT * min(first, last):
            text = (
                f"{title_of(d['type'], name)}: its mass stays that of the start, {d['mass_per_length'] * first:.4g} kg "
                f"of {first:.4g} m, while its natural length becomes {last:.4g} m; is this intended?"
            )
            yield Problem(text, deck.mark("elements", name))


def _natural_length(d, positions, t):
    """Return the length [m] without force, at time ``t``, of an element with checked values ``d``; 0 for a formula.

    ``positions`` are those of the nodes in the deck.
    """
    natural = d.get("natural_length")
    if is_formula(natural):
        return 0.0
    if natural is None:
        return float(np.linalg.norm(np.subtract(*(positions[node] for node in d["nodes"]))))
    return natural if isinstance(natural, float) else curve_at(natural, t)[0]


def _start_warnings(deck, system, s):
    """Yield the warnings of the kinds about the state at the start, for steady running with its velocity."""
    ahead = _velocity_to_add(deck, system, s)
    at, gravity = {node.name: i for i, node in enumerate(system.nodes)}, system.context.gravity
    at_rest = np.eye(3), np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3)
    ground = NodeAtStart(*at_rest, lambda: np.diag([np.inf] * 3), gravity)
    for name, d in deck.values["elements"].items():
        kind = KINDS[d["type"]]
        if kind.start_warnings is not nothing:
            names = element_nodes(kind, d)
            nodes = [node_at_start(system, s, at[node], ahead) if node in at else ground for node in names]
            for text in kind.start_warnings(d, nodes):
                yield Problem(f"{d['type']} '{name}': {text}", deck.mark("elements", name))


def _velocity_to_add(deck, system, s):
    """Return the velocity (3,) [m/s] of straight steady running still to be added to the state ``s``, or zero."""
    velocity = np.array((deck.values["initial"]["steady"] or {}).get("velocity") or (0.0, 0.0, 0.0))
    mean = s.v[system.numbering.x[:, None] + np.arange(3)].mean(axis=0)
    return velocity if mean @ velocity < 0.5 * velocity @ velocity else np.zeros(3)


def node_at_start(system: System, s: State, i: int, ahead: np.ndarray | float = 0.0) -> NodeAtStart:
    """Return the NodeAtStart of the node ``i`` at the state ``s``; ``ahead`` (3,) is added to its velocity."""
    of = system.numbering
    x, r, R = slice(of.x[i], of.x[i] + 3), slice(of.r[i], of.r[i] + 3), s.R[of.rotation[i]]
    w = R @ s.v[r] if of.r[i] < of.n_q and not np.any(ahead) else np.full(3, np.nan)
    motion = s.z[x], R, s.v[x] + ahead, w
    return NodeAtStart(system.nodes[i].R, *motion, partial(_inertia, system, s, i), system.context.gravity)


def _inertia(system, s, i):
    """Return the inertia (3, 3) of all that is attached to the node ``i``, material [kg m2]."""
    of = system.numbering
    masses = system.assemble(s, cM=1.0).data
    rows, cols = (numbers - of.r[i] for numbers in (system.rows, system.cols))
    turning, M = (0 <= rows) & (rows < 3) & (0 <= cols) & (cols < 3), np.zeros((3, 3))
    np.add.at(M, (rows[turning], cols[turning]), masses[: len(rows)][turning])
    return M


def _massless(deck, system, s, length):
    """Return warnings about nodes without mass; none for statics or for a model without any mass."""
    if not deck.values["time"] or not any("mass" in b.p.dtype.names and b.p["mass"].any() for b in system.batches):
        return []
    names = system.numbering.name
    found: dict[tuple[str, tuple[str, ...]], set[str]] = {}  # (place, nodes) -> types of unknowns
    for i in massless_unknowns(system, s, length):
        sort = "rotation" if system.numbering.kind[i] == ROTATION else "displacement"
        found.setdefault((names[i].place, names[i].nodes), set()).add(sort)
    knots = loose_knots(system, s, length)
    return [
        _knot(deck, place, nodes, knots[place]) if place in knots else _no_mass(deck, place, nodes, sorted(sorts))
        for (place, nodes), sorts in found.items()
    ]


def _twists_without_inertia(deck):
    """Yield a warning for each section that has mass, but none off its axis, where nothing else turns with its beams.

    Inertia is taken as missing at inner nodes, and at nodes between two beams that belong to no body; not in statics.
    """
    elements = deck.values["elements"].values()
    for name, section in deck.values["sections"].items() if deck.values["time"] else ():
        if section.get("mass_per_length") and not section["rotary_inertia"][0]:
            bodies = {node for d in elements if "inertia" in d for node in (d["node"], *(d.get("attached") or ()))}
            beams = [d for d in elements if d["type"] == "beam" and d["section"] == section]
            ends = Counter(node for d in beams for node in d["nodes"] if node not in bodies)
            if any(d["mesh"] > 1 for d in beams) or any(n > 1 for n in ends.values()):
                text = (
                    f"section '{name}' has mass, but no rotary inertia about axis 1: the twist of its beams has no "
                    "inertia, and steps may fail or be wrong; a plane section has mass_per_length times the sum of the "
                    "squares of both radii of gyration"
                )
                yield Problem(text, deck.mark("sections", name))


def _knot(deck, place, nodes, lines):
    text = (
        f"{place}: nothing gives mass to its displacement, and only lines that may go slack hold it "
        f"({name_list(lines, MOST_NAMED)}): when slack, they leave its position undetermined, and the run may end; "
        "give it mass with a point_mass, or replace lines in series by a single line"
    )
    return Problem(text, _mark(deck, nodes))


def _mark(deck, nodes):
    return next((mark for name in nodes if (mark := deck.mark("nodes", name))), None)


def _no_mass(deck, place, nodes, sorts):
    missing = "point_mass or a rigid_body" if "displacement" in sorts else "rigid_body or a held_rotation"
    text = (
        f"{place}: nothing gives mass to its {' and '.join(sorts)}, which follows forces without inertia; is this "
        f"intended, or is a {missing} missing?"
    )
    return Problem(text, _mark(deck, nodes))
