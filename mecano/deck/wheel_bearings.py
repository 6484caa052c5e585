"""Warnings about the bearings of wheels: axes that are not those of the wheels, wheels without a bearing."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from mecano.deck.physics import own_nodes
from mecano.deck.turning_axes import are_parallel, listed
from mecano.element_interface import SECTIONS, Kind
from mecano.element_interface.kind import FREELY

if TYPE_CHECKING:
    from mecano.deck.lint import LocatedWarning
    from mecano.schema import Values

APART = 0.2  # sine of the angle between the axes of a wheel and of its bearing; toe and camber turn both


def misplaced_bearings(values: "Values", kinds: Mapping[str, Kind]) -> "Iterator[LocatedWarning]":
    """Yield (path, text) on wheels that turn about another axis than theirs, or that nothing holds beside held ones."""
    wheels = _wheels(values, kinds)
    around = {name: _at_node(values, kinds, node, name) for name, (node, _) in wheels.items()}
    for name, (node, axis) in wheels.items():
        if not around[name] and any(around.values()):
            held = next(other for other, found in around.items() if found)
            text = f"no joint or member holds its node '{node}', as one holds wheel '{held}'; is a bearing missing?"
            yield ("elements", name), f"{values['elements'][name]['type']} '{name}': {text}"
        elif len(around[name]) == 1 and (text := _other_axis(axis, *around[name][0])):
            yield ("joints", around[name][0][0], "axis"), text.format(wheel=name)


def _wheels(values, kinds):
    """Return {name: (node, axis (3,))} of the elements that roll; a skate has no radius."""
    found = {}
    for name, d in values["elements"].items():
        kind = kinds[d["type"]]
        if "wheels" in kind.display.pictures and ("tire_law" in d or "radius" in d):
            found[name] = own_nodes(kind, d)[-1], np.array(d["axis"])
    return found


def _at_node(values, kinds, node, wheel):
    """Return (name, Kind, deck values) of the joints and members of a node, without the ``wheel`` and point bodies."""
    return [
        (name, kinds[d["type"]], d)
        for section in SECTIONS[:2]
        for name, d in values[section].items()
        for nodes in [own_nodes(kinds[d["type"]], d)]
        if node in nodes and name != wheel and len(nodes) > 1
    ]


def _other_axis(axis, name, kind, d):
    """Return a text if the only joint of a wheel lets it turn about another axis than that of the wheel."""
    if kind.turns != FREELY:
        return ""
    if are_parallel(axis, d["axis"], APART):
        return ""
    return (
        f"{d['type']} '{name}': its axis is not that of the wheel '{{wheel}}' on it, {listed(axis)}: "
        "the wheel cannot spin"
    )
