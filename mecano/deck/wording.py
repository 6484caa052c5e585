"""Words for messages: quoted texts, descriptions of values, and suggestions."""

import os
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

from mecano.deck.scalar import number
from mecano.deck.similar_names import similar
from mecano.deck.units import is_quantity

if TYPE_CHECKING:
    from mecano.deck.compose import Node
    from mecano.schema import Field

NUMERIC = ("number", "integer", "curve", "drive", "either")  # types whose values may be numbers
SLIPS = (  # as typed, as read
    (r"[,;]\s*$", ""), ("[−–]", "-"),
    (r"(?<=[0-9])[ _'’](?=[0-9]{3}(?![0-9]))", ""),
    (r"(?<=[0-9]),(?=[0-9]{3}(?:,[0-9]{3})*\.)", ""), ("(?<=[0-9]),(?=[0-9])", "."),
    (r"\s*[x*·×]\s*10\s*(?:\^|\*\*)\s*", "e"), (r"^10\s*\^", "1e"),
    (r"^np\.\w+\((.*)\)$", r"\1"),
)  # fmt: skip
THOUSANDS_COMMA = r"[^,.]*[0-9],[0-9]{3}(?![0-9])[^,.]*"
LISTS = ("vector", "direction", "inertia", "numbers", "nodes")  # types whose values are lists
QUOTED = r"(?s)\[.*\]|\{.*\}"  # a list or mapping given as text
AXES = {sign + axis: f"[{', '.join(f'{sign}1' if axis == other else '0' for other in 'xyz')}]".replace("+", "")
        for sign in ("", "+", "-") for axis in "xyz"}  # fmt: skip
MAX_SHOWN = 60
MAX_LISTED = 16
LONGEST_NAME, MOST_NAMES = 80, 1000  # of files among which a similar one is searched


def quoted(text: str) -> str:
    """Return a text in quotes, truncated if long, without unprintable characters."""
    return repr(text if len(text) <= MAX_SHOWN else text[: MAX_SHOWN - 3] + "...")


def found(node: "Node") -> str:
    """Return the description of a value of the deck, to complete "..., got"."""
    value = node.value
    if value is None:
        return "nothing"
    if type(value) is str and is_quantity(value):
        return value
    if type(value) is str:
        return f"the text {quoted(value)}"
    if type(value) is list:
        return _listed(value)
    if type(value) is dict:
        return "a mapping"
    return node.raw if 0 < len(node.raw) <= MAX_SHOWN else str(value)


def how_to_write(node: "Node", field: "Field") -> str:
    """Return a hint on how to write a number, for a text with digits in place of a number; otherwise ""."""
    text = node.value
    if type(text) is not str or field.type.name not in NUMERIC or is_quantity(text):
        return ""
    unit = re.split(r" or |,", field.unit)[0].strip() if "unit" not in field.unit else ""
    if text.strip() == "pi":
        return "write '=pi', or 180 deg" if unit == "rad" else "write '=pi'"
    if right := corrected(text):
        return f"write {right}"
    shown = f"2.5 or 2.5 {unit}" if unit not in ("", "-") else "2.5"
    return f"a number is written as {shown}" if any(letter.isdigit() for letter in text) else ""


def corrected(text: str) -> str:
    """Return the number or quantity that is meant by a text with slips of typing, or ""."""
    if len(text) > MAX_SHOWN or re.fullmatch(THOUSANDS_COMMA, text):
        return ""  # 1,000 may be 1000 or 1.000
    right = text
    for slip, instead in SLIPS:
        right = re.sub(slip, instead, right)
    return right if right != text and (is_quantity(right) or number(right) is not None) else ""


def as_list(node: "Node", field: "Field") -> str:
    """Return a hint for a text, or a list of one text, in place of a list: where the brackets or commas are missing."""
    if type(node.value) is str and field.type.name == "direction" and node.value.lower() in AXES:
        return f"write {AXES[node.value.lower()]}"
    if type(node.value) is str and field.type.name in LISTS and re.fullmatch(r"-[A-Za-z_]\w*", node.value):
        return "write a space after '-'"
    if type(node.value) is str and field.type.name != "text" and re.fullmatch(QUOTED, node.value.strip()):
        return "write it without quotes; from Python give a list or a dict, not its text"
    lone = node.value[0].value if type(node.value) is list and len(node.value) == 1 else node.value
    if type(lone) is not str or field.type.name not in LISTS or len(lone) > MAX_SHOWN:
        return ""
    items = [item for item in re.split(r"[\s,;]+", lone.strip(" ()")) if item]
    names = field.type.name == "nodes" and all(item.isidentifier() for item in items)
    if len(items) > 1 and (names or all(number(item) is not None for item in items)):
        return f"write [{', '.join(items)}]"
    return ""


def _listed(items):
    scalars = all(type(item.value) not in (list, dict) for item in items)
    if len(items) <= 4 and scalars:
        text = "[" + ", ".join(quoted(i.value) if type(i.value) is str else i.raw or "null" for i in items) + "]"
        if len(text) <= 2 * MAX_SHOWN:
            return text
    return f"a list of {len(items)}"


def unit_text(field: "Field") -> str:
    """Return the unit of a field in brackets; "" if it has none or depends on the use of a law."""
    return "" if field.unit in ("", "-") or "unit of" in field.unit else f" [{field.unit}]"


def suggestion(word: str, known: Iterable[str]) -> str:
    """Return a hint for an unknown word: the most similar known words, or all if they are few."""
    known = list(known)
    if len(word) <= MAX_SHOWN:
        near = [quoted(name) for name in similar(word, known)]
        if near:
            return f"did you mean {' or '.join([', '.join(near[:-1]), near[-1]] if near[1:] else near)}?"
    if 0 < len(known) <= MAX_LISTED:
        return "known: " + ", ".join(quoted(name)[1:-1] for name in known)
    return ""


def similar_files(path: str, endings: tuple[str, ...]) -> str:
    """Return a hint on files with these endings in the folder of a path whose names are similar to its own, or ""."""
    folder, name = os.path.split(path)
    try:
        names = {os.path.splitext(n)[0]: n for n in sorted(os.listdir(folder or ".")) if n.endswith(endings)}
    except (OSError, ValueError):
        return ""
    few = len(name) <= LONGEST_NAME and len(names) <= MOST_NAMES
    near = [quoted(names[stem]) for stem in similar(os.path.splitext(name)[0], names)] if few else []
    return f"did you mean {' or '.join(near)}?" if near else ""
