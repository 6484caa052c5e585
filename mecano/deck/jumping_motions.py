"""Warnings of prescribed motions whose value, rate or second rate jumps in a run.

A jump of the rate is a shock: the impulse that it takes is in no output, so the largest force or moment of the drive is
too small. At a jump of the value it is infinite, and the motion depends on the steps. A monotone cubic table has jumps
of the acceleration at its points, and with it of the forces.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from mecano.element_interface import Kind
from mecano.errors import LocatedWarning
from mecano.laws.law_table import breakpoints
from mecano.laws.probe import JUMP, curve_values
from mecano.schema import MOTION, Values

STRAIGHT = 2  # points of a table that is a straight line
NEAR = 1e-9  # of a time, on both sides of which values and rates are compared


def jumping_motions(values: Values, kinds: Mapping[str, Kind]) -> Iterator[LocatedWarning]:
    """Yield (path, text) on prescribed motions that jump within a run.

    ``values`` are those of a checked deck, ``kinds`` is {name: Kind} of all elements. The rate at the start is no jump:
    the run starts with it.
    """
    time = values["time"]
    for name, d in values["joints"].items() if time else ():
        for path, unit, law in _motions(kinds[d["type"]].fields, d, ()):
            inner = np.array([t for t in breakpoints(law) if time["start"] < t < time["end"]])
            if text := _described(law, inner, unit) or _of_cubics(law):
                yield ("joints", name, *path), f"{d['type']} '{name}': '{'.'.join(path)}' {text}"


def _motions(fields, values, path):
    """Yield (path, unit, law) of the motions among checked values that are laws of time."""
    for field in fields:
        value = values[field.name]
        if field.type == MOTION and isinstance(value, tuple):
            yield (*path, field.name), field.unit, value
        elif field.type.name == "mapping" and value is not None:
            yield from _motions(field.type.options, value, (*path, field.name))


def _described(law, places, unit):
    """Return a text on the largest jump of a law at one of the ``places``, of its value or else of its rate; or ""."""
    if len(places):
        for order, text in enumerate((_of_value, _of_rate)):
            if found := _largest_jump(law, places, order):
                return text(found[0], found[1], unit)
    return ""


def _of_cubics(law):
    """Return a text on a table of a law that is a monotone cubic; "" if there is none."""
    cubics = [term for name, term in law if name == "table" and term["interpolation"] == "cubic"]
    if not any(len(term["points"]) > STRAIGHT for term in cubics):
        return ""
    return (
        "is a table with the default interpolation, a monotone cubic, whose acceleration jumps at each point, and with "
        "it the forces, by a multiple of themselves; write 'interpolation: spline'"
    )


def _largest_jump(law, places, order):
    """Return the largest jump of the derivative of this ``order`` and its time, or None without one."""
    step = NEAR * (1.0 + np.abs(places))
    before, after = curve_values(law, places - step), curve_values(law, places + step)
    jump = after[:, order] - before[:, order]
    smooth = step * (np.abs(after[:, order + 1]) + np.abs(before[:, order + 1]))
    jump[np.abs(jump) <= JUMP + smooth] = 0.0
    largest = int(np.argmax(np.abs(jump)))
    return (jump[largest], places[largest]) if jump[largest] else None


def _of_value(jump, t, unit):
    return (
        f"jumps by {jump:g} {unit} at {t:g} s: no force moves a mass so fast, and the motion after it depends on the "
        "steps; give a 'step' a 'rise'"
    )


def _of_rate(jump, t, unit):
    return (
        f"has a rate that jumps by {jump:g} {unit}/s at {t:g} s: a shock, whose impulse is in no output; the "
        "rates of a 'step' with a 'rise' and, up to its ends, of a 'table' with 'interpolation: spline' do not jump"
    )
