"""Sensors of coordinates (one for the value, one for the rate) and of the motion of nodes."""

from mecano.constraints.along_coordinate.sense import rate_sensor_kind, sensor_kind
from mecano.constraints.along_coordinate.signal import SIGNAL
from mecano.constraints.coordinates.displacement import DISPLACEMENT
from mecano.constraints.coordinates.distance import DISTANCE
from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.twist import TWIST
from mecano.element_interface import Kind, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import number
from mecano.maths.vector import dot, mat, vec


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
        sensor_kind(f"{name}_sensor", f"Sensor of {what}.", coordinate),
        rate_sensor_kind(f"{name}_rate_sensor", f"Sensor of the rate of {what}.", coordinate),
    )


SENSORS = {
    TWIST: _sensors("twist", "the twist of two nodes, over any number of turns", TWIST),
    SLIDE: _sensors("slide", "the sliding of a node along an axis fixed in another", SLIDE),
    DISTANCE: _sensors("distance", "the distance between two nodes", DISTANCE),
}
PLACE_SENSOR = sensor_kind("place_sensor", "Sensor of the position of a node along a direction.", DISPLACEMENT)
VELOCITY_SENSOR = _of_node("velocity_sensor", "Sensor of the velocity of a node along a direction.", "x0", _velocity)
TURNING_SENSOR = _of_node("turning_sensor", "Sensor of the angular velocity of a node.", "R0", _turning)
NODE_SENSORS = {"position": PLACE_SENSOR, "velocity": VELOCITY_SENSOR, "angular_velocity": TURNING_SENSOR}
