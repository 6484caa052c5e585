r"""Loads along the coordinate of a joint, or along a line or about an axis of two nodes: actuators, motors, cylinders.

A load P acts along a coordinate c of the nodes, in the sense of increasing c:

.. math::  f = -P\, \nabla c

with the power :math:`P\, \dot c` supplied by the surroundings. c is the angle of the joint about its axis
(``joint_moment``), its displacement along the axis (``joint_force``), the distance between two nodes (``line_force``; P
> 0 pushes them apart), or the position of node b along an axis fixed in node a (``internal_force``: P acts on b, and -P
on a at the same place, with its moment). The rate of c is the relative angular velocity of both nodes about an axis
fixed in node a for a ``couple``, which acts on b about this axis and on a against it, whatever joins the nodes. P is a
function of time or a formula of signals, such as a controller that measures the angle.
"""

from functools import partial

from mecano.constraints.along_coordinate.demand import law_of, on_demand
from mecano.constraints.coordinates.coordinate import Coordinate, add_along, rate_of
from mecano.constraints.coordinates.distance import DISTANCE
from mecano.constraints.coordinates.slide import SLIDE
from mecano.constraints.coordinates.twist import TWIST
from mecano.constraints.joint_nodes import NODES, check_apart
from mecano.constraints.triads import carried_axis
from mecano.element_interface import Display, Kind, Output, named, record
from mecano.jit.kernel import kernel
from mecano.maths.vector import mat, vec
from mecano.schema import DIRECTION, DRIVE, NODE_PAIR, Field, joint_with

EQUATIONS = __doc__.partition("\n\n")[2]
AXIS = Field("axis", DIRECTION, "-", "axis at the start, inertial; fixed in a")


@kernel
def _about_axis(p, at):
    """Return what takes the place of a gradient for a turn about an axis fixed in the first node."""
    axis = vec(p.axis, 0)
    on_b = mat(at.R[1]).T @ (mat(at.R[0]) @ axis)
    return (0, 0.0 * on_b - axis), (3, on_b)  # both Duals if one is


TURN = Coordinate(("R0", "R1"), "rad", {"axis": 3}, None, _about_axis)  # of a rate that no value has


def _functions(coordinate, demand):
    """Return ``residual`` and ``observe`` of a load P along a coordinate: f = -P dc/dq, power P dc/dt."""
    gradient = coordinate.gradient

    @kernel
    def residual(p, at, f):
        add_along(f, -demand(p, at), gradient(p, at))

    @kernel
    def observe(p, at, F, y, e):
        size, rate = demand(p, at), rate_of(gradient(p, at), at.v)
        y[0], y[1], y[2] = size, rate, size * rate
        e[3] = size * rate

    return named(residual, observe)


def _load(name, what, coordinate, fields, prepare, along="along the coordinate", **declared):
    """Return the Kind of a load ``along`` a coordinate of the nodes that the ``fields`` name.

    ``declared`` are other fields of the Kind.
    """
    quantity, unit = coordinate.load
    kind = Kind(
        name=name, section="loads", doc=f"{what}.\n\n{EQUATIONS}", dtype=record(**coordinate.axes, law="i"),
        layout=coordinate.layout, fields=(*fields, Field("value", DRIVE, unit, f"{quantity} {along}")),
        outputs=(
            Output(quantity, unit, f"{quantity} {along}"),
            Output("rate", f"{coordinate.unit}/s", "rate of the coordinate"),
            Output("power", "W", "power given to the nodes"),
        ),
        prepare=prepare, **declared,
    )  # fmt: skip
    return on_demand(kind, partial(_functions, coordinate), "value")


def _along_joint(output):
    """Return the ``prepare`` of a load along an output of a joint, a Measured on both of its nodes."""

    def prepare(d, nodes, context):
        kind = context.kinds[d["joint"]["type"]]
        return {"law": law_of(d["value"], context), **kind.measures[output](d["joint"], nodes, context).axes}

    return prepare


def _sample(rng):
    """Return a load along a cylindrical joint."""
    return [({"joint": {"type": "cylindrical", "axis": rng.normal(size=3), "axis_1": None}}, 2, "")]


def _joint(output, kinds):
    return (Field("joint", joint_with(output), "-", f"{kinds}, along whose {output} the load acts"),)


JOINT_MOMENT = _load(
    "joint_moment", "Moment about the axis of a joint, such as that of a motor", TWIST,
    _joint("angle", "hinge, cylindrical, planar or screw joint"),
    _along_joint("angle"), sample=_sample,
)  # fmt: skip
JOINT_FORCE = _load(
    "joint_force", "Force along the axis of a joint, such as that of a linear motor", SLIDE,
    _joint("displacement", "prismatic, cylindrical or screw joint"),
    _along_joint("displacement"), sample=_sample,
)  # fmt: skip
LINE_FORCE = _load(
    "line_force", "Force along the line between two nodes, such as that of a hydraulic cylinder", DISTANCE,
    (Field("nodes", NODE_PAIR, "-", "its two nodes, not at the same place"),),
    lambda d, nodes, context: {"law": law_of(d["value"], context)}, check=check_apart, display=Display("actuator"),
)  # fmt: skip
INTERNAL_FORCE = _load(
    "internal_force", "Force between two nodes along an axis fixed in the first, such as that of a magnetic bearing",
    SLIDE, (NODES, AXIS),
    lambda d, nodes, context: {"law": law_of(d["value"], context), "mu": carried_axis(d, nodes)},
)  # fmt: skip
COUPLE = _load(
    "couple", "Moment between two nodes about an axis fixed in the first, such as that of a motor", TURN,
    (NODES, AXIS),
    lambda d, nodes, context: {"law": law_of(d["value"], context), "axis": carried_axis(d, nodes)},
    "on b about the axis, and on a against it", counts_angles=lambda d: [("axis", d["axis"], d["nodes"])],
)  # fmt: skip
