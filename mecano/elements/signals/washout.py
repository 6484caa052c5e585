r"""Washout: a high-pass filter, which passes changes and removes constant values.

.. math::  y = g\,(u - x), \qquad T \dot x = u - x

x follows the input with the time constant T. With the gain g = 1/T, y is the rate of x, a filtered derivative of u.
"""

import math

from mecano.constraints.along_coordinate.signal import OF_INPUT, VALUE, signal_of_input
from mecano.element_interface import Output, named
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.schema import NUMBER, Field, positive

STATE = Output("state", OF_INPUT, "state x: the input without its changes, in SI units")
OWN, X, U = 0, 1, 2  # local unknowns: the value, the state; the input


@kernel
def residual(p, at, f):
    """Add the equations of value and state."""
    change = number(at.q[U]) - number(at.q[X])
    f[OWN] += number(at.q[OWN]) - p.gain * change
    f[X] += number(at.v[X]) - change / p.time_constant


@kernel
def observe(p, at, F, y, e):
    """Write value and state."""
    y[0], y[1] = at.q[OWN], at.q[X]


def is_rate(d):
    """Return whether the value is the rate of the input: the gain is 1/T."""
    return d["gain"] != 1.0 and math.isclose(d["gain"] * d["time_constant"], 1.0, rel_tol=1e-3)


WASHOUT = signal_of_input(
    "washout", __doc__, Field("time_constant", NUMBER, "s", "time constant T", check=positive),
    Field("gain", NUMBER, "-", "g, the value over a sudden change of the input", 1.0),
    Field("initial_state", NUMBER, OF_INPUT, "x at the start: the input from which changes count", 0.0),
    same_unit_as=lambda d: d["input"] if d["gain"] == 1.0 or is_rate(d) else "",
    power_of_seconds=lambda d: -1.0 if is_rate(d) else 0.0,
    scalars=("value", "state"), states=("state",),
    outputs=(VALUE, STATE),
    start=lambda p: [0.0, p["initial_state"]],
    **named(residual, observe),
)  # fmt: skip
