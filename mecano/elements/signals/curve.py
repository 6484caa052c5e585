r"""Curve: a law of its input, such as a table of commands over time, a characteristic, a gain that varies.

.. math::  y = c(u)

``slope`` is dc/du. With the input ``time`` it is the rate of a path, for example for a feedforward.

With the input ``time``, or an increasing linear function of it such as ``20*time - 3``, the curve is a law of time,
which may prescribe a motion. Steps end at its breakpoints, also with other inputs that depend on the time alone. With
any other input, its breakpoints are corners of the signal, at which no step ends.
"""

from mecano.constraints.along_coordinate.signal import OF_SLOPE, VALUE, signal_of_input
from mecano.element_interface import Output, named
from mecano.jit.kernel import kernel
from mecano.laws.formula import read_formula
from mecano.laws.law_table import breakpoints, curve, curve_and_slope
from mecano.laws.probe import corners, places_of_jumps
from mecano.laws.term import VALUE as VALUE_UNIT
from mecano.maths.dual import number
from mecano.schema import CURVE as CURVE_LAW
from mecano.schema import Field

SLOPE = Output("slope", OF_SLOPE, "dc/du; the rate, if the input is the time")
OWN, U = 0, 1  # local unknowns: the value; the input


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    f[OWN] += number(at.q[OWN]) - curve(at.laws, p.law, number(at.q[U]))


@kernel
def observe(p, at, F, y, e):
    """Write the value and the slope of the law."""
    _, slope = curve_and_slope(at.laws, p.law, number(at.q[U]))
    y[0], y[1] = at.q[OWN], slope


def times(d, start, end):
    """Return the times [s] at which an input that depends on the time alone passes the breakpoints of the law."""
    places, text = breakpoints(d["law"]), d["input"].strip()
    if text == "time" or not places:
        return [t for t in places if start < t < end]
    formula = read_formula(text)
    if formula.references or not formula.depends_on_time:
        return []
    from mecano.laws.formula_corners import crossings  # few runs need it

    return crossings(formula.program, places, start, end)


TABLE = {"points": [(-2.0, 0.5), (0.0, 1.0), (2.0, 4.0)], "interpolation": "cubic", "beyond": "hold"}  # of samples

CURVE = signal_of_input(
    "curve", __doc__,
    Field("law", CURVE_LAW, VALUE_UNIT, "c, the value as a function of the input, both in SI units"),
    outputs=(VALUE, SLOPE),
    jumps=lambda d: bool(places_of_jumps(d["law"])),
    output_jumps=lambda d, output: output == SLOPE.name and bool(corners(d["law"])),
    cases=tuple({"law": (term,)} for term in (("table", TABLE), ("polynomial", {"coefficients": [1.0, 0.3, 2.0]}))),
    **named(residual, observe, times),
)  # fmt: skip
