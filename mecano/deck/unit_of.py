"""SI unit of a number in a deck, named by its path, if known."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mecano.deck.compose import compose
from mecano.deck.sections import SECTIONS
from mecano.deck.source import Source
from mecano.deck.units import is_quantity, si_unit
from mecano.elements import KINDS
from mecano.elements.members.cross_section import SHAPES
from mecano.laws import TERMS
from mecano.laws.term import VALUE
from mecano.schema import Values, mapping

if TYPE_CHECKING:
    from mecano.deck.deck import Deck

DECKS = ".yaml", ".yml"
EITHER = ("either", "shorthand")  # types of which the first option is another type
LAWS = ("law", "curve", "drive", "law_in_place")
SEVERAL = ("list", "vector", "numbers", "coefficients", "direction")


def unit_of(path: str, values: Values, texts: Iterable[Any] = ()) -> str:
    """Return the SI unit of the value at a ``path`` (as in ``--set``) in checked or resolved values of a deck.

    The result is "" if there is no unit or it is unknown. A parameter is a plain number; its unit is that of the first
    of its values ``texts`` that is written with one.
    """
    return _declared(path.split("."), values) or _written(texts)


def parameters_of(file: str, text: str) -> dict[str, Any]:
    """Return {path: value} of the parameters as written in the ``text`` of a deck's own ``file``."""
    root = compose(Source(file, text), [])
    _, section = root.value.get("parameters", (None, None)) if root else (None, None)
    written = section.value if section and type(section.value) is dict else {}
    return {f"parameters.{name}": node.value for name, (_, node) in written.items()}


def written_parameters(deck: "Deck") -> dict[str, Any]:
    """Return {path: value} of the parameters as written in a checked Deck and in the files that it includes."""
    written: dict[str, Any] = {}
    for name in deck.files:
        source = Path(deck.file).parent / name
        if source.suffix in DECKS and source.exists():
            written |= parameters_of(str(source), source.read_text(encoding="utf-8"))
    return written | parameters_of(deck.file, deck.text)


def _declared(keys, values):
    """Return the unit declared for the value at the end of the keys in checked values of a deck."""
    type_, unit, at = mapping(*SECTIONS), "-", values
    for key in keys:
        type_, unit = _inside(type_, unit, key, at)
        if type_ is None:
            return ""
        at = at.get(key) if isinstance(at, dict) else None
    return "" if unit == "-" or " or " in unit or "unit" in unit else unit


def _inside(type_, unit, key, at):
    """Return type and unit of the entry ``key`` in a value ``at`` of a type; None and "" if unknown."""
    while type_.name in EITHER:
        type_ = type_.options[0]
    if type_.name == "named":
        return type_.options[0], "-"
    if type_.name in SEVERAL:
        return type_.options[0] if type_.name == "list" else type_, unit
    if type_.name in LAWS and key in TERMS:
        return mapping(*TERMS[key].fields), unit
    fields = type_.options if type_.name == "mapping" else ()
    if type_.name == "kind" and isinstance(at, dict):
        fields = (KINDS.get(at["type"]) or SHAPES[at["type"]]).fields
    field = next((field for field in fields if field.name == key), None)
    return (field.type, unit if field.unit == VALUE else field.unit) if field else (None, "")


def _written(values):
    """Return the SI unit of the first value that is written with one."""
    return next((si_unit(value) for value in values if type(value) is str and is_quantity(value)), "")
