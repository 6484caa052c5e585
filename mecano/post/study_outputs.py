"""Numbers of a study as displayed: angles in degrees, rounding errors as zero; which cases govern an output."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mecano.post.quantity import largest
from mecano.post.style import shown_unit
from mecano.results.study_file import Column, StudyTable

NEAR = 1.0
"""Limits are drawn if they are not further from the values than this part of the span of the values and zero."""
ROUNDING = 1e-9
"""Values below this part of the largest output of the same unit are rounding errors, such as the side load of a
symmetric landing beside that of a drift landing."""


def displayed_outputs(table: StudyTable) -> tuple[Column, ...]:
    """Return the columns of the outputs of a StudyTable, with zeros in place of rounding errors."""
    outputs = table.group("outputs")
    sizes: dict[str, float] = {}  # by unit
    for one in outputs:
        sizes[one.unit] = max(sizes.get(one.unit, 0.0), largest(one.values))
    return tuple(
        replace(one, values=np.where(np.abs(one.values) < ROUNDING * sizes[one.unit], 0.0, one.values))
        for one in outputs
    )


def study_unit(unit: str, values: np.ndarray) -> tuple[float, str]:
    """Return factor and unit for the display of values of a study: as ``shown_unit``, but degrees for angles.

    A study varies angles that its file and its deck give in degrees as a rule, so that limits and outputs compare.
    """
    if unit != "rad":
        return shown_unit(unit, values)
    factor, shown = shown_unit("deg", np.degrees(values))
    return math.radians(factor), shown


def severity(output: Column) -> np.ndarray:
    """Return numbers (n,), the larger the more a case governs an output; nan of a missing value.

    They are the magnitudes; of an output with a single limit the values on the side of this limit.
    """
    lower, upper = output.limits
    if (lower is None) == (upper is None):
        return np.abs(output.values)
    return -output.values if upper is None else output.values


def heading_of(table: StudyTable, outputs: Sequence[Column]) -> str:
    """Return the heading of a picture of ``outputs``: the verdict, and what a shade means if there is any."""
    return table.verdict + "; shaded: beyond a limit" * any(near_limits(output, 1.0) for output in outputs)


def near_limits(output: Column, factor: float) -> list[tuple[float, float]]:
    """Return (limit over ``factor``, side beyond it: -1 or 1) of an output, of limits near enough for a picture."""
    low, high = min(0.0, np.nanmin(output.values)), max(0.0, np.nanmax(output.values))
    far = NEAR * (high - low)
    limits = zip(output.limits, (-1.0, 1.0), strict=True)
    return [(limit / factor, side) for limit, side in limits if limit is not None and low - far <= limit <= high + far]
