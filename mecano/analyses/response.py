"""Frequency response of a deck from inputs to outputs: computation, file, warnings; export of a state space."""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp

from mecano.analyses.friction_and_play import friction_and_play_warnings
from mecano.analyses.input_channels import Input, place_of, unknowns_of, with_inputs
from mecano.analyses.observed_outputs import MemberOutput, NodeOutput
from mecano.analyses.operating_point import OperatingPoint, angular_velocity_of, held_warnings, operating_point
from mecano.analyses.output_channels import Output, with_outputs
from mecano.analyses.response_text import table
from mecano.analyses.small_motion_warnings import accuracy_warnings, imbalance_warnings, noticed, slow_response_warnings
from mecano.analyses.source import source_of
from mecano.analyses.state_space_file import LinearModel, linear_model, refuse, refuse_plant, write_state_space
from mecano.deck.deck import Deck
from mecano.errors import UnknownNameError, UsageError
from mecano.model.signal_units import UNKNOWN
from mecano.process.interrupt import call_interruptibly
from mecano.results.file_names import to_be_written
from mecano.results.response_file import refuse_table, write_response, write_table
from mecano.solve.modal.frequency_grid import Sampled, grid, peaks, refine
from mecano.solve.modal.frequency_response import Plant, TransferFunction
from mecano.solve.modal.late_feedback import growing_poles
from mecano.solve.modal.linearize import linearize
from mecano.solve.modal.modes import poles_up_to

SLOW = 1e-4, 1e-3  # of the lowest frequency: frequencies that give the static gain
STATIC = 1e-3  # relative change between these up to which there is a static gain
ACCURATE = 1e-8  # backward error above which a warning is given
BEYOND = 1.1  # of the highest frequency: poles up to there are computed
MOST_POINTS = 100_000


@dataclass(frozen=True, kw_only=True)
class FrequencyRequest:
    """Requested frequencies [Hz] and operating point."""

    low: float
    high: float
    number: int = 200
    linear: bool = False  # equal distances of the frequencies, else equal ratios
    at: str | None = None
    at_rest: bool = False
    frame: str = "inertial"

    @property
    def grid(self) -> np.ndarray:
        """The circular frequencies (number,) [rad/s]."""
        return 2.0 * np.pi * grid(self.low, self.high, self.number, self.linear)

    def check(self) -> None:
        """Raise UsageError for frequencies out of range."""
        for which, value in (("lowest", self.low), ("highest", self.high)):
            if not (np.isfinite(value) and value > 0.0):
                raise UsageError(f"the {which} frequency must be finite and greater than zero, got {value:g} Hz")
        if self.high < self.low:
            raise UsageError(f"the highest frequency, {self.high:g} Hz, is less than the lowest, {self.low:g} Hz")
        if not 1 <= self.number <= MOST_POINTS:
            raise UsageError(f"the number of frequencies must be from 1 to {MOST_POINTS}, got {self.number}")


@dataclass(frozen=True, kw_only=True)
class ResponseRequest(FrequencyRequest):
    """The requested response: names of inputs and outputs, frequencies [Hz], operating point."""

    inputs: Sequence[str]
    outputs: Sequence[str]
    refined: bool = True  # with points around resonances and located peaks

    def check(self) -> None:
        """Raise UsageError for frequencies out of range, and for missing or repeated inputs and outputs."""
        super().check()
        for channel, names in (("input", self.inputs), ("output", self.outputs)):
            if not names:
                raise UsageError(f"no {channel} is given: name one or more")
            if twice := [name for i, name in enumerate(names) if name in names[:i]]:
                raise UsageError(f"the {channel} {twice[0]} is given twice")


@dataclass(frozen=True)
class Peak:
    """A local maximum of the magnitude of a transfer function."""

    output: str
    input: str
    frequency: float  # [Hz]
    value: complex  # infinite without damping


@dataclass(frozen=True, kw_only=True)
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
    warnings: tuple[str, ...] = field(repr=False)
    plant: Plant = field(repr=False)
    base: OperatingPoint = field(repr=False)

    def __call__(self, output: str | None = None, input: str | None = None) -> np.ndarray:
        """Return a transfer function (n,); the name of a single input or output may be omitted.

        Raises UnknownNameError.
        """
        i, j = _place(output, self.outputs, "output"), _place(input, self.inputs, "input")
        return self.values[:, i, j]

    def state_space(self) -> LinearModel:
        """Return the linear model as matrices of independent first-order equations.

        Raises UsageError if a transfer function grows with the frequency, or a signal is delayed.
        """
        return linear_model(self)

    @property
    def text(self) -> str:
        """The table that `mecano response` prints, and the warnings."""
        return "\n".join([*table(self), *(f"mecano: {text}" for text in self.warnings)])

    def __str__(self):
        return self.text


def _place(name, names, what):
    """Return the index of an output or input. Raises UnknownNameError."""
    if name is None and len(names) == 1:
        return 0
    if name not in names:
        raise UnknownNameError(f"no {what} {name!r} in this response: there are {', '.join(names)}")
    return names.index(name)


def response(
    deck: Deck,
    path: str | os.PathLike[str] | None,
    request: ResponseRequest,
    *,
    state_space: str | os.PathLike[str] | None = None,
    columns: bool = False,
    force: bool = False,
) -> tuple[str, Response]:
    """Compute a response, write it to ``path`` unless it is None, and return (text of the table, Response).

    ``state_space``: file .npz or .mat for the matrices of the linear model; ``columns``: also write a table beside
    ``path``, as CSV. Raises UsageError, the errors of ``mecano run``, and, before anything is computed, ResultsError if
    a file exists.
    """
    request.check()
    if state_space is not None:
        refuse(state_space, force)
    with new_file(path, columns, force):
        found = _find(deck, request, state_space is not None)
        matrices = None if state_space is None else linear_model(found)
        if path is not None:
            write_response(path, found, source_of(deck, warnings=found.warnings), force=force)
            if columns:
                write_table(path, found, force)
    lines = [found.text]
    if state_space is not None and matrices is not None:
        lines.append(write_state_space(state_space, found, matrices))
    return "\n".join(lines), found


@contextmanager
def new_file(path: str | os.PathLike[str] | None, columns: bool, force: bool) -> Iterator[None]:
    """Lock a file of numbers over frequencies that is to be written; do nothing if ``path`` is None.

    Raises UsageError if its name is that of a table, and ResultsError if it or, with ``columns``, the table next to it
    exists, unless ``force``.
    """
    with to_be_written(path, force, "the command with --csv writes the numbers as a table"):
        if path is not None and columns:
            refuse_table(path, force)
        yield


def _find(deck, request, to_export):
    """Return the Response to a ResponseRequest. Raises UsageError if it has no state space that is ``to_export``."""
    changed, inputs = with_inputs(deck, tuple(request.inputs))
    changed, outputs = with_outputs(changed, tuple(request.outputs))
    base = operating_point(changed, request.at, request.at_rest)
    system = base.prepared.system
    turning = angular_velocity_of(system, base.state, request.frame)
    plant = plant_of(changed, base, inputs, outputs, turning)
    if to_export:
        refuse_plant(plant)
    omegas, values, found, static, error = call_interruptibly(_sampled_response, plant, request)
    warnings = [
        *state_warnings(changed, base, plant, turning, "the response", float(omegas.min())),
        *slow_response_warnings(plant.lin, float(omegas.min())),
        *_unstable(plant, request),
        *_without_effect(plant, inputs, values),
        *inaccurate(error),
    ]
    units = system.signal_units
    return Response(
        frequency=omegas / (2.0 * np.pi), values=values, inputs=tuple(one.name for one in inputs),
        outputs=tuple(one.name for one in outputs),
        input_units=tuple(_known(units.get(f"signals/{one.signal}/value"), one.unit) for one in inputs),
        output_units=tuple(_unit_of(one, units) for one in outputs),
        static_gain=static, about=base.words, warnings=tuple(warnings), plant=plant, base=base,
        peaks=tuple(Peak(outputs[i].name, inputs[j].name, frequency, value) for i, j, frequency, value in found),
    )  # fmt: skip


def state_warnings(
    deck: Deck, base: OperatingPoint, plant: Plant, turning: np.ndarray, what: str, lowest: float
) -> Iterator[str]:
    """Yield warnings about the state of a deck for which ``what`` was computed, such as "the response".

    ``lowest`` [rad/s]: its lowest frequency.
    """
    late = set(held_warnings(deck))
    yield from (text for text in base.warnings if text not in late)
    yield from imbalance_warnings(base, turning, f"{what} is that")
    yield from friction_and_play_warnings(deck, base.prepared.system, base.state)
    yield from accuracy_warnings(noticed(plant.lin, lowest), [], f"{what} holds")


def _unit_of(output, units):
    """Return the unit of an output; ``units``: {path: unit} of signals."""
    measured = isinstance(output, Output) and not output.unit
    return units[f"signals/{output.signals[0]}/value"] if measured else output.unit


def _known(of_signal, otherwise):
    """Return the unit of an input: that of its signal, if it is known."""
    return of_signal if of_signal and (of_signal != UNKNOWN or not otherwise) else otherwise


def plant_of(
    deck: Deck,
    base: OperatingPoint,
    inputs: Sequence[Input],
    outputs: Sequence[Output | NodeOutput | MemberOutput],
    turning: np.ndarray,
) -> Plant:
    """Return the Plant of the operating point with its inputs and outputs, in axes that turn with ``turning`` (3,)."""
    prepared, system = base.prepared, base.prepared.system
    lin = linearize(system, base.state, prepared.length, turning, base.assemble, prepared.stiff_compliance)
    columns = np.array([one.columns(lin, system, base.state, deck) for one in inputs])
    rows = [one.rows(system, base.state, turning) for one in outputs]
    R = [sp.csr_matrix(sp.vstack([row[k] for row in rows])) for k in range(3)]
    late = tuple(_delayed_signals(deck, system))
    return Plant(lin, [columns[:, k].T.copy() for k in range(3)], R, late, tuple(_late_inputs(inputs, late, system)))


def _late_inputs(inputs, late, system):
    """Yield (row, input, transfer function) of the signals that read an input at an earlier time."""
    for number, one in enumerate(inputs):
        at = place_of(system, one.signal)[0] if one.signal else -1
        yield from ((row, number, f) for row, column, f in late if column == at)


def _delayed_signals(deck, system):
    """Yield (row, column, transfer function) of the signals that depend on their input at earlier times."""
    for name, d in deck.values["signals"].items():
        if d["type"] not in LATE:
            continue
        own, source = unknowns_of(system, name)[:2].tolist()
        yield own, source, LATE[d["type"]](d)


def _delayed(d):
    return lambda s: np.exp(-s * d["time"])


def _held_sample(d):
    """Return the transfer function of a sampled value that is held for a period."""
    return lambda s: (1.0 - np.exp(-s * d["period"])) / (s * d["period"]) if s else 1.0


LATE = {"delay": _delayed, "sample_and_hold": _held_sample}


def _sampled_response(plant, request):
    """Return (frequencies (n,) [rad/s], responses (n, p, m), Peaks, static gains (p, m), largest backward error)."""
    H = TransferFunction(plant)
    sampled = Sampled(lambda omega: H(1j * omega))
    base = request.grid
    if request.refined and request.number > 1:
        poles = poles_up_to(plant.lin, BEYOND * base[-1])
        refine(sampled, base, poles)
        found = peaks(sampled, () if plant.late else poles)  # without late feedback the poles are others
    else:
        found = []
        for omega in base.tolist():
            sampled.at(omega)
    omegas, values = sampled.values
    return omegas, values, found, static_gains(H, base[0]), H.error


def static_gains(H: Callable[[complex], np.ndarray], lowest: float) -> np.ndarray:
    """Return the limits (p, m) at low frequency, nan where infinite, from responses below ``lowest`` [rad/s]."""
    slowest, slow = (np.where(np.isfinite(one), one, np.nan) for one in (H(1j * share * lowest) for share in SLOW))
    settled = np.abs(slow - slowest) <= STATIC * np.abs(slowest)
    vanishes = np.abs(slowest) < 0.5 * np.abs(slow)
    return np.where(settled, slowest.real, np.where(vanishes, 0.0, np.nan))


def _unstable(plant, request) -> Iterator[str]:
    """Yield a warning if small motions grow without any input."""
    if growing := call_interruptibly(growing_poles, plant, *request.grid[[0, -1]].tolist()):
        poles = f"{growing} pole{'s' if growing > 1 else ''} with a positive real part"
        yield (
            f"the linearized system is unstable, with {poles} (`mecano modes`): the response is its transfer function, "
            "but no motion settles to this sinusoid"
        )


def _without_effect(plant, inputs, values) -> Iterator[str]:
    """Yield warnings about inputs that nothing reads, and about pairs without a connection."""
    for j, one in enumerate(inputs):
        if not any(q[:, j].any() for q in plant.inputs) and j not in [number for _, number, _ in plant.late_inputs]:
            yield f"the input {one.name} acts on nothing: no load, joint or signal reads it"
        elif not values[:, :, j].any():
            yield f"no output responds to the input {one.name}"


def inaccurate(error: float) -> Iterator[str]:
    """Yield a warning if the backward ``error`` of a response is large."""
    if error > ACCURATE:
        yield f"the equations are satisfied to {error:.1g} of their terms only: the response may be inaccurate"
