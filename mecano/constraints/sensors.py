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


def _sensor(name, doc, layout, dtype, measured, **memory):
    """Return the Kind of a signal that equals ``measured(p, at)``."""
    row = 3 * len(layout)

    @kernel
    def residual(p, at, f):
        f[row] += number(at.q[row]) - measured(p, at)

    return Kind(name=name, doc=doc, dtype=dtype, layout=layout, residual=residual, **SIGNAL, **memory)


def _sensors(name, what, coordinate):
    """Return the Kinds that sense a coordinate and its rate."""
    value, gradient = counted(coordinate), coordinate.gradient

    @kernel
    def from_zero(p, at):
        return value(p, at) - p.zero

    @kernel
    def rate(p, at):
        return rate_of(gradient(p, at), at.v)

    @kernel
    def commit(p, at, m_out):
        m_out[0] = value(p, at)

    layout, dtype = coordinate.layout, record(**coordinate.axes, zero=())
    memory = {"memory": ("angle",), "commit": commit} if coordinate.periodic else {}
    return (
        _sensor(f"{name}_sensor", f"Sensor of {what}.", layout, dtype, from_zero, **memory),
        _sensor(f"{name}_rate_sensor", f"Sensor of the rate of {what}.", layout, dtype, rate),
    )


@kernel
def _turning(p, at):
    return dot(vec(p.direction, 0), mat(at.R[0]) @ vec(at.v, 0))


SENSORS = {
    TWIST: _sensors("twist", "the twist of two nodes, over any number of turns", TWIST),
    SLIDE: _sensors("slide", "the sliding of a node along an axis fixed in another", SLIDE),
    DISTANCE: _sensors("distance", "the distance between two nodes", DISTANCE),
}
POSITION, VELOCITY = _sensors("place", "the position of a node along a direction", DISPLACEMENT)
ANGULAR_VELOCITY = _sensor(
    "turning_sensor", "Sensor of the angular velocity of a node about an inertial direction.", ("R0",),
    record(direction=3), _turning,
)  # fmt: skip
NODE_SENSORS = {"position": POSITION, "velocity": VELOCITY, "angular_velocity": ANGULAR_VELOCITY}
