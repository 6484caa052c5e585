"""Warnings of bodies that are not where they should be: centres of mass from the origin, nodes welded to two bodies."""

from collections.abc import Iterator

import numpy as np

from mecano.deck.physics import poses
from mecano.errors import LocatedWarning
from mecano.schema import Values

OUTSIDE = 1.0  # in sizes of all nodes, as the next ones: the last link of a double pendulum ends this far from them
INSIDE = 0.1
FAR = 10.0
BESIDE, AMONG = 0.25, 0.05  # in sizes of the nodes of the body
DIGITS = 12  # after the point, so that the rounding of a rotation is not shown


def misplaced_bodies(values: Values) -> Iterator[LocatedWarning]:
    """Yield (path, text) on the bodies among the checked ``values`` of a deck."""
    bodies = {name: d for name, d in values["elements"].items() if {"node", "center_of_mass"} <= d.keys()}
    yield from _from_the_origin(bodies, values["nodes"])
    yield from _attached_twice(bodies)


def _from_the_origin(bodies, nodes):
    """Yield warnings of centres of mass far from all nodes, or beside those of the body, that count from the origin."""
    at = poses(nodes)
    places = np.array([x for x, _ in at.values()])
    size = _size(places)
    for name, d in bodies.items() if size else ():
        c, (x, R) = np.array(d["center_of_mass"]), at[d["node"]]
        own = np.array([at[node][0] for node in (d["node"], *(d.get("attached") or ()))])
        far = _outside(x + R @ c, places)
        distant = far > FAR * size
        among_all = far > OUTSIDE * size and _outside(c, places) <= INSIDE * size
        if distant or among_all or _is_beside(c, x + R @ c, own):
            off = (
                f"{far:.3g} m from all nodes"
                if distant or among_all
                else f"{_outside(x + R @ c, own):.3g} m from its nodes"
            )
            meant = ", ".join(f"{number:.6g}" for number in np.round(R.T @ (c - x), DIGITS) + 0.0)
            text = (
                f"{d['type']} '{name}': its centre of mass is {off}; 'center_of_mass' is relative to its node, in the "
                "axes of the node: "
            )
            yield ("elements", name, "center_of_mass"), text + ("is it in m?" if distant else f"is [{meant}] meant?")


def _is_beside(c, center, own):
    """Return whether a ``center`` is beside the nodes of its body, and ``c`` from the origin would be among them."""
    size = _size(own)
    return _outside(center, own) > BESIDE * size > 0.0 and _outside(c, own) <= AMONG * size


def _size(places):
    """Return the diagonal [m] of the box of places (n, 3)."""
    return float(np.linalg.norm(np.ptp(places, axis=0)))


def _outside(x, places):
    """Return the distance [m] of a point from the box of places (n, 3)."""
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(places.min(axis=0) - x, x - places.max(axis=0)))))


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
