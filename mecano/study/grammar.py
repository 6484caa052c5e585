"""Grammar of study files: fields and types in addition to those of decks, with their checks."""

from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias

from mecano.deck.check import CHECKS
from mecano.deck.compose import MAX_DEPTH, Content, Node
from mecano.deck.json_schema import mapping_schema
from mecano.deck.limits import at_least_one, not_empty
from mecano.deck.scope import INVALID, Invalid, Scope
from mecano.deck.units import ANY, UnitError, alike, converted, is_quantity, number_and_unit
from mecano.deck.wording import quoted
from mecano.schema import INTEGER, NUMBER, TEXT, Field, Type, Values, choice, list_of, mapping, named

VERSION = 1
NAME = "case"  # key that names the case of a row
PATH = "a path in the deck, as in --set: 'time.end'"
OF_SERIES = ("max", "min", "largest", "largest_magnitude", "time_of_max", "time_of_min", "final", "mean")
OF_EVENTS = ("first", "last", "count", "impulse", "energy_lost")


class Entry(NamedTuple):
    """A value set by a study: the node of its path, and the node of its value or choices."""

    key: Node
    node: Node


Entries: TypeAlias = dict[str, Entry]  # by the path of the value


def check_output(output: Values) -> str | None:
    """Check that an output is of a series or of events, with a fitting ``take``; return the error text or None."""
    if (output["of"] is None) == (output["event"] is None):
        return "an output is 'of' a series, or of an 'event'"
    known, what = (OF_SERIES, "a series") if output["event"] is None else (OF_EVENTS, "events")
    if output["take"] not in known:
        return f"'take' of {what} is one of: {', '.join(known)}"
    if output["event"] is not None and len(output["event"].split()) != 2:
        return "'event' is the name of an element and the name of its event: 'wheel touch_down'"
    if None not in (output["at_least"], output["at_most"]) and output["at_least"] > output["at_most"]:
        return "'at_least' must not be greater than 'at_most'"
    return None


def check_number(number: int) -> str | None:
    """Check a number of cases; return the error text or None."""
    return at_least_one(number) or ("must be at most 100000" if number > 100_000 else None)


SPAN_FIELDS = (
    Field("from", NUMBER, ANY, "first value"),
    Field("to", NUMBER, ANY, "last value"),
    Field("number", INTEGER, "-", "number of values, at equal distances", check=check_number),
)
SPAN = {"anyOf": [{"type": "array", "minItems": 1}, mapping_schema(SPAN_FIELDS)]}
PAIR = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 2, "maxItems": 2}
PATH_TEXT = Type("path", PATH, schema={"type": "string"})
SETTINGS = Type(
    "settings", "a mapping of paths in the deck, as in --set, to values: {time.end: 2}",
    schema={"type": "object"},
)  # fmt: skip
CHOICES = Type(
    "choices", "a mapping of paths in the deck to lists, or to {from: 1, to: 2, number: 5}",
    schema={"type": "object", "minProperties": 1, "additionalProperties": SPAN},
)  # fmt: skip
RANGES = Type(
    "ranges", "a mapping of paths in the deck to [lowest, highest]",
    schema={"type": "object", "minProperties": 1, "additionalProperties": PAIR},
)  # fmt: skip
HYPERCUBE_FIELDS = (
    Field("ranges", RANGES, "-", "varied values, with their ranges"),
    Field("number", INTEGER, "-", "number of rows of values", check=check_number),
    Field("seed", INTEGER, "-", "seed of the random numbers: the same seed gives the same rows", 0),
)
SEED_FIELDS = (
    Field("path", PATH_TEXT, "-", "path of the seed: laws.road.random.seed"),
    Field("number", INTEGER, "-", "number of seeds", check=check_number),
    Field("first", INTEGER, "-", "first seed; the others are the numbers after it", 1),
)
OUTPUT_FIELDS = (
    Field("of", TEXT, "-", "a series of the results, as in `mecano post --plot`: wheel.radial_force", None),
    Field("event", TEXT, "-", "an element, or a pattern, and its event: wheel touch_down, '* locks'", None),
    Field("take", choice(*OF_SERIES, *OF_EVENTS), "-", "the number to take"),
    Field("at_least", NUMBER, ANY, "a case with a smaller number fails; no limit when absent", None),
    Field("at_most", NUMBER, ANY, "a case with a larger number fails; no limit when absent", None),
)
OUTPUT = replace(mapping(*OUTPUT_FIELDS), expects="a mapping, such as {of: hinge.angle, take: max}")
FIELDS = (
    Field("study", INTEGER, "-", "version of the study file"),
    Field("title", TEXT, "-", "title of the study", ""),
    Field("deck", TEXT, "-", "file of the deck, relative to the study file"),
    Field("set", SETTINGS, "-", "values of the deck in all cases; a row of list or csv may replace one", {}),
    Field("grid", CHOICES, "-", "all combinations of values", None, check=not_empty),
    Field("list", list_of(SETTINGS), "-", "rows of values that belong together; 'case' names a row", None,
          check=not_empty),
    Field("csv", TEXT, "-", "a CSV file of such rows; its first line has the varied values, and 'case'", None),
    Field("latin_hypercube", mapping(*HYPERCUBE_FIELDS), "-", "rows of random values that fill ranges evenly", None),
    Field("seeds", mapping(*SEED_FIELDS), "-", "one case for each seed of random numbers", None),
    Field("outputs", named(OUTPUT, check_output), "-", "numbers of each case, for the table", {}),
)  # fmt: skip


def path_of(node: Node, scope: Scope) -> str | Invalid:
    """Return the text of a path of keys, or INVALID after reporting the problem."""
    keys = node.value.split(".") if type(node.value) is str else []
    if not keys or not all(keys) or len(keys) > MAX_DEPTH or set(node.value) & set("=\n"):
        return scope.refuse(
            node, f"{quoted(str(node.value))} is not a path of keys separated by dots, such as 'time.end'"
        )
    return node.value


def path(node: Node, field: Field, scope: Scope) -> str | Invalid:
    """Return a path of keys."""
    return path_of(node, scope)


def settings(node: Node, field: Field, scope: Scope) -> Entries | Invalid:
    """Return {path: Entry}, at least one."""
    return _by_path(node, field, scope, lambda value, name: value)


def choices(node: Node, field: Field, scope: Scope) -> Entries | Invalid:
    """Return {path: Entry}, each of a list of nodes."""
    return _by_path(node, field, scope, lambda value, name: _values(value, name, scope))


def ranges(node: Node, field: Field, scope: Scope) -> Entries | Invalid:
    """Return {path: Entry}, each of two numbers [lowest, highest]."""
    return _by_path(node, field, scope, lambda value, name: _range(value, name, scope))


def _by_path(node, field, scope, value_of):
    if type(node.value) is not dict:
        return scope.refuse_value(node, field)
    if not node.value and field.required:
        return scope.refuse_value(node, field, "must not be empty")
    found = {}
    for name, (key, value) in node.value.items():
        scope.owner = key
        found[path_of(key, scope)] = Entry(key, value_of(value, name))
    return INVALID if INVALID in found or any(entry.node is INVALID for entry in found.values()) else found


def _values(node, name, scope):
    if type(node.value) is dict:
        return _span(node, name, scope)
    if type(node.value) is not list or not node.value:
        return scope.refuse_value(node, Field(name, Type("", "a list, or {from: 1, to: 2, number: 5}"), "-", ""))
    return node


def _span(node, name, scope):
    span = scope.checks["mapping"](node, Field(name, mapping(*SPAN_FIELDS), "-", ""), scope)
    if span is INVALID:
        return INVALID
    if text := _unlike(*(node.value[end][1].raw for end in ("from", "to"))):
        return scope.refuse(node, f"{quoted(name)}: {text}")
    first, last, steps = span["from"], span["to"], max(span["number"] - 1, 1)
    raw = node.value["from"][1].raw
    return node_at(node, [node_in_unit(node, first + (last - first) * i / steps, raw) for i in range(span["number"])])


def _range(node, name, scope):
    pair = replace(SPAN_FIELDS[0], name=name, type=Type("numbers", "[lowest, highest]"))
    if type(node.value) is not list or len(node.value) != 2:
        return scope.refuse_value(node, pair)
    found = scope.checks["numbers"](node, pair, scope)
    if found is INVALID:
        return INVALID
    if text := _unlike(*(end.raw for end in node.value)):
        return scope.refuse(node, f"{quoted(name)}: {text}")
    raw = node.value[0].raw
    return node_at(node, found, raw) if found[0] < found[1] else scope.refuse_value(node, pair, "must be ascending")


def _unlike(first, last):
    """Return an error text for ends of a range that are written as different quantities, or ""."""
    both = is_quantity(first) and is_quantity(last)
    return f"{first} and {last} are different quantities" if both and not alike(first, last) else ""


def node_at(node: Node, value: Content, raw: str = "") -> Node:
    """Return the node of another value at the position of ``node``; ``raw``: the written text, with its unit."""
    return Node(value, node.source, node.line, node.column, raw)


def node_in_unit(node: Node, value: float, raw: str) -> Node:
    """Return the node of a value [SI] of a range whose end is written as ``raw``: in its unit, if it has one."""
    if not is_quantity(raw):
        return node_at(node, value, raw)
    _, unit = number_and_unit(raw)
    return node_at(node, f"{value / converted(f'1 {unit}', ANY):.15g} {unit}", raw)


def plain_value(node: Node) -> Any:
    """Return the value of a node as plain JSON data."""
    if type(node.value) is dict:
        return {key: plain_value(item) for key, (_, item) in node.value.items()}
    return [plain_value(item) for item in node.value] if type(node.value) is list else node.value


def shown_value(value: Any) -> float | str:
    """Return a value as shown in tables: a quantity as a number in SI units, lists and mappings as text."""
    if type(value) is str and is_quantity(value):
        try:
            return converted(value, ANY)
        except UnitError:
            return value
    return value if type(value) in (int, float, str) else repr(value)


STUDY_CHECKS = {**CHECKS, "settings": settings, "choices": choices, "ranges": ranges, "path": path}
