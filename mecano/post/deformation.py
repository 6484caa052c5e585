"""Deformation of flexible parts, to be magnified: beams and superelements that share nodes, and their rigid motions.

The rigid motion is the least-squares fit of the part to its shape at the start. Points at nodes of joints and bodies
weigh much more than all others, so that a magnified part stays attached there.
"""

from collections.abc import Container, Sequence
from dataclasses import dataclass

import numpy as np

from mecano.post.shapes import ROD, Shape

HELD = 1e4  # weight of points where something else is attached, over that of others


@dataclass(frozen=True)
class Part:
    """A flexible part: the indices of its ``shapes``, and its rigid motion.

    ``start`` (3,): weighted middle of its points at the start [m]; ``places`` (n, 3): positions of this middle [m];
    ``turns`` (n, 3, 3): rotations of the part since the start.
    """

    shapes: tuple[int, ...]
    start: np.ndarray
    places: np.ndarray
    turns: np.ndarray


def flexible_parts(shapes: Sequence[Shape], flexible: Container[str], held: Container[str]) -> list[Part]:
    """Return the Parts of ``shapes``, whose first instant is the start, with names in ``flexible``.

    ``held`` are names of nodes where other things are attached.
    """
    parts = []
    for numbers in _connected(
        [i for i, shape in enumerate(shapes) if shape.name in flexible and shape.style == ROD], shapes
    ):
        points = np.concatenate([shapes[i].points for i in numbers], axis=1)
        nodes = [node for i in numbers for node in shapes[i].nodes]
        weights = np.array([HELD if node in held else 1.0 for node in nodes])
        parts.append(Part(tuple(numbers), *rigid_fit(points[0], points, weights)))
    return parts


def _connected(numbers, shapes):
    """Return lists of the indices of shapes that share nodes."""
    groups: list[tuple[set[int], set[str]]] = []
    for i in numbers:
        own = ({i}, set(filter(None, shapes[i].nodes)))
        joined = [group for group in groups if group[1] & own[1]]
        groups = [group for group in groups if group not in joined]
        groups.append((own[0].union(*(g[0] for g in joined)), own[1].union(*(g[1] for g in joined))))
    return [sorted(group) for group, _ in groups]


def rigid_fit(
    reference: np.ndarray, points: np.ndarray, weights: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit a rigid motion of ``reference`` (k, 3) to ``points`` (n, k, 3): middle (3,), places (n, 3), turns (n, 3, 3).

    Least squares with ``weights`` (k,), by singular values (Kabsch 1976).
    """
    share = weights / weights.sum()
    start, places = share @ reference, np.einsum("k,nkj->nj", share, points)
    products = np.einsum("k,ki,nkj->nij", share, reference - start, points - places[:, None])
    u, _, vh = np.linalg.svd(products)
    flip = np.linalg.det(u) * np.linalg.det(vh)
    v = np.swapaxes(vh, 1, 2)
    v = np.concatenate([v[..., :2], (v[..., 2] * flip[:, None])[..., None]], axis=2)
    return start, places, v @ np.swapaxes(u, 1, 2)


def quaternions(turns: np.ndarray) -> np.ndarray:
    """Return unit quaternions (w, x, y, z) (n, 4) of rotation matrices (n, 3, 3)."""
    from scipy.spatial.transform import Rotation  # takes 0.2 s to import, and few models have flexible parts

    return np.roll(Rotation.from_matrix(turns).as_quat(), 1, axis=1)
