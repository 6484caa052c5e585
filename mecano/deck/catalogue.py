"""All that a deck can contain, by name: what `mecano list` and `mecano explain` print."""

import re
from textwrap import wrap

from mecano.deck.describe import WIDTH, describe, describe_section, describe_shape, describe_term
from mecano.deck.sections import SECTIONS
from mecano.deck.wording import quoted, suggestion
from mecano.elements import KINDS
from mecano.elements.cross_section import SHAPES
from mecano.errors import UsageError
from mecano.laws import TERMS

ROLES = {"curve": "laws of one variable", "force": "laws of extension and rate"}
_MATHS = re.compile(r":math:`([^`]*)`")
_DISPLAY = re.compile(r"^\.\. math:: *", re.MULTILINE)


def catalogue():
    """Text: all kinds by section, all terms of laws, all sections, each with what it is in a line."""
    groups = {f"{kind.section}:": [] for kind in KINDS.values()}
    for kind in KINDS.values():
        groups[f"{kind.section}:"].append((kind.name, kind.doc))
    for role, title in ROLES.items():
        groups[f"terms of laws, {title}:"] = [(term.name, term.doc) for term in TERMS.values() if term.role == role]
    groups["cross sections of beams:"] = [(shape.name, shape.doc) for shape in SHAPES.values()]
    groups["sections of a deck:"] = [(section.name, section.doc) for section in SECTIONS]
    width = max(len(name) for entries in groups.values() for name, _ in entries)
    lines = []
    for title, entries in groups.items():
        lines.append(title)
        for name, doc in entries:
            head, rest = f"  {name:<{width}}  ", " " * (width + 4)
            lines += wrap(_sentence(doc), WIDTH + width, initial_indent=head, subsequent_indent=rest)
        lines.append("")
    return "\n".join([*lines, "mecano explain NAME says more of each."])


def explain(name):
    """Text on a kind, a term of a law or a section of the deck; on all of that name.

    Raises UsageError for an unknown name, with the most similar one.
    """
    sections = {section.name: section for section in SECTIONS}
    found = [(KINDS, describe), (SHAPES, describe_shape), (TERMS, describe_term), (sections, _section)]
    texts = [_plain(text(known[name])) for known, text in found if name in known]
    if not texts:
        known = [*KINDS, *SHAPES, *TERMS, *sections]
        hint = suggestion(name, known) or "`mecano list` names all"
        raise UsageError(f"there is no kind, law or section {quoted(name)}; {hint}")
    return ("\n" + "-" * WIDTH + "\n\n").join(texts)


def _section(section):
    """A section, with the names of all that may stand in it where a kind or a term is to be named."""
    names = [kind.name for kind in (*KINDS.values(), *SHAPES.values()) if kind.section == section.name]
    names = list(TERMS) if section.name == "laws" else names
    if not names:
        return describe_section(section)
    listed = wrap(", ".join(names), WIDTH, initial_indent="  ", subsequent_indent="  ")
    return "\n".join([describe_section(section), "Kinds", *listed, ""])


def _sentence(doc):
    """The first sentence of a documentation, in one line."""
    first = " ".join(_plain(doc).strip().split("\n\n")[0].split())
    return re.split(r"(?<=\.)\s(?=[A-Z])", first)[0]


def _plain(doc):
    """Documentation for a terminal: formulas without the markup around them."""
    return _DISPLAY.sub("    ", _MATHS.sub(r"\1", doc))
