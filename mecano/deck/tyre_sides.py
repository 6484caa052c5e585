"""Warnings about tyres of .tir files that are not symmetric, and turn on both sides of a vehicle."""

from collections.abc import Iterator, Mapping

import numpy as np

from mecano.deck.physics import own_nodes
from mecano.element_interface import Kind
from mecano.errors import LocatedWarning
from mecano.schema import Values

ONE_SIDED = ("PHY1", "PVY1", "QHZ1", "QDZ6", "QSX1")  # of ply steer and conicity, at no camber and the nominal load
APART = 0.5  # radii from the middle of all wheels, along the axle


def one_sided_tyres(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on tyre laws with ply steer or conicity that wheels on both sides of a vehicle share."""
    hubs = {n: own_nodes(kinds[d["type"]], d)[-1] for n, d in values["elements"].items() if "tire_law" in d}
    wheels = [(n, values["elements"][n]) for n, hub in hubs.items() if hub in values["nodes"]]  # others: inside beams
    if len(wheels) < 2:
        return
    axis = np.array(wheels[0][1]["axis"]) / np.linalg.norm(wheels[0][1]["axis"])
    places = [axis @ values["nodes"][hubs[name]]["position"] for name, _ in wheels]
    middle = 0.5 * (min(places) + max(places))
    for law, t in values["tire_laws"].items():
        given = (t.get("magic_formula") or {}).get("coefficients") or {}
        uneven = [f"{key} = {given[key]:g}" for key in ONE_SIDED if given.get(key)]
        far = [(y - middle, name) for y, (name, d) in zip(places, wheels, strict=True) if d["tire_law"] is t]
        sides = [[name for y, name in far if sign * y > APART * (t["radius"] or 0.0)] for sign in (1.0, -1.0)]
        if uneven and all(sides):
            text = f"tire law '{law}': wheels on both sides use it, '{sides[0][0]}' and '{sides[1][0]}', and its file "
            text += f"has ply steer or conicity ({', '.join(uneven)}): together they pull to one side; give one side a "
            yield ("tire_laws", law, "magic_formula"), f"{text}law with 'mirrored: true'"
