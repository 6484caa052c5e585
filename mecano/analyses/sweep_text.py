"""The results of a sweep of modes as lines for a terminal."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from mecano.post.text_table import aligned
from mecano.results.sweep_file import whirl_word
from mecano.solve.modal.families import FAMILIES
from mecano.solve.modal.modes import damping, unstable
from mecano.solve.modal.tracking import least_damped

if TYPE_CHECKING:
    from mecano.analyses.sweep import Sweep

MOST_ROWS, MOST_DIGITS, INSTANT_DIGITS = 200, 11, 3


def lines(sweep: "Sweep") -> Iterator[str]:
    """Yield the lines of the table: the least stable mode at each value, the modes, the critical values."""
    sweep = _displayed(sweep)
    first = sweep.axes[0]
    span = f"from {first.values[0]:g} to {first.values[-1]:g} {first.unit}".rstrip()
    yield f"modes over {first.name}, {len(first.values)} values {span}"
    yield f"about: {sweep.about}"
    if len(sweep.axes) == 1:
        yield from _state_lines(first, sweep.loci[0])
        yield from _modes(first.name, sweep.loci[0])
        yield from _families(first.name, sweep.loci[0])
        yield _unstable_ranges(first, sweep.loci[0])
        yield from _critical(first.name, sweep.loci[0])
        if sweep.rotor:
            yield from _resonance_lines(sweep, sweep.loci[0])
        return
    for value, locus in zip(sweep.axes[1].values, sweep.loci, strict=True):
        yield f"{sweep.axes[1].name} {value:.6g}: {_unstable_ranges(first, locus)}"
        yield from (f"  {text}" for text in _critical(first.name, locus))


def _displayed(sweep):
    """Return the Sweep with values of its axes for people: angles in degrees."""
    axes = tuple(axis.displayed for axis in sweep.axes)
    return replace(sweep, axes=axes, loci=[_in_units_of(locus, axes[0]) for locus in sweep.loci])


def _in_units_of(locus, axis):
    """Return a Locus with the values of a displayed Axis."""
    size = locus.axis.size
    critical = [replace(one, place=one.place / size, error=one.error / size) for one in locus.critical]
    resonances = [replace(one, place=one.place / size) for one in locus.resonances]
    return replace(locus, axis=axis, critical=critical, resonances=resonances)


def _state_lines(axis, locus):
    """Yield a line for each value: the number of growing modes, and the least stable mode."""
    head = f"{axis.name} [{axis.unit}]" if axis.unit else axis.name
    rows = [(head, "growing", "mode", "growth [1/s]", "damped [Hz]", "damping")]
    for i, value in enumerate(axis.values):
        if locus.count[i] < 0:
            rows.append((f"{value:.9g}", "-", "-", "no state", "-", "-"))
            continue
        of = np.where(np.abs(locus.values[:, i]) > locus.least[i], locus.values[:, i], np.nan)
        if not np.any(np.isfinite(of)):
            rows.append((f"{value:.9g}", "0", "-", "-", "-", "-"))
            continue
        b = int(np.nanargmax(of.real))
        mark = "" if locus.converged[b, i] else " not converged"
        frequency, ratio = _numbers(of[b])
        rows.append((f"{value:.9g}", str(locus.count[i]), str(b + 1), f"{of[b].real:.6g}", frequency, ratio + mark))
    yield from aligned(rows, ">" * len(rows[0]))[: MOST_ROWS + 1]
    if len(rows) > MOST_ROWS + 1:
        yield f"... and {len(rows) - 1 - MOST_ROWS} more, which are in the file"


def _modes(name, locus):
    """Yield a line for each mode: family, frequency, damping and largest motions where it is least damped."""
    yield "modes, where they are least damped:"
    turns = () if locus.whirl is None else ("whirl",)
    rows = [("mode", "family", *turns, "damped [Hz]", "damping", f"at {name}", "from", "to [Hz]", "largest motions")]
    for b, values in enumerate(locus.values):
        i, frequency = least_damped(values, locus.least), values.imag / (2.0 * np.pi)
        unsure = int(np.sum(~locus.converged[b]))
        mark = f" (not converged at {unsure} of {np.sum(np.isfinite(values))} values)" if unsure else ""
        rows.append((
            str(b + 1), FAMILIES[locus.families[b, i]], *(_last_whirl(locus.whirl[b]) for _ in turns),
            *_numbers(values[i]), f"{locus.axis.values[i]:.6g}",
            f"{np.nanmin(frequency):.4g}", f"{np.nanmax(frequency):.4g}", locus.motions[b] + mark,
        ))  # fmt: skip
    yield from _aligned(rows)


def _last_whirl(whirls):
    """Return the whirl of a mode at the last value at which it has one, in words."""
    known = whirls[np.isfinite(whirls)]
    return whirl_word(known[-1]) if known.size else "-"


def _families(name, locus):
    """Yield a line for each family: its least damped mode over all values."""
    yield "least damped of each family:"
    rows = [("family", "mode", "damped [Hz]", "damping", f"at {name}")]
    for number in np.unique(locus.families[locus.families >= 0]):
        values = np.where(locus.families == number, locus.values, np.nan).ravel()
        i = least_damped(values, np.broadcast_to(locus.least, locus.values.shape).ravel())
        b, at = np.unravel_index(i, locus.values.shape)
        mark = "" if locus.converged[b, at] else " not converged"
        rows.append((FAMILIES[number], str(b + 1), *_numbers(values[i]), f"{locus.axis.values[at]:.6g}{mark}"))
    yield from _aligned(rows)


def _numbers(value):
    """Return damped frequency [Hz] and damping ratio of an eigenvalue as texts."""
    return f"{value.imag / (2.0 * np.pi):.6g}", f"{round(float(damping(value)), 5) + 0.0:.5f}"


def _aligned(rows):
    """Return the lines of rows of texts aligned to the right, the last column to the left."""
    return aligned(rows, ">" * (len(rows[0]) - 1) + "<")


def _critical(name, locus):
    """Yield a line for each critical value, at which a mode becomes unstable or stable, and for each not refined."""
    for c in locus.critical:
        digits = INSTANT_DIGITS if locus.of_instant(c) else 6
        what = f"oscillates at {c.value.imag / (2 * np.pi):.{digits}g} Hz" if c.value.imag else "diverges"
        side = "above" if c.destabilizes else "below"
        grows = f"mode {c.branch + 1} ({what}) grows {side} it"
        if locus.of_instant(c):
            about = f"critical {name} about {c.place:.{INSTANT_DIGITS}g}"
            yield f"{about}: {grows}, for an instant only: the states there are not steady"
        else:
            yield f"critical {name} {known_digits(c.place, c.error)}: {grows}"
    yield from locus.unrefined


def _resonance_lines(sweep, locus):
    """Yield a line for each value at which a mode has a multiple of the speed of the rotor."""
    orders = ", ".join(f"{order:g}" for order in sweep.orders)
    if not locus.resonances:
        yield f"no mode has {orders} times the speed of '{sweep.rotor}' between these values"
        return
    yield f"modes with {orders} times the speed of '{sweep.rotor}':"
    rows = [("times", "mode", "whirl", sweep.axes[0].name, "speed [rad/s]", "[1/min]", "damped [Hz]", "damping", "")]
    for one in locus.resonances:
        numbers = f"{one.place:.9g}", f"{one.speed:.9g}", f"{one.speed * 30.0 / math.pi:.7g}"
        rows.append((f"{one.order:g}", str(one.branch + 1), whirl_word(one.whirl), *numbers, *_numbers(one.value), ""))
    yield from _aligned(rows)


def known_digits(value: float, error: float) -> str:
    """Return a value with its correct digits, at most 11: half a unit of the last digit is at least the ``error``."""
    if not (value and error):
        return f"{value:.{MOST_DIGITS}g}"
    digits = math.floor(math.log10(abs(value))) - math.ceil(math.log10(2.0 * error)) + 1
    return f"{value:.{min(max(digits, 1), MOST_DIGITS)}g}"


def _unstable_ranges(axis, locus):
    """Return a text on the ranges of values in which some mode grows, and on those in which an oscillation does.

    A slow divergence, such as the capsize of a bicycle, may grow in ranges in which everything that oscillates decays.
    """
    grows, swings = locus.count > 0, (locus.count > 0) & unstable(locus.swinging)
    if not grows.any():
        return f"stable at all values of {axis.name}"
    text = f"unstable at {axis.name} {_ranges(axis, grows)}"
    return f"{text}; oscillations grow at {_ranges(axis, swings)}" if swings.any() and np.any(grows & ~swings) else text


def _ranges(axis, chosen):
    """Return the ranges of values that are ``chosen`` (n,) bool as text."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(int)))
    ends = [dict.fromkeys((f"{axis.values[a]:.6g}", f"{axis.values[b - 1]:.6g}")) for a, b in edges.reshape(-1, 2)]
    return ", ".join(" to ".join(one) for one in ends)
