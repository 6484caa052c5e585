"""Monitoring of outputs during a run: limits with a warning, and ends of the range of an element."""

from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np

from mecano.element_interface import SECTIONS
from mecano.elements import KINDS
from mecano.model.mesh import piece_names
from mecano.model.sampler import Sampler
from mecano.schema import Values

Watched: TypeAlias = "tuple[str, Values, str, int, Any, Any, int]"
"""Name and deck values of an element, its output, its column in the row, the limit or bounds, the text beyond, or the
function of the row that returns it, and the column of the output that must not be zero, too"""


def has_end_conditions(values: Values) -> bool:
    """Return whether elements with the deck values ``values`` may end a run."""
    return any(KINDS[d["type"]].end_conditions(d) for section in SECTIONS for d in values[section].values())


def watched_outputs(values: Values, sampler: Sampler, what: str) -> list[Watched]:
    """Return the monitored outputs of the elements with the deck values ``values``.

    ``what`` is "limits", "bounds" or "end_conditions". The result is a list of (name of the
    element, or of each element of a divided member; deck values, output, its column in the row, value, text, column
    that must not be zero), one for each component of a vector.
    """
    columns = {column.path: column for column in sampler.columns}

    def bound(text, place):
        """Return the text of an element at a ``place`` of the columns, or the function of a row for it."""
        if isinstance(text, str):
            return text
        return lambda row: text(lambda output: row[columns[f"{place}/{output}"].start])

    return [
        (
            piece,
            d,
            output + part,
            column.start + i,
            value,
            bound(text, f"{section}/{piece}"),
            required.start if during else column.start + i,
        )
        for section in SECTIONS
        for name, d in values[section].items()
        for output, value, text, *during in getattr(KINDS[d["type"]], what)(d)
        for piece in piece_names(name, d)
        for column, required in [[columns[f"{section}/{piece}/{one}"] for one in (output, *(during or [output]))]]
        for i, part in enumerate((".x", ".y", ".z") if column.size == 3 else ("",))
    ]


def ended(ends: Iterable[Watched], row: np.ndarray) -> str:
    """Return a text for the first element in a row (row_size,) of the sampler that has reached its end, or ""."""
    beyond = (one for one in ends if abs(row[one[3]]) > one[4] and row[one[6]] != 0.0)
    return next((end_text(watched, row) for watched in beyond), "")


def end_text(watched: Watched, row: np.ndarray) -> str:
    """Return the text on an element that has reached its end in a row (row_size,) of the sampler."""
    name, d, *_, text, _ = watched
    return f"{d['type']} '{name}' {text if isinstance(text, str) else text(row)}"
