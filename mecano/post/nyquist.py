"""Bode and Nyquist diagrams of a file of margins: the loop transfer function, its crossovers and its margins."""

from typing import TYPE_CHECKING

import matplotlib
import numpy as np

from mecano.post.bode import frequency_axis, magnitude_axis, phase_axis, unwrapped
from mecano.post.figure import plain_figure
from mecano.post.style import COLOURS, GREY, INK, LEGEND, SETTINGS
from mecano.results.margins_file import MarginsFile

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE = 11.0, 5.0  # inches
CENTRE = -90.0  # deg: a loop of negative feedback begins within half a turn of it
NEAR, FAR = 1.6, 3.0  # limits of the Nyquist diagram, at least and at most


def margins_figure(file: MarginsFile) -> "Figure":
    """Return the figure of a MarginsFile: Bode diagram on the left, Nyquist diagram on the right."""
    with matplotlib.rc_context(SETTINGS):
        heading = f"loop opened at {file.signal}; about: {file.about}"
        figure = plain_figure(*SIZE, file.title or file.path.stem, heading)
        grid = figure.add_gridspec(2, 2, height_ratios=[1.2, 1.0])
        upper = figure.add_subplot(grid[0, 0])
        lower = figure.add_subplot(grid[1, 0], sharex=upper)
        _bode(upper, lower, file)
        _nyquist(figure.add_subplot(grid[:, 1]), file)
        handles, labels = upper.get_legend_handles_labels()
        figure.legend(handles=handles, labels=labels, loc="outside lower center", ncols=len(handles), **LEGEND)
    return figure


def _crossovers(file):
    """Return the crossovers of the gain and of the phase above zero frequency: (label, frequency, L, marker)."""
    of = file.crossovers
    value = of["real_part"] + 1j * of["imaginary_part"]
    for label, gain, marker in (("phase margin", 1.0, "o"), ("gain margin", 0.0, "s")):
        own = of["of_gain"] == gain
        if own.any():
            yield label, of["frequency"][own], value[own], marker


def _bode(upper, lower, file):
    """Draw the magnitude and the phase, with the margins as lines from the crossovers to 1 and to odd 180 degrees."""
    size, phase = np.abs(file.values), unwrapped(file.values, CENTRE)
    size = np.where(np.isfinite(size) & (size > 0.0), size, np.nan)
    for ax, values in ((upper, size), (lower, phase)):
        ax.plot(file.frequency, values, color=COLOURS[0], label="L" if ax is upper else None)
    upper.axhline(1.0, color=INK, linewidth=0.8)
    for label, frequency, value, marker in _crossovers(file):
        shown = frequency > 0.0
        at, own = frequency[shown], np.interp(frequency[shown], file.frequency, phase)
        odd = 360.0 * np.round((own + 180.0) / 360.0) - 180.0
        style = {"color": COLOURS[1], "marker": marker, "linestyle": "none", "markersize": 5}
        upper.plot(at, np.abs(value[shown]), label=label, **style)
        lower.plot(at, own, **style)
        upper.vlines(at, np.minimum(1.0, np.abs(value[shown])), np.maximum(1.0, np.abs(value[shown])), COLOURS[1])
        lower.vlines(at, np.minimum(odd, own), np.maximum(odd, own), COLOURS[1])
    for odd in np.arange(-180.0 - 360.0 * np.ceil(-phase.min() / 360.0), phase.max() + 180.0, 360.0):
        lower.axhline(odd, color=INK, linewidth=0.8)
    upper.set_ylabel("magnitude of L")
    lower.set_ylabel("phase [deg]")
    magnitude_axis(upper, float(np.nanmedian(size)))
    phase_axis(lower, min(float(phase.min()), -180.0), float(phase.max()))
    frequency_axis(upper, lower, file.frequency)


def _nyquist(ax, file):
    """Draw L in the complex plane, of negative frequencies dashed, with the unit circle and the point -1."""
    L = np.where(np.isfinite(file.values), file.values, np.nan)
    ax.plot(L.real, L.imag, color=COLOURS[0])
    ax.plot(L.real, -L.imag, color=COLOURS[0], linewidth=0.8, linestyle=(0, (3, 2)))
    turn = np.exp(2j * np.pi * np.linspace(0.0, 1.0, 201))
    ax.plot(turn.real, turn.imag, color=GREY, linewidth=0.8)
    if np.isfinite(peak := file.margins["sensitivity_peak"]):
        ax.plot(turn.real / peak - 1.0, turn.imag / peak, color=GREY, linewidth=0.8, linestyle=(0, (1, 2)))
    for _, _, value, marker in _crossovers(file):
        ax.plot(value.real, value.imag, color=COLOURS[1], marker=marker, linestyle="none", markersize=5)
    ax.plot(-1.0, 0.0, color=INK, marker="+", markersize=10)
    limit = min(max(1.1 * float(np.nanmax(np.abs(L))), NEAR), FAR)
    ax.set(xlabel="real part of L", ylabel="imaginary part of L", xlim=(-limit, limit), ylim=(-limit, limit))
    ax.set_aspect("equal")
