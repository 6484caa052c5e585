"""Extremes over all accepted steps that are worth reporting for a run as a whole."""

import math
from collections.abc import Mapping

from mecano.results.reader import Extreme

ROUNDING = 1e-10  # of the largest value of the same unit: smaller extremes are rounding errors


def notable(extremes: Mapping[str, Extreme]) -> list[tuple[str, Extreme]]:
    """Return (name, Extreme) of all outputs, without nodes, formulas, zeros and rounding errors.

    Formulas are those written in place, such as the condition of a release, which results contain as differences.
    Joints come first, because a divided member may have many elements.
    """
    least = dict.fromkeys((extreme.unit for extreme in extremes.values()), 0.0)
    for extreme in extremes.values():
        if math.isfinite(size := _largest(extreme)):
            least[extreme.unit] = max(least[extreme.unit], ROUNDING * size)
    found = [
        (path, extreme)
        for path, extreme in extremes.items()
        if not path.startswith(("nodes/", "formulas/")) and not _largest(extreme) <= least[extreme.unit]
    ]
    found.sort(key=lambda item: not item[0].startswith("joints/"))
    return [(named(path), extreme) for path, extreme in found]


def named(path: str) -> str:
    """Return the name of an output as used in requests."""
    return path.replace("/", ".")


def _largest(extreme):
    return max(abs(extreme.minimum), abs(extreme.maximum))
