r"""Torsion spring-damper: a moment about an axis, from a law of the relative angle of two nodes and its rate.

The axis is fixed in both nodes; the angle is the hinge angle if a hinge keeps the axes aligned, and otherwise the
twist, the part of the relative rotation that remains after removing the smallest rotation from the axis of a to that of
b. It is continued over whole turns. M > 0 turns the nodes back against a positive angle, as N > 0 of a spring pulls its
ends together:

.. math::  M = M(\theta - \theta_0, \dot\theta - \dot\theta_0)

The natural angle :math:`\theta_0` may be a law of time or a formula of signals: the set point of an elastic drive,
whose power :math:`-M\dot\theta_0` the surroundings give. With a ``stress_free`` activation the angle counts from that
instant.
"""

from mecano.constraints.activation import SHIFT, since_activation, with_activation
from mecano.constraints.along_coordinate.demand import on_demand, with_rate
from mecano.constraints.along_coordinate.law import (
    SET_POINT,
    counted,
    extension,
    law_kind,
    law_values,
    report,
    set_point_of_law,
)
from mecano.constraints.along_coordinate.measure import OVER_TURNS, angle_outputs
from mecano.constraints.coordinates.coordinate import rate_of
from mecano.constraints.coordinates.twist import TWIST
from mecano.constraints.joint_nodes import NODES
from mecano.constraints.joint_samples import SPRUNG
from mecano.constraints.of_coordinates import TWIST_LAW
from mecano.constraints.release import with_release
from mecano.constraints.stop_phases import EVENTS, PHASES
from mecano.constraints.triads import triad
from mecano.element_interface import Display, Kind, Measured, Output
from mecano.jit.kernel import kernel
from mecano.schema import CONTINUOUS_DRIVE, DIRECTION, LAW, Field

angle, along = counted(TWIST), TWIST.gradient


def prepare(d, nodes, context):
    """Return the record of one spring: the triad in the axes of both nodes."""
    axes = triad(d["axis"])
    ends = {"mu": axes @ nodes[0][1], "xi": axes @ nodes[1][1]}
    return law_values(ends, d["law"], d["natural_angle"], context)


STOPPED = (*SPRUNG, ("stop", {"stiffness": 9.0, "lower": -0.5, "upper": 0.5, "damping": 0.1}))  # of samples
BENT = (
    ("table", {"points": [[-7, -3], [0, 0], [7, 8]], "file": None, "interpolation": "cubic", "beyond": "extend"}),
    ("damper", {"coefficient": 1.5}),
)


def _angle(d, nodes, context):
    p = prepare(d, nodes, context)
    return Measured(TWIST, (0, 1), {"mu": p["mu"], "xi": p["xi"]})


def _functions(set_point):
    """Return the functions of a spring with this ``set_point`` (p, at) -> natural angle and its rate."""
    law = law_kind(TWIST_LAW.name, TWIST_LAW.doc, TWIST, set_point)

    @kernel
    def observe(p, at, F, y, e):
        theta, rate = angle(p, at), rate_of(along(p, at), at.v)
        y[0], y[1] = theta, rate
        report(p, at, set_point(p, at), theta, rate, y[2:], e)

    return {"residual": law.residual, "observe": observe, "event_values": law.event_values, "commit": law.commit}


def _stress_free(set_point):
    """Return the functions and the memory of a spring whose law takes the angle since its activation."""

    @kernel
    def commit(p, at, m_out):
        theta = angle(p, at)
        m_out[0], m_out[1] = theta, extension(p, set_point(p, at), theta)

    return {**_functions(since_activation(set_point, 1)), "memory": ("angle", SHIFT), "commit": commit}


def _spring(functions):
    """Return the Kind of a spring with these ``functions`` of its set point, and with a release."""
    kind = Kind(
        name="torsion_spring_damper", section="elements", doc=__doc__,
        display=Display("nothing", pictures=("torsion_springs",)), dtype=TWIST_LAW.dtype, layout=("R0", "R1"),
        fields=(
            NODES,
            Field("axis", DIRECTION, "-", "axis at the start, inertial"),
            Field(
                "law", LAW, "-", "moment [N m] from angle [rad] and rate [rad/s]; > 0 turns against a positive angle",
                argument="rad",
            ),
            Field("natural_angle", CONTINUOUS_DRIVE, "rad", f"angle {SET_POINT.format('spring')}", 0.0),
        ),
        outputs=(
            *angle_outputs(OVER_TURNS),
            Output("moment", "N m", "moment of the law: on a about +axis, on b about -axis"),
        ),
        phases=PHASES,
        events=EVENTS,
        memory=("angle",),
        counts_angles=lambda d: [("axis", d["axis"], d["nodes"])],
        prepare=prepare,
        cases=(*({"law": STOPPED, "natural_angle": angle} for angle in (1.5, 0.0, -1.5)), {"law": BENT}),
        measures={"angle": _angle},
    )  # fmt: skip
    return with_release(on_demand(kind, functions, "natural_angle", set_point_of_law, with_rate), "spring", (2,))


TORSION_SPRING_DAMPER = with_activation(_spring(_functions), "spring", (2,), (_spring(_stress_free), (2,)))
