"""Margins of stability of control loops from Python."""

import os
from typing import TYPE_CHECKING

import numpy as np

from mecano.interface.deck import AnyDeck, AnyPath, Values, checked_deck
from mecano.interface.saved_state import SavedState, saved_state
from mecano.process.cores import bounded_blas

if TYPE_CHECKING:
    from mecano.analyses.margins import Margins


@bounded_blas()
def margins(
    deck: AnyDeck, path: AnyPath | None = None, *, open_loop: str, low: float | None = None, high: float | None = None,
    number: int = 200, linear: bool = False, set: Values | None = None, at: SavedState | None = None,
    at_rest: bool = False, frame: str = "inertial", force: bool = False,
) -> "Margins":  # fmt: skip
    """Compute gain, phase and delay margins of a control loop, opened at a signal.

    An input u replaces the signal for everything that reads it, and the signal itself responds with y; L = -y/u.

    Parameters
    ----------
    deck, number, linear, set, at, at_rest, frame, force
        As for `mecano.response`; frequencies are added around resonances and crossovers.
    low, high : float
        Range of frequencies [Hz]; by default from below poles and crossovers to ten times the frequency at which the
        loop gain falls below 1.
    path : str or Path
        File for the margins; by default none is written.
    open_loop : str
        A signal, or a load that is a formula of signals: "motor.value".

    Returns
    -------
    Margins

    Raises
    ------
    DeckError, UsageError, AssemblyError, ConvergenceError, NonFiniteError, ResultsError

    Examples
    --------
    >>> deck = {
    ...     "mecano": 1, "gravity": "none", "time": {"end": 1, "step": 1e-3},
    ...     "nodes": {"cart": {"position": [0, 0, 0]}},
    ...     "elements": {"cart": {"type": "point_mass", "node": "cart", "mass": 2}},
    ...     "joints": {"rail": {"type": "prismatic", "nodes": ["ground", "cart"], "axis": [1, 0, 0]}},
    ...     "signals": {"thrust": "-50*rail.displacement - 20*rail.velocity"},
    ...     "loads": {"motor": {"type": "joint_force", "joint": "rail", "value": "thrust"}},
    ... }
    >>> found = mecano.margins(deck, open_loop="thrust", low=0.1, high=100)
    >>> float(round(np.degrees(found.phase.value), 2)), float(round(found.phase.frequency, 3))
    (76.35, 1.638)
    """
    from mecano.analyses.margins import LoopRequest
    from mecano.analyses.margins import margins as find

    request = LoopRequest(
        signal=open_loop, low=np.nan if low is None else low, high=np.nan if high is None else high, number=number,
        linear=linear, at=saved_state(at, at_rest), at_rest=at_rest, frame=frame,
    )  # fmt: skip
    request.check()
    return find(checked_deck(deck, set), None if path is None else os.fspath(path), request, force=force)[1]
