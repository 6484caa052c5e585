"""Requested plots ``--plot Y[,Y2]:X`` of a study: columns of its table over one another, a dot for each case."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib
import numpy as np

from mecano.deck.wording import suggestion
from mecano.errors import UnknownNameError, UsageError
from mecano.post.figure import plain_figure
from mecano.post.request import Request
from mecano.post.study_outputs import displayed_outputs, study_unit
from mecano.post.study_plots import PANEL, panel, short_names, varied
from mecano.post.style import SETTINGS, with_unit
from mecano.results.study_file import Column, StudyTable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDE = 5.0  # inches


def requested_figures(table: StudyTable, plots: Iterable[str]) -> "Iterator[tuple[str, Figure]]":
    """Yield (end of the name of the file, figure) of each of the ``plots`` "Y[,Y2]:X" of the table of a study.

    Raises UsageError for a plot without X, UnknownNameError for a name that is not a column.
    """
    for text in plots:
        request = Request.parse(text)
        if request.x == "time":
            raise UsageError(f"--plot '{text}': the cases of a study have no time; write Y:X, columns of its table")
        yield request.name, _figure(table, request)


def _figure(table, request):
    """Return the figure: a panel for each Y, coloured and joined by the varied value that distinguishes best."""
    x, ys = column_of(table, request.x), [column_of(table, name) for name in request.ys]
    factor, unit = study_unit(x.unit, x.values) if x.numeric else (1.0, "")
    scaled = replace(x, values=x.values / factor) if x.numeric else x
    other, alone = _series(table, x), [one.name for one in varied(table)] == [x.name]
    heading = f"{', '.join(request.ys)} over {request.x}; {table.verdict}"
    with matplotlib.rc_context(SETTINGS):
        figure = plain_figure(WIDE, len(ys) * PANEL[1] + 0.6, table.title or Path(table.deck).stem, heading)
        grid = figure.subplots(len(ys), 1, squeeze=False, sharex=True)[:, 0]
        for i, (ax, y) in enumerate(zip(grid, ys, strict=True)):
            title = with_unit(short_names([other.name])[other.name], other.unit) if other is not None and not i else ""
            panel(ax, y, scaled, other, alone or other is not None, title)
            ax.set_ylabel(with_unit(y.name.replace("_", " "), study_unit(y.unit, y.values)[1]))
        grid[-1].set_xlabel(with_unit(x.name.removeprefix("parameters.").replace("_", " "), unit))
    return figure


def column_of(table: StudyTable, name: str) -> Column:
    """Return the output, or the varied value by any ending of its path. Raises UnknownNameError, UsageError."""
    columns = [*displayed_outputs(table), *table.group("parameters")]
    found = [column for column in columns if column.name == name]
    found = found or [column for column in columns if column.name.endswith(f".{name}")]
    if not found:
        known = [column.name.removeprefix("parameters.") for column in columns]
        raise UnknownNameError(f"the study has no output or varied value '{name}'; {suggestion(name, known)}")
    if len(found) > 1:
        raise UsageError(f"'{name}' may be {' or '.join(column.name for column in found)}: write more of the path")
    if not found[0].numeric:
        raise UsageError(f"'{name}' is not a number in all cases")
    if not np.isfinite(found[0].values).any():
        raise UsageError(f"'{name}' has no value in any case")
    return found[0]


def _series(table, x):
    """Return the varied parameter with the fewest values, each of which gives a series of dots; None without one."""
    others = [one for one in varied(table) if one.name != x.name]
    cases = len(x.values)
    fewest = min(others, key=lambda one: len(set(one.values)), default=None)
    return fewest if fewest is not None and len(set(fewest.values)) < cases else None
