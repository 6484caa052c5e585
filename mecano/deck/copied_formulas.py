"""Formulas of signals in copies: values of parameters are written into them, names of the template get its prefix.

A copy of ``torque: $gain*(command - hinge.angle)`` in the template ``leg``, placed as ``left``, is the formula
``60*(left_command - left_hinge.angle)``. A word given to the template is a name from outside and keeps a mark until the
names of the template have their prefix.
"""

import re
from collections.abc import Callable, Container, Mapping

from mecano.deck.expressions import INSERT, WORDS, inner_text, inner_value, insert
from mecano.deck.parameters import Parameters
from mecano.element_interface import SECTIONS

OUTER = "^"  # before a name from outside, once for each template around it; no formula contains it
SIGNS = r"[\s*/+<>,()]|^-"  # outside of inserts: of formulas, not of names
OUTPUT = r"\$[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)+"  # an output or a motion of what a word names
QUANTITY = r"(?<![\w.])[0-9][0-9.]*\s*(?![eE][-+0-9])[A-Za-z°%]"  # 90 deg
OPERAND = rf"(?<![\w.])(?!(?:{WORDS})\b)[A-Za-z_]\w*\b(?!\s*\()"
MEASURED = rf"(\{OUTER}*)(?<![\w.])([A-Za-z_]\w*)\b((?:\.\w+)*)\b(?!\s*\()"
JOINED = r"[\w.$)(]"  # next to an insert: it is part of a name


def is_formula(text: str, parameters: Parameters) -> bool:
    """Return whether a text with a $ has operands besides numbers and ``parameters``, and is no name with inserts."""
    signs = re.fullmatch(OUTPUT, text.strip()) or re.search(SIGNS, INSERT.sub("", text).strip())
    if text.startswith("=") or not signs:
        return False
    shown = INSERT.sub(lambda match: "x" if parameters.word(inner_text(match)) else "0", text)
    return not re.search(QUANTITY, shown) and re.search(OPERAND, shown) is not None


def filled_in(text: str, parameters: Parameters, shown: Callable[[str], str] | None = None) -> str:
    """Return a formula with the values of ``parameters``, and names with inserts; raises the errors of ``evaluate``.

    ``shown(name)`` is the text in place of the value of a parameter.
    """
    return INSERT.sub(lambda match: _value(match, text, parameters, shown), text)


def with_prefix(text: str, prefix: str, own: Mapping[str, Container[str]]) -> str:
    """Return a formula in which the names of the template, those in ``own`` {section: names}, have the ``prefix``."""
    return re.sub(MEASURED, lambda match: _outside(match, prefix, own), text)


def is_own(name: str, own: Mapping[str, Container[str]]) -> bool:
    """Return whether a template defines something of this name that can be measured, a signal, or a law."""
    return any(name in own.get(section, ()) for section in (*SECTIONS, "nodes", "laws"))


def _value(match, text, parameters, shown):
    before, after = text[: match.start()][-1:], text[match.end() :][:1]
    begins = before == "(" or not re.match(JOINED, before)
    word = parameters.word(inner_text(match))
    if word:
        return OUTER * (getattr(word, "rise", 0) if begins else 0) + word.value
    if not begins or (after != ")" and re.match(JOINED, after)):
        return insert(match, parameters)
    value = inner_value(match, parameters)
    if shown and match[2]:
        return shown(match[2])
    number = str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)
    return f"({number})" if value < 0.0 else number


def _outside(match, prefix, own):
    marks, first, rest = match.groups()
    if marks:
        return marks[1:] + first + rest
    if first in SECTIONS and rest and is_own(rest.split(".")[1], own):
        return f"{first}.{prefix}{rest[1:]}"
    return f"{prefix}{first}{rest}" if is_own(first, own) else first + rest
