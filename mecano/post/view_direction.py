"""Choose the view direction of a mechanism in space: the one in which its parts hide one another least."""

from collections.abc import Sequence

import numpy as np

AZIMUTHS = np.radians([a for a in range(-170, 181, 10) if 20 <= abs(a) % 90 <= 70])  # not along an axis
ELEVATIONS = np.radians((14.0, 22.0, 35.0))
USUAL = np.radians((-60.0, 22.0))  # direction used if all others are as good
PREFERRED = 0.15  # bonus in the score of the usual direction


def eye(
    cloud: np.ndarray,
    wheels: Sequence[tuple[np.ndarray, np.ndarray, float]] = (),
    up: Sequence[float] | np.ndarray = (0.0, 0.0, 1.0),
) -> np.ndarray:
    """Return the unit vector (3,) from the mechanism to the eye.

    Parameters
    ----------
    cloud : (n, k, 3) array
        Points of the mechanism at some instants [m], about a common middle at each.
    wheels : sequence of (centre (3,), axis (3,), radius)
        At one instant; one of two wheels that overlap in a picture hides the other.
    up : (3,) sequence
        The vertical.
    """
    points = np.reshape(cloud, (-1, 3))
    size = float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
    best = max(
        ((azimuth, elevation) for elevation in ELEVATIONS for azimuth in AZIMUTHS),
        key=lambda angles: _score(angles, points / size, wheels, up),
    )
    return direction(*best, up)


def direction(azimuth: float, elevation: float, up: Sequence[float] | np.ndarray = (0.0, 0.0, 1.0)) -> np.ndarray:
    """Return the unit vector (3,) at an azimuth about ``up`` and an elevation over the horizontal [rad]."""
    first, second = axes_across(up)
    level = np.cos(azimuth) * first + np.sin(azimuth) * second
    return np.cos(elevation) * level + np.sin(elevation) * np.asarray(up, float)


def axes_across(up: Sequence[float] | np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two horizontal axes (3,), which with ``up`` are right-handed."""
    vertical = int(np.argmax(np.abs(up)))
    first = np.eye(3)[(vertical + 1) % 3]
    return first, np.cross(up, first)


def projection(eye: np.ndarray, up: Sequence[float] | np.ndarray = (0.0, 0.0, 1.0)) -> np.ndarray:
    """Return the matrix (2, 3) that projects positions to the right and up of a picture seen from ``eye``."""
    right = np.cross(up, eye)
    right = right / np.linalg.norm(right)
    return np.stack([right, np.cross(eye, right)])


def _score(angles, points, wheels, up):
    """Return a score of a direction: spread of the points, visibility of the wheels, and of their discs."""
    azimuth, elevation = angles
    seen = direction(azimuth, elevation, up)
    flat = projection(seen, up)
    spread = np.sqrt(np.linalg.det(np.cov((points @ flat.T).T) + 1e-9 * np.eye(2)))
    off = np.abs(np.angle(np.exp(1j * (angles[0] - USUAL[0])))) / np.pi + abs(angles[1] - USUAL[1])
    return spread * (1.0 - PREFERRED * off) * _wheels_seen(wheels, seen, flat)


def _wheels_seen(wheels, seen, flat):
    """Return the visible fraction of the discs of wheels, weighted by how far they face the eye."""
    if not wheels:
        return 1.0
    faces = [max(abs(axis @ seen) / np.linalg.norm(axis), 0.05) for _, axis, _ in wheels]
    worth = np.mean(np.minimum(faces, 0.7))
    for i, (a, _, radius) in enumerate(wheels):
        for j, (b, _, other) in enumerate(wheels[:i]):
            right, above = np.abs(flat @ (a - b))
            width = radius * faces[i] + other * faces[j]
            hidden = max(0.0, 1.0 - right / width) * max(0.0, 1.0 - above / (radius + other))
            worth *= 1.0 - 0.8 * hidden
    return worth
