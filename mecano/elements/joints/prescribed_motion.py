r"""Prescribed motions: a coordinate c of one or two nodes is a function of time.

.. math::  c - c_0 - f(t) = 0

c is the displacement :math:`n \cdot x` of a node along an inertial direction n (``prescribed_position``), the angle of
node b relative to node a about an axis that another joint keeps aligned (``prescribed_angle``), or the distance
:math:`|x_b - x_a|` of two nodes, whose ends rotate freely (``prescribed_length``). c_0 is its value in the deck, or
zero if the deck gives the distance itself; an angle may cover many turns. f is a law of time or a formula of the time.
The multiplier is the load along c: a force along n, a moment on b about the axis, or a force that pushes the nodes
apart. Its power :math:`k\lambda\, \dot f` is supplied by the surroundings.
"""

import numpy as np

from mecano.constraints.along_coordinate.hold import motion_values, with_motion
from mecano.constraints.along_coordinate.law import as_it_is
from mecano.constraints.along_coordinate.measure import angle_outputs
from mecano.constraints.body_fixed import follow
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.constraints.coordinates.displacement import DISPLACEMENT
from mecano.constraints.coordinates.distance import DISTANCE
from mecano.constraints.coordinates.twist import TWIST
from mecano.constraints.joint_nodes import ENDS, NODES, check_apart, distance
from mecano.constraints.of_coordinates import DISTANCE as DRIVEN_DISTANCE
from mecano.constraints.of_coordinates import HELD_COORDINATE, RELATIVE_ANGLE, drive_part
from mecano.constraints.triads import triad
from mecano.element_interface import BY_COMMAND, Display, Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.schema import DIRECTION, MOTION, NODE, Field

EQUATIONS = __doc__.partition("\n\n")[2]


def _prescribed(name, what, coordinate, constraint, motion_of, motions=("value",), **declared):
    """Return the Kind of a joint that drives a ``coordinate`` by the Part ``constraint``.

    ``motion_of(d, nodes)`` returns the axes of the coordinate, the motion of the deck and the value to which it counts;
    ``motions`` are the fields that may give it, ``declared`` other fields of the Kind.
    """
    value, gradient, row = coordinate.value, coordinate.gradient, coordinate.row
    nearest = follow if coordinate.periodic else as_it_is
    on = tuple(range(len({slot[1] for slot in coordinate.layout})))

    def prepare(d, nodes, context):
        axes, motion, zero = motion_of(d, nodes)
        return {**axes, **motion_values(motion, zero, context)}

    def parts(d, nodes, context):
        axes, motion, zero = motion_of(d, nodes)
        return [drive_part(constraint, on, axes, motion, zero, context)]

    def drives(d):
        return [d[name] for name in motions if d[name] is not None]

    def kind(motion):
        """Return the Kind of a joint whose coordinate follows this motion."""
        target = motion.at

        @kernel
        def observe(p, at, F, y, e):
            wanted, wanted_rate = target(p, at)
            y[0] = nearest(wanted, value(p, at))
            y[1] = rate_of(gradient(p, at), at.v)
            y[2] = at.q[row]
            e[3] = at.q[row] * wanted_rate

        return Kind(
            name=name, section="joints", doc=f"{what}.\n\n{EQUATIONS}", layout=coordinate.layout,
            dtype=record(**coordinate.axes, **motion.fields), **named(prepare, parts, drives, observe), **declared,
        )  # fmt: skip

    return with_motion(kind, *motions)


def _displacement(d, nodes):
    return {"direction": triad(d["direction"])[2], "origin": np.asarray(nodes[0][0])}, d["value"], 0.0


def _angle(d, nodes):
    mu = triad(d["axis"])
    return {"mu": mu @ nodes[0][1], "xi": mu @ nodes[1][1]}, d["value"], 0.0


def _length(d, nodes):
    if d["length"] is not None:
        return {}, d["length"], 0.0
    return {}, d["value"], distance(nodes)


def _check_length(d, nodes):
    """Check that there is one law, and an initial direction."""
    if (d["length"] is None) == (d["value"] is None):
        return ["needs either 'value', the change of the distance, or 'length', the distance itself"]
    return check_apart(d, nodes)


def _sine(amplitude, frequency, offset):
    """Return a motion of samples."""
    return (("sine", {"amplitude": amplitude, "frequency": frequency, "phase": 0.4, "offset": offset}),)


PRESCRIBED_POSITION = _prescribed(
    "prescribed_position", "Displacement of a node along an inertial direction, as a function of time", DISPLACEMENT,
    HELD_COORDINATE, _displacement,
    display=Display("nothing", pictures=("slides",)),
    fields=(
        Field("node", NODE, "-", "node that is moved"),
        Field("direction", DIRECTION, "-", "direction of the displacement, inertial"),
        Field("value", MOTION, "m", "displacement from the position in the deck"),
    ),
    outputs=(
        Output("displacement", "m", "displacement of the node along the direction", rate="velocity"),
        Output("velocity", "m/s", "rate of the displacement"),
        Output("force", "N", "force on the node along the direction"),
    ),
    cases=({"value": _sine(0.3, 0.7, 0.1)}, {"value": "time**2/2"}),
)  # fmt: skip
PRESCRIBED_ANGLE = _prescribed(
    "prescribed_angle", "Rotation of node b relative to node a about an axis, as a function of time", TWIST,
    RELATIVE_ANGLE, _angle,
    display=Display("nothing", pictures=("angles",)),
    turns=BY_COMMAND,
    counts_angles=lambda d: [("axis", d["axis"], d["nodes"])],
    fields=(
        NODES,
        Field("axis", DIRECTION, "-", "axis at the start, inertial; fixed in both nodes"),
        Field("value", MOTION, "rad", "rotation of b relative to a since the start"),
    ),
    outputs=(
        *angle_outputs("rotation of b relative to a about the axis since the start"),
        Output("moment", "N m", "moment of a on b about the axis"),
    ),
    cases=({"value": _sine(30.0, 0.2, 4.0)}, {"value": "9*sin(time/4)"}),
)  # fmt: skip
PRESCRIBED_LENGTH = _prescribed(
    "prescribed_length", "Distance of two nodes as a function of time, as for a driven strut or leg", DISTANCE,
    DRIVEN_DISTANCE, _length, ("value", "length"),
    display=Display("line"),
    fields=(
        ENDS,
        Field("value", MOTION, "m", "change of the distance since the start", None),
        Field("length", MOTION, "m", "the distance itself, instead of 'value'", None),
    ),
    outputs=(
        Output("length", "m", "distance of the nodes", rate="rate"),
        Output("rate", "m/s", "rate of the length"),
        Output("force", "N", "force of the drive, positive when it pushes the nodes apart"),
    ),
    check=_check_length,
    cases=({"value": _sine(0.2, 0.7, 0.1)}, {"length": _sine(0.2, 0.7, 1.3)}, {"length": "2 + cos(time)"}),
)  # fmt: skip
