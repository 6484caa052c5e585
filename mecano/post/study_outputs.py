"""Outputs of a study as displayed: rounding errors are shown as zero."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.post.quantity import largest

if TYPE_CHECKING:
    from mecano.results.study_file import Column, StudyTable

NEAR = 1.0
"""Limits are drawn if they are not further from the values than this part of the span of the values and zero."""
ROUNDING = 1e-9
"""Values below this part of the largest output of the same unit are rounding errors, such as the side load of a
symmetric landing beside that of a drift landing."""


def displayed_outputs(table: "StudyTable") -> "tuple[Column, ...]":
    """Return the columns of the outputs of a StudyTable, with zeros in place of rounding errors."""
    outputs = table.group("outputs")
    sizes: dict[str, float] = {}  # by unit
    for one in outputs:
        sizes[one.unit] = max(sizes.get(one.unit, 0.0), largest(one.values))
    return tuple(
        replace(one, values=np.where(np.abs(one.values) < ROUNDING * sizes[one.unit], 0.0, one.values))
        for one in outputs
    )


def near_limits(output: "Column") -> list[float]:
    """Return the limits of an output that are near enough to its values for a picture."""
    low, high = min(0.0, np.nanmin(output.values)), max(0.0, np.nanmax(output.values))
    far = NEAR * (high - low)
    return [limit for limit in output.limits if limit is not None and low - far <= limit <= high + far]
