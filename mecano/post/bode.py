"""Bode diagram of a file of a response: magnitude and phase of its transfer functions over the frequency."""

from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MultipleLocator, NullFormatter

from mecano.post.figure import plain_figure
from mecano.post.style import COLOURS, DASHES, LEGEND, SETTINGS, legend_columns, power_of_ten
from mecano.results.response_file import ResponseFile, ratio_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTHS = 6.8, 4.6, 4.0  # inches, of a panel, by the number of columns
MAGNITUDE, PHASE = 2.3, 1.7  # inches, heights
DECADES = 2e2  # ratio of the frequencies up to which ticks at 2 and 5 of each decade have labels
PLAIN = 1e-3, 1e4  # numbers that are written without a power of ten
LINE = 0.2  # inches of the legend
RANGE = 1e4  # of magnitudes that are shown, below their median
FEW = 20  # frequencies up to which each is marked
ROUND = (30.0, 45.0, 90.0, 180.0, 360.0)  # deg, steps of the axis of the phase


def response_figure(file: ResponseFile) -> "Figure":
    """Return the figure of a ResponseFile: for each unit of transfer functions a panel of magnitudes and of phases."""
    groups = _by_unit(file)
    columns = 2 if len(groups) == 4 else min(len(groups), len(WIDTHS))
    rows, width = -(-len(groups) // columns), WIDTHS[columns - 1]
    with matplotlib.rc_context(SETTINGS):
        handles = _handles(file)
        of_legend = legend_columns(handles, width * columns)
        height = rows * (MAGNITUDE + PHASE) + LINE * -(-len(handles) // of_legend)
        source = f"response to {file.inputs[0]}" if len(file.inputs) == 1 else "response"
        figure = plain_figure(width * columns, height, file.title or file.path.stem, f"{source}; about: {file.about}")
        grid = figure.add_gridspec(2 * rows, columns, height_ratios=[MAGNITUDE, PHASE] * rows)
        for k, (unit, pairs) in enumerate(groups.items()):
            upper = figure.add_subplot(grid[2 * (k // columns), k % columns])
            lower = figure.add_subplot(grid[2 * (k // columns) + 1, k % columns], sharex=upper)
            _magnitudes(upper, file, unit, pairs)
            _phases(lower, file, pairs)
            frequency_axis(upper, lower, file.frequency)
        figure.legend(handles=handles, loc="outside lower center", ncols=of_legend, **LEGEND)
    return figure


def frequency_axis(upper: "Axes", lower: "Axes", frequency: np.ndarray) -> None:
    """Set the common axis of the ``frequency`` (n,) [Hz], ascending, of two panels."""
    upper.set_xscale("log")
    low, high = frequency[0], frequency[-1]
    if low < high:
        upper.set_xlim(low, high)
    lower.set_xlabel("frequency [Hz]")
    lower.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high / low < DECADES else (1.0,)))
    lower.xaxis.set_major_formatter(FuncFormatter(plain_number))
    lower.xaxis.set_minor_formatter(NullFormatter())
    upper.tick_params(labelbottom=False)


def plain_number(x: float, _: object = None) -> str:
    """Return the label of a number on a logarithmic axis."""
    if PLAIN[0] <= x <= PLAIN[1]:
        return f"{x:.6g}"
    exponent = int(np.floor(np.log10(x) + 1e-9))
    factor = x / 10.0**exponent
    return power_of_ten(exponent) if abs(factor - 1.0) < 1e-6 else f"{factor:.0f}·{power_of_ten(exponent)}"


def _by_unit(file):
    """Return {unit: (output, input) pairs}."""
    groups: dict[str, list[tuple[int, int]]] = {}
    for j, of_input in enumerate(file.input_units):
        for i, of_output in enumerate(file.output_units):
            groups.setdefault(_unit(of_output, of_input), []).append((i, j))
    return groups


def _unit(of_output, of_input):
    """Return the unit of a transfer function, "m per N"; "" if both units are equal."""
    return "" if of_output == of_input else ratio_unit(of_output, of_input)


def _style(file, i, j):
    number = i + j * len(file.outputs)
    dashes, marker = DASHES[number // len(COLOURS) % len(DASHES)], "o" if len(file.frequency) < FEW else ""
    return {"color": COLOURS[number % len(COLOURS)], "linestyle": dashes, "marker": marker}


def _handles(file):
    """Return the entries of the legend; the input is named if there are several."""
    handles = []
    for j, source in enumerate(file.inputs):
        for i, output in enumerate(file.outputs):
            label = f"{output} by {source}" if len(file.inputs) > 1 else output
            none = "" if np.any(file.values[:, i, j]) else " (no response)"
            handles.append(Line2D([], [], label=label + none, **_style(file, i, j)))
    return handles


def _magnitudes(ax: "Axes", file, unit, pairs):
    size = np.abs(file.values)
    for i, j in pairs:
        shown = np.where((size[:, i, j] > 0.0) & np.isfinite(size[:, i, j]), size[:, i, j], np.nan)
        ax.plot(file.frequency, shown, **_style(file, i, j))
    of_pairs = np.array([size[:, i, j] for i, j in pairs])
    seen = of_pairs[np.isfinite(of_pairs) & (of_pairs > 0.0)]
    ax.set_ylabel(f"magnitude [{unit}]" if unit else "magnitude")
    if len(seen):
        magnitude_axis(ax, float(np.median(seen)))


def magnitude_axis(ax: "Axes", median: float) -> None:
    """Set the axis of magnitudes with this ``median``; magnitudes smaller by more than RANGE are not shown."""
    ax.set_yscale("log")
    ax.yaxis.set_major_formatter(FuncFormatter(plain_number))
    ax.yaxis.set_minor_formatter(NullFormatter())
    if ax.get_ylim()[0] < (lowest := median / RANGE):
        ax.set_ylim(bottom=lowest)


def _phases(ax: "Axes", file, pairs):
    low, high = np.inf, -np.inf
    for i, j in pairs:
        H = file.values[:, i, j]
        if not np.any(H):
            continue
        phase = unwrapped(H)
        ax.plot(file.frequency, phase, **_style(file, i, j))
        low, high = min(low, phase.min()), max(high, phase.max())
    ax.set(ylabel="phase [deg]")
    if np.isfinite(low):
        phase_axis(ax, low, high)


def unwrapped(H: np.ndarray, centre: float = 0.0) -> np.ndarray:
    """Return the phase (n,) [deg] of a transfer function (n,), at the first frequency within 180 of a ``centre``."""
    phase = np.degrees(np.unwrap(np.angle(np.where(np.isfinite(H), H, 1.0))))
    return phase - 360.0 * np.round((phase[0] - centre) / 360.0)


def phase_axis(ax: "Axes", low: float, high: float) -> None:
    """Set the axis of phases from ``low`` to ``high`` [deg]."""
    step = next((step for step in ROUND if high - low <= 5.0 * step), ROUND[-1])
    ax.yaxis.set_major_locator(MultipleLocator(step))
    margin = max(0.05 * (high - low), 5.0)
    ax.set_ylim(low - margin, high + margin)
