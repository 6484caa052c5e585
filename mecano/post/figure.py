"""Figures of sheets by matplotlib, without a display."""

import math
from pathlib import Path
from typing import IO, TYPE_CHECKING

import matplotlib
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from mecano.errors import ResultsError
from mecano.post.curve_styles import CurveStyles
from mecano.post.draw_events import EventLegend
from mecano.post.draw_panel import draw_panel, room_above
from mecano.post.draw_sketch import draw_sketch
from mecano.post.sheet import Panel, Sheet
from mecano.post.style import GREY, LEGEND, LINE_OF_TEXT, SETTINGS, legend_columns

if TYPE_CHECKING:
    pass

PANEL = (4.6, 2.35)  # inches
SKETCH_WIDTH, LOWEST, HIGHEST = 9.5, 2.0, 7.0
ROOM = 0.8  # for the headings
PAD = 0.08
COLUMNS = 3  # of the overview
MOST_COLUMNS = 6  # of the legend
SMALLEST = 8  # points
CUT = " ..."
METADATA = {"png": {"Software": "mecano"}, "svg": {"Creator": "mecano", "Date": None}}


def sheet_figure(sheet: Sheet, title: str) -> Figure:
    """Return the figure of a sheet: its panels in columns, or its sketches one below the other."""
    if not isinstance(sheet.panels[0], Panel):
        return _sketches(sheet, title)
    columns = 1 if len(sheet.panels) < 2 else 2
    rows = math.ceil(len(sheet.panels) / columns)
    width, height = (6.4, 3.6) if len(sheet.panels) == 1 else PANEL
    styles, cells = CurveStyles(sheet), [(i // columns, i % columns) for i in range(len(sheet.panels))]
    with matplotlib.rc_context(SETTINGS):
        room = _room(sheet, styles, cells, columns * width)
        figure = plain_figure(columns * width, rows * height + room, title, sheet.heading)
        grid = figure.add_gridspec(rows, columns)
        _fill(figure, sheet, [grid[cell] for cell in cells], styles)
    return figure


def overview_figure(sheet: Sheet, title: str, facts: str) -> Figure:
    """Return the figure of an overview: panels around the sketch in a corner, or below it if it is wide."""
    first = sheet.panels[0]
    sketched = not isinstance(first, Panel)
    wide = not isinstance(first, Panel) and first.wide
    cells = [(r, c) for r in range(len(sheet.panels)) for c in range(COLUMNS)]
    taken = [(0, c) for c in range(COLUMNS if wide else sketched)]
    free = [cell for cell in cells if cell not in taken][: len(sheet.panels) - sketched]
    rows = 1 + max(r for r, _ in [*taken, *free])
    styles, width = CurveStyles(sheet, panel_by_panel=True), COLUMNS * PANEL[0]
    with matplotlib.rc_context(SETTINGS):
        room = _room(sheet, styles, [(0, 0)] * sketched + free, width)
        figure = plain_figure(width, rows * PANEL[1] + room, title, facts)
        grid = figure.add_gridspec(rows, COLUMNS)
        places = ([grid[0, :] if wide else grid[0, 0]] if sketched else []) + [grid[cell] for cell in free]
        _fill(figure, sheet, places, styles)
    return figure


def save(figure: Figure, target: Path | IO[bytes], kind: str = "") -> None:
    """Write a figure to a path, whose extension is the default of ``kind``, or to a stream; it can be saved only once.

    The same figure gives the same bytes. Raises ResultsError if the path cannot be written.
    """
    kind = kind or (target.suffix[1:] if isinstance(target, Path) else "")
    with matplotlib.rc_context(SETTINGS):
        if engine := figure.get_layout_engine():
            engine.execute(figure)
    with matplotlib.rc_context(SETTINGS | {"figure.constrained_layout.use": False}):
        figure.set_layout_engine()  # none: savefig would draw everything again to compute the layout
        try:
            figure.savefig(target, format=kind, metadata=METADATA[kind])
        except OSError as error:
            raise ResultsError(f"cannot write {target}: {error.strerror}") from error


def _room(sheet, styles, cells, width):
    """Return the heights [inch] of the legends above each row of panels, and of the common legend below."""
    rows: dict[int, float] = {}
    for (row, _), panel in zip(cells, sheet.panels, strict=True):
        if isinstance(panel, Panel):
            rows[row] = max(rows.get(row, 0.0), room_above(panel, styles))
    return sum(rows.values()) + LINE_OF_TEXT / 72 * sum(_lines(some, width) for some in _legends(sheet, styles))


def _legends(sheet, styles):
    """Return the lists of entries of the common legends: of curves, and of events."""
    return [handles for handles in (styles.handles(), EventLegend(sheet, styles).handles()) if handles]


def _lines(handles, width):
    return -(-len(handles) // min(legend_columns(handles, width), MOST_COLUMNS))


def _sketches(sheet, title):
    heights = [min(max(SKETCH_WIDTH * sketch.aspect, LOWEST), HIGHEST) for sketch in sheet.panels]
    with matplotlib.rc_context(SETTINGS):
        figure = plain_figure(SKETCH_WIDTH, sum(heights), title, sheet.heading)
        grid = figure.add_gridspec(len(heights), 1, height_ratios=heights)
        for i, sketch in enumerate(sheet.panels):
            draw_sketch(figure.add_subplot(grid[i]), sketch, sketch.label if sheet.run_labels else "")
    return figure


def plain_figure(width: float, height: float, title: str, heading: str) -> Figure:
    """Return an empty figure with a bold title and a heading below it."""
    layout = ConstrainedLayoutEngine(w_pad=PAD, h_pad=PAD, wspace=0.03, hspace=0.03)
    figure = Figure(figsize=(width, height + ROOM), layout=layout)
    head = figure.suptitle(f"{title}\n", x=0.01, ha="left", fontsize=12, fontweight="bold")
    top = 1.0 - (PAD + 0.25) / (height + ROOM)
    below = figure.text(0.01, top, heading, ha="left", va="top", color=GREY)
    for text in (head, below):
        _fit(text, 0.98 * width)
    return figure


def _fit(text, inches):
    """Reduce the size of a line of text, and truncate it at the smallest size, to fit a width in inches."""
    share = inches * text.figure.dpi / max(text.get_window_extent().width, 1.0)
    size = text.get_fontsize()
    if share < 1.0:
        text.set_fontsize(max(share * size, SMALLEST))
    if share * size < SMALLEST:
        line, *below = text.get_text().split("\n")
        kept = int(0.97 * len(line) * share * size / SMALLEST) - len(CUT)
        text.set_text("\n".join([line[:kept].rstrip() + CUT, *below]))


def _fill(figure, sheet, places, styles):
    """Draw the panels, and the legends below them all."""
    legend = EventLegend(sheet, styles)
    for place, panel in zip(places, sheet.panels, strict=True):
        ax = figure.add_subplot(place)
        if isinstance(panel, Panel):
            draw_panel(ax, panel, styles, sheet.events, legend)
        else:
            draw_sketch(ax, panel, panel.label if sheet.run_labels else "")
    handles = [handle for some in _legends(sheet, styles) for handle in some]
    if handles:
        columns = min(legend_columns(handles, figure.get_figwidth()), MOST_COLUMNS)
        figure.legend(handles=handles, loc="outside lower center", ncols=columns, **LEGEND)
