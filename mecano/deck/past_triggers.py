"""Warnings of releases, activations and grips at times before the start of a run."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from mecano.element_interface import SECTIONS, Kind

if TYPE_CHECKING:
    from mecano.deck.lint import Remark
    from mecano.schema import Values

TRIGGER = {"time", "when"}  # options of a trigger (constraints/along_coordinate/trigger.py)


def past_triggers(values: "Values", kinds: Mapping[str, Kind]) -> "Iterator[Remark]":
    """Yield (path, text) on times of triggers before the start; none of a run that continues an earlier one.

    ``values`` are those of a checked deck, ``kinds`` is {name: Kind} of all elements.
    """
    start = values["time"]["start"] if values["time"] else None
    if start is None or values["initial"]["from"]:
        return
    for section in SECTIONS:
        for name, d in values[section].items():
            for path, time in _times(kinds[d["type"]].fields, d):
                if time < start:
                    text = (
                        f"{d['type']} '{name}': '{path}' is {time:g} s, before the start at {start:g} s: it happens at "
                        "the start, without an event"
                    )
                    yield (section, name, *path.split(".")), text


def _times(fields, values, path=""):
    """Yield (path, time) of the triggers among checked values."""
    for field in fields:
        value = values[field.name]
        if field.type.name != "mapping" or value is None:
            continue
        if TRIGGER <= value.keys() and value["time"] is not None:
            yield f"{path}{field.name}.time", value["time"]
        yield from _times(field.type.options, value, f"{path}{field.name}.")
