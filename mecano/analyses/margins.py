"""Margins of stability of a loop of a deck, opened at a signal: computation, file, warnings."""

import os
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from mecano.analyses.input_channels import place_of, unknowns_of, with_inputs
from mecano.analyses.margins_text import table
from mecano.analyses.operating_point import angular_velocity_of, operating_point
from mecano.analyses.output_channels import Output
from mecano.analyses.response import (
    BEYOND,
    FrequencyRequest,
    inaccurate,
    new_file,
    plant_of,
    state_warnings,
    static_gains,
)
from mecano.analyses.samplers import samplers_of
from mecano.analyses.source import source_of
from mecano.deck.deck import Deck
from mecano.errors import UsageError, name_list
from mecano.model.system import System
from mecano.process.interrupt import call_interruptibly
from mecano.results.margins_file import write_margins, write_table
from mecano.solve.modal.frequency_grid import Sampled
from mecano.solve.modal.frequency_response import Plant, TransferFunction
from mecano.solve.modal.late_feedback import growing_poles
from mecano.solve.modal.loop_transfer import Crossover, crossovers, highest, in_loops, opened, sample
from mecano.solve.modal.modes import poles_up_to
from mecano.solve.modal.sampled_loop import SampledLoop
from mecano.solve.modal.sampled_system import DiscreteLoop, SampledSystem, sampled_system

CLOSE = 1.0 - 1e-9  # of half the sampling frequency: highest one
BESIDE = 0.999  # of it: highest crossover of the phase besides the one there
NOTHING = 1e-13  # of what L could be: rounding
REACH, TRIED = 10.0, 200  # factor on frequencies of poles and crossovers; frequencies at which L is tried
ROUNDED = 1e-9  # of the fastest pole: a slower one counts as zero
MOST = 8  # names in a message
COLUMNS = ("frequency", "gain_margin", "phase_margin", "delay_margin")  # of crossovers


@dataclass(frozen=True, kw_only=True)
class LoopRequest(FrequencyRequest):
    """What is asked for: the name of a signal at which the loop is opened, frequencies [Hz], operating point.

    A lowest or highest frequency that is nan follows from the poles and the loop gain.
    """

    low: float = np.nan
    high: float = np.nan
    signal: str

    def check(self) -> None:
        """Raise UsageError for frequencies out of range, and for a single one."""
        low, high = (other if np.isnan(one) else one for one, other in ((self.low, self.high), (self.high, self.low)))
        if not np.isnan(low):
            replace(self, low=low, high=high)._check_given()
        if self.low >= self.high or self.number < 2:
            raise UsageError(f"margins need two or more frequencies, the highest greater than {self.low:g} Hz")

    def _check_given(self):
        super().check()

    def around(self, loop: TransferFunction, poles: np.ndarray) -> "LoopRequest":
        """Return the request with the frequencies that are not given.

        With the slowest and the fastest of the ``poles`` [1/s], and the frequency at which the gain of the ``loop``
        falls below one for good (the fastest pole if it is never above): the lowest is REACH below the slowest pole, or
        twice as far below that frequency if that is less; the highest is REACH above that frequency.
        """
        sizes = np.abs(poles[np.abs(poles) > ROUNDED * np.abs(poles).max(initial=0.0)]) / (2.0 * np.pi)
        slowest, fastest = (sizes.min(), sizes.max()) if sizes.size else (1.0, 1.0)  # a loop of delays alone
        tried = np.geomspace(slowest / REACH**2, fastest * REACH, TRIED)
        crossing = max((one for one in tried if abs(loop(2j * np.pi * one)[0, 0]) >= 1.0), default=fastest)
        low = min(slowest / REACH, crossing / REACH**2) if np.isnan(self.low) else self.low
        high = max(crossing, low) * REACH if np.isnan(self.high) else self.high
        return replace(self, low=float(min(low, high / REACH) if np.isnan(self.low) else low), high=float(high))


class Margin(NamedTuple):
    """A margin and its frequency [Hz]; nan where there is none."""

    value: float
    frequency: float


@dataclass(frozen=True, kw_only=True)
class Margins:
    """The loop transfer function L of a signal over the frequency, and its margins."""

    signal: str
    frequency: np.ndarray = field(repr=False)  # (n,) [Hz], ascending
    values: np.ndarray = field(repr=False)  # (n,) complex L
    static: float  # limit of L at low frequency; nan where there is none
    crossovers: list[Crossover] = field(repr=False)
    sensitivity_peak: Margin  # largest modulus of 1/(1 + L)
    growing: int | None  # poles of the closed loop that grow; None if not determined
    sample_poles: np.ndarray = field(repr=False)  # (k,) s [1/s] of z = exp(s T), one of each pair; none if not found
    about: str
    warnings: tuple[str, ...] = field(repr=False)
    plant: Plant = field(repr=False)

    def _least(self, name: str, sizes: list[float]) -> Margin:
        """Return the margin ``name`` of the Crossover of the least of these sizes; nan without one."""
        known = [(size, i) for i, size in enumerate(sizes) if size >= 0.0]
        if not known:
            return Margin(np.nan, np.nan)
        one = self.crossovers[min(known)[1]]
        return Margin(float(getattr(one, name)), one.frequency)

    @property
    def stable(self) -> bool | None:
        """Whether the closed loop is stable; None if not determined."""
        return None if self.growing is None else not self.growing

    @property
    def text(self) -> str:
        """The table that `mecano margins` prints, and the warnings."""
        return "\n".join([*table(self), *(f"mecano: {text}" for text in self.warnings)])

    def __str__(self):
        return self.text

    @property
    def gain(self) -> Margin:
        """The least factor from 1 on."""
        factors = [one.gain_margin for one in self.crossovers]
        return self._least("gain_margin", [factor if factor >= 1.0 else np.nan for factor in factors])

    @property
    def gain_reduction(self) -> Margin:
        """The largest factor below 1."""
        factors = [one.gain_margin for one in self.crossovers]
        return self._least("gain_margin", [1.0 / factor if factor < 1.0 else np.nan for factor in factors])

    @property
    def phase(self) -> Margin:
        """The phase margin [rad] with the least modulus."""
        return self._least("phase_margin", [abs(one.phase_margin) for one in self.crossovers])

    @property
    def delay(self) -> Margin:
        """The least delay margin [s]."""
        return self._least("delay_margin", [one.delay_margin for one in self.crossovers])


def margins(
    deck: Deck, path: str | os.PathLike[str] | None, request: LoopRequest, *, columns: bool = False, force: bool = False
) -> tuple[str, Margins]:
    """Compute the Margins of a loop, write them to ``path`` unless it is None, and return (text of the table, Margins).

    ``columns``: also write L as CSV beside ``path``. Raises UsageError, also if the signal is in no loop, the errors of
    ``mecano run``, and, before anything is computed, ResultsError if a file exists.
    """
    request.check()
    with new_file(path, columns, force):
        found = _compute(deck, request)
        if path is not None:
            plain = contents(found)
            write_margins(path, plain, source_of(deck, warnings=found.warnings), force=force)
            if columns:
                write_table(path, plain, force)
    return found.text, found


def _compute(deck, request):
    """Return the Margins that answer a LoopRequest."""
    changed, (one,) = with_inputs(deck, (request.signal,), "signal")
    if not one.signal:
        raise UsageError(
            f"{request.signal}: a prescribed motion is a function of time, so it closes no loop; give a "
            "signal, or a load that depends on signals"
        )
    base = operating_point(changed, request.at, request.at_rest)
    system = base.prepared.system
    turning = angular_velocity_of(system, base.state, request.frame)
    closed = plant_of(changed, base, [one], [Output(one.name, "", (one.signal,))], turning)
    loop = opened(closed, place_of(system, one.signal)[0], unknowns_of(system, one.signal))
    samplers = samplers_of(deck, system)
    if one.signal in samplers and np.isnan(request.high):
        request = replace(request, high=0.5 / samplers[one.signal].period)  # there are no frequencies above
    if np.isnan(request.low) or np.isnan(request.high):
        poles = np.concatenate([call_interruptibly(poles_up_to, plant.lin, np.inf) for plant in (closed, loop)])
        request = call_interruptibly(request.around, TransferFunction(loop), poles)
    _refuse_without_loop(request, changed, system, closed, loop)
    found = call_interruptibly(_margins, closed, loop, request, one.signal, samplers)
    of_state = state_warnings(changed, base, closed, turning, "the loop", request.grid[0])
    warnings = [*of_state, *_unsure(found, request)]
    return Margins(signal=request.signal, about=base.words, warnings=tuple(warnings), plant=loop, **found.numbers)


def _refuse_without_loop(request, deck, system, closed, loop):
    """Raise UsageError if what reads a signal does not act back on it."""
    H = TransferFunction(loop)
    for omega in request.grid[[0, len(request.grid) // 2, -1]]:
        L, size = H.with_size(1j * omega)
        if np.any(np.abs(L) > NOTHING * np.where(np.isfinite(size), size, 1.0)):
            return
    if not any(q.any() for q in loop.inputs) and not loop.late_inputs:
        reason = "nothing that moves reads it at this state"
    else:
        reason = "what it drives does not act back on it at this state"
    loops = list(_in_loops(deck, system, closed))
    there = f"signals in loops: {name_list(loops, MOST)}" if loops else "no signal of the deck is in a loop"
    raise UsageError(f"{request.signal}: the signal is in no loop: {reason}; {there}")


def _in_loops(deck, system: System, closed: Plant) -> Iterator[str]:
    """Yield the signals of a deck whose readers act back on them."""
    loop = in_loops(closed.lin, closed.late)
    for name in deck.values["signals"]:
        at, own = place_of(system, name)[0], unknowns_of(system, name)
        if np.sum(loop == loop[at]) > np.sum(loop[own] == loop[at]):
            yield name


class _Computed(NamedTuple):
    """The fields of Margins that are numbers, the backward error, and warnings about sampled signals."""

    numbers: dict[str, Any]
    error: float
    warnings: list[str]


def _margins(closed, loop, request, signal, samplers):
    """Return the _Computed values of a loop opened at a signal; ``samplers``: those of the closed loop, by signal."""
    H, base, half = TransferFunction(loop), request.grid, np.nan
    whole = _sampled(closed, samplers)
    transfer, poles = _transfer(H, closed, signal, samplers, whole)
    if signal in samplers:
        base, half = _below(request, transfer.period), float(transfer(1j * np.pi / transfer.period)[0, 0].real)
    L = Sampled(lambda omega: transfer(1j * omega))
    own = poles_up_to(closed.lin, BEYOND * base[-1])
    S = sample(L, base, [*own, *poles_up_to(loop.lin, BEYOND * base[-1]), *poles])
    static = float(static_gains(H, base[0])[0, 0])
    found = crossovers(L, static)
    if signal in samplers:
        found = list(_with_half(found, 0.5 / transfer.period, half))
    omegas, values = L.values
    numbers = {
        "frequency": omegas / (2.0 * np.pi), "values": values[:, 0, 0], "static": static, "crossovers": found,
        "sensitivity_peak": Margin(*highest(S, () if closed.late else own)),
        "growing": _growing(closed, loop, transfer, base, samplers, whole),
        "sample_poles": whole.poles() if isinstance(whole, SampledSystem) else np.zeros(0, complex),
    }  # fmt: skip
    return _Computed(numbers, H.error, list(_averaged(signal, samplers, transfer, whole)))


def _sampled(closed, samplers):
    """Return the SampledSystem of a closed loop, or why there is none; "" without samplers."""
    if not samplers:
        return ""
    if len(closed.late) > len(samplers):
        return "there are delays besides"
    return sampled_system(closed.lin, list(samplers.values()))


def _transfer(H, closed, signal, samplers, whole):
    """Return (the loop transfer function L of a signal, poles [1/s] around which it is to be sampled)."""
    if signal not in samplers:
        return H, ()
    if isinstance(whole, SampledSystem) and np.isclose(whole.period, samplers[signal].period, rtol=1e-9):
        transfer = whole.loop(list(samplers).index(signal))
        return transfer, [pole for pole in (*transfer.poles, *whole.poles()) if pole.imag > 0.0]
    return SampledLoop(H, samplers[signal].period, not _late_besides(closed)), ()


def _late_besides(closed):
    """Return whether a loop has late signals besides that at which it is opened, whose sinusoid is the first output."""
    loop, value = in_loops(closed.lin, closed.late), closed.outputs[0].indices[0]
    return any(row != value and loop[row] == loop[value] for row, *_ in closed.late)


def _with_half(found, frequency, half):
    """Yield the Crossovers of a sampled loop, with that at half the sampling ``frequency``, where L is real: ``half``.

    Beside it the sign of the imaginary part is rounding.
    """
    yield from (one for one in found if one.gain or one.frequency < BESIDE * frequency)
    if half < 0.0:
        yield Crossover(False, frequency, complex(half))


def _below(request, period):
    """Return the circular frequencies [rad/s] below half the sampling frequency, which is the last one if asked for.

    Raises UsageError if there are none.
    """
    half = 0.5 / period
    if request.low >= half:
        raise UsageError(f"from {request.low:g} Hz: half the sampling frequency of the loop is {half:g} Hz")
    return replace(request, high=min(request.high, CLOSE * half)).grid


def _growing(closed, loop, transfer, base, samplers, whole):
    """Return the number of growing poles of the closed loop, or None; of a sampled one, those of its samples."""
    if not samplers:
        return growing_poles(closed, base[0], base[-1])
    if isinstance(whole, SampledSystem):
        return _count_of(whole.growing(), whole)
    if len(samplers) > 1 or isinstance(transfer, TransferFunction):
        return None
    open_poles, turns = growing_poles(loop, base[0], base[-1]), transfer.turns(base[0])
    return None if open_poles is None or turns is None else open_poles + turns


def _count_of(growing, whole):
    """Return how many poles are growing, two for a conjugate pair; None if all are slower than the equations change.

    At half the sampling frequency a pole is real.
    """
    faster = growing[growing.real > whole.pace]
    if len(growing) and not len(faster):
        return None
    return int(np.sum(1 + ((faster.imag > 0.0) & (faster.imag < CLOSE * np.pi / whole.period))))


def _averaged(signal, samplers, transfer, whole) -> Iterator[str]:
    """Yield warnings about samplers that are not counted as such."""
    if samplers and not isinstance(whole, SampledSystem) and (len(samplers) > 1 or signal not in samplers):
        yield f"the stability of the samples is not determined: {whole}"
    for name, one in samplers.items():
        if name != signal and not isinstance(transfer, DiscreteLoop):
            yield (
                f"'{name}' is sampled: the loop is that of its mean over a period, accurate only well below half the "
                f"sampling frequency, {0.5 / one.period:g} Hz; open it at '{name}' for the margins of its samples"
            )


def _unsure(found, request) -> Iterator[str]:
    """Yield warnings about margins that do not say how far the loop is from instability."""
    numbers, error, warnings = found
    yield from warnings
    if numbers["growing"]:
        yield (
            "the closed loop is unstable already: the margins show where poles cross the imaginary axis, not how far "
            "a stable loop is from that"
        )
    if abs(numbers["values"][-1]) >= 1.0:
        yield f"the loop gain is not below 1 at {request.high:g} Hz: crossovers above it are not seen"
    yield from inaccurate(error)


def contents(found: Margins) -> dict[str, Any]:
    """Return the content of the file as plain numbers; see docs/results-file.md."""
    named = {"gain": found.gain, "gain_reduction": found.gain_reduction, "phase": found.phase, "delay": found.delay}
    named["sensitivity_peak"] = found.sensitivity_peak
    margins = {name: margin.value for name, margin in named.items()}
    margins |= {f"{name}_frequency": margin.frequency for name, margin in named.items()}
    crossovers = {name: [getattr(one, name) for one in found.crossovers] for name in COLUMNS}
    values = np.array([one.value for one in found.crossovers], complex)
    return {
        "about": found.about, "signal": found.signal,
        "loop": {
            "frequency": found.frequency, "real_part": found.values.real, "imaginary_part": found.values.imag
        },
        "crossovers": {
            **crossovers, "of_gain": [one.gain for one in found.crossovers], "real_part": values.real,
            "imaginary_part": values.imag,
        },
        "sample_poles": {"real_part": found.sample_poles.real, "imaginary_part": found.sample_poles.imag},
        "margins": {
            **margins, "growing": -1 if found.growing is None else found.growing, "static_gain": found.static
        },
    }  # fmt: skip
