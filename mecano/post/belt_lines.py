"""A belt over pulleys as lines in space: its spans, and the pulleys with a spoke that turns with the node."""

from typing import TYPE_CHECKING

import numpy as np

from mecano.constraints.triads import triad

if TYPE_CHECKING:
    from mecano.post.shapes import AnyMotion
    from mecano.schema import Values

UPRIGHT = (0.0, 0.0, 1.0)  # axis of a cable without pulleys
RIM = np.linspace(0.0, 2.0 * np.pi, 49)


def belt_lines(motion: "AnyMotion", d: "Values") -> list[np.ndarray]:
    """Return lines [(instants, n, 3)] of a belt with the deck values ``d`` in a Motion (shapes.py)."""
    nodes, radii = d["nodes"], np.array(d["radii"], float)
    if not all(node in motion.nodes for node in nodes):
        return []
    places = [motion.position(node) for node in nodes]
    e1, e2, _ = triad(d.get("axis") or UPRIGHT)
    pairs = list(zip(range(len(nodes) - 1), range(1, len(nodes)), strict=True))
    pairs += [(len(nodes) - 1, 0)] if d.get("closed") else []
    lines = [_tangent(places[i], places[j], radii[i], radii[j], e1, e2) for i, j in pairs]
    for node, x, radius in zip(nodes, places, np.abs(radii), strict=True):
        if radius:
            rim = radius * (np.cos(RIM)[:, None] * e1 + np.sin(RIM)[:, None] * e2)
            spoke = radius * motion.turned(node, e1)
            lines.append(np.concatenate([x[:, None] + rim, (x + rim[0])[:, None]], axis=1))
            lines.append(np.stack([x, x + spoke], axis=1))
    return lines


def _tangent(x_0, x_1, radius_0, radius_1, e1, e2):
    """Return both ends (instants, 2, 3) of the span between two circles in the plane of e1 and e2, or two points."""
    if not radius_0 and not radius_1:
        return np.stack([x_0, x_1], axis=1)
    d = x_1 - x_0
    x, y = d @ e1, d @ e2
    lean = np.clip((radius_1 - radius_0) / np.hypot(x, y), -1.0, 1.0)
    angle = np.arctan2(y, x) - np.arcsin(lean)
    right = np.sin(angle)[:, None] * e1 - np.cos(angle)[:, None] * e2
    return np.stack([x_0 + radius_0 * right, x_1 + radius_1 * right], axis=1)
