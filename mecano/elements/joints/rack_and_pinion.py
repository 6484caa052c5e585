r"""Rack and pinion: node b, the centre of the pinion, rolls along a rack fixed in node a.

With the direction :math:`\sigma` of the rack, the pitch radius r, and the angle :math:`\theta` of the pinion relative
to the rack about an axis perpendicular to it:

.. math::  \sigma \cdot (x_b - x_a) - c - r\,\theta = 0

A positive angle moves the pinion along :math:`+\sigma`, or the rack along :math:`-\sigma`: the teeth are on the side of
:math:`n \times \sigma`, n the axis. Other joints guide both parts, so that the axes of both nodes stay aligned. The
multiplier is the tangential force of the teeth; it acts at the pitch point. The separating force of inclined flanks
does no work and is omitted. ``backlash``, elastic ``teeth`` and ``friction`` are those of a gear pair (docs/gears.md);
the left-hand side is the transmission error.
"""

import numpy as np

from mecano.constraints.along_coordinate.measure import OVER_TURNS, angle_outputs
from mecano.constraints.body_fixed import follow
from mecano.constraints.coordinates.slide import slide
from mecano.constraints.coordinates.twist import turned
from mecano.constraints.gear_teeth import Mesh, with_teeth
from mecano.constraints.geared_slide import GEARED_SLIDE, slide_travel
from mecano.constraints.joint_nodes import check_perpendicular
from mecano.constraints.triads import triad
from mecano.element_interface import Display, Kind, Output
from mecano.jit.kernel import kernel
from mecano.maths.vector import vec
from mecano.schema import DIRECTION, NODE_PAIR, NUMBER, Field, positive


@kernel
def _put_motion(p, at, y):
    """Write rolling and sliding; the sliding determines the turn."""
    angle, y[1] = turned(p, at)
    along, y[3] = slide(at, vec(p.sigma, 0))
    y[2] = along - p.offset
    y[0] = follow((along - p.offset) / p.travel, angle)


def prepare(d, nodes, context):
    """Return axes of both nodes, direction of the rack and the initial position of b along it."""
    (x_a, R_a), (x_b, R_b) = nodes
    mu, sigma = triad(d["axis"]), triad(d["direction"])[2]
    along = sigma @ np.subtract(x_b, x_a)
    return {"mu": mu @ R_a, "xi": mu @ R_b, "sigma": sigma @ R_a, "offset": along, "travel": d["radius"]}


_RIGID = Kind(
    name="rack_and_pinion", section="joints", doc=__doc__,
    display=Display(shape="gears", support=False, pictures=("gears",)),
    fields=(
        Field("nodes", NODE_PAIR, "-", "nodes a (rack) and b (centre of the pinion); either may be ground"),
        Field("axis", DIRECTION, "-", "axis of the pinion at the start, inertial; fixed in both nodes"),
        Field(
            "direction", DIRECTION, "-",
            "direction of the rack at the start, inertial, fixed in a; positive rotation moves b along it",
        ),
        Field("radius", NUMBER, "m", "radius of the pitch circle", check=positive),
    ),
    outputs=(
        *angle_outputs(OVER_TURNS),
        Output("displacement", "m", "sliding of b relative to a along the direction since the start", rate="velocity"),
        Output("velocity", "m/s", "rate of the displacement"),
        Output("force", "N", "tangential force of the teeth of a on b, along the direction, without friction"),
    ),
    counts_angles=lambda d: [("axis", d["axis"], d["nodes"])],
    check=lambda d, nodes: check_perpendicular(d, "axis", "direction"),
    prepare=prepare,
    cases=({"axis": (0.6, 0.0, 0.8), "direction": (-0.8, 1.0, 0.6), "radius": 2.0},),
)  # fmt: skip
RACK_AND_PINION = with_teeth(_RIGID, Mesh(GEARED_SLIDE, slide_travel, driver=1), _put_motion, "radius")
