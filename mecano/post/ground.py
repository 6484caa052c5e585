"""The line in which the ground of a wheel cuts the plane of a side view."""

import numpy as np

STEEPEST = 0.2  # component of the normal along the vertical axis below which the ground is not drawn
POINTS = 60


def ground_line(deck, ground, axes, centre, half_width):
    """Points (n, 2) of the ground below ``centre`` (3,) [m], as wide to both sides as told; None if seen from above.

    ``deck`` is the resolved deck, ``ground`` one of its grounds, ``axes`` those that point to the right and up.
    """
    right, up = axes
    normal = np.array(ground["plane"]["normal"], float)
    normal /= np.linalg.norm(normal)
    if abs(normal[up]) < STEEPEST:
        return None
    profile, point = ground.get("profile"), np.array(ground["plane"]["point"], float)
    points = np.tile(np.array(centre, float), (POINTS if profile else 2, 1))
    points[:, right] += np.linspace(-half_width, half_width, len(points))
    points[:, up] -= (points - point) @ normal / normal[up]
    if profile:
        direction = np.array(profile["direction"], float)
        direction -= (direction @ normal) * normal
        heights = _heights(deck, profile["height"], (points - point) @ (direction / np.linalg.norm(direction)))
        points += heights[:, None] * normal
    return points[:, axes]


def _heights(deck, law, distances):
    """Heights [m] of a profile by its law: a name or terms of the resolved deck."""
    from mecano.laws.probe import curve_at

    checked = _checked(deck["laws"][law] if isinstance(law, str) else law)
    return np.array([curve_at(checked, s)[0] for s in distances])


def _checked(terms):
    """A law of a resolved deck as the checked law it comes from: what is absent there is the default."""
    from mecano.laws import TERMS

    return tuple(
        (name, {f.name: values.get(f.name, f.default) for f in TERMS[name].fields}) for name, values in terms.items()
    )
