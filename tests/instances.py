"""Kinds for the tests that every one of them must pass."""

from mecano.constraints.gear_mesh import GEAR_MESH
from mecano.constraints.geared_slide import GEARED_SLIDE
from mecano.constraints.of_coordinates import (
    ANGLE_LATCH,
    ANGLE_STOP,
    DISTANCE,
    DRIVEN_SLIDE,
    HELD_COORDINATE,
    IN_PLANE,
    LEVEL_AXIS,
    ORTHOGONAL,
    RELATIVE_ANGLE,
    SAME_ANGLE,
    SAME_DISTANCE,
    SLIDE_LATCH,
    SLIDE_STOP,
)  # fmt: skip
from mecano.constraints.release import until_released
from mecano.constraints.rigid_offset import RIGID_OFFSET
from mecano.constraints.rolling import ROLLING
from mecano.constraints.rolling_radius import ROLLING_RADIUS
from mecano.constraints.sensors import NODE_SENSORS, SENSORS
from mecano.constraints.wound_line import CATCH
from mecano.elements import KINDS
from mecano.elements.wheels.cardona_wheel import UPRIGHT_ROLLING

CONSTRAINTS = {
    kind.name: kind
    for kind in (
        DISTANCE, DRIVEN_SLIDE, HELD_COORDINATE, IN_PLANE, LEVEL_AXIS, ORTHOGONAL, RELATIVE_ANGLE, SAME_ANGLE,
        RIGID_OFFSET, GEARED_SLIDE, GEAR_MESH,
        ROLLING, ROLLING_RADIUS, UPRIGHT_ROLLING, ANGLE_LATCH, ANGLE_STOP, SLIDE_LATCH, SLIDE_STOP, CATCH,
        *(kind for pair in SENSORS.values() for kind in pair), *NODE_SENSORS.values(), 
        *map(until_released, (IN_PLANE, ORTHOGONAL, SAME_ANGLE, SAME_DISTANCE, RIGID_OFFSET, GEARED_SLIDE)),
    )
}  # fmt: skip
ALL_KINDS = {**KINDS, **CONSTRAINTS}
