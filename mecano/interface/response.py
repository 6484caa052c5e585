"""Compute frequency responses and linear models from Python."""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from mecano.interface.deck import AnyDeck, AnyPath, Values, checked_deck
from mecano.interface.saved_state import SavedState, saved_state
from mecano.process.cores import bounded_blas

if TYPE_CHECKING:
    from mecano.analyses.response import Response


@bounded_blas()
def response(
    deck: AnyDeck, path: AnyPath | None = None, *, inputs: str | Sequence[str], outputs: str | Sequence[str],
    low: float, high: float, number: int = 200, linear: bool = False, refined: bool = True,
    set: Values | None = None, at: SavedState | None = None, at_rest: bool = False, frame: str = "inertial",
    force: bool = False,
) -> "Response":  # fmt: skip
    """Compute the response of small motions to a small sinusoid of each input, and a linear model.

    Parameters
    ----------
    deck, set, at, at_rest, frame, force
        As for `mecano.modes`.
    path : str or Path
        File for the response; by default none is written.
    inputs : str or sequence of str
        Signals, or functions of time of loads and prescribed motions: "push.value".
    outputs : str or sequence of str
        Outputs as in formulas of signals, accelerations of nodes, or formulas: "tip.acceleration.z".
    low, high : float
        Lowest and highest frequency [Hz].
    number : int
        Number of frequencies, at equal ratios, or at equal distances if ``linear``.
    refined : bool
        Add frequencies around resonances, and locate peaks.

    Returns
    -------
    Response

    Raises
    ------
    DeckError, UsageError, AssemblyError, ConvergenceError, NonFiniteError, ResultsError

    Examples
    --------
    >>> found = mecano.response(
    ...     "pendulum.yaml", inputs="motor.value", outputs="hinge.angle", low=0.1, high=10,
    ...     set={"initial": "static", "loads": {"motor": {"type": "joint_moment", "joint": "hinge", "value": 0}}},
    ... )
    >>> float(round(found.static_gain[0, 0], 5))  # 1/(m g l), 1 kg and 0.75 m
    0.13592
    >>> found.state_space().A.shape
    (2, 2)
    """
    from mecano.analyses.response import ResponseRequest
    from mecano.analyses.response import response as find

    names = [tuple([given] if isinstance(given, str) else given) for given in (inputs, outputs)]
    request = ResponseRequest(
        inputs=names[0], outputs=names[1], low=low, high=high, number=number, linear=linear, refined=refined,
        at=saved_state(at, at_rest), at_rest=at_rest, frame=frame,
    )  # fmt: skip
    request.check()
    return find(checked_deck(deck, set), None if path is None else os.fspath(path), request, force=force)[1]
