"""A panel of curves drawn into axes of matplotlib."""

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from mecano.post.style import (
    COLOURS,
    DASHES,
    GREY,
    INK,
    LINE_OF_TEXT,
    PALE,
    legend_above,
    legend_columns,
    note_below,
    range_of,
    shown_unit,
    with_unit,
)

EVENT_ROOM = 0.06  # of the width of the axes: labels of events are not closer to one another
LINE_ROOM = 0.01  # the same of their lines
MOST_LINES, RUG, RUG_ROOM = 24, 0.04, 0.003  # events from which on they are short lines at the axis: height, room
TILT, LABEL_RISE = 30, 0.028  # of such a label: degrees, inches for each letter
MOST_NAMED = 8  # events
LATE = 0.6  # of the axis: names of events that are mostly later stand to the left of their lines
MISSED = 1e-3  # of the largest value shown: a peak that is larger by that is marked
TINY = 1e-300
DECADES = 1e-12  # of the largest value: logarithmic axes show no less
REFERENCE = {"linestyle": "-", "linewidth": 3.5, "alpha": 0.3, "zorder": 1.5}
LINE, WIDER = 1.3, 0.9  # points
MOST_COVERING = 3
ALIKE = 0.01  # of their range
WIDTH = 3.7  # inches, of most axes
MANY = 500  # values from which on steps are drawn finer


class Look:
    """Colours tell runs apart, else elements, else quantities; dashes what is left.

    Elements are told apart in the whole sheet alike, with one legend for all panels, or in each panel by itself.
    """

    def __init__(self, sheet, panel_by_panel=False):
        self.runs = sheet.run_labels
        self._subjects = None if panel_by_panel else sheet.subjects

    def subjects(self, panel):
        """The elements that share colours with those of the panel."""
        return panel.subjects if self._subjects is None or self.runs else self._subjects

    def owners(self, panel):
        """The elements whose events are to be named: those of the sheet, or of a panel by itself."""
        return panel.subjects if self._subjects is None else self._subjects

    def style(self, curve, panel):
        """Options of ``plot`` for a curve."""
        colour, dashes = self._key(curve, panel)
        style = {"color": COLOURS[colour % len(COLOURS)], "linestyle": DASHES[dashes % len(DASHES)]}
        return style | REFERENCE if curve.reference else style

    def _key(self, curve, panel):
        what = panel.whats.index(curve.y.what) if curve.y.what in panel.whats else 0
        subjects = self.subjects(panel)
        subject = subjects.index(curve.subject)
        if self.runs:
            return curve.run, subject * len(panel.whats) + what
        return (subject, what) if len(subjects) > 1 else (what, 0)

    def handles(self):
        """Legend of the whole sheet: runs, or elements when there are several."""
        names = self.runs or self._subjects or ()
        if len(names) < 2:
            return []
        return [Line2D([], [], color=COLOURS[i % len(COLOURS)], label=name) for i, name in enumerate(names)]

    def legend(self, panel):
        """Legend of the panel: what the one of the sheet does not say."""
        several = len(panel.subjects) > 1 and (bool(self.runs) or self._subjects is None)
        named = len(panel.whats) > 1 or any(curve.reference for curve in panel.curves)
        handles = {}
        for curve in panel.curves:
            text = ": ".join([curve.subject] * several + [curve.y.what] * named)
            if text and text not in handles:
                style = self.style(curve, panel)
                if self.handles() and not curve.reference:
                    style["color"] = INK
                handles[text] = Line2D([], [], label=text, **style)
        return list(handles.values())


def draw_panel(ax, panel, look, events, labelled):
    """Draw the curves, their legend, the events; ``labelled``: they are named here."""
    unit = panel.curves[0].y.unit
    x_factor, x_unit = shown_unit(panel.curves[0].x.unit, _all(panel, "x"))
    y_factor, y_unit = (1.0, unit) if panel.logarithmic else shown_unit(unit, _all(panel, "y"))
    for i, curve in enumerate(panel.curves):
        y = curve.y.values / y_factor
        if panel.logarithmic:
            y = np.where(y > TINY, y, np.nan)
        style = look.style(curve, panel) | _steps(panel, y)
        if style["linestyle"] == "-":
            style.setdefault("linewidth", _width(curve, panel.curves[i + 1 :]))
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
        _draw_events(ax, marks, x_factor, look)
        if labelled:
            _name_events(ax, panel, marks, x_factor, look, taken)


def _all(panel, side):
    return np.concatenate([getattr(curve, side).values for curve in panel.curves])


def _misses_peak(curve):
    """Whether the values shown leave out the largest one of all accepted steps."""
    return bool(curve.peak) and abs(curve.peak[0]) > (1.0 + MISSED) * np.nanmax(np.abs(curve.y.values), initial=0.0)


def _width(curve, later):
    """A line is wider than those that cover it."""
    covering = sum(not other.reference and _alike(curve, other) for other in later)
    return LINE + WIDER * min(covering, MOST_COVERING)


def _alike(curve, other):
    """Whether two curves can hardly be told apart."""
    x, y = curve.x.values, curve.y.values
    if len(x) != len(other.x.values) or not np.array_equal(x, other.x.values):
        return False
    return np.abs(y - other.y.values).max() < ALIKE * max(np.ptp(y), np.ptp(other.y.values), TINY)


def _steps(panel, values):
    if not panel.stepped:
        return {}
    return {"drawstyle": "steps-pre", "linewidth": 0.6 if len(values) > MANY else 1.2}


def _scales(ax, panel, x_factor, y_factor):
    y = _all(panel, "y") / y_factor
    if panel.logarithmic:
        ax.set_yscale("log")
        largest = np.max(y, where=np.isfinite(y), initial=0.0)
        if np.any((y > TINY) & (y < DECADES * largest)):  # a step without any error, for example
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
        extreme = f"{'max' if value >= 0 else 'min'} {value / factor:.4g} {unit}"
        text = f"{extreme} at {time:.4g} {panel.curves[0].x.unit}".rstrip()
    if text:
        note_below(ax, text)


def _marks(panel, events, look):
    """Events of the elements of the panel; of all where they have none."""
    return [mark for mark in events if mark.element in look.owners(panel)] or events


def _draw_events(ax, marks, factor, look):
    """Thin lines at the times over ``factor``; of many, some of those that are close, so that they stay lines.

    Of very many only short ones at the axis, which would otherwise grey the panel.
    """
    low, high = ax.get_xlim()
    for run in dict.fromkeys(mark.run for mark in marks):
        own = [mark for mark in marks if mark.run == run and low <= mark.time / factor <= high]
        lines = _thinned(own, LINE_ROOM * (high - low) * factor if len(own) > MOST_NAMED else 0.0)
        rug = len(lines) > MOST_LINES
        if rug:
            lines = _thinned(own, RUG_ROOM * (high - low) * factor)
        colour = COLOURS[run % len(COLOURS)] if look.runs else GREY if rug else PALE
        for mark, _ in lines:
            ax.axvline(mark.time / factor, ymax=RUG if rug else 1.0, color=colour, linewidth=0.7,
                       alpha=0.4 if look.runs else 1.0, zorder=1)  # fmt: skip


def room_above(panel, events, look, labelled):
    """Inches that the legend of a panel takes, and the names of its events if it is ``labelled`` with them."""
    handles = look.legend(panel)
    room = LINE_OF_TEXT / 72 * -(-len(handles) // legend_columns(handles, WIDTH)) if handles else 0.0
    if labelled and panel.over_time:
        names = [name for _, name in _names(_marks(panel, events, look), *_span(panel))]
        room += LABEL_RISE * max(map(len, names), default=0)
    return room


def _span(panel):
    """First and last time [s] of a panel."""
    times = _all(panel, "x")
    return times.min(), times.max()


def _names(marks, low, high):
    """(mark, name) of the events between two times, as far as there is room; "+ 2" stands for two more close behind.

    The element is named where several meet the same. Of many events only lines are drawn: names of some would not
    tell which ones.
    """
    shown = [mark for mark in marks if low <= mark.time <= high]
    if len(shown) > MOST_NAMED:
        return []
    met = {text: len({mark.element for mark in shown if mark.text == text}) for text in {mark.text for mark in shown}}
    names = []
    for mark, behind in _thinned(shown, EVENT_ROOM * (high - low)):
        name = f"{mark.element}: {mark.text}" if met[mark.text] > 1 else mark.text
        names.append((mark, f"{name} + {behind}" if behind else name))
    return names


def _name_events(ax, panel, marks, factor, look, height):
    """Names of events so many points above the axes, tilted away from where there is less room."""
    low, high = _span(panel)
    names = _names(marks, low, high)
    late = np.mean([mark.time for mark, _ in names] or [low]) > low + LATE * (high - low)
    for mark, name in names:
        ax.annotate(
            name, (mark.time / factor, 1.0), xycoords=ax.get_xaxis_transform(), xytext=(0, 3 + height),
            textcoords="offset points", rotation=-TILT if late else TILT, rotation_mode="anchor", fontsize=7,
            ha="right" if late else "left", color=COLOURS[mark.run % len(COLOURS)] if look.runs else GREY,
        )  # fmt: skip


def _thinned(marks, room):
    """Marks that are at least ``room`` [s] apart, each with the number of those left out behind it."""
    kept = []
    for mark in sorted(marks, key=lambda mark: (mark.time, mark.run)):
        if kept and mark.time - kept[-1][0].time < room:
            kept[-1][1] += 1
        else:
            kept.append([mark, 0])
    return kept
