"""Picture of a study: a bar for each named case, or each output over each varied parameter, a dot for each case."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
import numpy as np

from mecano.post.figure import plain_figure
from mecano.post.page_layout import columns_of, height_of_row, rows_of
from mecano.post.study_bars import bar_figure
from mecano.post.study_outputs import displayed_outputs, heading_of, near_limits, study_unit
from mecano.post.style import COLOURS, DASHES, GREY, SETTINGS, mark_limits, range_of, with_unit
from mecano.post.value_labels import legible
from mecano.results.study_file import Column, StudyTable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL = (3.4, 2.4)  # inches
LOWEST, NARROWEST = 1.3, 5.0  # inches of a panel if there are many, and of the picture
MOST_COLOURS = 8  # values of another parameter distinguished by colours
MOST_TICKS = 5  # intervals between the numbers below a panel
BESIDE_ONE_ANOTHER = 36  # characters of texts below a panel; more of them are turned
IN_A_ROW = 56  # characters of a row of a legend
SERIES, ALIKE = 1.5, 1.3  # least ratio of neighbours in a geometric series; largest over least ratio: 1, 2, 5, 10
MOST_JOINED = 2  # number of parameters up to which dots that differ in one of them are joined by lines


def study_figure(table: StudyTable) -> "Figure | None":
    """Return the figure of a StudyTable: bars if its cases have names, else dots over each parameter; None if empty."""
    outputs = [column for column in displayed_outputs(table) if np.any(np.isfinite(column.values))]
    parameters = [legible(column) for column in varied(table)]
    names = table.case_names if table.named else ()
    if not outputs or not (parameters or names):
        return None
    with matplotlib.rc_context(SETTINGS):
        return bar_figure(table, outputs, names) if names else _figure(table, parameters, outputs)


def varied(table: StudyTable) -> list[Column]:
    """Return the columns of the values that differ between cases."""
    return [column for column in table.group("parameters") if len(set(column.values)) > 1]


def _figure(table, parameters, outputs):
    """Return the figure: for each output a row of panels, one for each parameter; several such rows side by side."""
    across = len(parameters)
    blocks = columns_of(len(outputs), across * PANEL[0], PANEL[1])
    rows, width = rows_of(len(outputs), blocks), blocks * across * PANEL[0]
    height = rows * height_of_row(rows, width, LOWEST, PANEL[1])
    heading = heading_of(table, outputs)
    figure = plain_figure(max(width, NARROWEST), height, table.title or Path(table.deck).stem, heading)
    grid = figure.add_gridspec(rows, blocks * across)
    shown = short_names([parameter.name for parameter in parameters])
    above: list[Axes | None] = [None] * across  # the panels of the first output
    for i, output in enumerate(outputs):
        row, first = i // blocks, i % blocks * across
        beside = None
        for j, parameter in enumerate(parameters):
            ax = beside = figure.add_subplot(grid[row, first + j], sharex=above[j], sharey=beside)
            above[j] = above[j] or ax
            other = parameters[(j + 1) % across] if across > 1 else None
            title = with_unit(shown[other.name], other.unit) if other is not None and i == 0 else ""
            panel(ax, output, parameter, other, across <= MOST_JOINED, title)
            _label_below(ax, parameter, shown[parameter.name] if i + blocks >= len(outputs) else "")
            _label_beside(ax, output if j == 0 else None)
    return figure


def _label_below(ax, parameter, name):
    """Label the horizontal axis of a panel by the ``name`` of its parameter; "" if a panel below it has the label."""
    ax.xaxis.set_tick_params(labelbottom=bool(name))
    if is_geometric(parameter):
        values = np.unique(parameter.values)
        ax.set_xscale("log")
        ax.set_xticks(values, [f"{value:.5g}" for value in values])
        ax.minorticks_off()
    elif parameter.numeric:
        ax.locator_params(axis="x", nbins=MOST_TICKS)
    elif sum(map(len, set(parameter.values))) > BESIDE_ONE_ANOTHER:
        for label in ax.get_xticklabels():
            label.set(rotation=20, ha="right", rotation_mode="anchor", fontsize=7)
    if name:
        ax.set_xlabel(with_unit(name, parameter.unit))


def is_geometric(parameter: Column) -> bool:
    """Return whether the values form a geometric series, such as the steps or meshes of a study of convergence."""
    if not parameter.numeric or min(values := np.unique(parameter.values)) <= 0.0 or len(values) < 3:
        return False
    ratios = values[1:] / values[:-1]
    return bool(SERIES <= ratios.min() and len(values) <= MOST_COLOURS and ratios.max() <= ALIKE * ratios.min())


def _label_beside(ax, output):
    """Label the vertical axis of a panel by its output; None if the panel to the left has the label."""
    ax.yaxis.set_tick_params(labelleft=output is not None)
    if output is None:
        return
    if not output.unit:  # a count
        ax.locator_params(axis="y", integer=True, min_n_ticks=1)
    _, unit = study_unit(output.unit, output.values)
    ax.set_ylabel(with_unit(output.name.replace("_", " "), unit))


def panel(ax: "Axes", output: Column, parameter: Column, other: Column | None, joined: bool, title: str) -> None:
    """Plot dots over the values of a ``parameter``; ``title`` of a legend, or "".

    They are coloured by the values of the ``other`` parameter if these are few; dots with the same value may be
    ``joined``.
    """
    factor, _ = study_unit(output.unit, output.values)
    joined = joined and (other is None or len(set(other.values)) <= MOST_COLOURS)
    groups = _groups(other, len(output.values))
    for number, (label, group) in enumerate(groups):
        known = np.flatnonzero(group & np.isfinite(output.values))
        if not len(known):
            continue
        known = known[np.argsort(parameter.values[known], kind="stable")]
        ax.plot(parameter.values[known], output.values[known] / factor, marker="o", markersize=3.5,
                linestyle=DASHES[0] if joined else "none", linewidth=0.8, color=COLOURS[number], alpha=0.8,
                label=label)  # fmt: skip
    limits = near_limits(output, factor)
    if constant := range_of(np.array([*output.values / factor, *(limit for limit, _ in limits)])):
        ax.set_ylim(*constant)
    mark_limits(ax, limits, "y")
    if len(groups) > 1 and title:
        columns = max(1, min(4, IN_A_ROW // max(len(label) + 4 for label, _ in groups)))
        ax.legend(title=title, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, fontsize=7, title_fontsize=7,
                  handlelength=0.8, columnspacing=0.8, borderaxespad=0.2, alignment="left",
                  labelcolor=GREY)  # fmt: skip


def _groups(other, cases):
    """Return [(label, flags (cases,))] of the values of a parameter if they are few, otherwise one without a label."""
    values = sorted(set(other.values)) if other is not None else []
    if not 1 < len(values) <= MOST_COLOURS:
        return [(None, np.ones(cases, bool))]
    return [(f"{value:.5g}" if other.numeric else str(value), other.values == value) for value in values]


def short_names(paths: Sequence[str]) -> dict[str, str]:
    """Return {path: its last two keys, without 'parameters', or as many as distinguish it from other ``paths``}."""
    keys = {path: path.removeprefix("parameters.").split(".") for path in paths}
    lengths = dict.fromkeys(paths, 2)
    for path in paths:
        while any(keys[path][-lengths[path] :] == keys[o][-lengths[path] :] for o in paths if o != path):
            lengths[path] += 1
    return {path: ".".join(keys[path][-lengths[path] :]) for path in paths}
