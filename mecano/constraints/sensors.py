"""Sensors of coordinates (one for the value, one for the rate) and of the motion of nodes.

A sensor of a coordinate c is a signal y with y - (c - zero) = 0, or y - dc/dt = 0. It exerts no forces: its equation
depends on the motion of the nodes, but their equations do not depend on it. An angle is continued over full turns with
the angle of the last accepted step, kept in memory.
"""

from mecano.constraints.along_coordinate.law import counted
from mecano.constraints.along_coordinate.signal import SIGNAL
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.constraints.coordinates.displacement import DISPLACEMENT
from mecano.constraints.coordinates.distance import DISTANCE
from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.twist import TWIST
from mecano.element_interface import Kind, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.vector import dot, mat, vec

ZERO = {"zero": ()}
"""Field of the record, after the axes of the coordinate."""


def _sensor(name, doc, coordinate):
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


def _rate_sensor(name, doc, coordinate):
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


@kernel
def _velocity(p, at, f):
    f[3] += number(at.q[3]) - dot(vec(p.direction, 0), vec(at.v, 0))


@kernel
def _turning(p, at, f):
    f[3] += number(at.q[3]) - dot(vec(p.direction, 0), mat(at.R[0]) @ vec(at.v, 0))


def _of_node(name, doc, slot, residual):
    """Return the Kind of a sensor of the motion of a node along an inertial direction."""
    return Kind(
        name=name, doc=doc, dtype=record(direction=3), layout=(slot,), residual=residual,
        sample=lambda rng: [({"direction": rng.normal(size=3)}, 1, "")], **SIGNAL,
    )  # fmt: skip


def _sensors(name, what, coordinate):
    return (
        _sensor(f"{name}_sensor", f"Sensor of {what}.", coordinate),
        _rate_sensor(f"{name}_rate_sensor", f"Sensor of the rate of {what}.", coordinate),
    )


SENSORS = {
    TWIST: _sensors("twist", "the twist of two nodes, over any number of turns", TWIST),
    SLIDE: _sensors("slide", "the sliding of a node along an axis fixed in another", SLIDE),
    DISTANCE: _sensors("distance", "the distance between two nodes", DISTANCE),
}
PLACE_SENSOR = _sensor("place_sensor", "Sensor of the position of a node along a direction.", DISPLACEMENT)
VELOCITY_SENSOR = _of_node("velocity_sensor", "Sensor of the velocity of a node along a direction.", "x0", _velocity)
TURNING_SENSOR = _of_node("turning_sensor", "Sensor of the angular velocity of a node.", "R0", _turning)
NODE_SENSORS = {"position": PLACE_SENSOR, "velocity": VELOCITY_SENSOR, "angular_velocity": TURNING_SENSOR}
