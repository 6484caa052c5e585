"""Campbell diagram: frequencies and damping over the speed of a rotor, lines of its multiples, and where they meet."""

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.lines import Line2D

from mecano.post.figure import plain_figure
from mecano.post.style import COLOURS, GREY, INK
from mecano.results.sweep_file import whirl_word

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mecano.results.sweep_file import SweepFile

SIZE = (8.4, 6.8)  # inches
ABOVE = 1.15  # times the highest frequency of interest: limit of the frequencies shown
LEAST = 1.5  # times the lowest frequency: least limit
STYLES: dict[str, Any] = {"forward": "-", "backward": (0, (5, 1.6)), "-": (0, (1.2, 1.2))}  # of lines
WORDS = {"forward": "forward whirl", "backward": "backward whirl", "-": "neither"}
LONGEST, MOST_NAMED = 100, 12  # characters of a motion in the legend; modes in it
NUMBERS = 7.5  # points


def campbell_figure(file: "SweepFile", below: float | None, above: float | None) -> "Figure":
    """Return the figure of a SweepFile with a rotor; ``below``, ``above`` [Hz]: limits of the frequencies shown."""
    heading = f"Campbell diagram of '{file.rotor}'; about: {file.about}"
    figure = plain_figure(*SIZE, file.title or file.path.stem, heading)
    over, under = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    assert file.speed is not None, "a sweep with a rotor has its speeds"
    x, limit = file.speed * 30.0 / np.pi, below or _limit(file)
    for order in file.orders:
        over.plot(x, order * x / 60.0, color=GREY, linewidth=0.8)
        _name(over, x, order * x / 60.0, limit, f"{order:g}x")
    frequency = np.where(file.modes["imaginary_part"] > 0.0, file.modes["frequency"], np.nan)
    damping = np.where(file.modes["imaginary_part"] > 0.0, file.modes["damping_ratio"], np.nan)
    shown = [b for b in range(len(frequency)) if np.any((frequency[b] <= limit) & (frequency[b] >= (above or 0.0)))]
    for i, b in enumerate(shown):
        marker = "." if len(x) < 3 else ""
        for word, style in STYLES.items():
            own = np.array([whirl_word(w) == word for w in file.modes["whirl"][b]])
            for ax, values in ((over, frequency[b]), (under, damping[b])):
                ax.plot(x, np.where(_with_next(own), values, np.nan), color=_colour(i), linestyle=style, marker=marker)
    _mark(over, file.resonances, limit)
    over.set(ylabel="damped frequency [Hz]", ylim=(above or 0.0, limit))
    under.set(xlabel=f"speed of '{file.rotor}' [1/min]", ylabel="damping ratio")
    under.axhline(0.0, color=INK, linewidth=0.8)
    figure.legend(handles=_handles(file, shown), loc="outside lower left", ncols=1)
    return figure


def _limit(file):
    """Return the highest frequency shown [Hz]: that of the modes with resonances, or of the multiples of the speed."""
    frequency = np.where(file.modes["imaginary_part"] > 0.0, file.modes["frequency"], np.nan)
    chosen = np.unique(file.resonances["mode"].astype(int)) - 1
    if chosen.size:
        return ABOVE * float(np.nanmax(frequency[chosen]))
    lowest = np.min(frequency, initial=np.inf, where=np.isfinite(frequency))
    highest = max(file.orders) * np.nanmax(file.speed) / (2.0 * np.pi)
    return max(ABOVE * highest, LEAST * lowest if np.isfinite(lowest) else 0.0) or 1.0


def _with_next(own):
    """Return the mask extended by the value before each chosen one, so that the parts of a curve join."""
    return own | np.append(own[1:], False)


def _name(ax, x, y, limit, text):
    """Write a text at the end of a line from zero, or at the point where it leaves the picture."""
    i = int(np.nanargmax(x))
    at = (x[i], y[i]) if y[i] <= limit else (x[i] * limit / y[i], limit)
    ax.annotate(text, at, xytext=(4, -9), textcoords="offset points", color=GREY, fontsize=NUMBERS)


def _mark(ax, found, limit):
    """Mark the resonances, filled where the mode whirls forward, with their speeds [1/min]."""
    for speed, frequency, whirl in zip(found["speed"], found["frequency"], found["whirl"], strict=True):
        if frequency > limit:
            continue
        x = speed * 30.0 / np.pi
        forward = whirl_word(whirl) == "forward"
        ax.plot(x, frequency, "o", color=INK, markerfacecolor=INK if forward else "white", markersize=5, zorder=3)
        ax.annotate(f"{x:.4g}", (x, frequency), xytext=(-4, 5) if forward else (5, -9), textcoords="offset points",
                    ha="right" if forward else "left", fontsize=NUMBERS, color=INK)  # fmt: skip


def _handles(file, shown):
    """Return the handles of the legend: the kinds of whirl, and the largest motions of the modes."""
    used = {whirl_word(w) for b in shown for w in file.modes["whirl"][b][np.isfinite(file.modes["whirl"][b])]}
    handles = [Line2D([], [], color=INK, linestyle=STYLES[word], label=WORDS[word]) for word in STYLES if word in used]
    for i, b in enumerate(shown[:MOST_NAMED]):
        text = f"{b + 1}: {file.motions[b]}"
        text = text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
        handles.append(Line2D([], [], color=_colour(i), label=text))
    if len(shown) > MOST_NAMED:
        handles.append(Line2D([], [], linestyle="none", label=f"and {len(shown) - MOST_NAMED} others"))
    return handles


def _colour(i):
    return COLOURS[i % len(COLOURS)]
