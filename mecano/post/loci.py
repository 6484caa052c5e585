"""Pictures of a sweep: root loci, growth, frequency and damping over a parameter; a map of stability over two."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.colors import TwoSlopeNorm
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from mecano.deck.unit_of import parameters_of, unit_of
from mecano.errors import UsageError
from mecano.post.campbell import campbell_figure
from mecano.post.figure import plain_figure
from mecano.post.style import COLOURS, DASHES, GREY, INK, SETTINGS, note_below, with_unit
from mecano.results.opening import open_checked
from mecano.results.sweep_file import SweepFile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE, MAP_SIZE = (9.6, 7.2), (6.8, 4.6)  # inches
WIDTH, NUMBERS = 3.7, 7.5  # inches of axes; points, size of the numbers of critical values
LETTER, ROW = 0.7 * NUMBERS / 72, NUMBERS + 1.5  # inches, width of a letter with its space; points
UNSTABLE = "#d55e00"
FAR = 2.5  # times the range near the limit of stability: eigenvalues that decay faster are cut off
DEEPEST = 10.0
LITTLE = 0.3  # damping ratio
CHANGES = 0.05  # of the damping ratio of a lightly damped mode over the sweep: from there on it is of interest
SLIGHT = 0.01  # damping ratio of the slowest oscillation, below which decay is not resolved
LONGEST = (110, 70)  # characters of a motion in a legend of one or two columns
LEFT_OUT = " ..."  # marks a text from which something is left out
MOST_NAMED, IN_A_COLUMN = 16, 4  # modes in the legend
MOST_REPORTED = 6  # modes listed as beyond the limits
ABOVE = 3.0  # times the frequency of the growing or least damped modes: faster ones are omitted
ROUNDED = 1e-6  # damping ratio that counts as zero


def sweep_figure(file: SweepFile, below: float | None = None, above: float | None = None) -> "Figure":
    """Return the figure of a SweepFile with the modes between ``above`` and ``below`` [Hz], see ``shown_modes``.

    Raises ResultsError, and UsageError for a map of stability with one of these.
    """
    units, is_map = _units(file), len(file.names) == 2
    given = [name for name, value in (("--below", below), ("--above", above)) if value is not None]
    if is_map and given:
        raise UsageError(f"{given[0]}: {file.path} is a map of stability, which shows the least stable of all modes")
    file, units = _displayed(file, units)
    with matplotlib.rc_context(SETTINGS):
        if file.rotor:
            return campbell_figure(file, below, above)
        return _map(file, units) if is_map else _loci(file, units[0], below, above)


def _units(file):
    """Return the units of the parameters of a SweepFile, as far as deck or sweep give them. Raises ResultsError."""
    with open_checked(file.path) as opened:
        text, resolved = opened["deck/text"][()].decode(), json.loads(opened["deck/resolved"][()])
    written = parameters_of(str(file.path), text)
    paths = [name if "." in name else f"parameters.{name}" for name in file.names]
    return [unit_of(path, resolved, [written.get(path)]) or unit for path, unit in zip(paths, file.units, strict=True)]


def _displayed(file, units):
    """Return a SweepFile and the units of its parameters for people: angles in degrees."""
    for name, unit in zip(("parameter", "other"), units, strict=False):
        if unit == "rad":
            critical = {**file.critical, name: np.degrees(file.critical[name])}
            file = replace(file, critical=critical, **{name: np.degrees(getattr(file, name))})
    return file, ["deg" if unit == "rad" else unit for unit in units]


def _headed(file, size):
    heading = f"modes over {' and '.join(file.names)}; about: {file.about}"
    width, height = size
    return plain_figure(width, height, file.title or file.path.stem, heading)


def shown_modes(
    modes: Mapping[str, np.ndarray], below: float | None = None, above: float | None = None
) -> tuple[np.ndarray, np.ndarray, float | None]:
    """Return (indices of the modes shown, indices of those faster than the limit, limit [Hz] or None).

    Modes that oscillate faster than the limit at all values are faster, those that oscillate slower than ``above`` [Hz]
    at all values, or do not, are not shown. Without ``below`` [Hz] the limit is ABOVE
    times the highest frequency of the modes that grow at some value or, if none grows, of those that are least damped
    at some value, and of lightly damped ones whose damping changes.
    """
    oscillates = modes["imaginary_part"] > 0.0
    frequency = np.where(oscillates, modes["frequency"], np.nan)
    if below is None:
        below = _of_interest(modes, frequency) * ABOVE
    known = np.isfinite(modes["real_part"])
    inside = np.any(known & ~(frequency > below), axis=1)
    faster = np.flatnonzero(~inside)
    if above is not None:
        inside &= np.any(frequency >= above, axis=1)
    return np.flatnonzero(inside), faster, below if np.any(frequency > below) else None


def _of_interest(modes, frequency):
    """Return the highest frequency [Hz] of the growing oscillations or, if none grows, of the least damped ones.

    Lightly damped oscillations whose damping the parameter changes, such as the wobble of a motorcycle, count as well.
    """
    ratio = np.where(np.isfinite(frequency), modes["damping_ratio"], np.inf)
    chosen = ratio < -ROUNDED
    if not chosen.any():
        chosen = np.isfinite(frequency) & (ratio <= ratio.min(axis=0, initial=np.inf) + ROUNDED)
    return frequency[chosen | _varied(ratio)].max(initial=0.0) or np.inf


def _varied(ratio):
    """Return where damping ratios (modes, values), inf where nothing oscillates, are low and vary over the sweep."""
    least, most = ratio.min(axis=1), np.where(np.isfinite(ratio), ratio, -np.inf).max(axis=1)
    return (ratio < LITTLE) & (most - least > CHANGES)[:, None]


def _loci(file, unit, below, above):
    figure = _headed(file, SIZE)
    shown, faster, limit = shown_modes(file.modes, below, above)
    grid = figure.subplots(2, 2)
    modes, x = file.modes, file.parameter
    oscillates = modes["imaginary_part"] > 0.0
    frequency = np.where(oscillates, modes["frequency"], np.nan)
    damping = np.where(oscillates, modes["damping_ratio"], np.nan)
    near = real_range({name: values[shown] for name, values in modes.items()})
    near = (*near[:2], [shown[i] for i in near[2]])
    _plane(grid[0, 0], file, unit, shown, near, limit)
    for ax, values, what in (
        (grid[0, 1], modes["real_part"], "growth [1/s]"), (grid[1, 0], frequency, "damped frequency [Hz]"),
        (grid[1, 1], damping, "damping ratio"),
    ):  # fmt: skip
        for b in shown:
            row = values[b]
            marker = "." if np.isfinite(row).sum() < 3 else ""
            ax.plot(x, row, color=_colour(b), linestyle=_dashes(b), marker=marker)
        ax.set(xlabel=with_unit(file.names[0], unit), ylabel=what)
        _mark(ax, file)
    for ax in (grid[0, 1], grid[1, 1]):
        ax.axhline(0.0, color=INK, linewidth=0.8)
    if not np.any(np.isfinite(frequency)):
        for ax in grid[1]:
            ax.text(0.5, 0.5, "no mode oscillates", transform=ax.transAxes, ha="center", color=GREY)
    _limited(grid[0, 1], grid[0, 1].set_ylim, *near)
    if limit is not None:
        grid[1, 0].set_ylim(0.0, limit)
        if len(faster):
            note_below(grid[1, 0], f"{_named(faster)} above {limit:.3g} Hz: --below HZ shows others")
    handles = _handles(file, shown)
    figure.legend(handles=handles, loc="outside lower left", ncols=1 if len(handles) <= IN_A_COLUMN else 2)
    return figure


def _handles(file, shown):
    """Return the handles of the legend: the largest motions of each mode, or of the least stable of many modes."""
    real = file.modes["real_part"][shown]
    order = shown[np.argsort(-np.nanmax(real, axis=1, initial=-np.inf), kind="stable")]
    longest = LONGEST[len(real) > IN_A_COLUMN]
    handles = []
    for b in np.sort(order[:MOST_NAMED]):
        text = _shortened(f"{b + 1}: {file.motions[b]}", longest)
        handles.append(Line2D([], [], color=_colour(b), linestyle=_dashes(b), label=text))
    if len(order) > MOST_NAMED:
        handles.append(Line2D([], [], linestyle="none", label=f"and {len(order) - MOST_NAMED} more stable ones"))
    return handles


def _shortened(text, longest):
    """Return the motions of a text that fit into a line of ``longest`` characters, with a mark if some are left out."""
    if len(text) <= longest:
        return text
    room = longest - len(LEFT_OUT)
    end = text.rfind("; ", 0, room + 1)
    return f"{text[: end if end > 0 else room]}{LEFT_OUT}"


def _plane(ax, file, unit, shown, near, limit):
    """Plot eigenvalues in the complex plane, from the open to the filled dot as the parameter increases.

    ``shown``: indices of the modes; ``near``: as in ``real_range``; ``limit``: of the frequencies [Hz], or None.
    """
    real, imaginary = file.modes["real_part"], file.modes["imaginary_part"]
    low, high, beyond = near
    for b in shown:
        known = np.flatnonzero(np.isfinite(real[b]))
        ax.plot(real[b], imaginary[b], color=_colour(b), linestyle=_dashes(b), marker=".", markersize=3, linewidth=1.0)
        for i, fill in ((known[0], "white"), (known[-1], _colour(b))):
            ax.plot(real[b, i], imaginary[b, i], "o", color=_colour(b), markerfacecolor=fill, markersize=5)
    first, last = file.parameter[[0, -1]]
    ax.set(xlabel="real part [1/s]", ylabel="imaginary part [rad/s]")
    ax.set_title(f"root loci: {file.names[0]} from {first:g} (open dots) to {last:g} {unit}".rstrip(), loc="left")
    _limited(ax, ax.set_xlim, low, high, beyond)
    own, parts = imaginary[shown], real[shown]
    own = own[(parts > low) & (parts < high) & ~(own > 2.0 * np.pi * (limit or np.inf))]
    if highest := own.max(initial=0.0):
        ax.set_ylim(-0.05 * highest, 1.1 * highest)
    if high > 0.0:
        ax.axvspan(0.0, high, color=UNSTABLE, alpha=0.07, linewidth=0)
    ax.axvline(0.0, color=INK, linewidth=0.8)


def _mark(ax, file):
    """Draw critical values as vertical lines with their numbers, stacked where lines are close."""
    places = file.critical["parameter"]
    vague = file.critical["of_instant"]
    texts = [f"about {value:.3g}" if unsure else f"{value:.5g}" for value, unsure in zip(places, vague, strict=True)]
    letter = LETTER / WIDTH * np.ptp(file.parameter)
    for value, text, row in zip(places, texts, _rows(places, [letter * len(text) for text in texts]), strict=True):
        ax.axvline(value, color=GREY, linewidth=0.8, linestyle=(0, (2, 2)))
        ax.annotate(text, (value, 1.0), xycoords=("data", "axes fraction"), xytext=(0, 1 + ROW * row),
                    textcoords="offset points", ha="center", va="bottom", fontsize=NUMBERS, color=GREY)  # fmt: skip


def _rows(places, widths):
    """Return, for each label centred at its position, the lowest row in which it does not overlap another."""
    rows = [0] * len(places)
    ends: list[float] = []  # of the last label in each row
    for i in np.argsort(places):
        free = [row for row, end in enumerate(ends) if places[i] - 0.5 * widths[i] >= end]
        rows[i] = free[0] if free else len(ends)
        ends[rows[i] : rows[i] + 1] = [places[i] + 0.5 * widths[i]]
    return rows


def real_range(modes: Mapping[str, np.ndarray]) -> tuple[float, float, Sequence[int]]:
    """Return limits for real parts, and the modes that are partly beyond them because they decay much faster.

    Growing modes, the least stable mode at each value, and modes lightly damped at some value are within the limits,
    unless they are DEEPEST times as far from the limit of stability as the fastest growth, the least decay, or the
    least decay of a lightly damped oscillation. If none grows, lightly damped modes that change are within them, too.
    """
    real, ratio = modes["real_part"], modes["damping_ratio"]
    if not np.any(np.isfinite(real)):
        return -1.0, 1.0, ()
    oscillates = modes["imaginary_part"] > 0.0
    least = np.max(real, axis=0, initial=-np.inf, where=np.isfinite(real))
    lightly = np.any(oscillates & (ratio < LITTLE), axis=1, keepdims=True)  # damped, at some value
    near = np.concatenate([real[oscillates & lightly], least[np.isfinite(least)], [0.0]])
    size = np.abs(modes["imaginary_part"][oscillates]).min(initial=np.inf) * SLIGHT if oscillates.any() else 0.0
    decays = least[np.isfinite(least)], real[oscillates & lightly]
    size = max(size, near.max(), *(-one.max() for one in decays if one.size))
    low, high = min(max(near.min(), -DEEPEST * size), -0.5 * near.max()), near.max()
    if high <= 0.0:
        low = min(low, real[_varied(np.where(oscillates, ratio, np.inf))].min(initial=0.0))
    if np.nanmin(real) > FAR * low:
        low = np.nanmin(real)
    margin = 0.05 * (high - low) or 1.0
    beyond = [b for b in range(len(real)) if np.nanmin(real[b]) < low - margin]
    return low - margin, high + margin, beyond


def _limited(ax, limits, low, high, beyond):
    """Set the limits of an axis, with a note on the modes beyond."""
    limits(low, high)
    if beyond:
        which = _named(beyond)
        note_below(ax, f"{which}: also beyond the left" if limits == ax.set_xlim else f"{which}: also below")


def _named(modes):
    """Return the numbers of modes as text, or their count if there are many."""
    if len(modes) > MOST_REPORTED:
        return f"{len(modes)} modes"
    return f"mode {', '.join(str(b + 1) for b in modes)}"


def _colour(b):
    return COLOURS[b % len(COLOURS)]


def _dashes(b):
    return DASHES[b // len(COLOURS) % len(DASHES)]


def _map(file, units):
    figure = _headed(file, MAP_SIZE)
    ax = figure.subplots()
    growth = np.ma.masked_invalid(file.map["growth"])
    size = float(np.abs(growth).max()) or 1.0
    largest = max(float(growth.max()), 1e-3 * size)
    lowest = min(float(growth.min()), -1e-3 * size)
    image = ax.pcolormesh(file.parameter, file.other, growth, cmap="RdBu_r", shading="nearest",
                          norm=TwoSlopeNorm(0.0, lowest, largest))  # fmt: skip
    sides = [(lowest, 0.0)] * bool(growth.min() < 0.0) + [(0.0, largest)] * bool(growth.max() > 0.0)  # scales differ
    ticks = [tick for ends in sides for tick in MaxNLocator(4).tick_values(*ends)]
    ticks = [tick for tick in ticks if lowest <= tick <= largest]
    figure.colorbar(image, ax=ax, label="largest growth [1/s]; red: unstable", ticks=ticks)
    if min(growth.shape) > 1 and growth.min() < 0.0 < growth.max():
        ax.contour(file.parameter, file.other, border(file), levels=[0.0], colors=GREY, linewidths=0.8)
    _hatch_oscillations(ax, file, growth)
    for grows, marker in ((1.0, ">"), (0.0, "<")):
        own = file.critical["destabilizes"] == grows
        if not own.any():
            continue
        ax.plot(file.critical["parameter"][own], file.critical["other"][own], marker, color=INK, markersize=4,
                label=f"border: unstable {'above' if grows else 'below'}")  # fmt: skip
    ax.set(xlabel=with_unit(file.names[0], units[0]), ylabel=with_unit(file.names[1], units[1]))
    ax.grid(False)
    if ax.get_legend_handles_labels()[0]:
        figure.legend(*ax.get_legend_handles_labels(), loc="outside lower left", ncols=3)
    return figure


def border(file: SweepFile) -> np.ma.MaskedArray:
    """Return a function (others, parameters) with the sign of the growth of a map, zero at its critical values.

    The growth itself has kinks where another mode becomes the fastest, so that its interpolation has zeros elsewhere.
    It is the distance along the parameter to a critical value beside, otherwise one interval of the sweep.
    """
    x, growth = file.parameter, np.ma.masked_invalid(file.map["growth"])
    found = np.sign(growth) * float(np.diff(x).mean())
    for value, other in zip(file.critical["parameter"], file.critical["other"], strict=True):
        row, after = int(np.argmin(np.abs(file.other - other))), int(np.searchsorted(x, value))
        if 0 < after < len(x) and found[row, after - 1] * found[row, after] < 0.0:
            found[row, after - 1] = np.sign(found[row, after - 1]) * (value - x[after - 1])
            found[row, after] = np.sign(found[row, after]) * (x[after] - value)
    return found


def _hatch_oscillations(ax, file, growth):
    """Hatch the part of a map in which an oscillation grows, if elsewhere something grows without oscillating."""
    swings = np.ma.masked_invalid(file.map["oscillation_growth"])
    grows, fastest = swings.filled(0.0) > 0.0, float(swings.max())
    if min(growth.shape) < 2 or not grows.any() or not np.any((growth.filled(0.0) > 0.0) & ~grows):
        return
    field = swings.filled(min(float(swings.min()), 0.0))
    ax.contourf(file.parameter, file.other, field, levels=[1e-6 * fastest, fastest], colors="none", hatches=["//"])
    ax.add_patch(Rectangle((np.nan, np.nan), 0.0, 0.0, fill=False, hatch="//", label="an oscillation grows"))
