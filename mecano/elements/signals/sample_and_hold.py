r"""Sample and hold: the input at the last sampling time, as in a digital controller.

.. math::  y(t) = u(t_k), \qquad t_k = t_0 + k T \le t < t_k + T

Time steps end at all sampling times, the first of which is the start of the run. In an equilibrium the value is the
input. If 'initial' is given, the value is 'initial' in an equilibrium and in the first period, and the first sample is
taken at t_0 + T. Samples are rounded to whole multiples of the 'resolution', halves upwards, like those of an encoder
or a converter. In an equilibrium, and thus in modes and margins, the input is not rounded.

A quantity that jumps at a sampling time, such as a 'switch', a law of time or another 'sample_and_hold', is sampled
before its jump. If one 'sample_and_hold' reads another of the same period, it is therefore late by one period, like a
controller that needs a period to compute. If it reads its own value, it is a discrete filter or integrator: y(t_k)
depends on y(t_(k-1)).
"""

import math
from dataclasses import replace

import numpy as np

from mecano.constraints.along_coordinate.signal import INITIAL, OF_VALUE, signal_of_input
from mecano.element_interface import named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import constant, number
from mecano.schema import NUMBER, Field, not_negative, positive

OWN, U = 0, 1  # local unknowns: the value; the input
HELD, START, COUNT = range(3)  # in the memory: the value; time of the first sample; number of samples
ROUNDING = 1e-9  # of the period: a step that ends by less before a sampling time ends at it
SAME_TIME = 2.3e-12  # of the time: no step is made between times that are nearer (LEAST_ULPS of time_integration.py)


@kernel
def residual(p, at, f):
    """Add the equation of the value; until the first sample it is the initial one, or that of the input."""
    u = number(at.q[U])
    if at.m[COUNT] != 0.0:
        u = constant(at.m[HELD], u)
    elif p.begins != 0.0:
        u = constant(p.initial, u)
    f[OWN] += number(at.q[OWN]) - u


@kernel
def commit(p, at, m_out):
    """Write the held value, sampled if the step ends at a sampling time, and the number of samples."""
    starts = at.m[COUNT] == 0.0
    if starts:
        m_out[START] = at.t
    following = at.m[START] + at.m[COUNT] * p.period  # a sum of periods would drift from 'sampling_times'
    if starts or at.t >= following - (ROUNDING * p.period + SAME_TIME * abs(at.t)):
        value = at.q[OWN] if starts else at.q[U]
        m_out[HELD] = value if starts and p.begins != 0.0 else rounded(value, p.resolution)
        m_out[COUNT] = at.m[COUNT] + 1.0


@kernel
def rounded(u, resolution):
    """Return the multiple of the ``resolution`` that is nearest to u; u itself if that is zero."""
    return math.floor(u / resolution + 0.5) * resolution if resolution > 0.0 else u


def prepare(d, nodes, context):
    """Return period, resolution and initial value, and whether there is one."""
    initial = d["initial"]
    return {
        "period": d["period"], "resolution": d["resolution"],
        "initial": initial or 0.0, "begins": 0.0 if initial is None else 1.0,
    }  # fmt: skip


def sampling_times(d, start, end):
    """Return the sampling times [s] after the start."""
    return (start + d["period"] * np.arange(1, int((end - start) / d["period"]) + 1)).tolist()


SAMPLE_AND_HOLD = signal_of_input(
    "sample_and_hold", __doc__, Field("period", NUMBER, "s", "T, time between two samples", check=positive),
    replace(
        INITIAL,
        default=None,
        doc="value in the first period, and in an equilibrium; that of the input when absent",
    ),
    Field(
        "resolution", NUMBER, OF_VALUE, "samples are rounded to whole multiples of it; 0: not at all", 0.0,
        check=not_negative,
    ),
    jumps=lambda d: True,
    dtype=record(period=(), resolution=(), initial=(), begins=()),
    same_unit_as=lambda d: d["input"],
    memory=("held", "start", "count"),
    reads_past=True,
    **named(residual, commit, prepare, sampling_times),
)  # fmt: skip
