"""Bodies that fly freely, such as spacecraft, as cuboids of their mass and inertia, which show their attitude."""

from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from mecano.deck.physics import rotations
from mecano.maths.inertia import inertia_matrix

if TYPE_CHECKING:
    from mecano.post.shapes import AnyMotion
    from mecano.schema import Values

WITH_LINES = frozenset({"line", "cable", "spring", "belt", "beam", "superelement", "wheel", "wheel_on_body", "contact"})
"""Shapes of elements beside which a body at their node is a dot."""
LARGEST = 0.25  # half a side, over the size of the mechanism: inertias of little influence are often arbitrary
THINNEST = 0.05  # side, over the longest one: a plane body is a plate


class LoneBodies:
    """The bodies of a motion that nothing but a node shows."""

    def __init__(self, motion: "AnyMotion"):
        self.motion = motion

    def corners(self, d: "Values") -> np.ndarray | None:
        """Return the corners (instants, 8, 3) [m] of the uniform cuboid of a body with the mass and inertia of ``d``.

        None if the body has no volume, or an element or joint shows how its node turns.
        """
        motion, node = self.motion, d["node"]
        if f"nodes/{node}/rotation" not in motion.run.paths or (node in self._shown and node != self.spacecraft):
            return None
        moments, axes = np.linalg.eigh(inertia_matrix(d["inertia"]))
        half = np.sqrt(np.maximum(1.5 * (moments.sum() - 2.0 * moments) / d["mass"], 0.0))
        if not half.any():
            return None
        half = np.maximum(half, THINNEST * half.max()) * min(1.0, self._largest / half.max())
        (R,) = rotations(np.array([motion.run.deck["nodes"][node]["orientation"]], float))
        sides = [motion.turned(node, size * R @ axis) for size, axis in zip(half, axes.T, strict=True)]
        signs = np.array(list(product((-1.0, 1.0), repeat=3)))
        centre = motion.position(node) + motion.turned(node, R @ d.get("center_of_mass", np.zeros(3)))
        return centre[:, None] + np.einsum("ks,sij->ikj", signs, np.array(sides))

    @cached_property
    def spacecraft(self) -> str:
        """Node of the body, with attached nodes, of most of the mass of a mechanism that nothing holds, or ""."""
        deck, things = self.motion.run.deck, self.motion.run.things
        held = any(node.get("fixed") for node in deck["nodes"].values()) or any(
            "ground" in d or "ground" in d.get("nodes", ()) or (path.startswith("joints/") and "node" in d)
            for path, d in things.items()
        )
        masses = {d["node"]: d["mass"] for d in things.values() if d.get("mass") and d.get("inertia")}
        if held or not masses:
            return ""
        heaviest = max(masses, key=lambda node: masses[node])
        carries = any(d.get("attached") for d in things.values() if d.get("node") == heaviest)
        return heaviest if carries and masses[heaviest] < sum(masses.values()) < 2.0 * masses[heaviest] else ""

    @cached_property
    def _shown(self):
        """Nodes of elements with lines, and of joints that hold a point."""
        run = self.motion.run
        return {
            node
            for path, d in run.things.items()
            if (
                run.display(d).support if path.startswith("joints/") else (run.display(d).shape or "line") in WITH_LINES
            )
            for node in (*d.get("nodes", ()), d.get("node"))
            if not path.startswith("loads/")
        }

    @cached_property
    def _largest(self):
        """Largest half side [m]: a part of the size of the mechanism at the first instant, if it has one."""
        places = np.array([self.motion.position(node)[0] for node in self.motion.nodes])
        size = np.linalg.norm(np.ptp(places, axis=0))
        return LARGEST * size if size > 0.0 else np.inf
