"""Bar charts of a study with named cases: a panel for each output, a bar for each case, the largest in full colour."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mecano.post.figure import plain_figure
from mecano.post.study_outputs import near_limits
from mecano.post.style import COLOURS, DASHES, GREY, LIMIT, shown_unit, with_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mecano.results.study_file import Column, StudyTable

COLUMNS = 2
WIDTH, ROW = 5.6, 0.19  # inches of a panel, and of a bar
OVER_LIMITS = {"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"}  # of the numbers at bars
BESIDE = 0.9  # inches of a panel, apart from its bars
PALE = 0.45


def bar_figure(table: "StudyTable", outputs: "Sequence[Column]", names: Sequence[str]) -> "Figure":
    """Return the figure of the ``outputs``, Columns of a StudyTable, of cases with these ``names``."""
    rows = -(-len(outputs) // COLUMNS)
    height = rows * (ROW * len(names) + BESIDE)
    figure = plain_figure(COLUMNS * WIDTH, height, table.title or Path(table.deck).stem, table.verdict)
    grid = figure.subplots(rows, COLUMNS, squeeze=False, sharey=True)
    for ax, output in zip(grid.flat, outputs, strict=False):
        _panel(ax, output)
    for ax in grid.flat[len(outputs) :]:
        ax.set_visible(False)
    grid[0, 0].set_yticks(range(len(names)), [name[:40] for name in names], fontsize=7)
    grid[0, 0].invert_yaxis()
    return figure


def _panel(ax, output):
    factor, unit = shown_unit(output.unit, output.values)
    values = output.values / factor
    governing = int(np.nanargmax(np.abs(values)))
    bars = ax.barh(range(len(values)), np.nan_to_num(values), height=0.7, color=COLOURS[0], alpha=PALE)
    bars[governing].set_alpha(1.0)
    ax.bar_label(bars, [f"{value:.4g}" if np.isfinite(value) else "" for value in values], padding=3, fontsize=7,
                 color=GREY, bbox=OVER_LIMITS)  # fmt: skip
    ax.margins(x=0.18)
    ax.axvline(0.0, color=GREY, linewidth=0.8)
    for limit in near_limits(output):
        ax.axvline(limit / factor, color=LIMIT, linewidth=0.8, linestyle=DASHES[1])
    ax.set_xlabel(with_unit(output.name.replace("_", " "), unit))
