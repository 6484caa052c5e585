"""Curves used mainly as road profiles: a bump, and a random road of given spectrum, which may begin flat."""

import math

import numpy as np

from mecano.jit.kernel import kernel
from mecano.laws.term import ARGUMENT, DENSITY, MOST_SHOWN, OF_A_WAVE, VALUE, Term, along
from mecano.schema import INTEGER, NUMBER, Field, not_negative, positive, requirement


@kernel
def bump(a, i, s):
    """Evaluate the term; numbers: start, length, height."""
    w, k = s - a[i], 2.0 * math.pi / a[i + 1]
    if w <= 0.0 or w >= a[i + 1]:
        return 0.0, 0.0, 0.0
    half = 0.5 * a[i + 2]
    return half * (1.0 - math.cos(k * w)), half * k * math.sin(k * w), half * k * k * math.cos(k * w)


@kernel
def bump_integral(a, i, s):
    """Return the antiderivative, zero before the bump."""
    w, k = min(max(s - a[i], 0.0), a[i + 1]), 2.0 * math.pi / a[i + 1]
    return 0.5 * a[i + 2] * (w - math.sin(k * w) / k)


@kernel
def waves(a, i, s):
    """Evaluate the term; numbers: start and length of the lead-in, count, then those of each wave.

    A wave has amplitude, angular frequency and phase. In the lead-in waves are multiplied by (1 - cos)/2.
    """
    x, lead = s - a[i], a[i + 1]
    y, d, h = 0.0, 0.0, 0.0
    if lead > 0.0 and x <= 0.0:
        return y, d, h
    for j in range(int(a[i + 2])):
        A, w, phase = a[i + 3 + 3 * j], a[i + 4 + 3 * j], a[i + 5 + 3 * j]
        c, s_ = math.cos(w * s + phase), math.sin(w * s + phase)
        y, d, h = y + A * c, d - A * w * s_, h - A * w * w * c
    if lead <= 0.0 or x >= lead:
        return y, d, h
    k = math.pi / lead
    part, slope, bend = 0.5 - 0.5 * math.cos(k * x), 0.5 * k * math.sin(k * x), 0.5 * k * k * math.cos(k * x)
    return part * y, part * d + slope * y, part * h + 2.0 * slope * d + bend * y


@kernel
def waves_integral(a, i, s):
    """Return the antiderivative, zero at s = 0, or before the lead-in."""
    start, lead, total = a[i], a[i + 1], 0.0
    x = min(max(s - start, 0.0), lead)
    for j in range(int(a[i + 2])):
        A, w, phase = a[i + 3 + 3 * j], a[i + 4 + 3 * j], a[i + 5 + 3 * j]
        if lead > 0.0:  # (1 - cos k x)/2 times a wave is a sum of three waves
            k, phase = math.pi / lead, phase + w * start
            total += A * (0.5 * area(w, phase, x) - 0.25 * (area(w + k, phase, x) + area(w - k, phase, x)))
            total += A * area(w, phase + w * x, max(s - start - x, 0.0))
        else:
            total += A / w * (math.sin(w * s + phase) - math.sin(phase))
    return total


@kernel
def area(w, phase, x):
    """Return the integral of cos(w x + phase) from 0 to x, also for w = 0."""
    half = 0.5 * w * x
    return x * math.cos(half + phase) * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)


def pack_random(values):
    """Return waves at the geometric means of geometric bands, with the mean square of the band, and random phases."""
    low, high, n = values["lowest"], values["highest"], values["waves"]
    edges = low * (high / low) ** (np.arange(n + 1) / n)
    frequency = np.sqrt(edges[:-1] * edges[1:])
    square = values["density"] * (frequency / values["reference"]) ** -values["exponent"] * np.diff(edges)
    phase = np.random.default_rng(values["seed"]).uniform(0.0, 2.0 * math.pi, n)
    phase -= 2.0 * math.pi * frequency * values["origin"]
    numbers = np.stack([np.sqrt(2.0 * square), 2.0 * math.pi * frequency, phase], axis=1)
    return [values["start"], values["lead_in"], n, *numbers.ravel()]


def shape_of_bump(values, low, high):
    """Return equally spaced arguments of the bump, from just after its start to just before its end."""
    start, end = values["start"], values["start"] + values["length"]
    return np.linspace(np.nextafter(start, end), np.nextafter(end, start), OF_A_WAVE + 1)


def shape_of_random(values, low, high):
    """Return arguments spaced by equal parts of the shortest wave."""
    part = 1.0 / (OF_A_WAVE * values["highest"])
    return low + part * np.arange(min(math.ceil((high - low) / part) + 1, MOST_SHOWN))


BUMP = Term(
    name="bump",
    doc="A single bump y = (height/2) (1 - cos(2 pi (s - start)/length)), zero outside; without corners.",
    role="curve",
    fields=(
        Field("start", NUMBER, ARGUMENT, "where the bump begins"),
        Field("length", NUMBER, ARGUMENT, "its length", check=positive),
        Field("height", NUMBER, VALUE, "its height; negative for a dip"),
    ),
    evaluate=bump, integral=bump_integral, shape=shape_of_bump,
    along_line=along(places=("start",), lengths=("length",)),
    breakpoints=lambda values: [values["start"], values["start"] + values["length"]],
    landmarks=lambda values: [values["start"] + 0.5 * values["length"]],
)  # fmt: skip

PER_ARGUMENT = "1 / unit of the argument"
RANDOM = Term(
    name="random",
    doc=(
        "A random road: a sum of cosines whose power spectral density is G(n) = density (n/reference)^-exponent for "
        "frequencies n from 'lowest' to 'highest' (ISO 8608: reference 0.1/m, exponent 2), the same for the same seed."
    ),
    role="curve",
    fields=(
        Field(
            "density", NUMBER, DENSITY, "one-sided density at 'reference'",
            check=not_negative,
        ),
        Field("reference", NUMBER, PER_ARGUMENT, "frequency at which the density is given, in waves", 0.1, positive),
        Field("exponent", NUMBER, "-", "exponent of the decrease of the density with frequency", 2.0),
        Field("lowest", NUMBER, PER_ARGUMENT, "lowest frequency", 0.011, positive),
        Field("highest", NUMBER, PER_ARGUMENT, "highest frequency", 2.83, positive),
        Field("waves", INTEGER, "-", "number of cosines", 100,
              requirement(lambda n: 1 <= n <= 2000, "must lie between 1 and 2000")),
        Field("seed", INTEGER, "-", "seed of the random phases", 1, not_negative),
        Field("lead_in", NUMBER, ARGUMENT, "length of the smooth rise from a flat road; none when absent", 0.0,
              not_negative),
        Field("start", NUMBER, ARGUMENT, "where the lead-in begins: flat before", 0.0),
        Field("origin", NUMBER, ARGUMENT, "by how much the waves are shifted: the same road, met later", 0.0),
    ),
    pack=pack_random,
    evaluate=waves,
    integral=waves_integral,
    shape=shape_of_random,
    along_line=along(("start", "origin"), ("density", "lead_in"), ("reference", "lowest", "highest")),
    frequency=lambda values: values["highest"] if values["density"] else 0.0,
    breakpoints=lambda values: [values["start"], values["start"] + values["lead_in"]] if values["lead_in"] else [],
    check=lambda values: [] if values["highest"] > values["lowest"] else ["'highest' must be greater than 'lowest'"],
)  # fmt: skip
