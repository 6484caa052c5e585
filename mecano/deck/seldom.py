"""Values that are allowed and seldom meant: told, not refused.

Negative stiffness and damping, which some mechanisms need; angles of more than a turn in whole or half numbers, which
are degrees; moduli and densities of no solid, which are in other units; loads on fixed nodes.
"""

import math

from mecano.contract import SECTIONS
from mecano.elements import KINDS

PUSHES = "it pushes away from its zero instead of back to it; is it meant so, as where something snaps through?"
DRIVES = "it drives slow motions on instead of braking them; is it meant so, as in what keeps itself swinging?"
SUSPECT = {  # term of a law: what may be negative in it, its number, what follows
    "spring": ("stiffness", lambda values: values["stiffness"], PUSHES),
    "linear": ("slope", lambda values: values["slope"], PUSHES),
    "damper_polynomial": ("coefficients[1]", lambda values: sum(values["coefficients"][1:2]), DRIVES),
}
MOST_NAMES = 3
MEANT_DEGREES = "is {0:g} rad, more than a turn; is it meant so? Degrees are written as '{0:g} deg'"
MATERIALS = {  # field of a section: its unit, below what no solid has it, what that is, another unit
    "E": ("Pa", 1e6, "softer than rubber", "GPa"),
    "density": ("kg/m3", 5.0, "lighter than foam", "g/cm3"),
}


def remarks(values):
    """Texts on what is seldom meant in checked deck ``values``."""
    yield from _signs(values)
    yield from _degrees(values)
    yield from _materials(values["sections"])
    yield from _idle(values["loads"], values["nodes"])


def _signs(values):
    """Texts on negative stiffness and damping, one for all that is alike."""
    found = {}
    for section in SECTIONS:
        for name, d in values[section].items():
            for path, what, number, follows in _negative(d):
                found.setdefault((d["type"], f"{path}.{what}", follows), {})[name] = number
    for (kind, path, follows), numbers in found.items():
        names, lowest, highest = [f"'{name}'" for name in numbers], min(numbers.values()), max(numbers.values())
        more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
        value = f"{lowest:g}" if lowest == highest else f"{lowest:g} to {highest:g}"
        yield f"{kind} {', '.join(names[:MOST_NAMES])}{more}: '{path}' is negative ({value}): {follows}"


def _negative(d):
    """(path of a law, what is negative in it, the number, what follows) of the values of an element."""
    for path, law in _laws(KINDS[d["type"]].fields, d):
        for term, values in law:
            if term in SUSPECT:
                what, number, follows = SUSPECT[term]
                if number(values) < 0.0:
                    yield path, f"{term}.{what}", number(values), follows


def _laws(fields, values, path=""):
    """(path, terms) of the laws of force among checked values."""
    for field in fields:
        value = values[field.name]
        if value is not None and field.type.name == "law":
            yield f"{path}{field.name}", value
        elif value is not None and field.type.name == "mapping":
            yield from _laws(field.type.options, value, f"{path}{field.name}.")


def _degrees(values):
    """Texts on angles that look like degrees."""
    for name, d in values["nodes"].items():
        size = math.hypot(*d["orientation"])
        if size > 2.0 * math.pi and all(_is_half(c) for c in d["orientation"]):
            yield f"node '{name}': 'orientation' {MEANT_DEGREES.format(size)}"
    for section in SECTIONS:
        for name, d in values[section].items():
            for path, angle in _angles(KINDS[d["type"]].fields, d):
                if abs(angle) > 2.0 * math.pi and _is_half(angle):
                    yield f"{d['type']} '{name}': '{path}' {MEANT_DEGREES.format(angle)}"


def _angles(fields, values, path=""):
    """(path, angle) of the angles among checked values."""
    for field in fields:
        value = values[field.name]
        if field.unit == "rad" and isinstance(value, float) and math.isfinite(value):
            yield f"{path}{field.name}", value
        elif field.type.name == "mapping" and value is not None:
            yield from _angles(field.type.options, value, f"{path}{field.name}.")


def _is_half(number):
    return (2.0 * number).is_integer()


def _materials(sections):
    """Texts on moduli and densities of no solid."""
    for name, d in sections.items():
        for field, (unit, least, what, other) in MATERIALS.items():
            if 0.0 < d.get(field, 0.0) < least:
                yield f"section '{name}': '{field}' is {d[field]:g} {unit}, {what}; is it meant so, or in {other}?"


def _idle(loads, nodes):
    """Texts on loads that can do nothing."""
    for name, d in loads.items():
        if d.get("node") in nodes and nodes[d["node"]]["fixed"]:
            yield f"{d['type']} '{name}': node '{d['node']}' is fixed, so the load moves nothing"
