"""Everything that a deck can contain, by name: the texts of `mecano list` and `mecano explain`."""

import re
from collections.abc import Callable, Mapping
from textwrap import wrap
from typing import Any

from mecano.deck.describe import (
    WIDTH,
    describe,
    describe_section,
    describe_shape,
    describe_slip_law,
    describe_term,
    field_lines,
)  # fmt: skip
from mecano.deck.expanded_sections import EXPANDED_SECTIONS, REPEAT
from mecano.deck.plain_maths import plain_text
from mecano.deck.sample_decks import example_text
from mecano.deck.sections import SECTIONS
from mecano.deck.synonyms import SYNONYMS, synonym, synonym_of_end
from mecano.deck.units import ALONE, PREFIXED, PREFIXES
from mecano.deck.wording import quoted, suggestion
from mecano.elements import KINDS
from mecano.elements.members.cross_section import SHAPES
from mecano.elements.wheels.slip_laws import SLIP_LAWS
from mecano.errors import UsageError
from mecano.laws import TERMS
from mecano.schema import Type

ALL_SECTIONS = {section.name: section for section in (*SECTIONS, *EXPANDED_SECTIONS, REPEAT)}
ROLES = {"curve": "curves y of one variable s", "force": "forces F of extension s and rate v"}
SEPARATOR = "\n" + "-" * WIDTH + "\n\n"
ELSEWHERE = {  # topics of `mecano explain` besides kinds, terms, sections and fields
    "units": "Units of numbers, as in 25 mm, 3 bar, 12 deg.", "study": "The files of `mecano sweep`.",
}  # fmt: skip
LAWS = [
    "A law is a sum of terms, each with its fields. It is named in the section 'laws' or written in place:",
    "",
    "  laws:",
    "    rising: {polynomial: {coefficients: [0, 0, 60]}}                        # 60 s^2",
    "    strut: {spring: {stiffness: 2.0e4}, damper: {coefficient: 300}}         # terms add up",
    "    two: [{bump: {start: 5, length: 1, height: 0.04}}, {bump: {start: 9, length: 1, height: 0.04}}]",
    "",
    "  value: rising                                   # the name of a law, in a field that takes one",
    "  value: {linear: {slope: 2.0}}                   # the same written in place",
    "  value: 4.0                                      # a number: constant",
    "",
]
SIGNALS = [
    "A signal is a formula, or a mapping with a type (a filter, a controller). Loads accept formulas as well as laws:",
    "",
    "  signals:",
    "    error: 0.5 - knee.angle                                    # an output of a joint",
    "    smooth: {type: lag, input: tip.velocity.z, time_constant: 20 ms}",
    "    torque: $gain*error - 2*knee.rate + min(smooth, 3)*sin(6*time)",
    "  loads:",
    "    motor: {type: joint_moment, joint: knee, value: torque}",
    "",
    "mecano explain formula lists what a formula may contain.",
    "",
]
WRITTEN = {
    "include": ["  include: [laws.yaml, parts/wheel.yaml]"],
    "set": ["  include: gear.yaml", "  set: {parameters.mass: 9400 kg, joints.stop: null, time.end: 3 s}"],
    "repeat": ["  nodes:", "    p$i: {repeat: {i: 0..5}, position: [0.1 * $i, 0, 0]}", "  elements:",
               "    bar$i: {repeat: {i: 1..5}, type: bar, nodes: [p$(i - 1), p$i], axial_stiffness: 10 kN}",
               "    rail: {type: rigid_body, node: a, mass: 1, inertia: [1, 1, 1],",
               "      attached: [b, {repeat: {i: 0..5}, items: [p$i]}]}"],
    "templates": ["  templates:", "    leg:", "      parameters: {length: 1.0, hold: null} # null: must be given",
                  "      nodes: {hip: {position: [0, 0, 0]}, toe: {position: [$length, 0, 0]}}",
                  "      joints: {pin: {type: spherical, nodes: [$hold, hip]}}"],
    "place": ["  place:", "    left: {template: leg, position: [0, 1, 0], orientation: [0, 0, 90 deg], "
              "with: {hold: top, length: 2}}", "  # adds nodes left_hip and left_toe, and the joint left_pin"],
}  # fmt: skip
UNITS_TEXT = "\n".join([
    "units (of numbers, as in 25 mm, 3 bar, 12 deg, 60 km/h, 2 kN/mm, 40 N m/rad)", "",
    *wrap(f"with the prefixes {' '.join(filter(None, PREFIXES))}: {' '.join(PREFIXED)}", WIDTH),
    *wrap(f"without: {' '.join(ALONE)}", WIDTH), "",
    "Powers: m2 or m^2. Products: N m. A / divides by the one unit after it: N/m/s. Without a unit: SI, radians.", "",
])  # fmt: skip


def catalogue(word: str = "") -> str:
    """Return the text of `mecano list`: all kinds by section, all terms of laws, all sections, each with a summary.

    With a ``word``, such as "joints" or "laws", only the groups whose title has it. Raises UsageError if none has.
    """
    groups: dict[str, list[Any]] = {}  # by title, of entries with name and doc
    for kind in KINDS.values():
        groups.setdefault(kind.section, []).append(kind)
    for role, title in ROLES.items():
        groups[f"terms of laws, {title}"] = [term for term in TERMS.values() if term.role == role]
    groups["slip laws of tyres, fields of tire_laws"] = [*SLIP_LAWS.values()]
    groups["cross sections of beams"] = [*SHAPES.values()]
    groups["sections of a deck"] = [*SECTIONS]
    groups["to compose decks"] = [*EXPANDED_SECTIONS, REPEAT]
    shown = {title: entries for title, entries in groups.items() if word.lower() in title}
    if not shown:
        raise UsageError(f"there is no list of {quoted(word)}; there are lists of {'; '.join(groups)}")
    width = max(len(entry.name) for entries in shown.values() for entry in entries)
    lines = []
    for title, entries in shown.items():
        lines.append(f"{title}:")
        for entry in entries:
            lines += _listed(entry.name, _sentence(entry.doc), width, WIDTH + width)
        lines.append("")
    return "\n".join([*lines, "mecano explain NAME describes each, mecano explain study the study files."])


def explain(name: str) -> str:
    """Return the text on all kinds, terms of laws and sections of the deck with this name.

    For a word of other programs, return the equivalents in mecano, for an example deck how to see it. Raises UsageError
    for an unknown name, with the most similar ones.
    """
    texts, known = _texts_on(name)
    for other in (re.sub("[ -]", "_", name), name.replace(" ", "."), name.lower()):
        texts = texts or _texts_on(other)[0]
    meant = synonym(name) or (None if texts else synonym_of_end(name))
    example = example_text(name)
    if not texts and not meant and not example:
        raise UsageError(f"there is no kind, law or section {quoted(name)}; {_nearest(name, known)}")
    if meant:
        texts.append(_for_synonym(name, *meant, bool(texts)))
    if example:
        texts.append(example)
    return SEPARATOR.join(texts)


def _texts_on(name):
    """Return the texts on everything with this name, and the names of kinds, shapes, terms and sections."""
    if name == "units":
        return [UNITS_TEXT], ()
    section = f"{name.replace(' ', '_')}s"  # ground, tire law: an entry of a section
    name = section if section in ALL_SECTIONS else name
    slip_laws = {key: law for key, law in SLIP_LAWS.items() if law.type.name == "mapping"}  # friction is of many
    found: list[tuple[Mapping[str, Any], Callable[[Any], str]]] = [
        (KINDS, describe), (SHAPES, describe_shape), (TERMS, describe_term), (slip_laws, describe_slip_law),
        (ALL_SECTIONS, _section),
    ]  # fmt: skip
    texts = [plain_text(text(known[name])) for known, text in found if name in known]
    texts = texts or [plain_text(text) for text in _texts_on_field(name)]
    return texts, [*KINDS, *SHAPES, *TERMS, *SLIP_LAWS, *ALL_SECTIONS]


def _nearest(name, known):
    """Return a hint for an unknown name: similar names of mecano first, then similar words of other programs."""
    owner = name.rpartition(".")[0]
    inside = [f"{owner}.{field.name}" for where, field in _fields() if owner and where == owner]
    return suggestion(name, inside or [*known, *SYNONYMS]) or "`mecano list` lists all"


def _for_synonym(name, targets, note, known):
    """Return the text on a word of other programs: in full for one equivalent, first sentences for several."""
    lines = [f"See also, for {quoted(name)}:" if known else f"{name}: equivalents in mecano", ""]
    width = max(map(len, targets), default=0)
    for target in targets:
        lines += _listed(target, _first_words(target), width, WIDTH)
    lines += wrap(f"{note[0].upper()}{note[1:]}.", WIDTH) if note else []
    return "\n".join([*lines, *(["", "mecano explain NAME describes each."] if targets else []), ""])


def _first_words(target):
    """Return the first sentence on a target of a synonym."""
    for known in (KINDS, SHAPES, TERMS, SLIP_LAWS, ALL_SECTIONS):
        if target in known:
            return _sentence(known[target].doc)
    return ELSEWHERE.get(target) or next(_fields_named(target))[1].doc


def _fields_named(name):
    """Yield (place, Field) of fields with the name "owner.field"."""
    owner, _, last = name.rpartition(".")
    for where, field in _fields():
        if field.name == last and (not owner or where == owner):
            yield where, field


def _section(section):
    """Return the text on a section, with the names of the kinds or terms that it may contain."""
    names = [kind.name for kind in (*KINDS.values(), *SHAPES.values()) if kind.section == section.name]
    names = list(TERMS) if section.name == "laws" else names
    written = {"laws": LAWS, "signals": SIGNALS}.get(section.name, [])
    if not names:
        return "\n".join([describe_section(section), *WRITTEN.get(section.name, ())])
    listed = wrap(", ".join(names), WIDTH, initial_indent="  ", subsequent_indent="  ")
    return "\n".join([describe_section(section), *written, "Kinds", *listed, ""])


def _texts_on_field(name):
    """Yield texts on a field of kinds or sections, or on a keyword of one: "friction", "hinge.friction"."""
    owner, _, last = name.rpartition(".")
    owners: dict[str, list[str]] = {}  # of fields with the same description
    for where, field in _fields():
        if owner and not f"{where}.".startswith(f"{owner}."):
            continue
        if field.name == last:
            owners.setdefault("\n".join(field_lines((field,))), []).append(where)
        elif field.type.name == "choice" and last in field.type.options:
            owners.setdefault("\n".join(field_lines((field,))), []).append(f"{where}.{field.name}")
    for lines, places in owners.items():
        yield "\n".join([*wrap(f"{last} (in {', '.join(places)})", WIDTH), "", lines, ""])


def _fields():
    """Yield (place, Field) of all fields of kinds, shapes and sections."""
    for kind in (*KINDS.values(), *SHAPES.values()):
        yield from _walk(kind.fields, kind.name)
    yield from _walk(SECTIONS, "deck")


def _walk(fields, place):
    """Yield (place, Field) of fields and of those inside their mappings."""
    for field in fields:
        yield place, field
        inner = f"{place}.{field.name}" if place != "deck" else field.name
        for type_ in (field.type, *(option for option in field.type.options if isinstance(option, Type))):
            if type_.name == "mapping":
                yield from _walk(type_.options, inner)


def _listed(name, text, width, longest):
    """Return lines of at most ``longest`` characters: a name, in a column of the given width, and a text beside it."""
    return wrap(text, longest, initial_indent=f"  {name:<{width}}  ", subsequent_indent=" " * (width + 4))


def _sentence(doc):
    """Return the first sentence of a documentation, on one line."""
    first = " ".join(plain_text(doc).strip().split("\n\n")[0].split())
    return re.split(r"(?<=\.)\s(?=[A-Z])", first)[0]
