"""Warnings of legal but suspicious input in a checked deck.

They concern negative stiffness and damping, which some mechanisms need; angles of more than a turn in whole or half
numbers, which look like degrees; gravity, moduli and densities in other units; tyres with unbounded rates of the patch;
values and triggers without effect; laws of time that the steps do not sample; unused entries; and those of
rare_checks.py.
"""

import math
from collections.abc import Container, Mapping

from mecano.deck.compose import Node
from mecano.deck.containers import singular
from mecano.deck.rare_checks import rare_warnings
from mecano.deck.sampled_laws import unsampled
from mecano.deck.without_effect import without_effect
from mecano.deck.wording import quoted
from mecano.element_interface import SECTIONS, Kind
from mecano.errors import Mark, Problem, name_list
from mecano.model.mesh import divides, inner_names
from mecano.schema import Values

PUSHES = "it pushes away from its zero instead of back to it; is this intended, as in a snap-through?"
DRIVES = "it drives slow motions instead of braking them; is this intended, as in a self-excited oscillation?"
SUSPECT = {  # term of a law: the quantity that may be negative, its value, the consequence
    "spring": ("stiffness", lambda values: values["stiffness"], PUSHES),
    "linear": ("slope", lambda values: values["slope"], PUSHES),
    "damper_polynomial": ("coefficients[1]", lambda values: sum(values["coefficients"][1:2]), DRIVES),
}
LEVELS = {"constant": ("value",), "sine": ("amplitude",), "step": ("from", "to"), "ramp": ("from", "to")}
MOST_NAMES = 3
MEANT_DEGREES = "is {0:g} rad, more than a turn; is this intended? Degrees are written as '{0:g} deg'"
MATERIALS = {  # field: unit, smallest value of a solid, what a smaller one means, other units and their largest values
    "E": ("Pa", 1e6, "softer than rubber", {"GPa": 1e3, "MPa": 1e6}),
    "density": ("kg/m3", 5.0, "lighter than foam", {"g/cm3": 5.0}),
}


LARGEST_REGULARIZATION = 10.0  # m/s, of the friction of a tyre
LARGEST_DAMPING = 10.0  # s/m, of a tyre
ROUND_CONTACT = 2  # hundreds of USE_MODE in a .tir file: a circular cross-section
LEAST_DEFLECTION = 0.01  # of the diameter of a tyre under its load
FASTEST = 3e4  # m/s, speed of waves along a rod
LARGEST_GRAVITY = 30.0  # m/s2, more than on any planet
OF_THE_EARTH = (9.78, 9.84)  # m/s2
NAMED = ("laws", "grounds", "tire_laws", "sections")  # sections of entries that others refer to


def suspicious(
    values: Values, root: Node, used: Mapping[str, Container[str]], kinds: Mapping[str, Kind], varied: bool
) -> list[Problem]:
    """Return warnings (list of Problem) on the checked deck ``values``, with marks of the checked tree ``root``.

    ``used`` is {section: names} of the parameters and named entries that the deck refers to; ``kinds`` is {name: Kind}
    of all elements. ``varied`` is True for a deck with overrides, or words that choose among entries, which may leave
    some without a use.
    """
    found = [
        *_gravity(values["gravity"]), *_signs(values, kinds), *_degrees(values, kinds), *_materials(values),
        *_tires(values["tire_laws"]), *without_effect(values, kinds),
        *unsampled(values, kinds), *_partly_moving(values, kinds),
        *rare_warnings(values, kinds),
    ]  # fmt: skip
    unused = [] if varied else _unused(root, used)
    return [*(Problem(text, _place(root, path).mark) for path, text in found), *unused]


def unplaced(templates: Mapping[str, Mark]) -> list[Problem]:
    """Return warnings on templates, {name: mark}, of which the deck places no copy."""
    return [Problem(f"template {quoted(name)} is not placed", mark) for name, mark in templates.items()]


def _place(root, path):
    """Return the deepest node on a path of keys: a value, or the key of a mapping that lacks the further keys."""
    key = node = root
    for word in path:
        if type(node.value) is not dict or word not in node.value:
            break
        key, node = node.value[word]
    return key if type(node.value) is dict else node


def _unused(root, used):
    """Yield warnings on unused entries of the deck itself; of a template, one for all its copies."""
    marks = set()
    for section in ("parameters", *NAMED):
        _, node = root.value.get(section, (None, root))
        entries = node.value if node is not root and type(node.value) is dict else {}
        for name, (key, _) in entries.items():
            included = key.source.file != root.source.file
            if name not in used[section] and not included and (key.line, key.column) not in marks:
                marks.add((key.line, key.column))
                yield Problem(f"{singular(section)} {quoted(name)} is not used", key.mark)


def _partly_moving(values, kinds):
    """Yield (path, text) on members of which initial velocities name some of the nodes inside, but not all."""
    members = {name: d for name, d in values["elements"].items() if divides(kinds[d["type"]], d)}
    for entry in values["initial"]["velocities"]:
        for name, d in members.items():
            inner = inner_names(name, d)
            missing = [] if entry["nodes"] == "all" else [node for node in inner if node not in entry["nodes"]]
            if 0 < len(missing) < len(inner):
                text = (
                    f"an entry of 'velocities' names nodes of {quoted(name)}, but not {name_list(missing, MOST_NAMES)}"
                )
                yield ("initial", "velocities"), f"{text}; {quoted(name)} itself stands for all of its nodes"


def _gravity(vector):
    """Yield (path, text) on gravity in other units."""
    size = math.hypot(*vector)
    if size == 0.0:
        return
    power = round(math.log10(size / 9.81))
    shifted = (power > 0 or power == -3) and OF_THE_EARTH[0] <= size / 10.0**power <= OF_THE_EARTH[1]
    if shifted or size > LARGEST_GRAVITY:
        text = f"'gravity' is {size:g} m/s2; on Earth it is 9.81, and the units of decks are m, kg and s"
        yield ("gravity",), text


def _signs(values, kinds):
    """Yield (path, text) on negative stiffness and damping, one for all similar elements."""
    found: dict[tuple[str, ...], dict[str, float]] = {}  # values by section, type, path and consequence, and by name
    for section in SECTIONS:
        for name, d in values[section].items():
            for path, what, number, follows in _negative(d, kinds):
                found.setdefault((section, d["type"], f"{path}.{what}", follows), {})[name] = number
    for (section, kind, path, follows), numbers in found.items():
        names, lowest, highest = [f"'{name}'" for name in numbers], min(numbers.values()), max(numbers.values())
        value = f"{lowest:g}" if lowest == highest else f"{lowest:g} to {highest:g}"
        text = f"{kind} {name_list(names, MOST_NAMES)}: '{path}' is negative ({value}): {follows}"
        yield (section, next(iter(numbers)), *path.split(".")), text


def _negative(d, kinds):
    """Yield (path of a law, negative quantity, value, consequence) from the values of an element."""
    for path, law in _laws(kinds[d["type"]].fields, d):
        for term, values in law:
            if term in SUSPECT:
                what, number, follows = SUSPECT[term]
                if number(values) < 0.0:
                    yield path, f"{term}.{what}", number(values), follows


def _laws(fields, values):
    """Yield (path, terms) of the laws of force among checked values."""
    for field, path, value in _leaves(fields, values):
        if value is not None and field.type.name == "law":
            yield path, value


def _leaves(fields, values, path=""):
    """Yield (Field, path, value) of checked values, those in mappings included."""
    for field in fields:
        value = values[field.name]
        if field.type.name == "mapping" and value is not None:
            yield from _leaves(field.type.options, value, f"{path}{field.name}.")
        else:
            yield field, f"{path}{field.name}", value


def _degrees(values, kinds):
    """Yield (path, text) on angles that look like degrees."""
    for name, d in values["nodes"].items():
        size = math.hypot(*d["orientation"])
        if size > math.pi and all(_is_half(c) for c in d["orientation"]):
            text = MEANT_DEGREES if size > 2.0 * math.pi else MEANT_DEGREES.replace("a turn", "half a turn")
            yield ("nodes", name, "orientation"), f"node '{name}': 'orientation' {text.format(size)}"
    for section in SECTIONS:
        for name, d in values[section].items():
            for path, angle in _angles(kinds[d["type"]].fields, d):
                if abs(angle) > 2.0 * math.pi and _is_half(angle):
                    text = f"{d['type']} '{name}': '{path}' {MEANT_DEGREES.format(angle)}"
                    yield (section, name, *path.split(".")), text
            for path, text in _edges(kinds[d["type"]].fields, d):
                yield (section, name, *path.split(".")), f"{d['type']} '{name}': '{path}': {text}"


def _edges(fields, values):
    """Yield (path, text) on edges in formulas of angles that look like degrees."""
    for field, path, value in _leaves(fields, values):
        if field.unit == "rad" and isinstance(value, str) and "step(" in value:
            from mecano.deck.degrees_in_functions import edge_in_degrees

            if text := edge_in_degrees(value):
                yield path, text


def _angles(fields, values):
    """Yield (path, angle) of the angles among checked values."""
    for field, path, value in _leaves(fields, values):
        if field.unit != "rad":
            continue
        for angle in _constants(value):
            if isinstance(angle, float) and math.isfinite(angle):
                yield path, angle


def _constants(value):
    """Return the constant terms of a law, the amplitudes of sines and the ends of edges in it; or the value itself."""
    if not isinstance(value, tuple):
        return [value]
    return [term[name] for kind, term in value for name in LEVELS.get(kind, ())]


def _is_half(number):
    return (2.0 * number).is_integer()


def _materials(values):
    """Yield (path, text) on moduli and densities that no solid has."""
    given = [("sections", name, d) for name, d in values["sections"].items()]
    given += [("elements", name, d) for name, d in values["elements"].items() if "E" in d]
    for section, name, d in given:
        for field, (unit, least, what, others) in MATERIALS.items():
            if 0.0 < (number := d.get(field) or 0.0) < least:
                other = next(other for other, most in others.items() if number < most)
                title = f"section '{name}'" if section == "sections" else f"{d['type']} '{name}'"
                text = f"{title}: '{field}' is {number:g} {unit}, {what}; is it intended, or in {other}?"
                yield (section, name, field), text
        E, density = d.get("E") or 0.0, d.get("density") or 0.0
        if density >= MATERIALS["density"][1] and (speed := math.sqrt(E / density)) > FASTEST:
            text = f"section '{name}': sound travels through it at {1e-3 * speed:.3g} km/s, through diamond at 18"
            yield (section, name, "density"), f"{text}; is 'density' in g/cm3, or 'E' not in Pa?"


def _tires(tire_laws):
    """Yield (path, text) on tyre laws: unbounded rates of a sliding patch, loads and dampings in other units."""
    for name, d in tire_laws.items():
        if d.get("lateral"):
            from mecano.elements.wheels.lateral_law import runaway  # few decks have such a law

            if found := runaway(d["lateral"]):
                field, text = found
                yield ("tire_laws", name, "lateral", *field.split(".")), f"tire law '{name}': {text}"
        for path, text in (*_in_other_units(d), *_round_tyres(d)):
            yield ("tire_laws", name, *path), f"tire law '{name}': {text}"


def _round_tyres(d):
    """Yield (path, text) on the file of a motorcycle tyre whose tread the tyre law does not round."""
    given = (d.get("magic_formula") or {}).get("coefficients") or {}
    contact = abs(int(given.get("USE_MODE", 0))) // 100
    if d.get("crown_radius") or not (contact == ROUND_CONTACT or given.get("MC_CONTOUR_A")):
        return
    why = "MC_CONTOUR_A" if given.get("MC_CONTOUR_A") else "USE_MODE"
    text = (
        f"its file is that of a motorcycle tyre ({why}), but without 'crown_radius' it stands on the ground as a disc"
    )
    yield ("magic_formula",), text


def _in_other_units(d):
    """Yield (path, text) on the numbers of a tyre law that no tyre has."""
    if (damping := d.get("radial_damping", 0.0)) > LARGEST_DAMPING:
        text = f"'radial_damping' multiplies the radial force by {1.0 + damping:.3g} at 1 m/s; a tyre has some 0.1 s/m"
        yield ("radial_damping",), text
    if (slip := d.get("slip_regularization") or 0.0) > LARGEST_REGULARIZATION:
        text = f"'slip_regularization' is {slip:g} m/s: the tyre reaches its friction only at larger slip speeds"
        yield ("slip_regularization",), f"{text}; is it in mm/s?"
    given = (d.get("magic_formula") or {}).get("coefficients") or {}
    low, high = given.get("FZMIN", 0.0), given.get("FZMAX", math.inf)
    if not low <= given.get("FNOMIN", low) <= high:
        text = f"the nominal load FNOMIN = {given['FNOMIN']:g} N is outside of FZMIN = {low:g} to FZMAX = {high:g} N"
        yield ("magic_formula",), f"{text}, the range of the file: are all of them in its unit of force?"
    if (size := d.get("smiley_horne")) and size["deflection"] < LEAST_DEFLECTION * size["diameter"]:
        share = size["deflection"] / size["diameter"]
        text = f"'smiley_horne.load' of {size['load']:g} N deflects the tyre by {share:.2g} of its diameter"
        yield ("smiley_horne", "load"), f"{text}; the usual load by 0.05 to 0.1: is it in N?"
