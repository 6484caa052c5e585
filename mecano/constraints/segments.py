"""Segments of a line of nodes along which a load is distributed."""

import numpy as np


def lengths(nodes):
    """Return the lengths (n - 1,) [m] of the segments between n ``nodes`` at the start."""
    return np.linalg.norm(np.diff([x for x, _ in nodes], axis=0), axis=1)


def check_line(nodes):
    """Return errors for a line of less than two nodes, or with nodes at one place."""
    if len(nodes) < 2:
        return ["'line' must name at least 2 nodes"]
    return [] if lengths(nodes).min() > 0.0 else ["consecutive nodes of 'line' must not coincide"]


def sample_line(rng):
    """Return, for samples, three nodes in random places with random orientations."""
    nodes = [(rng.normal(size=3), np.linalg.qr(rng.normal(size=(3, 3)))[0]) for _ in range(3)]
    return [(x, Q * np.linalg.det(Q)) for x, Q in nodes]
