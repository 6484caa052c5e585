r"""Prescribed length: the distance of two nodes is a function of time, as for a driven strut or leg.

.. math::  |x_b - x_a| - L - f(t) = 0

with L the initial distance, or zero if the deck gives the length itself. Both ends rotate freely. The multiplier
is the force of the drive, which pushes the nodes apart; its power :math:`k\lambda\, \dot f` is supplied by the
surroundings.
"""

import numpy as np

from mecano.constraints.along_coordinate.hold import motion_values, with_motion
from mecano.constraints.joint_frame import ENDS, at_one_place
from mecano.constraints.of_coordinates import DISTANCE, drive_part
from mecano.element_interface import Display, Kind, Output, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import dot, norm, vec
from mecano.schema import MOTION, Field


def prepare(d, nodes, context):
    """Return the initial length, or zero, and the motion."""
    return motion_values(*_motion(d, nodes), context)


def _motion(d, nodes):
    if d["length"] is not None:
        return d["length"], 0.0
    return d["value"], np.linalg.norm(np.subtract(nodes[1][0], nodes[0][0]))


def parts(d, nodes, context):
    """Return the Part of one distance."""
    return [drive_part(DISTANCE, (0, 1), {}, *_motion(d, nodes), context)]


def check(d, nodes):
    """Check that there is one law, and an initial direction."""
    if (d["length"] is None) == (d["value"] is None):
        return ["needs either 'value', the change of the distance, or 'length', the distance itself"]
    return at_one_place(d, nodes)


def sample(rng):
    """Return a leg that changes its length, and one whose length is given."""
    change, length = ((("sine", {"amplitude": 0.2, "frequency": 0.7, "phase": 0.4, "offset": x}),) for x in (0.1, 1.3))
    return [({"value": change}, 2, ""), ({"length": length}, 2, ""), ({"length": "2 + cos(time)"}, 2, "")]


def _kind(motion):
    target = motion.at

    @kernel
    def observe(p, at, F, y, e):
        d = vec(at.q, 3) - vec(at.q, 0)
        length = norm(d)
        y[0], y[1] = length, dot(d, vec(at.v, 3) - vec(at.v, 0)) / length
        y[2] = at.q[6]
        e[3] = at.q[6] * target(p, at)[1]

    return Kind(
        name="prescribed_length",
        section="joints",
        doc=__doc__,
        display=Display("line"),
        dtype=record(**motion.fields),
        layout=("x0", "x1"),
        fields=(
            ENDS,
            Field("value", MOTION, "m", "change of the distance since the start, a law or a formula of time [s]", None),
            Field(
                "length", MOTION, "m", "the distance itself, a law or a formula of time [s], instead of 'value'", None
            ),
        ),
        outputs=(
            Output("length", "m", "distance of the nodes", rate="rate"),
            Output("rate", "m/s", "rate of the length"),
            Output("force", "N", "force of the drive, positive when it pushes the nodes apart"),
        ),
        prepare=prepare,
        parts=parts,
        check=check,
        observe=observe,
        sample=sample,
    )


PRESCRIBED_LENGTH = with_motion(_kind, "value", "length")
