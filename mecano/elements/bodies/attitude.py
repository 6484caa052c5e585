r"""Attitude of a node: angles, directions of its axes, its motion in its own axes, as outputs and for signals.

The rotation from the axes of the node to the inertial ones is

.. math::  R = R_z(\psi)\, R_y(\theta)\, R_x(\phi)

with the yaw :math:`\psi` about the inertial z axis, then the pitch :math:`\theta` about the y axis turned by it, then
the roll :math:`\phi` about the x axis of the node: the Tait-Bryan angles z-y'-x'' of vehicles (ISO 8855) and aircraft,
if the node has x ahead, and z up or down. Yaw and roll count whole turns, from within half a turn at the start; the
pitch is between -90 and 90 degrees, where yaw and roll are not unique. The directions of the axes, the columns of R,
are unique everywhere: use them to point an axis at a target, or to control large rotations. With the angular velocity
(p, q, r) in the axes of the node,

.. math::
   \dot\psi = (q \sin\phi + r \cos\phi)/\cos\theta, \qquad \dot\theta = q \cos\phi - r \sin\phi, \qquad
   \dot\phi = p + \dot\psi \sin\theta

It has no mass and exerts no force.
"""

from mecano.constraints.body_fixed import follow
from mecano.element_interface import Display, Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.maths.dual import atan2, sqrt
from mecano.maths.vector import mat, put, vec
from mecano.schema import NODE, Field


@kernel
def _turned(R):
    """Return yaw and roll of a rotation, in (-pi, pi]."""
    return atan2(R[1][0], R[0][0]), atan2(R[2][1], R[2][2])


@kernel
def observe(p, at, F, y, e):
    """Write the angles, their rates, and both velocities in the axes of the node."""
    R, omega = mat(at.R[0]), vec(at.v, 3)
    yaw, roll = _turned(R)
    cosine = sqrt(R[2][1] * R[2][1] + R[2][2] * R[2][2])
    q_s, q_c = omega[1] * R[2][1] + omega[2] * R[2][2], omega[1] * R[2][2] - omega[2] * R[2][1]
    yaw_rate = q_s / (cosine * cosine)
    y[0], y[1], y[2] = follow(at.m[0], yaw), atan2(-R[2][0], cosine), follow(at.m[1], roll)
    y[3], y[4], y[5] = yaw_rate, q_c / cosine, omega[0] - yaw_rate * R[2][0]
    put(y, 6, omega)
    put(y, 9, R.T @ vec(at.v, 0))
    put(y, 12, vec(at.a, 0))
    put(y, 15, R.T @ (vec(at.a, 0) - vec(p.free_fall, 0)))
    axes = R.T
    put(y, 18, axes.x)
    put(y, 21, axes.y)
    put(y, 24, axes.z)


@kernel
def commit(p, at, m_out):
    """Write yaw and roll."""
    yaw, roll = _turned(mat(at.R[0]))
    m_out[0], m_out[1] = follow(at.m[0], yaw), follow(at.m[1], roll)


WASHOUT = "read the 'washout' of a component of the velocity, with the gain 1/time_constant"
ATTITUDE = Kind(
    name="attitude", section="elements", doc=__doc__, display=Display("nothing"), dtype=record(free_fall=3),
    layout=("x0", "R0"),
    fields=(Field("node", NODE, "-", "node whose attitude is measured"),),
    outputs=(
        Output("yaw", "rad", "yaw about the inertial z axis", rate="yaw_rate"),
        Output("pitch", "rad", "pitch about the y axis turned by the yaw", rate="pitch_rate"),
        Output("roll", "rad", "roll about the x axis of the node", rate="roll_rate"),
        Output("yaw_rate", "rad/s", "rate of the yaw"),
        Output("pitch_rate", "rad/s", "rate of the pitch"),
        Output("roll_rate", "rad/s", "rate of the roll"),
        Output("angular_velocity", "rad/s", "angular velocity in the axes of the node: p, q, r", (3,)),
        Output("velocity", "m/s", "velocity in the axes of the node: u, v, w", (3,)),
        Output("acceleration", "m/s2", "acceleration, inertial", (3,)),
        Output(
            "specific_force", "m/s2", "acceleration less gravity in the axes of the node, as accelerometers measure it",
            (3,),
        ),
        *(
            Output(f"{c}_axis", "-", f"direction of the {c} axis of the node, inertial", (3,), geometric=True)
            for c in "xyz"
        ),
    ),
    hidden={"acceleration": WASHOUT, "specific_force": WASHOUT},
    memory=("yaw", "roll"),
    prepare=lambda d, nodes, context: {"free_fall": context.gravity},
    **named(observe, commit),
)  # fmt: skip
