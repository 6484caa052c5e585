"""A line of nodes: the segments between them, and a smooth line through them, straight or made of arcs of circles."""

import math

import numpy as np

from mecano.constraints.joint_samples import rotation
from mecano.schema import LINE, Field

LINE_FIELD = Field(
    "line", LINE, "-", "nodes from one end to the other; a member, such as a beam, stands for all its nodes"
)
STRAIGHT = 1e-9  # rad: an element whose end directions differ by less is straight


def lengths(nodes):
    """Return the lengths (n - 1,) [m] of the segments between n ``nodes`` at the start."""
    return np.linalg.norm(np.diff([x for x, _ in nodes], axis=0), axis=1)


def check_line(d, nodes):
    """Return errors for a line of less than two nodes, or with nodes at one place: the ``check`` of a load."""
    if len(nodes) < 2:
        return ["'line' must name at least 2 nodes"]
    if lengths(nodes).min() > 0.0:
        return []
    return [
        "consecutive nodes of 'line' must not coincide: where a joint connects two members, each has a line of its own"
    ]


def sample_line(rng):
    """Return, for samples, three nodes in random places with random orientations."""
    return [(rng.normal(size=3), rotation(rng)) for _ in range(3)]


def smooth_line(places):
    """Return unit tangents (n, 3) of a smooth line through ``places`` (n, 3), and its length [m] up to each (n,)."""
    tangents = _directions(places)
    return tangents, np.concatenate([[0.0], np.cumsum(_arcs(places, tangents))])


def _directions(places):
    """Return at each node the direction of the circle through it and its neighbours."""
    chords = np.diff(places, axis=0)
    sizes = np.linalg.norm(chords, axis=1, keepdims=True)
    chords = chords / sizes
    if len(chords) == 1:
        return np.concatenate([chords, chords])
    inner = chords[:-1] * sizes[1:] + chords[1:] * sizes[:-1]  # of the circle through three nodes
    inner /= np.linalg.norm(inner, axis=1, keepdims=True)
    first, last = (2.0 * (c @ t) * c - t for c, t in ((chords[0], inner[0]), (chords[-1], inner[-1])))
    return np.concatenate([[first], inner, [last]])


def _arcs(places, tangents):
    """Return the lengths of the elements; an arc is longer than its chord."""
    chords = np.linalg.norm(np.diff(places, axis=0), axis=1)
    half = [0.5 * math.acos(min(1.0, a @ b)) for a, b in zip(tangents[:-1], tangents[1:], strict=True)]
    return [c * h / math.sin(h) if h > STRAIGHT else c for c, h in zip(chords, half, strict=True)]


def nearest_station(places, stations, x):
    """Return element and s [m] of the point on the chords between ``places`` (n, 3) nearest to x (3,)."""
    found = []
    for i, (start, chord) in enumerate(zip(places[:-1], np.diff(places, axis=0), strict=True)):
        u = float(np.clip((x - start) @ chord / (chord @ chord), 0.0, 1.0))
        found.append((np.linalg.norm(start + u * chord - x), i, stations[i] + u * (stations[i + 1] - stations[i])))
    return min(found)[1:]
