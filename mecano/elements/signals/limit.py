r"""Limit: its input between two limits, the saturation of an actuator, an amplifier or a sensor.

.. math::  y = \min(\max(u, y_{min}), y_{max})

Reaching and leaving a limit are events, at which time steps end. A limit that varies is a formula with ``min`` and
``max``, whose corners are not located; a ``pid`` has limits of its own, which hold its integral, too.
"""

import math

from mecano.constraints.along_coordinate.signal import OF_INPUT, signal_of_input
from mecano.element_interface import Event, named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number, select
from mecano.schema import NUMBER, Field

LOWER, WITHIN, UPPER = range(3)
OWN, U = 0, 1  # local unknowns: the value; the input
NONE = 1e300  # no limit


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    y = select(at.phase == WITHIN, number(at.q[U]), select(at.phase == UPPER, p.upper, p.lower))
    f[OWN] += number(at.q[OWN]) - y


@kernel
def event_values(p, at, g):
    """Write the distances of the input beyond each limit, and back from it."""
    u = at.q[U]
    g[0], g[1] = u - p.upper, p.upper - u
    g[2], g[3] = p.lower - u, u - p.lower


def check(d, nodes):
    """Return errors for limits in the wrong order, or none at all."""
    if math.isinf(d["lower"]) and math.isinf(d["upper"]):
        return ["give 'lower', 'upper' or both"]
    return [] if d["lower"] < d["upper"] else ["'lower' must be less than 'upper'"]


LIMIT = signal_of_input(
    "limit",
    __doc__,
    Field("lower", NUMBER, OF_INPUT, "least value; none when absent", -math.inf),
    Field("upper", NUMBER, OF_INPUT, "greatest value; none when absent", math.inf),
    dtype=record(lower=(), upper=()),
    phases=("lower", "within", "upper"),
    at_start=lambda p: WITHIN,
    events=(
        Event("upper limit", "within", "upper", "the input rises to the upper limit"),
        Event("upper limit left", "upper", "within", "the input falls from the upper limit"),
        Event("lower limit", "within", "lower", "the input falls to the lower limit"),
        Event("lower limit left", "lower", "within", "the input rises from the lower limit"),
    ),
    same_unit_as=lambda d: d["input"],
    prepare=lambda d, nodes, context: {"lower": max(d["lower"], -NONE), "upper": min(d["upper"], NONE)},
    sample=lambda rng: [
        ({"input": "a", "lower": -0.05, "upper": 0.1}, 1, phase) for phase in ("lower", "within", "upper")
    ],
    **named(check, residual, event_values),
)
