"""The basic constraints of which joints are made; see orthogonal.py for the shortest complete one."""

from mecano.constraints.angle_stops import ANGLE_LATCH, ANGLE_STOP
from mecano.constraints.blade import BLADE
from mecano.constraints.distance import DISTANCE
from mecano.constraints.gear_mesh import GEAR_MESH
from mecano.constraints.geared_slide import GEARED_SLIDE
from mecano.constraints.held_coordinate import HELD_COORDINATE
from mecano.constraints.in_plane import IN_PLANE
from mecano.constraints.level_axis import LEVEL_AXIS
from mecano.constraints.orthogonal import ORTHOGONAL
from mecano.constraints.relative_angle import RELATIVE_ANGLE
from mecano.constraints.rigid_offset import RIGID_OFFSET
from mecano.constraints.rolling import ROLLING
from mecano.constraints.rolling_radius import ROLLING_RADIUS
from mecano.constraints.slide_stops import SLIDE_LATCH, SLIDE_STOP
from mecano.constraints.upright_rolling import UPRIGHT_ROLLING
from mecano.constraints.wound_line import CATCH

CONSTRAINTS = {
    kind.name: kind
    for kind in (
        DISTANCE, HELD_COORDINATE, IN_PLANE, LEVEL_AXIS, ORTHOGONAL, RELATIVE_ANGLE, RIGID_OFFSET,
        GEARED_SLIDE, GEAR_MESH,
        BLADE, ROLLING, ROLLING_RADIUS, UPRIGHT_ROLLING, ANGLE_LATCH, ANGLE_STOP, SLIDE_LATCH, SLIDE_STOP, CATCH,
    )
}  # fmt: skip
