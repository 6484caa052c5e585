"""Picture of a study: a bar for each named case, or each output over each varied parameter, a dot for each case."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
import numpy as np

from mecano.post.figure import plain_figure
from mecano.post.study_bars import bar_figure
from mecano.post.study_outputs import displayed_outputs, near_limits
from mecano.post.style import COLOURS, DASHES, GREY, LIMIT, SETTINGS, shown_unit, with_unit
from mecano.post.value_labels import legible
from mecano.results.study_file import Column, StudyTable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANEL = (3.4, 2.4)  # inches
MOST_COLOURS = 8  # values of another parameter distinguished by colours
MOST_TICKS = 5  # intervals between the numbers below a panel
BESIDE_ONE_ANOTHER = 36  # characters of texts below a panel; more of them are turned
IN_A_ROW = 56  # characters of a row of a legend
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
    size = len(parameters) * PANEL[0], len(outputs) * PANEL[1]
    figure = plain_figure(max(size[0], 5.0), size[1], table.title or Path(table.deck).stem, table.verdict)
    grid = figure.subplots(len(outputs), len(parameters), squeeze=False, sharex="col", sharey="row")
    shown = short_names([parameter.name for parameter in parameters])
    for i, output in enumerate(outputs):
        for j, parameter in enumerate(parameters):
            other = parameters[(j + 1) % len(parameters)] if len(parameters) > 1 else None
            title = with_unit(shown[other.name], other.unit) if other is not None and i == 0 else ""
            panel(grid[i, j], output, parameter, other, len(parameters) <= MOST_JOINED, title)
            if i == len(outputs) - 1:
                grid[i, j].set_xlabel(with_unit(shown[parameter.name], parameter.unit))
                if parameter.numeric:
                    grid[i, j].locator_params(axis="x", nbins=MOST_TICKS)
                elif sum(map(len, set(parameter.values))) > BESIDE_ONE_ANOTHER:
                    for label in grid[i, j].get_xticklabels():
                        label.set(rotation=20, ha="right", rotation_mode="anchor", fontsize=7)
        if not output.unit:  # a count
            grid[i, 0].locator_params(axis="y", integer=True, min_n_ticks=1)
        _, unit = shown_unit(output.unit, output.values)
        grid[i, 0].set_ylabel(with_unit(output.name.replace("_", " "), unit))
    return figure


def panel(ax: "Axes", output: Column, parameter: Column, other: Column | None, joined: bool, title: str) -> None:
    """Plot dots over the values of a ``parameter``; ``title`` of a legend, or "".

    They are coloured by the values of the ``other`` parameter if these are few; dots with the same value may be
    ``joined``.
    """
    factor, _ = shown_unit(output.unit, output.values)
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
    for limit in near_limits(output):
        ax.axhline(limit / factor, color=LIMIT, linewidth=0.8, linestyle=DASHES[1])
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
