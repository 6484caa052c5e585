"""Sensors of a coordinate c and of its rate: a signal y with y - (c - zero) = 0, or y - dc/dt = 0.

A sensor exerts no forces: its equation depends on the motion of the nodes, but their equations do not depend on it. An
angle is continued over full turns with the angle of the last accepted step, kept in memory.
"""

from mecano.constraints.along_coordinate.law import counted
from mecano.constraints.along_coordinate.signal import SIGNAL
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.element_interface import Kind, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number

ZERO = {"zero": ()}
"""Field of the record, after the axes of the coordinate."""


def sensor_kind(name, doc, coordinate):
    """Return the Kind that senses a coordinate."""
    value, row = counted(coordinate), 3 * len(coordinate.layout)

    @kernel
    def residual(p, at, f):
        f[row] += number(at.q[row]) - (value(p, at) - p.zero)

    @kernel
    def commit(p, at, m_out):
        m_out[0] = value(p, at)

    return Kind(
        name=name, doc=doc, dtype=record(**coordinate.axes, **ZERO), layout=coordinate.layout,
        memory=("angle",) if coordinate.periodic else (), commit=commit if coordinate.periodic else None,
        residual=residual, sample=_sample(coordinate), **SIGNAL,
    )  # fmt: skip


def rate_sensor_kind(name, doc, coordinate):
    """Return the Kind that senses the rate of a coordinate."""
    gradient, row = coordinate.gradient, 3 * len(coordinate.layout)

    @kernel
    def residual(p, at, f):
        f[row] += number(at.q[row]) - rate_of(gradient(p, at), at.v)

    return Kind(
        name=name, doc=doc, dtype=record(**coordinate.axes, **ZERO), layout=coordinate.layout,
        residual=residual, sample=_sample(coordinate), **SIGNAL,
    )  # fmt: skip


def _sample(coordinate):
    nodes = len({slot[1] for slot in coordinate.layout})
    return lambda rng: [({**coordinate.sample(rng), "zero": 0.3}, nodes, "")]
