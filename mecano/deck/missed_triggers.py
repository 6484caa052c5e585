"""Warnings of releases, activations and grips at times before the start of a run, or after its end."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from mecano.element_interface import SECTIONS, Kind

if TYPE_CHECKING:
    from mecano.deck.lint import LocatedWarning
    from mecano.schema import Values

TRIGGER = {"time", "when"}  # options of a trigger (constraints/along_coordinate/trigger.py)


def missed_triggers(values: "Values", kinds: Mapping[str, Kind]) -> "Iterator[LocatedWarning]":
    """Yield (path, text) on times of triggers outside of a run.

    Those before the start of a run that continues an earlier one have happened there. ``values`` are those of a checked
    deck, ``kinds`` is {name: Kind} of all elements.
    """
    if not values["time"]:
        return
    start, end = values["time"]["start"], values["time"]["end"]
    for section in SECTIONS:
        for name, d in values[section].items():
            for path, time in _times(kinds[d["type"]].fields, d):
                if time < start and not values["initial"]["from"]:
                    missed = f"before the start at {start:g} s: it happens at the start"
                elif time > end:
                    missed = f"after the end at {end:g} s: it does not happen in this run"
                else:
                    continue
                yield (section, name, *path.split(".")), f"{d['type']} '{name}': '{path}' is {time:g} s, {missed}"


def _times(fields, values, path=""):
    """Yield (path, time) of the triggers among checked values."""
    for field in fields:
        value = values[field.name]
        if field.type.name != "mapping" or value is None:
            continue
        if TRIGGER <= value.keys() and value["time"] is not None:
            yield f"{path}{field.name}.time", value["time"]
        yield from _times(field.type.options, value, f"{path}{field.name}.")
