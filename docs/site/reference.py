"""Pages of the reference, from the declarations of kinds, laws and sections of decks."""

import re
from dataclasses import replace

from formulas import markdown_of

from mecano.deck.catalogue import ROLES, UNITS_TEXT, WRITTEN
from mecano.deck.describe import default_text, inner_fields
from mecano.deck.examples import example_lines
from mecano.deck.expanded_sections import EXPANDED_SECTIONS, REPEAT
from mecano.deck.sections import SECTIONS
from mecano.elements import KINDS
from mecano.elements.members.cross_section import SHAPES
from mecano.laws import TERMS

WIDTH = 96
GROUPS = {"elements": "Elements", "joints": "Joints", "loads": "Loads", "signals": "Signals"}


def pages(decks):
    """Return {path: Markdown} of all pages; ``decks`` is {file name: text} of the examples, which list the uses."""
    named = {f"reference/{kind.name}.md": _kind_page(kind, decks) for kind in _named_kinds()}
    groups = {f"reference/{section}.md": _group_page(section, title) for section, title in GROUPS.items()}
    return {
        "reference/index.md": _index(),
        "reference/deck.md": _deck_page(),
        "reference/laws.md": _laws_page(),
        "reference/cross-sections.md": _shapes_page(),
        "reference/units.md": f"# Units\n\n```text\n{UNITS_TEXT}```\n",
        **groups,
        **named,
    }


def _named_kinds():
    return [kind for kind in KINDS.values() if kind.section]


def _index():
    lines = ["# Reference of decks", "", "Everything that a deck can contain, with the texts of `mecano explain`."]
    names = ("deck", *GROUPS, "laws", "cross-sections", "units")
    return "\n".join([*lines, "", *_toctree(names, ":maxdepth: 2")]) + "\n"


def _group_page(section, title):
    kinds = [kind for kind in _named_kinds() if kind.section == section]
    rows = [(f"[{kind.name}]({kind.name}.md)", _first_sentence(kind.doc)) for kind in kinds]
    lines = [f"# {title}", "", *_table(("kind", "description"), rows)]
    return "\n".join([*lines, "", *_toctree((kind.name for kind in kinds), ":maxdepth: 1", ":hidden:")]) + "\n"


def _toctree(names, *options):
    return ["```{toctree}", *options, "", *names, "```"]


def _kind_page(kind, decks):
    lines = [f"# {kind.name}", "", f"*Section* `{kind.section}` *of a deck.*", "", markdown_of(kind.doc)]
    lines += ["", "## Fields", "", *_fields(kind.fields)]
    if kind.outputs:
        lines += ["", "## Outputs", "", *_outputs(kind.outputs)]
    for field in dict.fromkeys(field for field, _, _ in kind.optional):
        lines += _option(field, [(part, label) for name, part, label in kind.optional if name == field])
    if kind.multipliers:
        rows = [(row.name, row.unit) for row in kind.multipliers]
        lines += ["", "## Multipliers", "", *_table(("reaction", "unit"), rows)]
    if kind.events:
        lines += ["", "## Events", "", *_table(("event", "meaning"), [(e.name, e.doc) for e in kind.events])]
    lines += ["", "## Example", "", *_example(kind.name, kind.section)]
    used = [name for name, text in decks.items() if re.search(rf"type: {kind.name}\b", text)]
    if used:
        lines += ["", "Used in " + ", ".join(f"[{name}](../../../inputs/{name})" for name in used) + "."]
    return "\n".join(lines) + "\n"


def _option(field, found):
    """Return the part on an option ``field``: documentation and outputs of its parts, [(Kind, label)]."""
    lines = ["", f"## With `{field}`"]
    for doc in dict.fromkeys(part.doc for part, _ in found):
        lines += ["", markdown_of(doc)]
    outputs = [replace(output, name=output.name + label) for part, label in found for output in part.outputs]
    return [*lines, "", *_outputs(list(dict.fromkeys(outputs)))]


def _deck_page():
    lines = ["# Sections of a deck", "", "A deck is a mapping of these; how they are written: [decks](../../decks.md)."]
    for section in (*SECTIONS, *EXPANDED_SECTIONS, REPEAT):
        lines += ["", f"## {section.name}", "", _declaration(section)]
        if section.name in GROUPS or section.name in ("laws", "sections"):
            lines += ["", _where(section.name)]
        if inner_fields(section.type):
            lines += ["", *_fields(inner_fields(section.type))]
        if section.name in WRITTEN:
            lines += ["", *_fenced(line.removeprefix("  ") for line in WRITTEN[section.name])]
    return "\n".join(lines) + "\n"


def _where(section):
    if section == "laws":
        return "Terms: [laws](laws.md)."
    if section == "sections":
        return "Shapes: [cross sections](cross-sections.md)."
    return "Kinds: " + ", ".join(f"[{k.name}]({k.name}.md)" for k in _named_kinds() if k.section == section) + "."


def _laws_page():
    lines = ["# Laws", "", "A law is a sum of terms: [how they are written](../../decks.md#laws)."]
    for role, title in ROLES.items():
        lines += ["", f"## {title[0].upper()}{title[1:]}"]
        for term in TERMS.values():
            if term.role == role:
                lines += _entry(term, "laws")
    return "\n".join(lines) + "\n"


def _shapes_page():
    lines = ["# Cross sections", "", "Axes 1 along the beam, 3 towards `up`, 2 = 3 x 1: [beams](../../beams.md)."]
    for shape in SHAPES.values():
        lines += _entry(shape, shape.section)
    return "\n".join(lines) + "\n"


def _entry(declared, section):
    """Return the part of a page on a term of a law or a shape."""
    level = "###" if section == "laws" else "##"
    lines = ["", f"{level} {declared.name}", "", markdown_of(declared.doc), ""]
    return [*lines, *_fields(declared.fields), "", *_example(declared.name, section)]


def _example(name, section):
    return _fenced([line.removeprefix("  ") for line in example_lines(name, section, WIDTH)[2:]])


def _fenced(lines):
    return ["```yaml", *lines, "```"]


def _fields(fields):
    rows = [
        (
            f"`{place}`",
            "" if field.unit == "-" else field.unit,
            field.type.expects,
            _value(field),
            markdown_of(field.doc),
        )
        for place, field in _places(fields)
    ]
    return _table(("field", "unit", "value", "default", "meaning"), rows) if rows else ["None."]


def _places(fields, before=""):
    """Yield (dotted name, Field) of fields and of those inside them."""
    for field in fields:
        yield before + field.name, field
        yield from _places(inner_fields(field.type), f"{before}{field.name}.")


def _value(field):
    return default_text(field).removeprefix("default ")


def _outputs(outputs):
    rows = [
        (f"`{o.name}`", "" if o.unit == "-" else o.unit, " x ".join(map(str, o.shape)) or "1", markdown_of(o.doc))
        for o in outputs
    ]
    return _table(("output", "unit", "numbers", "meaning"), rows)


def _unit(declared):
    return "" if declared.unit == "-" else declared.unit


def _table(heading, rows):
    return [_row(heading), _row("---" for _ in heading), *(_row(row) for row in rows)]


def _row(cells):
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _first_sentence(doc):
    first = " ".join(markdown_of(doc).split("\n\n")[0].split())
    return re.split(r"(?<=\.)\s(?=[A-Z])", first)[0]


def _declaration(section):
    unit = f" [{section.unit}]" if _unit(section) else ""
    return f"{section.doc[0].upper()}{section.doc[1:].rstrip('.')}{unit}; {default_text(section)}."
