r"""Prescribed position: a node is displaced along an inertial direction n as a function of time.

.. math::  n \cdot (x - x_0) - f(t) = 0

with x_0 the position in the deck. The multiplier is the force on the node along n; its power :math:`k\lambda\, \dot f`
is supplied by the surroundings.
"""

import numpy as np

from mecano.constraints.along_coordinate.hold import motion_values, with_motion
from mecano.constraints.joint_frame import triad
from mecano.constraints.of_coordinates import HELD_COORDINATE, drive_part
from mecano.element_interface import Display, Kind, Output, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import dot, vec
from mecano.schema import DIRECTION, MOTION, NODE, Field


def _axes(d, nodes):
    return {"direction": triad(d["direction"])[2], "origin": np.asarray(nodes[0][0])}


def prepare(d, nodes, context):
    """Return direction, origin and motion."""
    return {**_axes(d, nodes), **motion_values(d["value"], 0.0, context)}


def parts(d, nodes, context):
    """Return the Part of one held coordinate."""
    return [drive_part(HELD_COORDINATE, (0,), _axes(d, nodes), d["value"], 0.0, context)]


def sample(rng):
    """Return a moving support."""
    sine = (("sine", {"amplitude": 0.3, "frequency": 0.7, "phase": 0.4, "offset": 0.1}),)
    return [({"direction": rng.normal(size=3), "value": value}, 1, "") for value in (sine, "time**2/2")]


def _kind(motion):
    target = motion.at

    @kernel
    def observe(p, at, F, y, e):
        n = vec(p.direction, 0)
        y[0] = dot(n, vec(at.q, 0) - vec(p.origin, 0))
        y[1] = dot(n, vec(at.v, 0))
        y[2] = at.q[3]
        e[3] = at.q[3] * target(p, at)[1]

    return Kind(
        name="prescribed_position",
        section="joints",
        doc=__doc__,
        display=Display("nothing", pictures=("slides",)),
        dtype=record(direction=3, origin=3, **motion.fields),
        layout=("x0",),
        fields=(
            Field("node", NODE, "-", "node that is moved"),
            Field("direction", DIRECTION, "-", "direction of the displacement, inertial"),
            Field("value", MOTION, "m", "displacement from the position in the deck, a law or a formula of time [s]"),
        ),
        outputs=(
            Output("displacement", "m", "displacement of the node along the direction", rate="velocity"),
            Output("velocity", "m/s", "rate of the displacement"),
            Output("force", "N", "force on the node along the direction"),
        ),
        prepare=prepare,
        parts=parts,
        observe=observe,
        sample=sample,
    )


PRESCRIBED_POSITION = with_motion(_kind, "value")
