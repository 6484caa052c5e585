"""Measurements of joints with an axis: rotation about it, sliding along it, reactions.

Local unknowns x0, R0, x1, R1; the record has AXES_FIELDS (pair.py).
"""

from mecano.constraints.body_fixed import follow
from mecano.constraints.coordinates.slide import slide
from mecano.constraints.coordinates.twist import turned
from mecano.element_interface import Output
from mecano.jit.kernel import kernel
from mecano.maths.vector import mat, vec

TURNING = (
    Output("angle", "rad", "rotation of b relative to a about the axis since the start, over any turns", rate="rate"),
    Output("rate", "rad/s", "rate of the angle"),
)
SLIDING = (
    Output("displacement", "m", "sliding of b relative to a along the axis since the start", rate="velocity"),
    Output("velocity", "m/s", "rate of the displacement"),
)
MOMENT = Output("moment", "N m", "moment of a on b at node b, about mu_1, mu_2 and the axis", (3,))
REACTIONS = (Output("force", "N", "force of a on b along mu_1, mu_2 and the axis", (3,)), MOMENT)


@kernel
def angle_in_turn(p, v, R):
    """Return the angle about the axis, in (-pi, pi] [rad], and its rate [rad/s]."""
    return turned(mat(R[0]), vec(v, 3), mat(p.mu), mat(R[1]), vec(v, 9), mat(p.xi))


@kernel
def put_turning(p, m, v, R, y, i):
    """Write ``TURNING`` starting at y[i]; the memory determines the turn."""
    angle, y[i + 1] = angle_in_turn(p, v, R)
    y[i] = follow(m[0], angle)


@kernel
def put_sliding(p, q, v, R, y, i):
    """Write ``SLIDING`` starting at y[i]."""
    along, y[i + 1] = slide(q, v, mat(R[0]), vec(p.mu[2], 0))
    y[i] = along - p.start[2]


@kernel
def follow_turning(p, at, m_out):
    """Continue the angle over whole turns: the ``commit`` of a joint with the memory ("angle",)."""
    m_out[0] = follow(at.m[0], angle_in_turn(p, at.v, at.R)[0])
