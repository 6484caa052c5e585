r"""Prescribed motions: a coordinate c of one or two nodes, or its rate, is a function of time.

.. math::  c - c_0 - f(t) = 0 \qquad \text{or} \qquad c - c_0 - \int_0^t u\, dt = 0

c is the displacement :math:`n \cdot x` of a node along an inertial direction n (``prescribed_position``), the angle of
node b relative to node a about an axis that another joint keeps aligned (``prescribed_angle``), or the distance
:math:`|x_b - x_a|` of two nodes, whose ends rotate freely (``prescribed_length``). c_0 is its value in the deck, or
zero if the deck gives the distance itself; an angle may cover many turns. f is a law of time or a formula of the time.
The ``rate`` u is a law of time, integrated exactly, or a formula of signals: then :math:`\dot c - u = 0` is a
constraint on velocities, and c follows from the integration in time, from c_0 at the start of the run on.
The multiplier is the load along c: a force along n, a moment on b about the axis, or a force that pushes the nodes
apart. After its ``release`` the drive exerts no force. Its power :math:`k\lambda\, \dot f` is supplied by the
surroundings; with a rate, :math:`k\lambda\, u`.
"""

from dataclasses import replace

import numpy as np

from mecano.constraints.along_coordinate.demand import is_formula
from mecano.constraints.along_coordinate.hold import BY_FORMULA, BY_LAW, motion_values
from mecano.constraints.along_coordinate.law import as_it_is, counted
from mecano.constraints.along_coordinate.measure import angle_outputs
from mecano.constraints.body_fixed import follow
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.constraints.coordinates.displacement import DISPLACEMENT
from mecano.constraints.coordinates.distance import DISTANCE
from mecano.constraints.coordinates.twist import TWIST
from mecano.constraints.joint_nodes import ENDS, NODES, check_apart, distance
from mecano.constraints.of_coordinates import DISTANCE as DRIVEN_DISTANCE
from mecano.constraints.of_coordinates import HELD_COORDINATE, RELATIVE_ANGLE, drive_part
from mecano.constraints.release import RELEASE, SAMPLE, check_release, releasable
from mecano.constraints.triads import triad
from mecano.element_interface import BY_COMMAND, UNUSED, Display, Kind, Output, named, nothing, record
from mecano.jit.kernel import kernel
from mecano.schema import CONTINUOUS_DRIVE, DIRECTION, MOTION, NODE, Field

EQUATIONS, RATE = __doc__.partition("\n\n")[2], "rate"
RATE_ALONE = 2  # index of the Kind of a joint that drives the rate, after those by a law and by a formula


def _prescribed(name, what, coordinate, constraint, place, motions=("value",), **declared):
    """Return the Kind of a joint that drives a ``coordinate`` by the Part ``constraint``.

    ``place(d, nodes)`` returns the axes of the coordinate and the value to which its motion counts; ``motions`` are the
    fields that may give it, besides its rate, ``declared`` other fields of the Kind.
    """
    on, names = tuple(range(len({slot[1] for slot in coordinate.layout}))), (*motions, RATE)
    also = declared.pop("check", nothing)

    def drives(d):
        return [d[name] for name in names if d[name] is not None]

    def prepare(d, nodes, context):
        axes, zero = place(d, nodes)
        return axes if d[RATE] is not None else {**axes, **motion_values(drives(d)[0], zero, context)}

    def parts(d, nodes, context):
        axes, zero = place(d, nodes)
        return [drive_part(constraint, on, axes, drives(d)[0], zero, context, d[RATE] is not None)]

    def check(d, nodes):
        once = [f"give exactly one of {', '.join(map(repr, names))}"] if len(drives(d)) != 1 else []
        return once + also(d, nodes) + check_release(d, ())

    def variant(d):
        number = RATE_ALONE if d[RATE] is not None else any(map(is_formula, drives(d)))
        return (released if d["release"] is not None else kinds)[number]

    doc = "rate, instead: its integral is the motion, of a law from the time 0, of a formula from the start of the run"
    declared["fields"] += (Field(RATE, CONTINUOUS_DRIVE, f"{coordinate.unit}/s", doc, None), RELEASE)
    kind = Kind(
        name=name, section="joints", doc=f"{what}.\n\n{EQUATIONS}", layout=coordinate.layout, **declared,
        **named(prepare, parts, drives, check, variant), **_of_motion(coordinate, BY_LAW),
    )  # fmt: skip
    kinds = kind, replace(kind, **_of_motion(coordinate, BY_FORMULA)), replace(kind, **_of_rate(coordinate, 0))
    released = [releasable(kind, **_released(coordinate, motion)) for motion in (BY_LAW, BY_FORMULA)]
    released.append(releasable(kind, **_of_rate(coordinate, 1)))
    return kind


def _of_motion(coordinate, motion):
    """Return the record and ``observe`` of a joint whose ``coordinate`` follows this ``motion``."""
    value, gradient, row, target = coordinate.value, coordinate.gradient, coordinate.row, motion.at
    nearest = follow if coordinate.periodic else as_it_is

    @kernel
    def observe(p, at, F, y, e):
        wanted, wanted_rate = target(p, at)
        y[0] = nearest(wanted, value(p, at))
        y[1] = rate_of(gradient(p, at), at.v)
        y[2] = at.q[row]
        e[3] = at.q[row] * wanted_rate

    return {"dtype": record(**coordinate.axes, **motion.fields), **named(observe)}


def _of_rate(coordinate, inputs):
    """Return the same of a joint that drives the rate, whose part has its power; the memory counts turns.

    ``inputs``: their number, which precede the multiplier.
    """
    count, gradient, row = counted(coordinate), coordinate.gradient, coordinate.row + inputs

    @kernel
    def observe(p, at, F, y, e):
        y[0], y[1], y[2] = count(p, at), rate_of(gradient(p, at), at.v), at.q[row]

    @kernel
    def commit(p, at, m_out):
        m_out[0] = count(p, at)

    turns = {"memory": ("angle",), "commit": commit} if coordinate.periodic else {}
    return {"dtype": record(**coordinate.axes or {UNUSED: ()}), **named(observe), **turns}


def _released(coordinate, motion):
    """Return the same of a joint with a release, whose ``coordinate`` follows this ``motion`` until then."""
    of_rate, target, row = _of_rate(coordinate, 1), motion.at, coordinate.row + 1
    measure = of_rate["observe"]

    @kernel
    def observe(p, at, F, y, e):
        measure(p, at, F, y, e)
        e[3] = at.q[row] * target(p, at)[1]

    return {**of_rate, "dtype": record(**coordinate.axes, **motion.fields), **named(observe)}


def _displacement(d, nodes):
    return {"direction": triad(d["direction"])[2], "origin": np.asarray(nodes[0][0])}, 0.0


def _angle(d, nodes):
    mu = triad(d["axis"])
    return {"mu": mu @ nodes[0][1], "xi": mu @ nodes[1][1]}, 0.0


def _length(d, nodes):
    return {}, 0.0 if d["length"] is not None else distance(nodes)


def _sine(amplitude, frequency, offset):
    """Return a motion of samples."""
    return (("sine", {"amplitude": amplitude, "frequency": frequency, "phase": 0.4, "offset": offset}),)


RATES = {"rate": _sine(0.3, 0.2, 0.1)}, {"rate": "command"}  # of samples
RELEASES = tuple({**given, **SAMPLE} for given in (*RATES, {"value": "time**2/2"}, {"value": RATES[0]["rate"]}))
PRESCRIBED_POSITION = _prescribed(
    "prescribed_position", "Displacement of a node along an inertial direction, as a function of time", DISPLACEMENT,
    HELD_COORDINATE, _displacement,
    display=Display("nothing", pictures=("slides",)),
    fields=(
        Field("node", NODE, "-", "node that is moved"),
        Field("direction", DIRECTION, "-", "direction of the displacement, inertial"),
        Field("value", MOTION, "m", "displacement from the position in the deck", None),
    ),
    outputs=(
        Output("displacement", "m", "displacement of the node along the direction", rate="velocity"),
        Output("velocity", "m/s", "rate of the displacement"),
        Output("force", "N", "force on the node along the direction"),
    ),
    cases=({"value": _sine(0.3, 0.7, 0.1)}, {"value": "time**2/2"}, *RATES, *RELEASES),
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
        Field("value", MOTION, "rad", "rotation of b relative to a since the start", None),
    ),
    outputs=(
        *angle_outputs("rotation of b relative to a about the axis since the start"),
        Output("moment", "N m", "moment of a on b about the axis"),
    ),
    cases=({"value": _sine(30.0, 0.2, 4.0)}, {"value": "9*sin(time/4)"}, *RATES, *RELEASES),
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
    check=check_apart,
    cases=(
        {"value": _sine(0.2, 0.7, 0.1)}, {"length": _sine(0.2, 0.7, 1.3)}, {"length": "2 + cos(time)"}, *RATES,
        *RELEASES,
    ),
)  # fmt: skip
