"""Outputs of a study as they are displayed: values that are rounding errors are zero."""

from dataclasses import replace

import numpy as np

from mecano.post.quantity import largest

ROUNDING = 1e-9
"""Values below this part of the largest output of the same unit are rounding errors, such as the side load of a
symmetric landing beside that of a drift landing."""


def displayed_outputs(table):
    """Return the columns of the outputs of a StudyTable, with zeros in place of rounding errors."""
    outputs, sizes = table.group("outputs"), {}
    for one in outputs:
        sizes[one.unit] = max(sizes.get(one.unit, 0.0), largest(one.values))
    return tuple(
        replace(one, values=np.where(np.abs(one.values) < ROUNDING * sizes[one.unit], 0.0, one.values))
        for one in outputs
    )
