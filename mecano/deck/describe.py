"""Texts on kinds, terms of laws and sections, from their declarations: the output of `mecano explain`."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from textwrap import wrap

import numpy as np

from mecano.deck.examples import example_lines
from mecano.element_interface import Kind
from mecano.element_interface.declarations import Output
from mecano.elements.members.cross_section import Shape
from mecano.elements.wheels.slip_law import SlipLaw
from mecano.laws.term import Term
from mecano.model.measured_outputs import measurable, powers
from mecano.schema import Field, Type

WIDTH = 100


def describe(kind: Kind) -> str:
    """Return the text on a kind of element, joint or load: its documentation, fields and outputs."""
    parts = [f"{kind.name} (section '{kind.section}')", "", kind.doc.strip(), "", "Fields", *field_lines(kind.fields)]
    if kind.outputs:
        parts += ["", "Outputs", *output_lines(kind.outputs)]
    names = [*(output.name for output in measurable(kind)), *powers(kind)]
    if names and kind.section != "signals":
        parts += ["", *wrap(f"Signals can read its {', '.join(names)} (mecano explain signals).", WIDTH)]
    for field in dict.fromkeys(field for field, _, _ in kind.optional):
        parts += _option(field, [(part, label) for name, part, label in kind.optional if name == field])
    if kind.multipliers:
        parts += ["", "Multipliers"]
        parts += [f"  {row.name} [{row.unit}]" for row in kind.multipliers]
    parts += _event_lines("Events", [kind, *_variants(kind)])
    return "\n".join([*parts, *example_lines(kind.name, kind.section, WIDTH)]) + "\n"


def _variants(kind):
    """Return the variants of a kind for the deck values of its samples."""
    samples = kind.samples(np.random.default_rng(0)) if kind.variant else []
    defaults = {field.name: field.default for field in kind.fields}
    return [kind.chosen({**defaults, **values}) for values, *_ in samples]


def _event_lines(heading, kinds):
    """Return the lines on the events of ``kinds``, each event once, with all its meanings."""
    meanings: dict[str, dict[str, None]] = {}
    lines: list[str] = []
    for event in (event for kind in kinds for event in kind.events):
        meanings.setdefault(event.name, {})[event.doc] = None
    for name, (first, *others) in meanings.items():
        lines += [f"  {name}: {first}", *(f"      or: {doc}" for doc in others)]
    return ["", heading, *lines] if lines else []


def _option(field, found):
    """Return the lines on an option ``field``: documentation and outputs of its parts, [(Kind, label)]."""
    lines = ["", f"With '{field}'"]
    for doc in dict.fromkeys(part.doc for part, _ in found):
        lines += ["", doc.strip()]
    lines += ["", f"Outputs with '{field}'"]
    named = [replace(output, name=output.name + label) for part, label in found for output in part.outputs]
    lines += output_lines({(one.name, one.unit, one.doc): one for one in named}.values())
    return lines + _event_lines(f"Events with '{field}'", [part for part, _ in found])


def describe_shape(shape: Shape) -> str:
    """Return the text on a shape of cross sections: its fields."""
    parts = [f"{shape.name} (section '{shape.section}')", "", shape.doc.strip(), "", "Fields"]
    example = example_lines(shape.name, shape.section, WIDTH)
    return "\n".join([*parts, *field_lines(shape.fields), *example]) + "\n"


def describe_term(term: Term) -> str:
    """Return the text on a term of a law: its fields."""
    what = "y of one variable s" if term.role == "curve" else "force F of extension s and rate v"
    parts = [f"{term.name} (term of a law, {what})", "", term.doc.strip(), "", *field_lines(term.fields)]
    example = example_lines(term.name, "laws", WIDTH)
    return "\n".join([*parts, *example, "", "More on laws: mecano explain laws"]) + "\n"


def describe_slip_law(law: SlipLaw) -> str:
    """Return the description of a slip law of tyres: its documentation and fields."""
    fields = (Field(law.name, law.type, "-", "a field of a tyre law"),)
    parts = [f"{law.name} (slip law, a field of 'tire_laws')", "", law.doc.strip(), "", "Fields", *field_lines(fields)]
    return "\n".join([*parts, *example_lines(law.name, "tire_laws", WIDTH)]) + "\n"


def describe_section(field: Field) -> str:
    """Return the text on a section of the deck with all fields below it."""
    return "\n".join([f"{field.name} (section of the deck)", "", *field_lines((field,))]) + "\n"


def field_lines(fields: Iterable[Field], indent: int = 1) -> list[str]:
    """Return lines for each field: name, unit, type, default, meaning; fields of inner mappings below theirs."""
    lines = []
    for field in fields:
        unit = "" if field.unit == "-" else f" [{field.unit}]"
        value = default_text(field)
        lines.append("  " * indent + f"{field.name}{unit}: {field.type.expects}; {value}")
        lines += _paragraph(field.doc, indent + 2)
        lines += field_lines(inner_fields(field.type), indent + 1)
    return lines


def output_lines(outputs: Iterable[Output]) -> list[str]:
    """Return lines for each output: name, unit, shape, meaning."""
    lines = []
    for output in outputs:
        unit = "" if output.unit == "-" else f" [{output.unit}]"
        shape = f", {' x '.join(map(str, output.shape))} numbers" if output.shape else ""
        lines += [f"  {output.name}{unit}{shape}", *_paragraph(output.doc, 3)]
    return lines


def _paragraph(text, indent):
    return wrap(text, WIDTH, initial_indent="  " * indent, subsequent_indent="  " * indent)


def default_text(field: Field) -> str:
    """Return the default of a field as shown to users: "required", "default 0.8", or "optional" without a default."""
    if field.required:
        return "required"
    if field.default is None or field.default in ((), {}, "", math.inf, -math.inf):
        return "optional"
    value = list(field.default) if isinstance(field.default, tuple) else field.default
    return f"default {str(value).lower() if isinstance(value, bool) else value}"


def inner_fields(type_: Type) -> Sequence[Field]:
    """Return the fields inside a value of a type: of a mapping, or of the mappings in a list or under names."""
    if type_.name == "mapping":
        return type_.options
    if type_.name in ("named", "list", "either", "shorthand"):
        return inner_fields(type_.options[0])
    return ()
