"""Curves used mainly as functions of time: sine, ramp, step with a smooth edge, exponential."""

import math

import numpy as np

from mecano.jit.kernel import kernel
from mecano.laws.term import ARGUMENT, MOST_SHOWN, OF_A_WAVE, VALUE, Term, along
from mecano.schema import NUMBER, Field, not_negative


@kernel
def sine(a, i, s):
    """Evaluate the term; numbers: amplitude, frequency, phase, offset."""
    w = 2.0 * math.pi * a[i + 1]
    y, d = a[i] * math.sin(w * s + a[i + 2]), a[i] * math.cos(w * s + a[i + 2])
    return y + a[i + 3], w * d, -w * w * y


@kernel
def sine_integral(a, i, s):
    """Return the antiderivative, zero at s = 0."""
    half = math.pi * a[i + 1] * s
    mean = math.sin(half + a[i + 2]) * (math.sin(half) / half if half != 0.0 else 1.0)
    return (a[i] * mean + a[i + 3]) * s


@kernel
def ramp(a, i, s):
    """Evaluate the term; numbers: start, end, from, to; at its corners the slope is that after them."""
    if s < a[i]:
        return a[i + 2], 0.0, 0.0
    if s >= a[i + 1]:
        return a[i + 3], 0.0, 0.0
    slope = (a[i + 3] - a[i + 2]) / (a[i + 1] - a[i])
    return a[i + 2] + slope * (s - a[i]), slope, 0.0


@kernel
def ramp_integral(a, i, s):
    """Return the antiderivative, zero at the start of the ramp."""
    w, length, rise = s - a[i], a[i + 1] - a[i], a[i + 3] - a[i + 2]
    if w <= 0.0:
        return a[i + 2] * w
    if w <= length:
        return w * (a[i + 2] + 0.5 * rise * w / length)
    return a[i + 2] * w + rise * (w - 0.5 * length)


@kernel
def step(a, i, s):
    """Evaluate the term; numbers: time, rise, from, to; the edge is u^3 (10 - 15 u + 6 u^2)."""
    w, rise, jump = s - a[i], a[i + 1], a[i + 3] - a[i + 2]
    if w >= rise:
        return a[i + 3], 0.0, 0.0
    if w <= 0.0:
        return a[i + 2], 0.0, 0.0
    u = w / rise
    y = a[i + 2] + jump * u * u * u * (10.0 - u * (15.0 - 6.0 * u))
    d = jump / rise * 30.0 * u * u * (1.0 - u) * (1.0 - u)
    return y, d, jump / (rise * rise) * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)


@kernel
def step_integral(a, i, s):
    """Return the antiderivative, zero at the start of the edge."""
    w, rise, jump = s - a[i], a[i + 1], a[i + 3] - a[i + 2]
    if w <= 0.0:
        return a[i + 2] * w
    if w >= rise:
        return a[i + 2] * w + jump * (w - 0.5 * rise)
    u = w / rise
    return a[i + 2] * w + jump * rise * u * u * u * u * (2.5 - u * (3.0 - u))


@kernel
def exponential(a, i, s):
    """Evaluate the term; numbers: start, limit, rate, origin."""
    w = s - a[i + 3]
    if w < 0.0:
        return a[i], 0.0, 0.0
    y = (a[i] - a[i + 1]) * math.exp(-a[i + 2] * w)
    return a[i + 1] + y, -a[i + 2] * y, a[i + 2] * a[i + 2] * y


@kernel
def exponential_integral(a, i, s):
    """Return the antiderivative, zero at the origin."""
    w, x = s - a[i + 3], -a[i + 2] * (s - a[i + 3])
    if w < 0.0:
        return a[i] * w
    mean = math.expm1(x) / x if x != 0.0 else 1.0
    return w * (a[i + 1] + (a[i] - a[i + 1]) * mean)


def shape_of_sine(values, low, high):
    """Return equally spaced arguments of a wave, including its extrema; at least one full wave."""
    frequency = values["frequency"]
    if not frequency:
        return []
    part, zero = 1.0 / (OF_A_WAVE * abs(frequency)), -values["phase"] / (2.0 * math.pi * frequency)
    first, count = np.ceil((low - zero) / part), max(OF_A_WAVE, np.ceil((high - low) / part))
    return zero + part * (first + np.arange(min(count, MOST_SHOWN)))


def end_of_edge(time, rise):
    """Return the first time at which the edge is complete, even if time + rise is rounded down."""
    end = time + rise
    return end if end - time >= rise else math.nextafter(end, math.inf)


SINE = Term(
    name="sine", doc="y = offset + amplitude sin(2 pi frequency s + phase).", role="curve",
    fields=(
        Field("amplitude", NUMBER, VALUE, "amplitude"),
        Field("frequency", NUMBER, "1 / unit of the argument", "full waves per unit of the argument: Hz for time"),
        Field("phase", NUMBER, "rad", "phase at the argument zero", 0.0),
        Field("offset", NUMBER, VALUE, "mean value", 0.0),
    ),
    evaluate=sine, integral=sine_integral, shape=shape_of_sine,
    along_line=lambda values, slope, offset: {
        "frequency": values["frequency"] * slope,
        "phase": values["phase"] + 2.0 * math.pi * values["frequency"] * offset,
    },
    frequency=lambda values: abs(values["frequency"]) if values["amplitude"] else 0.0,
)  # fmt: skip

RAMP = Term(
    name="ramp",
    doc="Constant, then a straight line from 'start' to 'end', then constant; with corners at both.",
    role="curve",
    fields=(
        Field("start", NUMBER, ARGUMENT, "where the ramp starts"),
        Field("end", NUMBER, ARGUMENT, "where the ramp ends"),
        Field("from", NUMBER, VALUE, "value before"),
        Field("to", NUMBER, VALUE, "value after"),
    ),
    evaluate=ramp, integral=ramp_integral,
    check=lambda values: [] if values["end"] > values["start"] else ["'end' must be greater than 'start'"],
    along_line=along(places=("start", "end")),
    breakpoints=lambda values: [values["start"], values["end"]],
)  # fmt: skip

STEP = Term(
    name="step",
    doc="From one value to another along a smooth edge, u^3 (10 - 15 u + 6 u^2) with u from 0 to 1, which is C2.",
    role="curve",
    fields=(
        Field("time", NUMBER, ARGUMENT, "where the edge starts"),
        Field("rise", NUMBER, ARGUMENT, "length of the edge; 0 for a jump", check=not_negative),
        Field("from", NUMBER, VALUE, "value before"),
        Field("to", NUMBER, VALUE, "value after"),
    ),
    evaluate=step,
    integral=step_integral,
    along_line=along(places=("time",), lengths=("rise",)),
    shape=lambda values, low, high: values["time"] + values["rise"] * np.linspace(0.0, 1.0, OF_A_WAVE + 1),
    # A smooth edge has no corner, but a time step must not skip it.
    breakpoints=lambda values: sorted({values["time"], end_of_edge(values["time"], values["rise"])}),
)

EXPONENTIAL = Term(
    name="exponential",
    doc="y = limit + (start - limit) exp(-rate (s - origin)) from the origin on, y = start before it.",
    role="curve",
    fields=(
        Field("start", NUMBER, VALUE, "value at the origin and before it"),
        Field("limit", NUMBER, VALUE, "value far beyond the origin", 0.0),
        Field("rate", NUMBER, "1 / unit of the argument", "rate of the approach", check=not_negative),
        Field("origin", NUMBER, ARGUMENT, "where it begins; a corner", 0.0),
    ),
    evaluate=exponential, integral=exponential_integral,
    shape=lambda values, low, high: (  # of a decay to a few thousandths
        values["origin"] + np.linspace(0.0, 6.0, OF_A_WAVE + 1) / values["rate"] if values["rate"] else []
    ),
    along_line=along(places=("origin",), rates=("rate",)),
    breakpoints=lambda values: [values["origin"]],
)  # fmt: skip
