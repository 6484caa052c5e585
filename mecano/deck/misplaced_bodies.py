"""Warnings of bodies that are not where they should be: centres of mass from the origin, nodes welded to two bodies."""

from collections.abc import Iterator

import numpy as np

from mecano.deck.physics import poses
from mecano.errors import LocatedWarning
from mecano.schema import Values

OUTSIDE = 1.0  # in sizes of all nodes, as the next ones: the last link of a double pendulum ends this far from them
INSIDE = 0.1
FAR = 10.0
DIGITS = 12  # after the point, so that the rounding of a rotation is not shown


def misplaced_bodies(values: Values) -> Iterator[LocatedWarning]:
    """Yield (path, text) on the bodies among the checked ``values`` of a deck."""
    bodies = {name: d for name, d in values["elements"].items() if {"node", "center_of_mass"} <= d.keys()}
    yield from _from_the_origin(bodies, values["nodes"])
    yield from _attached_twice(bodies)


def _from_the_origin(bodies, nodes):
    """Yield warnings of centres of mass far from all nodes that would be among them if they counted from the origin."""
    at = poses(nodes)
    places = np.array([x for x, _ in at.values()])
    low, high = places.min(axis=0), places.max(axis=0)
    size = float(np.linalg.norm(high - low))

    def outside(x):
        return float(np.linalg.norm(np.maximum(0.0, np.maximum(low - x, x - high)))) / size

    for name, d in bodies.items() if size else ():
        c, (x, R) = np.array(d["center_of_mass"]), at[d["node"]]
        far = outside(x + R @ c)
        if far > FAR or (far > OUTSIDE and outside(c) <= INSIDE):
            meant = ", ".join(f"{number:.6g}" for number in np.round(R.T @ (c - x), DIGITS) + 0.0)
            text = (
                f"{d['type']} '{name}': its centre of mass is {far * size:.3g} m from all nodes; 'center_of_mass' "
                "is relative to its node, in the axes of the node: "
            )
            yield (
                ("elements", name, "center_of_mass"),
                text + ("is it in m?" if far > FAR else f"is [{meant}] meant?"),
            )


def _attached_twice(bodies):
    """Yield warnings of nodes that are attached to two bodies."""
    owners: dict[str, str] = {}
    for name, d in bodies.items():
        for node in d.get("attached") or ():
            if (first := owners.setdefault(node, name)) != name:
                text = (
                    f"{d['type']} '{name}': node '{node}' is attached to '{first}', too, which welds both together; a "
                    "joint between them needs a node of each"
                )
                yield ("elements", name, "attached"), text
