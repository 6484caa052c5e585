"""Margins of stability of control loops from Python."""

import os
from dataclasses import dataclass, field

import numpy as np

from mecano.interface.deck import AnyDeck, AnyPath, Values, checked_deck
from mecano.interface.saved_state import SavedState, saved_state


def margins(
    deck: AnyDeck, path: AnyPath | None = None, *, open_loop: str, low: float | None = None, high: float | None = None,
    number: int = 200, linear: bool = False, set: Values | None = None, at: SavedState | None = None,
    at_rest: bool = False, frame: str = "inertial", force: bool = False,
) -> "LoopMargins":  # fmt: skip
    """Compute the margins of stability of a loop that is opened at a signal.

    All that reads the signal reads an input u instead, to which the signal responds with y; L = -y/u.

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
    LoopMargins

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
    text, found = find(checked_deck(deck, set), None if path is None else os.fspath(path), request, force=force)
    return _values_of(found, text)


def _values_of(found, text):
    """Return the LoopMargins of those of analyses/margins.py, with their ``text``."""
    crossovers = tuple(
        LoopCrossover(one.frequency, one.value, one.gain_margin, one.phase_margin, one.delay_margin)
        for one in found.crossovers
    )
    return LoopMargins(
        found.signal, found.frequency, found.values, Margin(*found.gain), Margin(*found.gain_reduction),
        Margin(*found.phase), Margin(*found.delay), Margin(*found.sensitivity), crossovers,
        None if found.growing is None else not found.growing, found.about, text,
    )  # fmt: skip


@dataclass(frozen=True)
class Margin:
    """A margin of stability and the frequency [Hz] at which poles cross the imaginary axis; nan where there is none."""

    value: float
    frequency: float


@dataclass(frozen=True)
class LoopCrossover:
    """A frequency at which a loop transfer function has the magnitude 1, or the phase -180 degrees."""

    frequency: float  # [Hz]; 0 for the limit at low frequency
    value: complex  # of L
    gain_margin: float  # nan where the phase is another
    phase_margin: float  # [rad]; nan where the magnitude is not 1
    delay_margin: float  # [s]; nan where the magnitude is not 1


@dataclass(frozen=True)
class LoopMargins:
    """The loop transfer function L of a signal over the frequency, and its margins of stability."""

    signal: str
    frequency: np.ndarray = field(repr=False)  # (n,) [Hz], ascending
    values: np.ndarray = field(repr=False)  # (n,) complex L
    gain: Margin  # least factor from 1 on
    gain_reduction: Margin  # largest factor below 1
    phase: Margin  # [rad]
    delay: Margin  # [s]
    sensitivity_peak: Margin  # largest modulus of 1/(1 + L)
    crossovers: tuple[LoopCrossover, ...] = field(repr=False)
    stable: bool | None  # the closed loop; None where it was not determined
    about: str
    text: str = field(repr=False)  # the table that `mecano margins` prints

    def __str__(self):
        return self.text
