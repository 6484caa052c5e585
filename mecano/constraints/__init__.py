"""The basic constraints of which joints are made; see orthogonal.py for the shortest complete one."""

from mecano.constraints.distance import DISTANCE
from mecano.constraints.held_coordinate import HELD_COORDINATE
from mecano.constraints.in_plane import IN_PLANE
from mecano.constraints.orthogonal import ORTHOGONAL
from mecano.constraints.relative_angle import RELATIVE_ANGLE
from mecano.constraints.rigid_offset import RIGID_OFFSET

CONSTRAINTS = {
    kind.name: kind for kind in (DISTANCE, HELD_COORDINATE, IN_PLANE, ORTHOGONAL, RELATIVE_ANGLE, RIGID_OFFSET)
}
