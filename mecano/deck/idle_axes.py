"""Warnings about springs, brakes, couples and racks that act about or along an axis which their joints hold."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from mecano.deck.turning_axes import are_parallel, bodies, listed, turning_together
from mecano.deck.wording import quoted
from mecano.element_interface import FREELY, Kind
from mecano.errors import LocatedWarning, name_list
from mecano.schema import Values

SLIDING = {"about_1", "about_2", "about_axis", "along_1", "along_2"}  # axes that a guide holds
ACROSS = 0.1  # cosine of the angle between two axes that count as perpendicular
MOST_NAMED = 3


def idle_axes(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on elements and loads that act about an axis across that about which their nodes can turn.

    This is the axis of a hinge between both bodies, or that of parallel hinges of both on a third one.
    """
    acting = [
        (section, name, field, axis, pair)
        for section in ("elements", "loads")
        for name, d in values[section].items()
        for field, axis, pair in kinds[d["type"]].counts_angles(d)
    ]
    if not acting:
        return
    body = bodies(values, kinds, turning_together)
    hinges = {body(d["nodes"]): name for name, d in values["joints"].items() if kinds[d["type"]].turns == FREELY}
    for section, name, field, axis, pair in acting:
        found = _between(body(pair), hinges)
        axes = [values["joints"][hinge]["axis"] for hinge in found]
        alike = all(are_parallel(axes[0], other, ACROSS) for other in axes)
        if found and alike and _are_perpendicular(axis, axes[0]):
            held = " and ".join(f"{values['joints'][hinge]['type']} {quoted(hinge)}" for hinge in found)
            text = f"{quoted(field)} {listed(axis)} is across {listed(axes[0])}, the only axis about which {held} "
            what = f"{values[section][name]['type']} {quoted(name)}: {text}let{'s' if len(found) == 1 else ''}"
            yield (section, name, field), f"{what} {name_list([quoted(n) for n in pair], MOST_NAMED)} turn: no effect"


def idle_racks(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on racks whose teeth run across the guide on which they slide."""
    racks = {name: d for name, d in values["joints"].items() if {"direction", "radius"} <= d.keys()}
    guides = {name: d for name, d in values["joints"].items() if set(kinds[d["type"]].holds(d)) == SLIDING}
    for name, d in racks.items():
        rack = d["nodes"][0]
        for guide, g in guides.items():
            if rack in g["nodes"] and _are_perpendicular(d["direction"], g["axis"]):
                text = f"'direction' {listed(d['direction'])} is across {listed(g['axis'])}, along which {g['type']}"
                what = f"{d['type']} {quoted(name)}: {text} {quoted(guide)} lets {quoted(rack)} slide: it cannot roll"
                yield ("joints", name, "direction"), what


def _between(pair, hinges):
    """Return the names of the hinge between two bodies, or of those that join both to a third one; [] if none do."""
    if len(pair) != 2 or pair in hinges:
        return [hinges[pair]] if pair in hinges else []
    a, b = pair
    for first, name in hinges.items():
        (third,) = first - {a} if a in first and len(first) == 2 else [None]
        if third is not None and (second := hinges.get(frozenset({third, b}))):
            return [name, second]
    return []


def _are_perpendicular(a: Sequence[float], b: Sequence[float]) -> bool:
    return bool(abs(np.dot(a, b)) <= ACROSS * np.linalg.norm(a) * np.linalg.norm(b))
