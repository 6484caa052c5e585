"""The ground of a wheel: its intersection with the plane of a side view, and lines on it along the path."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mecano.constraints.ground import in_plane
from mecano.constraints.triads import triad, unit
from mecano.post.curve_values import curve_values
from mecano.schema import Values

STEEPEST = 0.2  # component of the normal along the vertical axis below which the ground is not drawn
POINTS = 60
POINTS_OF_WAY = 500
BESIDE = 3.0  # radii on both sides of the path
FAR = 1.5  # sizes of the mechanism: a ground that remains farther below it is not drawn
ROUND = 0.15  # margin of a patch of ground around the mechanism, relative to its size


def ground_line(
    deck: Mapping[str, Any], ground: Values, axes: Sequence[int], centre: np.ndarray, half_width: float
) -> np.ndarray | None:
    """Return points (n, 2) of the ground below ``centre`` (3,) [m], or None if it is seen from above.

    ``deck`` is the resolved deck, ``ground`` one of its grounds, ``axes`` the indices of the inertial axes to the right
    and up, ``half_width`` [m] the extent to both sides.
    """
    right, up = axes
    point, normal = plane_of(ground)
    if abs(normal[up]) < STEEPEST:
        return None
    points = np.tile(np.array(centre, float), (POINTS if ground.get("profile") else 2, 1))
    points[:, right] += np.linspace(-half_width, half_width, len(points))
    points[:, up] -= (points - point) @ normal / normal[up]
    return _raised(deck, ground, points)[:, axes]


def grounds_near(deck: Mapping[str, Any], points: np.ndarray) -> list[Values]:
    """Return the grounds on which something rolls or stands, without those always far from ``points`` (n, k, 3) [m].

    A retracting gear may be high above its runway, which would leave no room for it in a picture.
    """
    size = np.ptp(points, axis=1).max()
    names = dict.fromkeys(d["ground"] for d in deck.get("elements", {}).values() if "ground" in d)
    grounds = [deck["grounds"][name] for name in names]
    return [one for one in grounds if _height(points, *plane_of(one)) <= FAR * size]


def _height(points, point, normal):
    """Return the least height [m] of ``points`` (n, k, 3) above a plane."""
    return ((points - point) @ normal).min()


def ground_patch(deck: Mapping[str, Any], ground: Values, points: np.ndarray) -> np.ndarray:
    """Return the outline (k, 3) [m] of the ground below ``points`` (n, 3), with a margin on all sides."""
    point, normal = plane_of(ground)
    axes = triad(normal)[:2]
    low, high = (points @ axes.T).min(axis=0), (points @ axes.T).max(axis=0)
    room = ROUND * (high - low).max()
    (a, b), (c, d) = low - room, high + room
    s = np.linspace(0.0, 1.0, POINTS)[:, None]
    corners = np.array([(a, b), (c, b), (c, d), (a, d), (a, b)])
    outline = np.concatenate([p + s * (q - p) for p, q in zip(corners[:-1], corners[1:], strict=True)]) @ axes
    outline += (point @ normal) * normal
    return _raised(deck, ground, outline)


def ground_path(
    deck: Mapping[str, Any], ground: Values, centres: np.ndarray, radius: float, beyond: float
) -> np.ndarray:
    """Return the sides (2, k, 3) of a strip of ground along the path of a wheel with ``centres`` (n, 3) and ``radius``.

    It continues by ``beyond`` [m] at both ends of the path.
    """
    point, normal = plane_of(ground)
    way = (centres[:, -1] - centres[:, 0]).mean(axis=0)
    centres = centres.reshape(-1, 3)
    way -= (way @ normal) * normal
    if np.linalg.norm(way) < radius:
        way = triad(normal)[1]
    way /= np.linalg.norm(way)
    across, middle = np.cross(normal, way), centres.mean(axis=0)
    along, aside = (centres - middle) @ way, np.abs((centres - middle) @ across).max() + BESIDE * radius
    count = POINTS_OF_WAY if ground.get("profile") else 2
    distances = np.linspace(along.min() - beyond, along.max() + beyond, count)
    sides = middle + distances[:, None] * way + np.array([-aside, aside])[:, None, None] * across
    sides -= ((sides - point) @ normal)[..., None] * normal
    return np.stack([_raised(deck, ground, points) for points in sides])


def bars_across(sides: np.ndarray, pitch: float) -> np.ndarray:
    """Return bars (n, 2, 3) across a ground between its ``sides`` (2, k, 3), every ``pitch`` [m] along the first."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(sides[0], axis=0), axis=1))])
    at = np.arange(0.0, way[-1], pitch)
    return np.stack([np.stack([np.interp(at, way, x) for x in side.T], axis=1) for side in sides], axis=1)


def plane_of(ground: Values) -> tuple[np.ndarray, np.ndarray]:
    """Return a point (3,) [m] of the plane of a ground, and its unit normal (3,)."""
    return np.array(ground["plane"]["point"], float), unit(ground["plane"]["normal"])


def _raised(deck, ground, points):
    """Return points (n, 3) of the plane of a ground, raised along its normal to the profile, if any."""
    if not (profile := ground.get("profile")):
        return points
    point, normal = plane_of(ground)
    heights = curve_values(deck, profile["height"], (points - point) @ unit(in_plane(profile["direction"], normal)))
    return points + heights[:, None] * normal
