"""Warnings about conditions of releases, activations and grips that never became true, or were true from the start."""

import re
from collections.abc import Iterator

import numpy as np

from mecano.deck.deck import Deck
from mecano.element_interface import RELEASES
from mecano.errors import name_list
from mecano.model.extremes import Extremes
from mecano.model.model import title_of
from mecano.model.sampler import Sampler
from mecano.model.system import System

MOST_CONDITIONS = 4  # named in a warning
LOAD = r"\b{}\.(?:\w+\.)*(?:tension|\w*force\w*|\w*moment\w*|\w*torque\w*)\b"  # on the element of this name
GRIPS = ("grip", "position_grip")  # kinds
GRIP_WAITS = {"open": "close", "closed": "release"}  # {phase: command that ends it}


def unmet_condition_warnings(
    deck: Deck, system: System, phases: np.ndarray, sampler: Sampler, extremes: Extremes
) -> Iterator[str]:
    """Yield a warning that names the conditions that, by the ``phases`` at the end, were never met.

    Those on a load of the element itself are those of a fuse, which is meant to hold. Whether a grip or lock was ever
    closed 'while' a condition held follows from the ``extremes`` of its outputs.
    """
    found = dict.fromkeys(
        text
        for batch in system.batches
        for unmet in (_unmet, _unmet_grips)
        for text in unmet(deck, batch, phases[batch.phases])
    )
    found.update(dict.fromkeys(_never_gripped(deck, sampler, extremes)))
    if found:
        yield f"conditions that did not become true: {name_list(list(found), MOST_CONDITIONS, '; ')}"


def released_at_start(deck: Deck, system: System, phases: np.ndarray) -> Iterator[str]:
    """Yield a warning, with its line, for each element whose release is due in the ``phases`` at the start.

    It may have become true in an earlier run that this one continues.
    """
    for batch in system.batches if not deck.values["initial"]["from"] else ():
        after = {event.after for event in batch.kind.events if event.name == RELEASES and event.command}
        for (path, _), phase in zip(batch.paths, phases[batch.phases], strict=True):
            section, _, name = path.partition("/")
            if batch.kind.phases[phase] in after and (when := deck.values[section][name]["release"]["when"]):
                title = title_of(deck.values[section][name]["type"], name)
                text = f"the condition of its release, {when}, is true at the start, so that it never acts"
                yield f"{deck.mark(section, name)}: {title}: {text}"


def _unmet(deck, batch, phases):
    """Yield a text for each element of a batch that still waits for the condition of a command."""
    for command in filter(None, dict.fromkeys(event.command for event in batch.kind.events)):
        events = [event for event in batch.kind.events if event.command == command]
        waiting = {event.before for event in events} - {event.after for event in events}
        for (path, _), phase in zip(batch.paths, phases, strict=True):
            section, _, name = path.partition("/")
            values = deck.values[section][name]
            field = "latch" if values.get("latch") else ""
            trigger = (values[field] if field else values).get(command)
            if batch.kind.phases[phase] in waiting and trigger and trigger["when"]:
                if not re.search(LOAD.format(re.escape(name)), trigger["when"]):
                    place = f"{field}.{command}" if field else command
                    yield f"{title_of(values['type'], name)}, '{place}: {{when: {trigger['when']}}}'"


def _unmet_grips(deck, batch, phases):
    """Yield a text for each grip of a batch that waits to close, or to open; its events have no commands."""
    if batch.kind.name not in GRIPS:
        return
    for (path, _), phase in zip(batch.paths, phases, strict=True):
        name = path.partition("/")[2]
        command = GRIP_WAITS.get(batch.kind.phases[phase])
        trigger = command and deck.values["joints"][name][command]
        if trigger and trigger["when"] and not re.search(LOAD.format(re.escape(name)), trigger["when"]):
            yield f"{title_of('grip', name)}, '{command}: {{when: {trigger['when']}}}'"


def _never_gripped(deck, sampler, extremes):
    """Yield a text for each grip, or lock of a joint, that was never closed 'while' its condition held."""
    for name, d in deck.values["joints"].items():
        option, closed = ("lock.", "locked") if d.get("lock") else ("", "closed")
        condition = d["lock"]["while"] if option else d.get("while")
        if condition and not extremes.high[sampler.starts[f"joints/{name}/{closed}"]]:
            yield f"{title_of(d['type'], name)}, '{option}while: {condition}'"
