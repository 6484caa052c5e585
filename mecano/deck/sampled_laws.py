"""Warnings of laws and formulas of time whose waves are too short for the steps of a run.

A wave that is sampled less often than about four times a period acts with another amplitude and frequency, in an
extreme case as a constant, and no error estimate notices.
"""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from mecano.deck.laws_of_time import uses_of_time
from mecano.element_interface import Kind
from mecano.errors import LocatedWarning
from mecano.laws import TERMS
from mecano.laws.formula import phase_rate, phases_of_time, read_formula
from mecano.laws.formula_rate import LONGEST
from mecano.schema import Values

LEAST, ENOUGH = 4.0, 20.0  # steps per period; a fortieth of the amplitude is lost between 20 samples
ROUNDING = 1e-6  # of a step, so that exactly four steps a period are enough
INSTANTS = 5  # of a run, at which the frequency of a wave in a formula is looked at


def unsampled(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on waves of time with fewer than ``LEAST`` steps a period, one for all uses of a law.

    ``values`` are those of a checked deck, ``kinds`` is {name: Kind} of all elements.
    """
    time = values["time"]
    if not time:
        return
    step, key = longest_step(time)
    found: dict[int, tuple[float, tuple[str, ...], str, list[str]]] = {}  # frequency, path, first use, all uses
    for owner, path, value in uses_of_time(values, kinds):
        frequency = _frequency(value, time)
        if LEAST * frequency * step > 1.0 + ROUNDING:
            found.setdefault(id(value), (frequency, path, owner, []))[3].append(owner)
    for frequency, path, owner, owners in found.values():
        more = f" (and {len(owners) - 1} more uses)" if len(owners) > 1 else ""
        text = (
            f"{owner}: {'.'.join(path[2:])!r} oscillates at {frequency:.4g} Hz, but steps of {step:g} s ({key}) "
            f"sample it only {1.0 / (frequency * step):.3g} times per period{more}, so the motion will differ; "
            f"{1.0 / (LEAST * frequency):.3g} s is the longest step that samples it {LEAST:g} times, "
            f"{1.0 / (ENOUGH * frequency):.3g} s resolves it"
        )
        yield path, text


def longest_step(time: Values) -> tuple[float, str]:
    """Return the longest step [s] that no error estimate shortens, and the key of the deck that gives it.

    An adaptive run without 'maximum_step' lengthens its first step only as long as it sees small errors.
    """
    longest = time["adaptive"] and time["adaptive"]["maximum_step"]
    if isinstance(longest, float):
        return longest, "time.adaptive.maximum_step"
    return time["step"], "time.step, the first step" if time["adaptive"] else "time.step"


def _frequency(value, time):
    """Return the highest frequency [Hz] of the waves of a checked law or formula of time; 0 without any."""
    if not isinstance(value, str):
        return max((TERMS[name].frequency(values) for name, values in value), default=0.0)
    phases, times = phases_of_time(read_formula(value, LONGEST)), np.linspace(time["start"], time["end"], INSTANTS)
    return max((phase_rate(phase, t) for phase in phases for t in times), default=0.0) / (2.0 * math.pi)
