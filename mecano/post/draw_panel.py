"""Drawing of a panel of curves into axes of matplotlib."""

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import LogFormatterSciNotation, MaxNLocator, NullFormatter

from mecano.post.draw_events import EventLegend, draw_events
from mecano.post.style import (
    LINE_OF_TEXT,
    legend_above,
    legend_columns,
    note_below,
    power_of_ten,
    range_of,
    shown_unit,
    with_unit,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from mecano.post.curve_styles import CurveStyles
    from mecano.post.event_marks import EventMark
    from mecano.post.sheet import Panel

MARKED = 3  # curves of a panel up to which their extremes are marked
MISSED = 1e-3  # of the largest value shown: a peak that is larger by that is marked
TINY = 1e-300
DECADES = 1e-12  # of the largest value: lower limit of logarithmic axes
LINE, WIDER = 1.3, 0.9  # points
MOST_COVERING = 3
ALIKE = 0.01  # of the span of the axes: curves that differ by less cover each other
WIDTH = 3.7  # inches, of most axes
MOST_NUMBERS = 6  # intervals between those below a panel: with signs and decimals more of them touch one another
MANY = 500  # with more values, steps are drawn with thinner lines


def draw_panel(
    ax: "Axes", panel: "Panel", styles: "CurveStyles", events: "Sequence[EventMark]", legend: EventLegend
) -> None:
    """Draw the curves with their extremes, their legend, the events with the marks of an EventLegend."""
    unit = panel.curves[0].y.unit
    x_factor, x_unit = shown_unit(panel.curves[0].x.unit, _all(panel, "x"))
    y_factor, y_unit = (1.0, unit) if panel.logarithmic else shown_unit(unit, _all(panel, "y"))
    spans = _spans(panel)
    drawn = [equal[0] for equal in styles.drawn(panel)]
    for i, curve in enumerate(drawn):
        y = curve.y.values / y_factor
        if panel.logarithmic:
            y = np.where(y > TINY, y, np.nan)
        style = styles.style(curve, panel) | _steps(panel, y)
        if style["linestyle"] == "-":
            style.setdefault("linewidth", _width(curve, drawn[i + 1 :], spans))
        ax.plot(curve.x.values / x_factor, y, **style)
        alone = _alone(y)
        if alone.any() and not curve.measured:
            ax.plot(curve.x.values[alone] / x_factor, y[alone], ".", color=style["color"], markersize=4.0, zorder=2.5)
        if curve.peak and not panel.logarithmic and (_misses_peak(curve) or len(drawn) <= MARKED):
            value, time = curve.peak
            ax.plot(time / x_factor, value / y_factor, "o", color=style["color"], markersize=3.5, zorder=3)
    _scales(ax, panel, x_factor, y_factor)
    ax.set_ylabel(with_unit(panel.label, y_unit))
    x = panel.curves[0].x
    ax.set_xlabel(with_unit(x.subject if x.of_signal else x.what, x_unit))
    legend_above(ax, styles.legend(panel), WIDTH)
    _note(ax, panel, y_factor, y_unit)
    if panel.over_time:
        draw_events(ax, legend.of(panel, events), x_factor, styles)


def _alone(y):
    """Return (n,) bool: values between two gaps, or between a gap and an end, through which no line passes."""
    gap = np.concatenate([[True], ~np.isfinite(y), [True]])
    return ~gap[1:-1] & gap[:-2] & gap[2:]


def _all(panel, side):
    return np.concatenate([getattr(curve, side).values for curve in panel.curves])


def _misses_peak(curve):
    """Return whether the values shown miss the peak over all accepted steps."""
    return bool(curve.peak) and abs(curve.peak[0]) > (1.0 + MISSED) * np.nanmax(np.abs(curve.y.values), initial=0.0)


def _spans(panel):
    """Return the spans of the curves of a panel along both axes, as drawn if they are constant."""
    x, y = _all(panel, "x"), _all(panel, "y")
    ranges = (x, range_of(x)), (y, range_of(y, panel.level))
    return [np.ptp(constant or values[np.isfinite(values)]) for values, constant in ranges]


def _width(curve, later, spans):
    """Return the width of a line [points], wider than the ``later`` lines that cover it."""
    covering = sum(not other.reference and _nearly_equal(curve, other, spans) for other in later)
    return LINE + WIDER * min(covering, MOST_COVERING)


def _nearly_equal(curve, other, spans):
    """Return whether two curves nearly coincide in a panel with these spans."""
    pairs = (curve.x.values, other.x.values), (curve.y.values, other.y.values)
    return len(pairs[0][0]) == len(pairs[0][1]) and all(
        np.all(np.abs(one - two)[np.isfinite(one - two)] <= ALIKE * span)
        for (one, two), span in zip(pairs, spans, strict=True)
    )


def _steps(panel, values):
    if not panel.stepped:
        return {}
    return {"drawstyle": "steps-pre", "linewidth": 0.6 if len(values) > MANY else 1.2}


class PlainPowers(LogFormatterSciNotation):
    """Formatter of a logarithmic axis without mathematical markup, because texts of pictures are not parsed."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of the tick at ``x``."""
        text = re.sub(r"\$\\mathdefault\{(.*)\}\$", r"\1", super().__call__(x, pos)).replace(r"\times", "×")
        return re.sub(r"10\^\{(-?\d+)\}", lambda match: power_of_ten(match[1]), text)


def _scales(ax, panel, x_factor, y_factor):
    y = _all(panel, "y") / y_factor
    if panel.logarithmic:
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter(PlainPowers())
        ax.yaxis.set_minor_formatter(PlainPowers(labelOnlyBase=False, minor_thresholds=(1.0, 0.4)))
        largest = np.max(y, where=np.isfinite(y), initial=0.0)
        if np.any((y > TINY) & (y < DECADES * largest)):  # for instance a step with nearly zero error
            ax.set_ylim(bottom=DECADES * largest)
    elif constant := range_of(y, panel.level):
        ax.set_ylim(*constant)
    elif panel.stepped and np.array_equal(y, np.round(y)):
        ax.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=6))
    if panel.decades:
        ax.set_xscale("log")
        ax.xaxis.set_major_formatter(PlainPowers())
        ax.xaxis.set_minor_formatter(NullFormatter())
    if panel.over_time:
        times = _all(panel, "x") / x_factor
        if np.ptp(times) > 0.0:
            ax.set_xlim(times.min(), times.max())
    elif not panel.decades:
        ax.locator_params(axis="x", nbins=MOST_NUMBERS)


def _note(ax, panel, factor, unit):
    text = panel.note
    if panel.peak:
        value, time = panel.peak
        times = "·" if unit.startswith("10") else " "  # a power of ten before the unit
        extreme = f"{'max' if value >= 0 else 'min'} {value / factor:.4g}{times}{unit}".rstrip()
        text = f"{extreme} at {time:.4g} {panel.curves[0].x.unit}".rstrip()
    if text:
        note_below(ax, text)


def room_above(panel: "Panel", styles: "CurveStyles") -> float:
    """Return the height of the legend of a panel [inch]."""
    handles = styles.legend(panel)
    return LINE_OF_TEXT / 72 * -(-len(handles) // legend_columns(handles, WIDTH)) if handles else 0.0
