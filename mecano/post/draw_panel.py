"""Drawing of a panel of curves into axes of matplotlib."""

import re

import numpy as np
from matplotlib.ticker import LogFormatterSciNotation, MaxNLocator

from mecano.post.style import (
    COLOURS,
    GREY,
    LINE_OF_TEXT,
    PALE,
    legend_above,
    legend_columns,
    note_below,
    power_of_ten,
    range_of,
    shown_unit,
    with_unit,
)

EVENT_ROOM = 0.06  # least distance of labels of events, over the width of the axes
LINE_ROOM = 0.01  # least distance of lines of events, likewise
MOST_LINES, RUG, RUG_ROOM = 24, 0.04, 0.003  # with more events, short lines at the axis: height, least distance
TILT, LABEL_RISE = 30, 0.028  # of labels of events: degrees, height per letter in inches
MOST_NAMED = 8  # events
LATE = 0.6  # of the axis: if events are later on average, their names are left of the lines
MISSED = 1e-3  # of the largest value shown: a peak that exceeds it by more is marked
TINY = 1e-300
DECADES = 1e-12  # of the largest value: lower limit of logarithmic axes
LINE, WIDER = 1.3, 0.9  # points
MOST_COVERING = 3
ALIKE = 0.01  # of the span of the axes: curves that differ by less cover each other
WIDTH = 3.7  # inches, of most axes
MANY = 500  # with more values, steps are drawn with thinner lines


def draw_panel(ax, panel, look, events, labelled):
    """Draw the curves of a panel, their legend and the events; ``labelled``: with names of the events."""
    unit = panel.curves[0].y.unit
    x_factor, x_unit = shown_unit(panel.curves[0].x.unit, _all(panel, "x"))
    y_factor, y_unit = (1.0, unit) if panel.logarithmic else shown_unit(unit, _all(panel, "y"))
    spans = _spans(panel)
    for i, curve in enumerate(panel.curves):
        y = curve.y.values / y_factor
        if panel.logarithmic:
            y = np.where(y > TINY, y, np.nan)
        style = look.style(curve, panel) | _steps(panel, y)
        if style["linestyle"] == "-":
            style.setdefault("linewidth", _width(curve, panel.curves[i + 1 :], spans))
        ax.plot(curve.x.values / x_factor, y, **style)
        if _misses_peak(curve) and not panel.logarithmic:
            value, time = curve.peak
            ax.plot(time / x_factor, value / y_factor, "o", color=style["color"], markersize=3.5, zorder=3)
    _scales(ax, panel, x_factor, y_factor)
    ax.set_ylabel(with_unit(panel.label, y_unit))
    ax.set_xlabel(with_unit(panel.curves[0].x.what, x_unit))
    taken = legend_above(ax, look.legend(panel), WIDTH)
    _note(ax, panel, y_factor, y_unit)
    if panel.over_time:
        marks = _marks(panel, events, look)
        names = _names(marks, *_span(panel)) if labelled else []
        _draw_events(ax, marks, x_factor, look, short=bool(look.runs) and not names)
        _name_events(ax, panel, names, x_factor, look, taken)


def _all(panel, side):
    return np.concatenate([getattr(curve, side).values for curve in panel.curves])


def _misses_peak(curve):
    """Return whether the values shown miss the peak over all accepted steps."""
    return bool(curve.peak) and abs(curve.peak[0]) > (1.0 + MISSED) * np.nanmax(np.abs(curve.y.values), initial=0.0)


def _spans(panel):
    """Return the spans of the curves of a panel along both axes, as drawn if they are constant."""
    return [np.ptp(range_of(values) or values[np.isfinite(values)]) for values in (_all(panel, "x"), _all(panel, "y"))]


def _width(curve, later, spans):
    """Return the width of a line [points], wider than the ``later`` lines that cover it."""
    covering = sum(not other.reference and _alike(curve, other, spans) for other in later)
    return LINE + WIDER * min(covering, MOST_COVERING)


def _alike(curve, other, spans):
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
    """Formatter of a logarithmic axis without mathematical markup, as texts of pictures are not parsed."""

    def __call__(self, x, pos=None):
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
    elif constant := range_of(y):
        ax.set_ylim(*constant)
    elif panel.stepped and np.array_equal(y, np.round(y)):
        ax.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=6))
    if panel.over_time:
        times = _all(panel, "x") / x_factor
        if np.ptp(times) > 0.0:
            ax.set_xlim(times.min(), times.max())


def _note(ax, panel, factor, unit):
    text = panel.note
    if panel.peak:
        value, time = panel.peak
        extreme = f"{'max' if value >= 0 else 'min'} {value / factor:.4g} {unit}".rstrip()
        text = f"{extreme} at {time:.4g} {panel.curves[0].x.unit}".rstrip()
    if text:
        note_below(ax, text)


def _marks(panel, events, look):
    """Return the events of the elements of the panel, or all if they have none."""
    return [mark for mark in events if mark.element in look.owners(panel)] or events


def _draw_events(ax, marks, factor, look, short):
    """Draw thin lines at the events, times divided by ``factor``; of many close events, only some.

    Very many events, or ``short`` ones, are marked at the axis only, as lines would cover the panel.
    """
    low, high = ax.get_xlim()
    for run in dict.fromkeys(mark.run for mark in marks):
        own = [mark for mark in marks if mark.run == run and low <= mark.time / factor <= high]
        lines = _thinned(own, LINE_ROOM * (high - low) * factor if len(own) > MOST_NAMED else 0.0)
        rug = short or len(lines) > MOST_LINES
        if rug:
            lines = _thinned(own, RUG_ROOM * (high - low) * factor)
        colour = COLOURS[run % len(COLOURS)] if look.runs else GREY if rug else PALE
        for mark, _ in lines:
            ax.axvline(mark.time / factor, ymax=RUG if rug else 1.0, color=colour, linewidth=0.7,
                       alpha=0.4 if look.runs else 1.0, zorder=1)  # fmt: skip


def room_above(panel, events, look, labelled):
    """Return the height [inches] of the legend of a panel and, if ``labelled``, of the names of its events."""
    handles = look.legend(panel)
    room = LINE_OF_TEXT / 72 * -(-len(handles) // legend_columns(handles, WIDTH)) if handles else 0.0
    if labelled and panel.over_time:
        names = [name for _, name in _names(_marks(panel, events, look), *_span(panel))]
        room += LABEL_RISE * max(map(len, names), default=0)
    return room


def _span(panel):
    """Return the first and last time [s] of a panel."""
    times = _all(panel, "x")
    return times.min(), times.max()


def _names(marks, low, high):
    """Return (mark, name) of the events between two times, at a least distance; [] for more than MOST_NAMED events.

    "+ 2" stands for two other events close behind, not counting the same event of another run. The element is named
    if several have the same event.
    """
    shown = [mark for mark in marks if low <= mark.time <= high]
    if len(shown) > MOST_NAMED:
        return []
    met = {text: len({mark.element for mark in shown if mark.text == text}) for text in {mark.text for mark in shown}}
    names = []
    for mark, others in _thinned(shown, EVENT_ROOM * (high - low)):
        behind = sum(other.run == mark.run or other.text != mark.text for other in others)
        name = f"{mark.element}: {mark.text}" if met[mark.text] > 1 else mark.text
        names.append((mark, f"{name} + {behind}" if behind else name))
    return names


def _name_events(ax, panel, names, factor, look, height):
    """Write names of events ``height`` points above the axes, tilted to the side with more room."""
    low, high = _span(panel)
    late = np.mean([mark.time for mark, _ in names] or [low]) > low + LATE * (high - low)
    for mark, name in names:
        ax.annotate(
            name, (mark.time / factor, 1.0), xycoords=ax.get_xaxis_transform(), xytext=(0, 3 + height),
            textcoords="offset points", rotation=-TILT if late else TILT, rotation_mode="anchor", fontsize=7,
            ha="right" if late else "left", color=COLOURS[mark.run % len(COLOURS)] if look.runs else GREY,
        )  # fmt: skip


def _thinned(marks, room):
    """Return marks at least ``room`` [s] apart, each with the list of marks left out after it."""
    kept = []
    for mark in sorted(marks, key=lambda mark: (mark.time, mark.run)):
        if kept and mark.time - kept[-1][0].time < room:
            kept[-1][1].append(mark)
        else:
            kept.append((mark, []))
    return kept
