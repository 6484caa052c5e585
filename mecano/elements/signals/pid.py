r"""PID controller with limits and anti-windup.

With the input e, the control error,

.. math::
   u = K_P\, e + x_I + \frac{K_D}{T_D} (e - x_D), \qquad y = \min(\max(u, y_{min}), y_{max}),

.. math::
   \dot x_I = K_I\, e + (y - u)/T_t, \qquad T_D\, \dot x_D = e - x_D

The derivative is filtered with the time constant :math:`T_D`, from :math:`x_D = 0` at the start: an error there counts
as a sudden one. At a limit the integral is reset with the tracking time :math:`T_t` (back-calculation; Astrom &
Hagglund, Advanced PID Control, 2006, section 3.5), so that the controller leaves the limit soon after the error changes
its sign. A part without a gain has no state. Reaching and leaving a limit are events.
"""

import math
from dataclasses import replace
from functools import cache

from mecano.constraints.along_coordinate.limits import between_limits, limited, limits_of, write_distances
from mecano.constraints.along_coordinate.signal import INITIAL, OF_INPUT, OF_VALUE, VALUE, signal_of_input
from mecano.element_interface import Output, named, record
from mecano.jit.kernel import kernel
from mecano.laws.stops import lower_below_upper
from mecano.maths.dual import number
from mecano.schema import NUMBER, Field, positive

RECORD = record(
    proportional=(), integral=(), derivative=(), derivative_time=(), lower=(), upper=(), tracking_time=(), initial=(),
    at_integral="i", at_filtered="i", at_input="i",
)  # fmt: skip
"""Gains, times, limits; local indices of the states x_I and x_D, or -1, and of the input. The value is unknown 0."""
STATES = (
    Output("integral", OF_VALUE, "integral x_I, in SI units; zero without an integral gain"),
    Output("filtered", OF_INPUT, "filtered error x_D, in SI units; zero without a derivative gain"),
)


@kernel
def observe(p, at, F, y, e):
    """Write value and states."""
    y[0] = at.q[0]
    if p.at_integral >= 0:
        y[1] = at.q[p.at_integral]
    if p.at_filtered >= 0:
        y[2] = at.q[p.at_filtered]


@kernel
def demanded(p, at):
    """Return the unlimited demand u, and the difference e - x_D."""
    e = number(at.q[p.at_input])
    u, change = p.proportional * e, 0.0 * e
    if p.at_integral >= 0:
        u = u + number(at.q[p.at_integral])
    if p.at_filtered >= 0:
        change = e - number(at.q[p.at_filtered])
        u = u + p.derivative / p.derivative_time * change
    return u, change


@kernel
def residual(p, at, f):
    """Add the equations of the value and of the states."""
    u, change = demanded(p, at)
    y = limited(p, at, u)
    f[0] += number(at.q[0]) - y
    if p.at_integral >= 0:
        rate = p.integral * number(at.q[p.at_input]) + (y - u) / p.tracking_time
        f[p.at_integral] += number(at.v[p.at_integral]) - rate
    if p.at_filtered >= 0:
        f[p.at_filtered] += number(at.v[p.at_filtered]) - change / p.derivative_time


@kernel
def event_values(p, at, g):
    """Write the distances of the demand beyond each limit, and back from it."""
    write_distances(p, demanded(p, at)[0], g)


def prepare(d, nodes, context):
    """Return the record of a controller."""
    scalars = _scalars(d)
    places = {f"at_{name}": scalars.index(name) if name in scalars else -1 for name in ("integral", "filtered")}
    gains = {name: d[name] for name in ("proportional", "integral", "derivative", "initial")}
    return {
        **gains, **places, **limits_of(d), "at_input": len(scalars),
        "derivative_time": d["derivative_time"] or 1.0, "tracking_time": _tracking_time(d),
    }  # fmt: skip


def _tracking_time(d):
    """Return the tracking time [s]: as given, or proportional over integral gain, or 1 s."""
    if d["tracking_time"] is not None:
        return d["tracking_time"]
    return d["proportional"] / d["integral"] if d["proportional"] and d["integral"] else 1.0


def _scalars(d):
    return ("value", *("integral",) * bool(d["integral"]), *("filtered",) * bool(d["derivative"]))


@cache
def _with(scalars):
    return replace(
        PID, scalars=scalars, states=scalars[1:], variant=None, start=_start_integral if "integral" in scalars else None
    )


def _start_integral(p):
    values = [0.0, p["initial"], 0.0]
    return values[: 2 + (p["at_filtered"] >= 0)]


def check(d, nodes):
    """Return errors: limits in the wrong order, a derivative without a time, an initial value without an integral."""
    found = lower_below_upper(d)
    if d["derivative"] and d["derivative_time"] is None:
        found.append("'derivative' needs 'derivative_time', the time constant of its filter")
    if d["initial"] and not d["integral"]:
        found.append("'initial' is the initial value of the integral: it needs 'integral', the gain")
    return found


def without_effect(d):
    """Return the times of a derivative without gain, and of an integral without gain or limits."""
    if d["derivative_time"] is not None and not d["derivative"]:
        yield "derivative_time", "the gain 'derivative' is zero"
    if d["tracking_time"] is not None and not d["integral"]:
        yield "tracking_time", "the gain 'integral' is zero"
    elif d["tracking_time"] is not None and d["lower"] == -math.inf and d["upper"] == math.inf:
        yield "tracking_time", "without 'lower' and 'upper' the integral is not reset"


LIMITS = {"lower": -0.05, "upper": 0.1}  # of samples

PID = signal_of_input(
    "pid", __doc__, Field("proportional", NUMBER, "-", "K_P", 0.0),
    Field("integral", NUMBER, "-", "K_I, per second", 0.0), Field("derivative", NUMBER, "-", "K_D, times seconds", 0.0),
    Field("derivative_time", NUMBER, "s", "T_D of the filter of the derivative", None, positive),
    Field("lower", NUMBER, OF_VALUE, "lower limit of the value; none when absent", -math.inf),
    Field("upper", NUMBER, OF_VALUE, "upper limit of the value; none when absent", math.inf),
    Field(
        "tracking_time", NUMBER, "s",
        "T_t of the reset of the integral at a limit; when absent K_P/K_I, or 1 s if either is zero", None, positive,
    ),
    replace(INITIAL, doc="integral x_I at the start"),
    dtype=RECORD,
    **between_limits("the demand"),
    outputs=(VALUE, *STATES),
    variant=lambda d: _with(_scalars(d)),
    cases=(
        {**LIMITS, "derivative_time": 0.2, "tracking_time": 0.4},
        {**LIMITS, "integral": 0.0, "derivative": 0.0, "initial": 0.0},
        {**LIMITS, "proportional": 0.0, "derivative": 0.0},
    ),
    **named(prepare, check, without_effect, residual, observe, event_values),
)  # fmt: skip
