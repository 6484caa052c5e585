"""Saved states about which modes, responses and margins are computed, as arguments of the Python interface."""

import os
from typing import TypeAlias

import numpy as np

from mecano.errors import UsageError
from mecano.interface.deck import AnyPath

SavedState: TypeAlias = AnyPath | tuple[AnyPath, float]


def saved_state(at: SavedState | None, at_rest: bool) -> str | None:
    """Return a saved state as the text of the option ``--at``, "results.h5:1.25", or None for the start.

    Raises UsageError for ``at_rest`` without a saved state, and TypeError if ``at`` is neither a path nor a pair.
    """
    if at is None:
        if at_rest:
            raise UsageError("at_rest=True belongs to a saved state: give at='results.h5:1.25'")
        return None
    if isinstance(at, tuple) and len(at) == 2 and isinstance(at[1], int | float | np.number):
        return f"{os.fspath(at[0])}:{float(at[1])!r}"
    if not isinstance(at, str | os.PathLike):
        raise TypeError(f"at={at!r}: write 'results.h5:1.25' or ('results.h5', 1.25)")
    return os.fspath(at)
