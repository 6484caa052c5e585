"""Events in panels over time: a line at each, a mark over the axes, a legend of the marks."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D

from mecano.post.event_marks import OTHERS, EventMark
from mecano.post.sheet import Panel, Sheet
from mecano.post.style import COLOURS, GREY, PALE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from mecano.post.curve_styles import CurveStyles

MARK_ROOM = 0.012  # of the width of the axes: marks of one kind are not closer to one another
LINE_ROOM = 0.01  # the same of lines
MANY = 8  # number of events above which lines close to others are omitted
MOST_LINES, RUG, RUG_ROOM = 24, 0.04, 0.003  # events above which lines are short ones at the axis; height, room
MOST_MARKS = 12  # of one kind: more would make a band over the axes, so only the first is drawn
SIZE = 4.5  # points


class EventLegend:
    """The events that the panels of a sheet show, and what their marks mean."""

    def __init__(self, sheet: Sheet, styles: "CurveStyles"):
        self._styles = styles
        panels = [panel for panel in sheet.panels if isinstance(panel, Panel) and panel.over_time]
        marks = [mark for panel in panels for mark in self.of(panel, sheet.events)]
        self._markers = {mark.key: mark.marker for mark in sorted(marks, key=lambda mark: mark.time)}

    def of(self, panel: Panel, events: Sequence[EventMark]) -> list[EventMark]:
        """Return the events within the time of a panel: those of its elements, or of all if these have none."""
        times = np.concatenate([curve.x.values for curve in panel.curves])
        own = [mark for mark in events if mark.element in self._styles.owners(panel)] or events
        return [mark for mark in own if times.min() <= mark.time <= times.max()]

    def handles(self) -> list[Line2D]:
        """Return the entries of the legend."""
        handles = [_handle(marker, key) for key, marker in self._markers.items() if marker != OTHERS]
        n_others = len(self._markers) - len(handles)
        return handles + [_handle(OTHERS, f"{n_others} other events")] * (n_others > 0)


def draw_events(ax: "Axes", marks: Iterable[EventMark], factor: float, styles: "CurveStyles") -> None:
    """Draw lines and marks at the times over ``factor``; short lines at the axis for many events or several runs.

    An event that occurs throughout, such as a stop in a limit cycle, is marked once, where there is room for it first.
    """
    low, high = ax.get_xlim()
    for run in dict.fromkeys(mark.run for mark in marks):
        own = [mark for mark in marks if mark.run == run and low <= mark.time / factor <= high]
        lines = thinned(own, LINE_ROOM * (high - low) * factor if len(own) > MANY else 0.0)
        rug = bool(styles.runs) or len(lines) > MOST_LINES
        if rug:
            lines = thinned(own, RUG_ROOM * (high - low) * factor)
        counts = Counter(mark.marker for mark in own)
        colour = COLOURS[run % len(COLOURS)] if styles.runs else GREY
        for mark in lines:
            ax.axvline(mark.time / factor, ymax=RUG if rug else 1.0, color=colour if rug else PALE, linewidth=0.7,
                       alpha=0.4 if styles.runs else 1.0, zorder=1)  # fmt: skip
        room = MARK_ROOM * (high - low)
        drawn: list[float] = []
        for marker in sorted(counts, key=counts.__getitem__):  # frequent events leave room for the marks of rare ones
            alike = [mark for mark in own if mark.marker == marker]
            times = [mark.time / factor for mark in thinned(alike, room * factor)]
            if len(times) > MOST_MARKS:
                times = [*(t for t in times if all(abs(t - other) >= room for other in drawn)), times[0]][:1]
            drawn += times
            ax.plot(times, [1.0] * len(times), marker, transform=ax.get_xaxis_transform(), color=colour,
                    markersize=SIZE, markeredgewidth=0.5, clip_on=False, zorder=5)  # fmt: skip


def thinned(marks: Iterable[EventMark], room: float) -> list[EventMark]:
    """Return marks that are at least ``room`` [s] apart, the first of those that are closer."""
    kept: list[EventMark] = []
    for mark in sorted(marks, key=lambda mark: (mark.time, mark.run)):
        if not kept or mark.time - kept[-1].time >= room:
            kept.append(mark)
    return kept


def _handle(marker, name):
    return Line2D([], [], marker=marker, linestyle="", color=GREY, markersize=SIZE, markeredgewidth=0.5, label=name)
