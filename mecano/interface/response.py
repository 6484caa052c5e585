"""Compute frequency responses and linear models from Python."""

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from mecano.errors import UnknownNameError
from mecano.interface.deck import AnyDeck, AnyPath, Values, checked_deck
from mecano.interface.saved_state import SavedState, saved_state

if TYPE_CHECKING:
    from mecano.analyses.response import Response as Found


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
    text, found = find(checked_deck(deck, set), None if path is None else os.fspath(path), request, force=force)
    peaks = tuple(
        Peak(found.outputs[one.output], found.inputs[one.input], one.frequency, one.value) for one in found.peaks
    )
    return Response(found.frequency, found.values, found.inputs, found.outputs, found.input_units, found.output_units,
                    found.static, peaks, found.about, text, found)  # fmt: skip


@dataclass(frozen=True)
class Peak:
    """A local maximum of the magnitude of a transfer function."""

    output: str
    input: str
    frequency: float  # [Hz]
    value: complex  # infinite without damping


@dataclass(frozen=True)
class Response:
    """Transfer functions over the frequency; ``found(output, input)`` is one of them."""

    frequency: np.ndarray = field(repr=False)  # (n,) [Hz], ascending
    values: np.ndarray = field(repr=False)  # (n, p, m) complex, output unit per input unit
    inputs: tuple[str, ...]  # (m,)
    outputs: tuple[str, ...]  # (p,)
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    static_gain: np.ndarray = field(repr=False)  # (p, m) limit at low frequency; nan where there is none
    peaks: tuple[Peak, ...] = field(repr=False)
    about: str
    text: str = field(repr=False)  # the table that `mecano response` prints
    _found: "Found" = field(repr=False)

    def __call__(self, output: str | None = None, input: str | None = None) -> np.ndarray:
        """Return a transfer function (n,); the name of a single input or output may be omitted.

        Raises UnknownNameError.
        """
        i, j = _place(output, self.outputs, "output"), _place(input, self.inputs, "input")
        return self.values[:, i, j]

    def state_space(self) -> "LinearModel":
        """Return the linear model as matrices of independent first-order equations.

        Raises UsageError if a transfer function grows with the frequency, or a signal is delayed.
        """
        from mecano.analyses.state_space_file import linear_model

        found = linear_model(self._found)
        of = found.matrices
        return LinearModel(of.A, of.B, of.C, of.D, tuple(found.states), tuple(found.units), self.inputs, self.outputs)

    def __str__(self):
        return self.text


@dataclass(frozen=True)
class LinearModel:
    """The equations x' = A x + B u, z = C x + D u of small motions; a state "d/dt a" is a rate."""

    A: np.ndarray  # (n, n)
    B: np.ndarray  # (n, m)
    C: np.ndarray  # (p, n)
    D: np.ndarray  # (p, m)
    states: tuple[str, ...]
    state_units: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


def _place(name, names, what):
    """Return the index of an output or input. Raises UnknownNameError."""
    if name is None and len(names) == 1:
        return 0
    if name not in names:
        raise UnknownNameError(f"no {what} {name!r} in this response: there are {', '.join(names)}")
    return names.index(name)
