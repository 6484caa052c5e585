"""Warnings of gravity gradients that do not belong to the bodies on which they act, or that act besides gravity."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from mecano.deck.wording import quoted

if TYPE_CHECKING:
    from mecano.errors import LocatedWarning
    from mecano.schema import Values

BODIES = ("rigid_body", "point_mass")
LEAST = 1e-6  # relative difference of two masses that is reported


def orbits(values: "Values") -> "Iterator[LocatedWarning]":
    """Yield (path, text) on the loads 'gravity_gradient' of a checked deck."""
    loads = {name: d for name, d in values["loads"].items() if d["type"] == "gravity_gradient"}
    if loads and any(values["gravity"]):
        text = "'gravity' accelerates a model in orbit, which falls freely: a deck with a gravity_gradient has 'none'"
        yield ("gravity",), text
    carried: dict[str, list[tuple[str, Values]]] = {}
    for name, d in values["elements"].items():
        if d["type"] in BODIES:
            carried.setdefault(d["node"], []).append((name, d))
    for name, d in loads.items():
        if bodies := carried.get(d["node"]):
            yield from _of_other_bodies(name, d, bodies)
    if loads:
        yield from _without(carried, {d["node"] for d in loads.values()})


def _of_other_bodies(name, load, bodies):
    """Yield a warning of a load that has another mass, or another centre of mass, than the bodies of its node."""
    mass = sum(d["mass"] for _, d in bodies)
    if not math.isclose(load["mass"], mass, rel_tol=LEAST):
        has = f"{load['mass']:g} kg, but what its node carries, {quoted(bodies[0][0])}, has {mass:g} kg"
        yield ("loads", name, "mass"), f"gravity_gradient {quoted(name)}: 'mass' is {has}"
    if len(bodies) > 1:
        return
    center = bodies[0][1].get("center_of_mass", (0.0,) * 3)
    if any(not math.isclose(*pair, rel_tol=LEAST) for pair in zip(center, load["center_of_mass"], strict=True)):
        at = f"[{', '.join(f'{x:g}' for x in center)}] m"
        text = f"gravity_gradient {quoted(name)}: 'center_of_mass' is not that of {quoted(bodies[0][0])}, {at}"
        yield ("loads", name), text


def _without(carried, nodes):
    """Yield a warning for each body with mass on a node that has no gravity gradient."""
    for node, bodies in carried.items():
        for name, d in bodies:
            if d["mass"] and node not in nodes:
                text = "has no gravity_gradient, as others have: it does not follow the orbit"
                yield ("elements", name), f"{d['type']} {quoted(name)} {text}"
