"""Forces as arrows in space: of joints, wheels and loads, where they act, in inertial axes."""

from dataclasses import dataclass

import numpy as np

from mecano.constraints.triads import triad
from mecano.post.shapes import Motion


@dataclass(frozen=True)
class Arrow:
    """A force at some instants: of the ``kind`` ``name``, at ``places`` (n, 3) [m], ``values`` (n, 3) [N]."""

    kind: str
    name: str
    places: np.ndarray
    values: np.ndarray


def arrows(motion: Motion) -> list[Arrow]:
    """Return the Arrows of a Motion for the nonzero forces that kinds declare (``Display.force``)."""
    found = []
    for path, d in motion.run.pieces.items():
        display, name = motion.run.display(d), path.partition("/")[2]
        if display.force and f"{path}/{display.force}" in motion.run.paths:
            place = _place(motion, path, d, display)
            values = _force(motion, path, d, display)
            if place is not None and values.any():
                found.append(Arrow(d["type"], name, place, values))
    return found


def _place(motion, path, d, display):
    """Return its points of application (n, 3) [m], or None if unknown."""
    if display.force_at:
        return motion.vector(f"{path}/{display.force_at}")
    nodes = [node for node in (*d.get("nodes", ()), d.get("node")) if node in motion.nodes]
    return motion.position(nodes[-1]) if nodes else None


def _force(motion, path, d, display):
    """Return the force (n, 3) [N] in inertial axes, for joints from the axes fixed in their first node."""
    force = motion.vector(f"{path}/{display.force}")
    if not display.along_axes:
        return force
    first, axes = d["nodes"][0], triad(d["axis"], d.get("axis_1"))
    if first not in motion.nodes:
        return force @ axes
    return sum(f[:, None] * motion.turned(first, mu) for f, mu in zip(force.T, axes, strict=True))
