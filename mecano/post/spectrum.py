"""Amplitude spectra and power spectral densities of quantities.

Amplitudes are one-sided, of the values minus their mean, with a Hann window, corrected by the mean of the window: a
sine of amplitude A gives a peak of height A if its frequency is a multiple of 1/duration; in between, up to 15 % less.

Densities are one-sided, too, and averaged over SEGMENTS segments that overlap by half (Welch, IEEE Trans. Audio
Electroacoust. 15 (1967) 70-73): the height of a random quantity does not depend on the duration, and the integral over
the frequency is the variance.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mecano.deck.wording import quoted
from mecano.errors import UsageError
from mecano.post.quantity import Quantity
from mecano.post.request import GRAMMAR, Request, curve_label, found_in, lacking
from mecano.post.runs import Run
from mecano.post.sheet import Curve, Panel, Sheet

FEWEST = 8  # least number of values
SEGMENTS = 8  # of a density, which has a standard error of about 1/sqrt(SEGMENTS)
UNEVEN = 1e-6  # of the interval: larger differences are not rounding errors
FLOOR = 1e-8  # of the largest amplitude: smaller ones are rounding errors and not shown


class Window(NamedTuple):
    """The times [s] whose values are transformed, from ``begin`` to ``end``; all by default."""

    begin: float | None = None
    end: float | None = None

    @property
    def text(self) -> str:
        """The window as part of a heading, "" for all times."""
        begin = "" if self.begin is None else f" from {self.begin:.6g} s"
        return begin + ("" if self.end is None else f" to {self.end:.6g} s")

    def cut(self, quantity: Quantity) -> Quantity:
        """Return the quantity at the times in the window."""
        room = UNEVEN * float(np.ptp(quantity.time)) / max(len(quantity.time) - 1, 1)
        begin, end = -np.inf if self.begin is None else self.begin, np.inf if self.end is None else self.end
        inside = (quantity.time >= begin - room) & (quantity.time <= end + room)
        return replace(quantity, time=quantity.time[inside], values=quantity.values[inside])


ALL = Window()


class Transforms(NamedTuple):
    """Quantities "Y[,Y2]" to transform: amplitude ``spectra`` and power spectral ``densities``, in a window of time."""

    spectra: Sequence[str] = ()
    densities: Sequence[str] = ()
    window: Window = ALL

    def sheets(self, runs: Sequence[Run]) -> list[Sheet]:
        """Return the Sheet of each of the spectra, then of the densities. Raises UsageError, UnknownNameError."""
        if self.window != ALL and not (self.spectra or self.densities):
            raise UsageError("--from, --to: only with --spectrum or --density")
        drawn = [spectrum_sheet(text, runs, self.window) for text in self.spectra]
        return drawn + [density_sheet(text, runs, self.window) for text in self.densities]


NO_TRANSFORMS = Transforms()


def spectrum_sheet(text: str, runs: Sequence[Run], window: Window = ALL) -> Sheet:
    """Return the Sheet of the amplitudes of "Y[,Y2]", with a panel per unit. Raises UsageError, UnknownNameError.

    Runs without one of the quantities have no curve of it, which the heading says.
    """
    request, curves, remark = _curves("spectrum", text, runs, window, amplitudes, FLOOR, lambda unit: unit)
    panels = [Panel(curve_label(own), own, logarithmic=True, note=_peak(own)) for own in _by_unit(curves)]
    heading = f"Amplitudes over the frequency{window.text}: Hann window, mean removed, a line every {_lines(curves)}"
    heading += remark
    return Sheet(f"spectrum_{request.name}", heading, tuple(panels), run_labels=_labels(runs))


def density_sheet(text: str, runs: Sequence[Run], window: Window = ALL) -> Sheet:
    """Return the Sheet of the power spectral densities of "Y[,Y2]", as ``spectrum_sheet``."""
    request, curves, remark = _curves("density", text, runs, window, densities, FLOOR**2, _squared_per_hertz)
    panels = [
        Panel(curve_label(own), own, logarithmic=True, note=_root_mean_square(own), decades=True)
        for own in _by_unit(curves)
    ]
    heading = (
        f"Power spectral densities{window.text}: {SEGMENTS} segments, Hann window, means removed, "
        f"a line every {_lines(curves)}{remark}"
    )
    return Sheet(f"density_{request.name}", heading, tuple(panels), run_labels=_labels(runs))


def _curves(option, text, runs, window, transform, floor, unit_of):
    """Return the Request of a text, the Curves of the transforms of its quantities in a Window, above the ``floor``,
    and a text on the runs that lack them.
    """
    request = Request.parse(text)
    if request.x != "time":
        raise UsageError(f"--{option} {quoted(text)} is over the frequency; {GRAMMAR.partition(',')[0]} or Y,Y2")
    quantities, curves = {name: found_in(runs, name) for name in request.ys}, []
    for number, run in enumerate(runs):
        for quantity in (quantity for name in request.ys for quantity in quantities[name][number]):
            interval, values = _evenly_sampled(quantity, run, window)
            frequencies, sizes = transform(values, interval)
            x = Quantity("frequency", "Hz", "frequency", f"{quantity.path} {number}", frequencies, frequencies)
            shown = np.where(sizes > floor * sizes.max(initial=0.0), sizes, np.nan)
            y = replace(quantity, unit=unit_of(quantity.unit), clock=x.clock, time=frequencies, values=shown)
            curves.append(Curve(x, y, number, quantity.subject))
    return request, curves, lacking(quantities, runs)


def _by_unit(curves):
    units = dict.fromkeys(curve.y.unit for curve in curves)
    return [tuple(curve for curve in curves if curve.y.unit == unit) for unit in units]


def _lines(curves):
    return ", ".join(dict.fromkeys(f"{curve.x.values[0]:.4g} Hz" for curve in curves))


def _labels(runs):
    return tuple(run.label for run in runs) if len(runs) > 1 else ()


def _squared_per_hertz(unit):
    if unit in ("", "-"):
        return "1/Hz"
    return f"({unit})2/Hz" if set(unit) & set("/ 0123456789") else f"{unit}2/Hz"


def amplitudes(values: np.ndarray, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [Hz] and amplitudes (n // 2,) of values (n,) every ``interval`` [s], without 0 Hz."""
    count = len(values)
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(count) / count)
    sizes = 2.0 * np.abs(np.fft.rfft((values - values.mean()) * window)) / window.sum()
    if count % 2 == 0:
        sizes[-1] *= 0.5  # the Nyquist frequency has one line, not one of each sign
    return np.fft.rfftfreq(count, interval)[1:], sizes[1:]


def densities(values: np.ndarray, interval: float) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies [Hz] and densities [1/Hz] of values (n,) every ``interval`` [s], without 0 Hz."""
    length = max(FEWEST, 2 * len(values) // (SEGMENTS + 1))
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(length) / length)
    starts = range(0, len(values) - length + 1, length // 2)
    parts = np.stack([values[i : i + length] - values[i : i + length].mean() for i in starts])
    sizes = 2.0 * interval * (np.abs(np.fft.rfft(parts * window)) ** 2).mean(axis=0) / (window @ window)
    if length % 2 == 0:
        sizes[-1] *= 0.5  # the Nyquist frequency has one line, not one of each sign
    return np.fft.rfftfreq(length, interval)[1:], sizes[1:]


def _evenly_sampled(quantity, run, window):
    """Return interval [s] and values of a quantity in a Window, without a last value at a shorter interval.

    Raises UsageError.
    """
    where = f"{quoted(quantity.path)} in {run.results.path}"
    if quantity.axis[1] != "s":
        raise UsageError(f"{where} is over the {quantity.axis[0]}: a spectrum needs times")
    quantity = window.cut(quantity)
    gaps = np.diff(quantity.time)
    if len(gaps) > 1 and gaps[-1] < (1.0 - UNEVEN) * gaps[0]:
        gaps = gaps[:-1]
    values = quantity.values[: len(gaps) + 1]
    if len(values) < FEWEST:
        raise UsageError(f"{where} has {len(values)} values{window.text}: too few for a spectrum")
    if np.ptp(gaps) > UNEVEN * gaps.mean():
        raise UsageError(
            f"{where} is known at intervals of {gaps.min():.3g} to {gaps.max():.3g} s: a spectrum needs equal "
            "intervals; run again with 'output: {every: ...}' in the deck"
        )
    if not np.all(np.isfinite(values)):
        raise UsageError(f"{where} is not finite everywhere")
    return float(gaps.mean()), values


def _root_mean_square(curves):
    """Return a text on the root mean square of a single curve about its mean, from its density, or ""."""
    if len(curves) > 1 or not np.any(np.isfinite(curves[0].y.values)):
        return ""
    [curve] = curves
    mean_square = np.nansum(curve.y.values) * curve.x.values[0]
    unit = curve.y.unit.removesuffix("2/Hz").strip("()") if curve.y.unit != "1/Hz" else ""
    return f"root mean square {np.sqrt(mean_square):.3g} {unit}".rstrip()


def _peak(curves):
    """Return a text on the highest line of a single curve, or ""."""
    if len(curves) > 1 or not np.any(np.isfinite(curves[0].y.values)):
        return ""
    [curve] = curves
    i = int(np.nanargmax(curve.y.values))
    return f"{curve.y.values[i]:.3g} {curve.y.unit} at {curve.x.values[i]:.3g} Hz"
