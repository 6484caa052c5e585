r"""Limit: its input between two limits, the saturation of an actuator, an amplifier or a sensor.

.. math::  y = \min(\max(u, y_{min}), y_{max})

Reaching and leaving a limit are events, at which time steps end. A limit that varies is a formula with ``min`` and
``max``, whose corners are not located; a ``pid`` has limits of its own, which hold its integral, too.
"""

import math

from mecano.constraints.along_coordinate.limits import between_limits, limited, limits_of, write_distances
from mecano.constraints.along_coordinate.signal import OF_INPUT, signal_of_input
from mecano.element_interface import named, record
from mecano.jit.kernel import kernel
from mecano.laws.stops import some_stop
from mecano.maths.dual import number
from mecano.schema import NUMBER, Field

OWN, U = 0, 1  # local unknowns: the value; the input


@kernel
def residual(p, at, f):
    """Add the equation of the value."""
    f[OWN] += number(at.q[OWN]) - limited(p, at, number(at.q[U]))


@kernel
def event_values(p, at, g):
    """Write the distances of the input beyond each limit, and back from it."""
    write_distances(p, at.q[U], g)


LIMIT = signal_of_input(
    "limit", __doc__, Field("lower", NUMBER, OF_INPUT, "least value; none when absent", -math.inf),
    Field("upper", NUMBER, OF_INPUT, "greatest value; none when absent", math.inf),
    dtype=record(lower=(), upper=()),
    **between_limits("the input"),
    same_unit_as=lambda d: d["input"],
    prepare=lambda d, nodes, context: limits_of(d),
    cases=({"lower": -0.05, "upper": 0.1},),
    check=lambda d, nodes: some_stop(d),
    **named(residual, event_values),
)  # fmt: skip
