"""Checks of mappings and lists: known and required keys, defaults, names, kinds. Arguments as in values.py."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from mecano.deck.compose import Node
from mecano.deck.expressions import is_evaluated
from mecano.deck.limits import ARITHMETIC, BEYOND_FLOATS
from mecano.deck.scalar import number
from mecano.deck.scope import INVALID, Checked, Invalid, Reference, Scope, node_of, place, place_of
from mecano.deck.similar_names import similar
from mecano.deck.units import is_quantity
from mecano.deck.wording import found, quoted, unit_text
from mecano.element_interface import SECTIONS
from mecano.schema import Field, Values

IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")
RESERVED = {"nodes": ("ground", "all")}
BEGIN = "begin it in the first column"
SECTION_NAMES = (
    "parameters", "nodes", *SECTIONS, "laws", "grounds", "tire_laws", "sections", "initial", "time", "output",
)  # fmt: skip
KEYS_OF_SECTIONS = {  # of those that are no mappings of names
    "initial": ("velocities", "steady", "static", "from"), "time": ("end", "step"), "output": ("every", "at"),
}  # fmt: skip


def checked(node: Node, field: Field, scope: Scope) -> Checked:
    """Return the value of a field if it has the right type and passes its own check; else INVALID."""
    owner = scope.owner
    value = scope.checks[field.type.name](node, field, scope)
    if field.check is None or value is INVALID or type(value) is Reference:
        return value
    if field.type.name == "either" and type(value) is str:
        return value
    text = _complaint(field, value)
    if not text:
        return value
    if type(value) is dict and field.type.name != "named":
        path = scope.name_of(field.name)
        return scope.refuse(place_of(text, node, owner or node), f"{path}: {text}" if path else text)
    if value == {}:  # of entries that were refused, or removed by an override
        return scope.refuse(node, f"{quoted(scope.name_of(field.name))} {text}")
    return scope.refuse_value(node, field, text)


def _complaint(field, value):
    """Return the complaint of the check of a field about a value, or None."""
    try:
        return field.check(value)
    except ARITHMETIC:
        return f"has numbers that are {BEYOND_FLOATS}"


def default(field: Field, scope: Scope) -> Checked:
    """Return a new copy of the checked default of a field. An infinite number represents an absent bound."""
    if field.default is None or field.type.name == "number":
        return field.default
    if id(field) not in scope.defaults:
        scope.defaults[id(field)] = checked(node_of(field.default), field, scope)
    return _copy(scope.defaults[id(field)])


def _copy(value):
    if type(value) is dict:
        return {key: _copy(item) for key, item in value.items()}
    return [_copy(item) for item in value] if type(value) is list else value


def mapping(node: Node, field: Field, scope: Scope) -> Values | Invalid:
    """Return a dict with all fields of the type, defaults filled in."""
    return filled(node, field, field.type.options, scope)


def filled(
    node: Node, field: Field, fields: Iterable[Field], scope: Scope, given: Mapping[str, Any] | None = None
) -> Values | Invalid:
    """Return a dict of the fields from a mapping; ``given`` are keys and values that the caller has already read."""
    if type(node.value) is not dict:
        return scope.refuse_value(node, field, hint=_as_mapping(node, fields, of_deck=not scope.subject))
    before, owner = len(scope.problems), scope.owner or node
    values = dict(given or {})
    known = {inner.name for inner in fields}.union(values)
    if field.name:
        scope.path.append(field.name)
    hints, before_it = "", None
    for key, (key_node, value_node) in node.value.items():
        if key in SECTION_NAMES and key not in known and _is_misplaced(key, value_node):
            scope.misplaced.add(key)
            of = " of decks, not of this file" if key_node.column == 0 else ""
            scope.refuse(key_node, f"{quoted(scope.name_of(key))} is a section{of}", "" if of else BEGIN)
        elif key not in known:
            from mecano.deck.unknown_keys import refuse_key  # few decks need it

            hints += refuse_key((key_node, value_node), before_it, known, fields, field, scope)
        before_it = value_node
    for inner in fields:
        pair = node.value.get(inner.name)
        if pair and not _left_out(pair[1], inner):
            scope.owner = pair[0]
            place(values, inner.name, checked(pair[1], inner, scope), scope)
        elif inner.required:
            if quoted(inner.name) not in hints:  # one mistake, one message
                _missing(inner, owner, scope)
        else:
            values[inner.name] = default(inner, scope)
    if field.name:
        scope.path.pop()
    # a parameter that was refused elsewhere makes a value invalid without another problem
    refused = len(scope.problems) > before or any(value is INVALID for value in values.values())
    return INVALID if refused else values


def _as_mapping(node, fields, of_deck):
    """Return a hint if a value may be the one required field, or 'points', of the expected mapping, or "".

    A section ``of_deck`` that requires nothing is chosen by an empty mapping.
    """
    fields = tuple(fields)
    if of_deck and node.value is True and fields and not any(field.required for field in fields):
        return "write {}, for all its defaults"
    required = [field for field in fields if field.required or field.type.name == "points" or len(fields) == 1]
    if len(required) != 1:
        return ""
    name, type_ = required[0].name, required[0].type.name
    if type(node.value) is list:
        text = found(node)
        return f"write {{{name}: {text if text.startswith('[') else '[...]'}}}" if type_ in ("vector", "points") else ""
    is_number = type(node.value) in (int, float) or (type(node.value) is str and _is_number(node.value))
    if type_ == "text" and type(node.value) is str and IDENTIFIER.fullmatch(node.value):
        return f"write {{{name}: {node.value}}}"
    return f"write {{{name}: {node.raw}}}" if type_ in ("number", "either") and is_number and node.raw else ""


def _left_out(node, field):
    """Return True if an optional field is written as null; an empty value is more likely a slip."""
    return node.value is None and node.raw != "" and not field.required


def _missing(field, owner, scope):
    what = f"{field.type.expects}{unit_text(field)}: {field.doc}"
    scope.refuse(owner, f"missing {quoted(scope.name_of(field.name))}, {what}")


def named(node: Node, field: Field, scope: Scope) -> Values | Invalid:
    """Return a dict from names chosen by the user to values of one type."""
    if type(node.value) is not dict:
        listed = type(node.value) is list and any(type(item.value) is dict for item in node.value)
        empty = "leave it out, or write {}" if node.value is None and not field.required else ""
        hint = "begin each entry with its name and ':', not with '-'" if listed else empty
        return scope.refuse_value(node, field, hint=hint)
    before = len(scope.problems)
    values: Values = {}
    type_, check = field.type.options
    inner = Field("", type_, field.unit, field.doc, check=check)
    outer, path = scope.subject, scope.path
    scope.path = []
    for name, (key_node, value_node) in node.value.items():
        scope.subject, scope.owner = f"{singular(field.name)} {quoted(name)}", key_node
        _check_name(name, key_node, field, scope)
        if name in SECTION_NAMES and _is_misplaced(name, value_node):
            scope.misplaced.add(name)
            place(values, name, scope.refuse(key_node, "this is a section", BEGIN), scope)
            if value_node.value is None:  # its entries follow as if they were some of this section
                break
            continue
        place(values, name, checked(value_node, inner, scope), scope)
    scope.subject, scope.path = outer, path
    return values if len(scope.problems) == before else INVALID


def _is_misplaced(name, node):
    """Return True if an entry with the ``name`` of a section looks like one: empty, of mappings, or with its keys."""
    if type(node.value) is not dict:
        return node.value is None
    if name in KEYS_OF_SECTIONS:
        return any(key in node.value for key in KEYS_OF_SECTIONS[name])
    values = [value.value for _, value in node.value.values()]
    if name == "signals":
        return not {"type", "position"} & node.value.keys() and all(type(value) in (dict, str) for value in values)
    return all(type(value) is dict for value in values)


def singular(section: str) -> str:
    """Return the name of a single entry of a section."""
    return section.removesuffix("s").replace("_", " ")


def _check_name(name, key_node, field, scope):
    if text := wrong_name(name, field.name):
        scope.refuse(key_node, text)


def wrong_name(name: str, section: str) -> str:
    """Return the reason why an entry of a section cannot have this name, or ""."""
    if not IDENTIFIER.fullmatch(name):
        return "a name begins with a letter from a to z or '_', and contains only such letters, digits, '_' and '-'"
    return f"the name {quoted(name)} is reserved" if name in RESERVED.get(section, ()) else ""


def list_(node: Node, field: Field, scope: Scope) -> list[Any] | Invalid:
    """Return a list of values of one type, each with its own check."""
    if type(node.value) is not list:
        hint = "begin each item with '-', or put it in a list: [{...}]" if type(node.value) is dict else ""
        return scope.refuse_value(node, field, hint=hint)
    before, values = len(scope.problems), [None] * len(node.value)
    type_, check = field.type.options
    for i, item in enumerate(node.value):
        inner = Field(f"{field.name}[{i}]", type_, field.unit, field.doc, check=check)
        scope.owner = item
        place(values, i, checked(item, inner, scope), scope)
    return values if len(scope.problems) == before else INVALID


def either(node: Node, field: Field, scope: Scope) -> Checked:
    """Return one of the keywords of the type, or a value of its other type."""
    type_, words = field.type.options
    if type(node.value) is str and node.value in words:
        return node.value
    if type(node.value) is str and not _is_number(node.value):
        lone = type_.name == "nodes" and IDENTIFIER.fullmatch(node.value) and not similar(node.value, words)
        return scope.refuse_value(node, field, hint=f"write [{node.value}]" if lone else "")
    return scope.checks[type_.name](node, replace(field, type=type_), scope)


def _is_number(text):
    return is_evaluated(text) or is_quantity(text) or number(text) is not None


def shorthand(node: Node, field: Field, scope: Scope) -> Checked:
    """Return the meaning of a keyword of the type, or a value of its type."""
    type_, words = field.type.options
    for word, meaning in words:
        if type(node.value) is type(word) and node.value == word:
            node = node_of(meaning)
            break
    if type(node.value) not in (dict, list):
        return scope.refuse_value(node, field)
    return scope.checks[type_.name](node, replace(field, type=replace(type_, expects=field.type.expects)), scope)


def kind(node: Node, field: Field, scope: Scope) -> Values | Invalid:
    """Return an element, joint or load as {"type": name of the kind, and the fields of the kind}."""
    if type(node.value) is not dict:
        return scope.refuse_value(node, field)
    section = field.type.options[0]
    if "type" not in node.value:
        from mecano.deck.unknown_keys import refuse_untyped  # few decks need it

        return refuse_untyped(node, section, scope)
    type_node = node.value["type"][1]
    found = scope.kinds.get(type_node.value) if type(type_node.value) is str else None
    if found is None or found.section != section:
        from mecano.deck.unknown_keys import refuse_kind  # few decks need it

        return refuse_kind(type_node, section, scope)
    scope.subject = f"{found.name} {scope.subject.partition(' ')[2]}"
    return filled(node, field, found.fields, scope, {"type": found.name})
