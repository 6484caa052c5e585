"""Bar charts of a study with named cases: a panel for each output, a bar for each case, the governing in full colour.

Of many cases, each panel shows those that govern its output, ordered by how much they do.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mecano.post.figure import plain_figure
from mecano.post.page_layout import columns_of, rows_of
from mecano.post.quantity import largest
from mecano.post.study_outputs import heading_of, near_limits, severity, study_unit
from mecano.post.style import COLOURS, GREY, mark_limits, with_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mecano.results.study_file import Column, StudyTable

MOST_BARS = 20  # of a panel; of more cases each panel shows the most severe ones
WIDTH, ROW = 3.6, 0.19  # inches of a panel without the names of the cases, and of a bar
LETTER, LONGEST = 0.062, 40  # inches of a letter of a name, and letters of it
OVER_LIMITS = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}  # of the numbers at bars
BESIDE = 0.9  # inches of a panel, apart from its bars
PALE = 0.45
UNSEEN = 1e-5  # of the largest bar of a panel: a smaller one has the number 0


def bar_figure(table: "StudyTable", outputs: "Sequence[Column]", names: Sequence[str]) -> "Figure":
    """Return the figure of the ``outputs``, Columns of a StudyTable, of cases with these ``names``."""
    short = np.array([name[:LONGEST] for name in names], object)
    some, room = len(names) > MOST_BARS, LETTER * max(map(len, short))  # names beside each panel, or beside the first
    bars = MOST_BARS if some else len(names)
    columns = columns_of(len(outputs), WIDTH + room * some, ROW * bars + BESIDE)
    rows = rows_of(len(outputs), columns)
    width = columns * WIDTH + room * (columns if some else 1)
    heading = heading_of(table, outputs) + f"; in each panel the {bars} most severe" * some
    figure = plain_figure(width, rows * (ROW * bars + BESIDE), table.title or Path(table.deck).stem, heading)
    grid = figure.subplots(rows, columns, squeeze=False)
    for i, (ax, output) in enumerate(zip(grid.flat, outputs, strict=False)):
        shown = _most_severe(output) if some else np.arange(len(names))
        _panel(ax, output, shown)
        labelled = some or i % columns == 0
        ax.set_yticks(range(len(shown)), short[shown] if labelled else [""] * len(shown), fontsize=7)
        ax.set_ylim(bars - 0.5, -0.5)
    for ax in grid.flat[len(outputs) :]:
        ax.set_visible(False)
    return figure


def _most_severe(output):
    """Return the indices of the MOST_BARS cases that govern an output, the first of which governs most."""
    known = np.flatnonzero(np.isfinite(output.values))
    return known[np.argsort(-severity(output)[known], kind="stable")][:MOST_BARS]


def _numbers(values):
    """Return the texts of numbers, which are zero if they are invisible beside the largest."""
    unseen = UNSEEN * largest(values)
    shown = np.where(np.abs(values) > unseen, values, 0.0 * values)
    return [f"{value + 0.0:.4g}" if np.isfinite(value) else "" for value in shown]


def _panel(ax, output, shown):
    factor, unit = study_unit(output.unit, output.values)
    values = output.values[shown] / factor
    bars = ax.barh(range(len(values)), np.nan_to_num(values), height=0.7, color=COLOURS[0], alpha=PALE)
    bars[int(np.nanargmax(severity(output)[shown]))].set_alpha(1.0)
    ax.bar_label(bars, _numbers(values), padding=3, fontsize=7, color=GREY, bbox=OVER_LIMITS)
    ax.margins(x=0.18)
    ax.axvline(0.0, color=GREY, linewidth=0.8)
    mark_limits(ax, near_limits(output, factor), "x")
    ax.set_xlabel(with_unit(output.name.replace("_", " "), unit))
