"""Extremes over all accepted steps that are worth telling of a run as a whole."""

import math

ROUNDING = 1e-10  # of the largest value of a unit: what stays below it says nothing


def telling(extremes):
    """(name as it is asked for, Extreme) of all but the nodes, and but what is zero or rounding beside its unit."""
    least = dict.fromkeys((extreme.unit for extreme in extremes.values()), 0.0)
    for extreme in extremes.values():
        if math.isfinite(size := _largest(extreme)):
            least[extreme.unit] = max(least[extreme.unit], ROUNDING * size)
    return [
        (named(path), extreme)
        for path, extreme in extremes.items()
        if not path.startswith("nodes/") and not _largest(extreme) <= least[extreme.unit]
    ]


def named(path):
    """The name by which an output is asked for."""
    return path.replace("/", ".")


def _largest(extreme):
    return max(abs(extreme.minimum), abs(extreme.maximum))
