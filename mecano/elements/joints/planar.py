r"""Planar joint: node b slides in a plane fixed in node a and rotates about its normal.

With :math:`\mu_3` the normal fixed in a and :math:`\xi_3` the one fixed in b:

.. math::  \mu_1 \cdot \xi_3 = 0, \qquad \mu_2 \cdot \xi_3 = 0, \qquad \mu_3 \cdot (x_b - x_a) - c = 0

The constant c is the initial value: the plane passes through node b. The multipliers are the moments on b about
:math:`+\mu_2` and :math:`-\mu_1`, then the force on b along the normal, of either sign: b cannot leave the plane. The
axes in the plane are chosen as for the hinge, and the assembly rejects :math:`\xi_3 = -\mu_3`.

Option: ``turning_law`` gives a moment about the normal from the angle and its rate.
"""

from mecano.constraints.along_coordinate.law import TURNING_FIELDS
from mecano.constraints.along_coordinate.measure import MOMENT, TURNING, follow_turning, put_turning
from mecano.constraints.coordinates.slide import slide
from mecano.constraints.joint_frame import NODES, not_across, not_flipped
from mecano.constraints.joint_samples import SPRUNG, two_places
from mecano.constraints.of_coordinates import TWIST_LAW, turning_parts
from mecano.constraints.pair import AXES_RECORD, AXIS_1, axis_place, pair_parts
from mecano.element_interface import Display, Kind, Output
from mecano.jit.kernel import kernel
from mecano.maths.vector import mat, put, vec
from mecano.schema import DIRECTION, Field

HELD = ("about_2", "about_1", "along_axis")


@kernel
def observe(p, at, F, y, e):
    """Write sliding, rotation and reactions."""
    for i in range(3):
        along, y[3 + i] = slide(at.q, at.v, mat(at.R[0]), vec(p.mu[i], 0))
        y[i] = along - p.start[i]
    put_turning(p, at.m, at.v, at.R, y, 6)
    y[8] = at.q[14]
    put(y, 9, (-at.q[13], at.q[12], 0.0))


def parts(d, nodes, context):
    """Return the Parts that keep the normals parallel and b in the plane; the law of the angle."""
    p = axis_place(d, nodes, context)
    return pair_parts(p, HELD, None, context) + turning_parts(d, p, context)


def sample(rng):
    """Return a random plane next to the first node, with and without the law."""
    nodes, d = two_places(rng), {"axis": rng.normal(size=3)}
    law = {"turning_law": SPRUNG, "natural_angle": 0.2}
    return [(d, nodes, ""), ({**d, "axis_1": rng.normal(size=3), **law}, nodes, "")]


PLANAR = Kind(
    name="planar",
    section="joints",
    doc=__doc__,
    display=Display(support=False, pictures=("planes",)),
    dtype=AXES_RECORD,
    layout=("x0", "R0", "x1", "R1"),
    fields=(
        NODES,
        Field("axis", DIRECTION, "-", "normal of the plane at the start, inertial; fixed in a"),
        AXIS_1,
        *TURNING_FIELDS,
    ),
    outputs=(
        Output(
            "displacement",
            "m",
            "sliding of b relative to a along mu_1, mu_2 and the normal since the start",
            (3,),
            rate="velocity",
        ),
        Output("velocity", "m/s", "rate of the displacement", (3,)),
        *TURNING,
        Output("force", "N", "force of a on b along the normal"),
        MOMENT,
    ),
    optional=(("turning_law", TWIST_LAW, ""),),
    memory=("angle",),
    prepare=axis_place,
    parts=parts,
    check=not_across,
    observe=observe,
    commit=follow_turning,
    admissible=not_flipped,
    sample=sample,
)
