"""Checks of laws: a number, a name, a mapping of terms or a list of such; tables may come from CSV files."""

import re
from dataclasses import replace
from typing import TypeAlias

from mecano.deck.compose import Node
from mecano.deck.containers import IDENTIFIER, filled
from mecano.deck.scope import INVALID, Invalid, Reference, Scope, place_of
from mecano.deck.units import unit_of
from mecano.deck.values import number, plain_number
from mecano.deck.wording import quoted
from mecano.laws.term import ARGUMENT, DENSITY, VALUE, Term
from mecano.schema import NUMBER, TIME_CURVE, Field, Type, Values

Law: TypeAlias = tuple[tuple[str, Values], ...]  # its terms, each with the values of its fields
TERM = Type("mapping", "a mapping")
LIST = "`mecano explain laws` lists the terms"
HOW = "{term: {field: value, ...}, another: {...}}, such as {linear: {slope: 2.0}}"
FORCES = {"m": "N", "rad": "N m"}  # values of laws of extension and of angle, in the order of "N/m or N m/rad"
MEANT = {  # terms by other names
    "stiffness": "spring", "damping": "damper", "viscous": "damper", "friction": "dry_friction",
    "coulomb": "dry_friction", "gap": "dead_band", "free_play": "dead_band", "backlash": "dead_band",
    "force": "preload", "pulse": "bump", "spline": "table", "torsion_spring": "spring", "torsional_spring": "spring",
    "rotational_spring": "spring", "torsional_damper": "damper", "rotational_damper": "damper",
}  # fmt: skip
CURVES = {"spring": "a force in proportion to it is {linear: ...}"}  # hints where a curve is required
SQUARED = r"([A-Za-z%]+)(\d*)"  # a factor of a unit, and its power
POINT_NUMBER = r"\bpoint (\d+)\b"  # number of the faulty point in the text of a check


def law_or_name(node: Node, field: Field, scope: Scope) -> Law | Reference | Invalid:
    """Return a law as a tuple of (term, {field: value}); a name gives a Reference, a number the constant curve."""
    if type(node.value) is dict or _is_sum(node):
        return law(node, field, scope)
    value = plain_number(node, field, scope)
    if value is INVALID:
        return INVALID
    if value is not None and field.type.name != "law":
        value = number(node, replace(field, type=NUMBER), scope)
        return INVALID if value is INVALID else (("constant", {"value": value}),)
    if type(node.value) is str and IDENTIFIER.fullmatch(node.value):
        return Reference(node.value, "laws", field.type.name, node, scope.subject, use=field)
    hint = (
        f"write {{spring: {node.raw}}}, if it is a stiffness" if value is not None and "spring" in scope.terms else ""
    )
    return scope.refuse_value(node, field, hint=hint)


def law_in_place(node: Node, field: Field, scope: Scope) -> Law | Invalid:
    """Return a law of the section ``laws``: a number or a mapping of terms, not a name."""
    value = law_or_name(node, replace(field, unit=VALUE), scope)
    return scope.refuse_value(node, field) if isinstance(value, Reference) else value


def _is_sum(node):
    """Return whether a node is a list of mappings of terms, with which a law may have several terms of one name."""
    return type(node.value) is list and any(type(item.value) is dict for item in node.value)


def law(node: Node, field: Field, scope: Scope) -> Law | Invalid:
    """Return the terms of a mapping, or of all mappings of a list."""
    if _is_sum(node):
        parts = [_part(item, field, scope) for item in node.value]
        return INVALID if INVALID in parts else tuple(term for part in parts for term in part)
    if not node.value:
        return scope.refuse(node, "a law needs at least one term", "known: " + ", ".join(scope.terms))
    if "type" in node.value:
        named = node.value["type"][1].value
        how = f"{{{named}: {{...}}}}" if type(named) is str and named in scope.terms else HOW
        return scope.refuse(node.value["type"][0], "a law has no 'type': it is a mapping of terms", f"write {how}")
    if field.name:
        scope.path.append(field.name)
    terms = tuple((name, _term(name, key, inner, field, scope)) for name, (key, inner) in node.value.items())
    if field.name:
        scope.path.pop()
    return INVALID if any(values is INVALID for _, values in terms) else terms


def _part(node, field, scope):
    """Return the terms of an item of a list."""
    if type(node.value) is dict:
        return law(node, field, scope)
    return scope.refuse(node, "each item of a law that is a list is a mapping of terms", f"write [{HOW}, {{...}}]")


def _term(name, key, node, field, scope):
    term = scope.terms.get(name)
    if term is None:
        meant = MEANT.get(name)
        hint = f"write {{{meant}: ...}}" if meant in scope.terms else scope.suggest(name, scope.terms) or LIST
        return scope.refuse(key, f"unknown term {quoted(scope.name_of(name))} of a law", hint)
    if not fits(term, field.type.name):
        return scope.refuse(
            key,
            f"{quoted(name)} is a force of extension and rate; {field.type.expects} is required here",
            CURVES.get(name, ""),
        )
    scope.owner = key
    if term.single and type(node.value) is not dict:
        node = Node({term.single.name: (key, node)}, node.source, node.line, node.column)
    _, exponent = node.value.get("exponent", (None, None)) if type(node.value) is dict else (None, None)
    fields = _in_use(term, field, exponent.value if exponent else None)
    values = filled(node, Field(name, TERM, "-", term.doc), fields, scope)
    if values is INVALID or ("file" in values and not _with_points(values, term.fields, fields, node, scope)):
        return INVALID
    texts = term.check(values)
    for text in texts:
        scope.refuse(place_of(text, node, key), f"{name}: {text}")
    return INVALID if texts else values


def _in_use(term, use, exponent):
    """Return the fields of a Term with the units of value and argument, where the field of its ``use`` gives them.

    ``exponent``: that of a power in the deck.
    """
    value, argument = units_in(use)
    if term.role == "force" and argument:
        argument += "/s"  # a curve of the rate
    units = [_unit_in_use(field.unit, value, argument) for field in term.fields]
    if type(exponent) in (int, float) and value and argument:
        units = [unit.replace("^p", f"^{exponent:g}") for unit in units]
    return [replace(field, unit=unit) for field, unit in zip(term.fields, units, strict=True)]


def units_in(use: Field) -> tuple[str, str]:
    """Return the units of the value and of the argument of a law in this use, "" where they depend on the deck."""
    if use.type.name == "law":
        return FORCES.get(use.argument, ""), use.argument
    if use.type.name not in ("curve", "drive"):
        return "", ""  # of the section 'laws'
    of_time = use.type == TIME_CURVE or use.type.name == "drive"
    return "" if "unit" in use.unit else use.unit, "s" if of_time else use.argument


def _unit_in_use(unit, value, argument):
    """Return the unit of a field of a term for the units of value and argument in a use, "" where unknown."""
    if unit == DENSITY and value and argument:
        return _of_density(value, argument)
    if value in FORCES.values() and " or " in unit:
        return unit.split(" or ")[list(FORCES.values()).index(value)]
    return ", ".join(_with(part, value, argument) for part in unit.split(", "))


def _of_density(value, argument):
    """Return VALUE^2 ARGUMENT as a unit."""
    if value == argument and value.isalpha():
        return f"{value}3"
    over, *under = value.split("/")
    tops, bottoms = ([re.sub(SQUARED, _squared, one) for one in part] for part in (over.split(" "), under))
    return "/".join([" ".join([top for top in tops if top != "-"] + [argument]), *bottoms])


def _squared(unit):
    """Return a matched unit with twice its power."""
    return f"{unit[1]}{2 * int(unit[2] or 1)}"


def _with(unit, value, argument):
    """Return VALUE, ARGUMENT, "VALUE / ARGUMENT^p" or "1 / ARGUMENT" with the units in their places, if known."""
    over, _, below = unit.partition(" / ")
    if not below:
        return {VALUE: value, ARGUMENT: argument}.get(unit) or unit
    value = "-" if over == "1" else value
    if not (value and argument):
        return unit
    power = below.removeprefix(ARGUMENT)
    (top, *under), (divisor, *times) = value.split("/"), argument.split("/")
    product = " ".join([top] * (top != "-") + [factor + power for factor in times]) or "1"
    return "/".join([product, *under, divisor + power])


def fits(term: Term, wanted: str) -> bool:
    """Return True if a law with this term is allowed where ``wanted`` ("law", "curve" or "drive") is required."""
    return wanted not in ("curve", "drive") or term.role == "curve"


def _with_points(values, general, in_use, node, scope):
    """Read the points of a term from its file, if it has one; return False if they cannot be read.

    ``general`` are its fields with the units of any use, as one file may have several, ``in_use`` those of this use.
    """
    if values["file"] is None:
        useless = next((key for key in ("columns", "units") if values[key] is not None), None)
        if useless:
            scope.refuse(node.value[useless][0], f"{quoted(useless)} belongs to 'file'")
        return useless is None
    if values["points"] is not None:
        scope.refuse(node.value["file"][0], "give either 'points' or 'file', not both")
        return False
    from mecano.deck.csv_tables import ColumnRequest, table  # few decks have tables in files

    points, used = (next(field for field in fields if field.name == "points") for fields in (general, in_use))
    request = ColumnRequest(_pair(values, "columns", node), _pair(values, "units", node), points.unit)
    found = table(values["file"], node.value["file"][1], request, scope)
    if found is None or not _units_fit(found, used.unit, scope):
        return False
    values |= {"file": None, "columns": None, "units": None, "points": found.points}
    text = points.check(values["points"])
    if text:
        match = re.search(POINT_NUMBER, text)
        scope.refuse(found.place(int(match[1]) - 1 if match else 0), f"the points {text}")
    return not text


def _pair(values: Values, key: str, node: Node) -> list[Node | None]:
    """Return the nodes of the two items of a list that a term may have, for x and y; twice None without it."""
    return [None, None] if values[key] is None else node.value[key][1].value


def _units_fit(found, declared, scope):
    """Return whether the units of the columns of a Table agree with its use; report those that do not."""
    given = [(unit_of(declared, i, 2), *pair) for i, pair in enumerate(found.units) if pair]
    from mecano.deck.csv_tables import factor

    return None not in [factor(unit, wanted, place, scope) for wanted, unit, place in given]
