"""The grammar of decks as JSON Schema, draft 7, for editors, from the same declarations as the check of decks.

It describes keys and types; names, physics and dimensions are left to `mecano check`.
"""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias

from mecano.deck.expanded_sections import EXPANDED_SECTIONS, REPEAT
from mecano.deck.sections import SECTIONS
from mecano.elements import KINDS
from mecano.elements.members.cross_section import SHAPES
from mecano.laws import TERMS
from mecano.schema import LINE, NODE_SET, NODES, SECTION_OF, Field, not_negative, positive, share

EXPRESSION = r"^\s*=|\$|^[-+( ]*(\.?[0-9]|pi\b|[a-z0-9]+\()"  # in place of a number: an expression, or 25 mm
WORD = r"^[A-Za-z_][A-Za-z0-9_]*$"  # of a parameter that is inserted into names
NAME = r"^[A-Za-z_$][A-Za-z0-9_$()+*/% -]*$"
BOUNDS = {positive: {"exclusiveMinimum": 0}, not_negative: {"minimum": 0}, share: {"minimum": 0, "maximum": 1}}
TEXT, NULL = {"type": "string"}, {"type": "null"}
WORKED_OUT = {"type": "string", "pattern": EXPRESSION}
NUMBER = {"$ref": "#/definitions/number"}
Schema: TypeAlias = dict[str, Any]  # JSON Schema, or a part of one, as plain data
LAW = {"$ref": "#/definitions/law"}


def deck_schema() -> Schema:
    """Return the schema of a deck, or of an included file, as plain data."""
    definitions = {
        "repeat": _repeat(),
        "law": _law(),
        **{f"term {term.name}": _term(term) for term in TERMS.values()},
        **{f"kind {kind.name}": _kind(kind) for kind in (*KINDS.values(), *SHAPES.values())},
        "template": _template(),
    }
    return file_schema("deck", (*SECTIONS, *EXPANDED_SECTIONS), ["mecano"], definitions)  # an included file has no more


def schema_text(schema: Schema) -> str:
    """Return a JSON Schema as the text of its file."""
    return json.dumps(schema, indent=1) + "\n"


def file_schema(
    what: str, fields: Iterable[Field], required: Sequence[str], definitions: Mapping[str, Schema]
) -> Schema:
    """Return the schema of a file of ``fields`` as plain data; the first of ``required`` is its version, 1."""
    properties = {field.name: _property(field) for field in fields}
    properties[required[0]]["const"] = 1
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": f"mecano {what}",
        "type": "object",
        "required": required,
        "additionalProperties": False,
        "properties": properties,
        "definitions": {"number": {"anyOf": [{"type": "number"}, WORKED_OUT]}, **definitions},
    }


def _property(field):
    """Return the schema of a field, with title and description for editors."""
    unit = "" if field.unit == "-" else f" [{field.unit}]"
    schema = _bounded(field) if field.check in BOUNDS else _of(field.type)
    if not field.required:
        schema = _or_null(schema)
    else:
        schema = {"allOf": [schema]} if "$ref" in schema else dict(schema)
    schema |= {"title": f"{field.name}{unit}", "description": field.doc}
    default = field.default
    if not field.required and default is not None and not (type(default) is float and math.isinf(default)):
        schema["default"] = list(default) if type(default) is tuple else default
    return schema


def _or_null(schema):
    """Return the schema with null allowed; errors inside a mapping or list still point to their position."""
    if type(schema.get("type")) is str:
        return {**schema, "type": [schema["type"], "null"]}
    return {**schema, "else": _or_null(schema["else"])} if "else" in schema else {"anyOf": [schema, NULL]}


def _bounded(field):
    type_ = field.type if field.type.name != "either" else field.type.options[0]
    words = [{"enum": list(field.type.options[1])}] if type_ is not field.type else []
    kind = "integer" if type_.name == "integer" else "number"
    return {"anyOf": [{"type": kind, **BOUNDS[field.check]}, WORKED_OUT, *words]}


def _of(type_):
    """Return the schema of a type."""
    if type_.schema is not None:
        return type_.schema
    if type_.name in WRITTEN:
        return WRITTEN[type_.name]
    if type_.name in MADE:
        return MADE[type_.name](type_)
    return TEXT if type_.name in SECTION_OF else {}


def _list(item, least=0, most=None):
    return {"type": "array", "items": item, "minItems": least, **({} if most is None else {"maxItems": most})}


def _items(item):
    """Return the schema of a list whose items may be repeated."""
    return _list({"if": {"type": "object", "required": ["repeat"]}, "then": REPEATED_ITEMS, "else": item})


def _nodes(type_):
    return _items(TEXT) if type_ in (NODES, NODE_SET) else _list(TEXT, *(2 * type_.options))


def mapping_schema(fields: Iterable[Field], doc: str = "", **more: Schema) -> Schema:
    """Return the schema of a mapping of ``fields``, and of ``more`` keys with schemas of their own."""
    properties = {field.name: _property(field) for field in fields}
    required = [field.name for field in fields if field.required]
    schema = {"type": "object", "properties": {**more, **properties}, "additionalProperties": False}
    if required:
        schema["required"] = required
    return {**schema, "description": doc.strip().split("\n\n")[0]} if doc else schema


def _kind(kind):
    return mapping_schema(kind.fields, kind.doc, type={"const": kind.name}, repeat={"$ref": "#/definitions/repeat"})


def _one_of_kinds(type_):
    kinds = [kind for kind in (*KINDS.values(), *SHAPES.values()) if kind.section == type_.options[0]]
    chosen = [
        {"if": {"properties": {"type": {"const": kind.name}}}, "then": {"$ref": f"#/definitions/kind {kind.name}"}}
        for kind in kinds
    ]
    names = {"enum": [kind.name for kind in kinds], "description": "kind; `mecano list` describes each"}
    return {"type": "object", "required": ["type"], "properties": {"type": names}, "allOf": chosen}


def _named(type_):
    """Return the schema of a section of names, each entry of which may be repeated."""
    inner = type_.options[0]
    repeated = inner.name == "mapping"
    entry = mapping_schema(inner.options, repeat={"$ref": "#/definitions/repeat"}) if repeated else _of(inner)
    return {"type": "object", "propertyNames": {"pattern": NAME}, "additionalProperties": entry}


def _shorthand(type_):
    """Return the schema of a mapping or list, or of the keywords that replace one."""
    schema, words = _of(type_.options[0]), [word for word, _ in type_.options[1]]
    return {"if": {"type": schema["type"]}, "then": schema, "else": {"enum": words}}


def _law():
    terms = {name: {"$ref": f"#/definitions/term {name}"} for name in TERMS}
    mapping = {
        "type": "object", "description": "a sum of terms", "minProperties": 1, "additionalProperties": False,
        "properties": {**terms, "repeat": {"$ref": "#/definitions/repeat"}},
    }  # fmt: skip
    several = {"type": "array", "description": "a sum of terms, some of one name", "minItems": 1, "items": mapping}
    return {"if": {"type": "array"}, "then": several, "else": mapping}


def _term(term):
    """Return the schema of a mapping of fields; a term with one required field may also be its value."""
    fields = mapping_schema(term.fields, term.doc)
    return {"anyOf": [_of(term.single.type), fields]} if term.single else fields


def _repeat():
    value = {"type": ["number", "string"]}
    values = {"type": "object", "minProperties": 1, "additionalProperties": {"anyOf": [TEXT, _list(value, 1)]}}
    row = {"type": "object", "minProperties": 1, "additionalProperties": value}
    return {"description": REPEAT.doc, "anyOf": [values, _list(row, 1)]}


def _template():
    parts = [
        field for field in (*SECTIONS, *EXPANDED_SECTIONS) if field.type.name == "named" and field.name != "templates"
    ]
    properties = {field.name: _property(field) for field in parts}
    value = {"type": ["number", "string", "null"]}
    properties["parameters"] = {
        "description": "names with defaults; one without must be given by 'with'", "type": "object",
        "additionalProperties": value,
    }  # fmt: skip
    return {"type": "object", "additionalProperties": False, "properties": properties}


ARRAY_OR_ROWS = {"anyOf": [NUMBER, _list(NUMBER)]}
REPEATED_ITEMS = {
    "type": "object", "description": "items for each value of a repeat", "required": ["repeat", "items"],
    "properties": {"repeat": {"type": ["object", "array"]}, "items": {"type": "array"}}, "additionalProperties": False,
}  # fmt: skip
WRITTEN = {
    "number": NUMBER, "parameter": {"anyOf": [NUMBER, {"type": "string", "pattern": WORD}]},
    "integer": {"anyOf": [{"type": "integer"}, WORKED_OUT]},
    "boolean": {"type": "boolean"}, "text": TEXT, "unit": TEXT, "numbers": _items(NUMBER),
    "coefficients": _list(NUMBER), "vector": _list(NUMBER, 3, 3),
    "direction": _list(NUMBER, 3, 3), "inertia": _list(ARRAY_OR_ROWS, 3, 6), "matrix": _list(_list(NUMBER, 6, 6), 6, 6),
    "matrix_6": _list(ARRAY_OR_ROWS, 6, 6), "points": _list(_list(NUMBER, 2, 2)), "law": {"anyOf": [TEXT, LAW]},
    "drive": {"anyOf": [{"type": "number"}, TEXT, LAW]}, "formula": {"type": ["string", "number"]}, "condition": TEXT,
    "function": {"type": ["string", "number"]},
    "curve": {"anyOf": [{"type": "number"}, TEXT, LAW]}, "law_in_place": {"anyOf": [NUMBER, LAW]},
    "reduced": {"anyOf": [TEXT, {"type": "object"}]}, "rows": {"anyOf": [TEXT, _list(_list(NUMBER))]},
    "arguments": {"type": "object", "additionalProperties": {"type": ["number", "string"]}},
    "columns": _list({"type": ["string", "integer"]}, 2, 2), "units": _list(TEXT, 2, 2),
    "files": {"anyOf": [TEXT, _list(TEXT)]}, "template": {"$ref": "#/definitions/template"},
}  # fmt: skip
MADE = {
    "choice": lambda t: {"enum": list(t.options)},
    "nodes": lambda t: {"anyOf": [TEXT, _items(TEXT)]} if t == LINE else _nodes(t),
    "mapping": lambda t: mapping_schema(t.options),
    "named": _named,
    "list": lambda t: (_items if t.options[0].name == "mapping" else _list)(_of(t.options[0])),
    "either": lambda t: {"anyOf": [_of(t.options[0]), {"enum": list(t.options[1])}]},
    "shorthand": _shorthand,
    "kind": _one_of_kinds,
    "signal_entry": lambda t: {"if": {"type": "object"}, "then": _one_of_kinds(t), "else": WRITTEN["formula"]},
}  # fmt: skip
