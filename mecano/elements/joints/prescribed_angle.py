r"""Prescribed angle: node b is rotated relative to node a about an axis, as a function of time.

For two nodes that share this axis through another joint (a hinge, a cylindrical joint):

.. math::  \theta - f(t) = 0

with theta the angle of that joint, zero in the deck; f may cover many turns. The multiplier is the moment on b
about the axis; its power :math:`k\lambda\, \dot f` is supplied by the surroundings.
"""

from mecano.constraints.along_coordinate.hold import motion_values, with_motion
from mecano.constraints.along_coordinate.measure import angle_outputs
from mecano.constraints.body_fixed import follow
from mecano.constraints.coordinates.twist import turned
from mecano.constraints.joint_frame import NODES, triad
from mecano.constraints.joint_samples import two_places
from mecano.constraints.of_coordinates import RELATIVE_ANGLE, drive_part
from mecano.element_interface import BY_COMMAND, Display, Kind, Output, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import mat, vec
from mecano.schema import DIRECTION, MOTION, Field


def _axes(d, nodes):
    mu = triad(d["axis"])
    return {"mu": mu @ nodes[0][1], "xi": mu @ nodes[1][1]}


def prepare(d, nodes, context):
    """Return axes of both nodes and the motion."""
    return {**_axes(d, nodes), **motion_values(d["value"], 0.0, context)}


def parts(d, nodes, context):
    """Return the Part of one relative angle."""
    return [drive_part(RELATIVE_ANGLE, (0, 1), _axes(d, nodes), d["value"], 0.0, context)]


def sample(rng):
    """Return a motion of many turns."""
    sine = (("sine", {"amplitude": 30.0, "frequency": 0.2, "phase": 0.4, "offset": 4.0}),)
    nodes = two_places(rng)
    return [({"axis": rng.normal(size=3), "value": value}, nodes, "") for value in (sine, "9*sin(time/4)")]


def _kind(motion):
    target = motion.at

    @kernel
    def observe(p, at, F, y, e):
        angle, y[1] = turned(mat(at.R[0]), vec(at.v, 0), mat(p.mu), mat(at.R[1]), vec(at.v, 3), mat(p.xi))
        wanted, wanted_rate, _ = target(p, at)
        y[0] = follow(wanted, angle)
        y[2] = at.q[6]
        e[3] = at.q[6] * wanted_rate

    return Kind(
        name="prescribed_angle",
        section="joints",
        doc=__doc__,
        display=Display("nothing", pictures=("angles",)),
        turns=BY_COMMAND,
        dtype=record(mu=(3, 3), xi=(3, 3), **motion.fields),
        layout=("R0", "R1"),
        fields=(
            NODES,
            Field("axis", DIRECTION, "-", "axis at the start, inertial; fixed in both nodes"),
            Field(
                "value", MOTION, "rad", "rotation of b relative to a since the start, a law or a formula of time [s]"
            ),
        ),
        outputs=(
            *angle_outputs("rotation of b relative to a about the axis since the start"),
            Output("moment", "N m", "moment of a on b about the axis"),
        ),
        prepare=prepare,
        parts=parts,
        observe=observe,
        sample=sample,
    )


PRESCRIBED_ANGLE = with_motion(_kind, "value")
