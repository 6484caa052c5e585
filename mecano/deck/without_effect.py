"""Warnings of loads, triggers and values that have no effect, because of other values in the deck.

Triggers are those of releases, activations and grips at times before the start of a run, or after its end.
"""

from collections.abc import Iterator, Mapping

from mecano.deck.sections import SECTIONS as SECTIONS_OF_DECKS
from mecano.element_interface import SECTIONS, Kind
from mecano.errors import LocatedWarning
from mecano.laws.law_table import terms_of
from mecano.schema import Values

TRIGGER = {"time", "when"}  # options of a trigger (constraints/along_coordinate/trigger.py)
OF_OTHER_METHODS = ("rho_inf",), ("newton", "force_tolerance"), ("scale", "penalty")  # not used by Radau IIA


def without_effect(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on values without effect.

    ``values`` are those of a checked deck, ``kinds`` is {name: Kind} of all elements.
    """
    yield from _loads(values["loads"], values["nodes"])
    yield from _missed_triggers(values, kinds)
    yield from _options_of_other_methods(values["time"])
    yield from _friction_of_tyres(values["tire_laws"])
    for entry in values["initial"]["velocities"]:
        if isinstance(entry["about"], list) and not any(entry["angular_velocity"]):
            yield ("initial", "velocities"), "'about' has no effect without 'angular_velocity'"
    for section in SECTIONS:
        for name, d in values[section].items():
            for field, why in kinds[d["type"]].without_effect(d):
                yield (section, name, field), f"{d['type']} '{name}': '{field}' has no effect: {why}"


def _loads(loads, nodes):
    """Yield (path, text) on loads on fixed nodes."""
    for name, d in loads.items():
        if d.get("node") in nodes and nodes[d["node"]]["fixed"]:
            text = f"{d['type']} '{name}': node '{d['node']}' is fixed, so the load has no effect"
            yield ("loads", name, "node"), text


def _missed_triggers(values, kinds):
    """Yield (path, text) on times of triggers outside of a run.

    Those before the start of a run that continues an earlier one have happened there.
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


def _friction_of_tyres(tire_laws):
    """Yield (path, text) on values that go with 'friction' in tyre laws of another slip law."""
    for name, d in tire_laws.items():
        by_speed = terms_of(d.get("friction_by_speed", 1.0)) != terms_of(1.0)
        given = {"friction_by_speed": by_speed, "slip_regularization": d.get("slip_regularization") is not None}
        for field in given if d.get("friction") is None else ():
            if given[field]:
                yield ("tire_laws", name, field), f"tire law '{name}': '{field}' has no effect without 'friction'"


def _options_of_other_methods(time):
    """Yield (path, text) on options of the generalized-alpha family in a run by Radau IIA."""
    for path in OF_OTHER_METHODS if time and time["method"] == "radau" else ():
        value, fields = time, next(section.type.options for section in SECTIONS_OF_DECKS if section.name == "time")
        for word in path:
            value, field = value[word], next(field for field in fields if field.name == word)
            fields = field.type.options
        if value != field.default:
            yield ("time", *path), f"time: {'.'.join(path)!r} has no effect with the method radau"
