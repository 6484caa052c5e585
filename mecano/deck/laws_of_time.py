"""The laws and formulas of time in a deck, wherever they stand: also inside mappings, and in grounds that move."""

from collections.abc import Iterator, Mapping

from mecano.deck.laws import Law
from mecano.element_interface import SECTIONS, Kind
from mecano.schema import TIME_CURVE, Values


def uses_of_time(values: Values, kinds: Mapping[str, Kind]) -> Iterator[tuple[str, tuple[str, ...], Law | str]]:
    """Yield (owner, path, value) of all checked laws and formulas of time; ``values`` are those of a checked deck."""
    for section in SECTIONS:
        for name, d in values[section].items():
            for path, value in _within(kinds[d["type"]].fields, d, (section, name)):
                yield f"{d['type']} '{name}'", path, value
    for name, d in values["grounds"].items():
        for key in ("speed", "rate"):
            if d["motion"] and d["motion"][key] is not None:
                yield f"ground '{name}'", ("grounds", name, "motion", key), d["motion"][key]


def _within(fields, values, path):
    for field in fields:
        value = values[field.name]
        if value is None:
            continue
        if field.type == TIME_CURVE or field.type.name in ("drive", "formula"):
            yield (*path, field.name), value
        elif field.type.name == "mapping":
            yield from _within(field.type.options, value, (*path, field.name))
