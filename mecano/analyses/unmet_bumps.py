"""Warnings about grounds with bumps that no wheel met in a run: an end too early, a direction or a sign is wrong."""

from collections.abc import Iterator

import numpy as np

from mecano.deck.deck import Deck
from mecano.model.extremes import Extremes
from mecano.model.sampler import Sampler

DIGITS = 6  # after the point of a distance [m]


def unmet_bump_warnings(deck: Deck, sampler: Sampler, extremes: Extremes) -> Iterator[str]:
    """Yield a warning about each ground whose profile consists of bumps, of which its wheels met none.

    The distances covered are those of the box around all points of contact, which may be longer than the way.
    """
    for name, ground in deck.values["grounds"].items():
        height = ground["profile"]["height"] if ground["profile"] else ()
        bumps = [values for term, values in height if term == "bump"]
        if not bumps or len(bumps) < len(height):
            continue
        wheels = [wheel for wheel, d in deck.values["elements"].items() if d.get("ground") is ground]
        ways = {
            wheel: _way(sampler.starts.get(f"elements/{wheel}/contact_point"), ground, extremes) for wheel in wheels
        }
        known = {wheel: way for wheel, way in ways.items() if way}
        if known and not any(_meet(way, bump) for way in known.values() for bump in bumps):
            wheel, (low, high) = next(iter(known.items()))
            yield (
                f"no wheel met a bump of ground '{name}': along the 'direction' of its profile they lie from "
                f"{min(bump['start'] for bump in bumps):g} m on, and wheel '{wheel}' was between {low:.4g} and "
                f"{high:.4g} m; does the run end too early, or is the 'direction' wrong?"
            )


def _way(start, ground, extremes):
    """Return the least and the largest distance of a point along the profile of a ground, or None if it is unknown."""
    if start is None:
        return None
    normal = np.array(ground["plane"]["normal"]) / np.linalg.norm(ground["plane"]["normal"])
    along = np.array(ground["profile"]["direction"], float)
    along -= along @ normal * normal
    along /= np.linalg.norm(along)
    low, high = (values[start : start + 3] - ground["plane"]["point"] for values in (extremes.low, extremes.high))
    ends = np.round(np.sort([along * low, along * high], axis=0).sum(axis=1), DIGITS) + 0.0
    return float(ends[0]), float(ends[1])


def _meet(way, bump):
    return way[0] < bump["start"] + bump["length"] and way[1] > bump["start"]
