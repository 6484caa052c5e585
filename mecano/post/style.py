"""Style of pictures: colours, lines, units with prefixes, ranges of axes."""

from collections.abc import Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from mecano.post.quantity import largest
from mecano.post.sheet import CONSTANT

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#6a51a3", "#8c564b")
DASHES: tuple[Any, ...] = (  # styles of lines of matplotlib
    "-", (0, (5, 1.6)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)), (0, (3, 3)), (0, (8, 2, 2, 2, 2, 2)),
)  # fmt: skip
LEGEND = {"handlelength": 1.6, "columnspacing": 1.2}  # in units of the font size
LONGEST_LABEL = 27  # characters
LINE_OF_TEXT = 13.0  # points
BESIDE = 24  # characters of small print that fit next to the label of an axis
GREY, PALE, INK = "#777777", "#bbbbbb", "#222222"
LIMIT = "#b34700"
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SETTINGS: dict[Any, Any] = {  # rcParams of matplotlib
    "text.parse_math": False,  # titles and names may contain any characters
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#888888",
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "axes.grid": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "lines.linewidth": 1.3,
    "lines.solid_joinstyle": "round",
    "agg.path.chunksize": 10000,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-6, 7),
    "figure.constrained_layout.use": True,
    "figure.dpi": 150,
    "savefig.dpi": "figure",
    "svg.hashsalt": "mecano",
}

LARGE = {"N": "kM", "N m": "kM", "J": "kM", "W": "kM", "Pa": "kM"}
SMALL = {"m": "nµm", "s": "nµm", "m/s": "µm"}
FACTORS = {"k": 1e3, "M": 1e6, "m": 1e-3, "µ": 1e-6, "n": 1e-9}


def shown_unit(unit: str, values: np.ndarray) -> tuple[float, str]:
    """Return factor and unit for the display of values: kN from 2000 N, mm below 0.1 m, µm below 0.1 mm, and so on."""
    unit = "" if unit in ("-", "1") else unit
    size = largest(values)
    for prefix in reversed(LARGE.get(unit, "")):
        if size >= 2.0 * FACTORS[prefix]:
            return _scaled(size, FACTORS[prefix], prefix + unit)
    for prefix in SMALL.get(unit, ""):
        if 0.0 < size < 100.0 * FACTORS[prefix]:
            return _scaled(size, FACTORS[prefix], prefix + unit)
    return _scaled(size, 1.0, unit)


def _scaled(size, factor, unit):
    """Return factor and unit, with a power of 1000 before the unit if the numbers are too long for an axis."""
    if not size or 2e-3 <= size / factor < 2e5:
        return factor, unit
    exponent = 3 * int(np.floor(np.log10(size / factor / 2.0) / 3.0))
    return factor * 10.0**exponent, f"{power_of_ten(exponent)} {unit}".strip()


def with_unit(label: str, unit: str) -> str:
    """Return a label with its unit, if any, in brackets, on several lines if it is long."""
    text = f"{label} [{unit}]" if unit else label
    if len(text) <= LONGEST_LABEL:
        return text
    owner, colon, what = label.partition(": ")
    if colon:
        return f"{owner}:\n{with_unit(what, unit)}"
    lines = wrap(label, LONGEST_LABEL, break_long_words=False)
    if not unit:
        return "\n".join(lines)
    fits = len(f"{lines[-1]} [{unit}]") <= LONGEST_LABEL
    return "\n".join(lines) + f"{' ' if fits else chr(10)}[{unit}]"


def legend_columns(handles: "Sequence[Line2D]", inches: float) -> int:
    """Return the number of columns of a legend that fit into a width in inches."""
    longest = max(len(str(handle.get_label())) for handle in handles)
    return min(len(handles), max(1, int(inches / (0.064 * longest + 0.44))))


def legend_above(ax: "Axes", handles: "Sequence[Line2D]", inches: float) -> float:
    """Draw a legend above axes of a width in inches, and return its height in points."""
    if not handles:
        return 0.0
    columns = legend_columns(handles, inches)
    ax.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, borderaxespad=0.2,
              borderpad=0.2, labelspacing=0.3, **LEGEND)  # fmt: skip
    return LINE_OF_TEXT * -(-len(handles) // columns)


def note_below(ax: "Axes", text: str) -> None:
    """Write small print at the lower right of axes, below their label if it is long."""
    wider = max(0, len(ax.get_xlabel()) - len("time [s]")) // 2  # the label is centred
    down = -18 if len(text) <= BESIDE - wider else -32
    ax.annotate(text, (1.0, 0.0), xycoords="axes fraction", xytext=(0, down), textcoords="offset points",
                ha="right", va="top", fontsize=7.5, color=GREY)  # fmt: skip


def mark_limits(ax: "Axes", limits: Sequence[tuple[float, float]], across: str) -> None:
    """Mark limits by lines, and shade what is beyond them; they are values along the axis ``across``, "x" or "y".

    Each limit is (value, side beyond it: -1 or 1).
    """
    line, span = (ax.axvline, ax.axvspan) if across == "x" else (ax.axhline, ax.axhspan)
    for value, _ in limits:
        line(value, color=LIMIT, linewidth=0.8, linestyle=DASHES[1])
    ends = getattr(ax, f"get_{across}lim")()
    for value, side in limits:
        span(value, ends[side > 0], color=LIMIT, alpha=0.1, linewidth=0, zorder=0)
    ax.set(**{f"{across}lim": ends})


def range_of(values: np.ndarray, level: float = CONSTANT) -> tuple[float, float] | None:
    """Return limits of an axis for values that vary by no more than a share ``level`` of them, otherwise None."""
    values = values[np.isfinite(values)]
    if not values.size:
        return 0.0, 1.0
    low, high, size = values.min(), values.max(), np.abs(values).max()
    if high - low > level * size and size > 1e-300:
        return None
    middle, margin = 0.5 * (low + high), 0.1 * size if size > 1e-12 else 1.0
    return middle - margin, middle + margin


def power_of_ten(exponent: int | str) -> str:
    """Return a power of ten with a superscript exponent, given as int or str."""
    return f"10{str(exponent).translate(RAISED)}"
