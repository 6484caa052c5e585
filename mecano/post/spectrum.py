"""Amplitude spectra of quantities.

One-sided amplitudes of the values minus their mean, with a Hann window, corrected by the mean of the window: a sine of
amplitude A gives a peak of height A if its frequency is a multiple of 1/duration; in between, up to 15 % less.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.deck.wording import quoted
from mecano.errors import UsageError
from mecano.post.quantity import Quantity
from mecano.post.request import GRAMMAR, Request, curve_label, found
from mecano.post.sheet import Curve, Panel, Sheet

if TYPE_CHECKING:
    from mecano.post.runs import Run

FEWEST = 8  # least number of values
UNEVEN = 1e-6  # of the interval: larger differences are not rounding errors
FLOOR = 1e-8  # of the largest amplitude: smaller ones are rounding errors and not shown


def spectrum_sheet(text: str, runs: "Sequence[Run]") -> Sheet:
    """Return the Sheet of the spectra of "Y[,Y2]", with a panel per unit. Raises UsageError, UnknownNameError."""
    request = Request.parse(text)
    if request.x != "time":
        raise UsageError(f"--spectrum {quoted(text)} is over the frequency; {GRAMMAR.partition(',')[0]} or Y,Y2")
    curves = [
        _spectrum(quantity, run, number)
        for number, run in enumerate(runs)
        for name in request.ys
        for quantity in found(run, name)
    ]
    panels = []
    for unit in dict.fromkeys(curve.y.unit for curve in curves):
        own = tuple(curve for curve in curves if curve.y.unit == unit)
        panels.append(Panel(curve_label(own), own, logarithmic=True, note=_peak(own)))
    lines = ", ".join(dict.fromkeys(f"{curve.x.values[0]:.4g} Hz" for curve in curves))
    heading = f"Amplitudes over the frequency: Hann window, mean removed, a line every {lines}"
    labels = tuple(run.label for run in runs) if len(runs) > 1 else ()
    return Sheet(f"spectrum_{request.name}", heading, tuple(panels), run_labels=labels)


def _spectrum(quantity, run, number):
    interval, values = _evenly_sampled(quantity, run)
    frequencies, sizes = amplitudes(values, interval)
    x = Quantity("frequency", "Hz", "frequency", f"{quantity.path} {number}", frequencies, frequencies)
    shown = np.where(sizes > FLOOR * sizes.max(initial=0.0), sizes, np.nan)
    return Curve(x, replace(quantity, clock=x.clock, time=frequencies, values=shown), number, quantity.subject)


def amplitudes(values: np.ndarray, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [Hz] and amplitudes (n // 2,) of values (n,) every ``interval`` [s], without 0 Hz."""
    count = len(values)
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(count) / count)
    sizes = 2.0 * np.abs(np.fft.rfft((values - values.mean()) * window)) / window.sum()
    if count % 2 == 0:
        sizes[-1] *= 0.5  # the Nyquist frequency has one line, not one of each sign
    return np.fft.rfftfreq(count, interval)[1:], sizes[1:]


def _evenly_sampled(quantity, run):
    """Return interval [s] and values of a quantity, without a last value at a shorter interval. Raises UsageError."""
    where, gaps = f"{quoted(quantity.path)} in {run.results.path}", np.diff(quantity.time)
    if quantity.axis[1] != "s":
        raise UsageError(f"{where} is over the {quantity.axis[0]}: a spectrum needs times")
    if len(gaps) > 1 and gaps[-1] < (1.0 - UNEVEN) * gaps[0]:
        gaps = gaps[:-1]
    values = quantity.values[: len(gaps) + 1]
    if len(values) < FEWEST:
        raise UsageError(f"{where} has {len(values)} values: too few for a spectrum")
    if np.ptp(gaps) > UNEVEN * gaps.mean():
        raise UsageError(
            f"{where} is known at intervals of {gaps.min():.3g} to {gaps.max():.3g} s: a spectrum needs equal "
            "intervals; run again with 'output: {every: ...}' in the deck"
        )
    if not np.all(np.isfinite(values)):
        raise UsageError(f"{where} is not finite everywhere")
    return float(gaps.mean()), values


def _peak(curves):
    """Return a text on the highest line of a single curve, or ""."""
    if len(curves) > 1 or not np.any(np.isfinite(curves[0].y.values)):
        return ""
    [curve] = curves
    i = int(np.nanargmax(curve.y.values))
    return f"{curve.y.values[i]:.3g} {curve.y.unit} at {curve.x.values[i]:.3g} Hz"
