r"""Constant-velocity joint: both shafts turn at the same rate at any angle between them (Rzeppa, tripod).

Both nodes share one position (Boolean identification: no multiplier). With the axes :math:`\mu_3` of the shaft of a and
:math:`\xi_3` of that of b, the joint holds their *twist*, the part of the relative rotation beyond the smallest
rotation from :math:`\mu_3` to :math:`\xi_3`:

.. math::  \mu_2 \cdot \xi_1 - \mu_1 \cdot \xi_2 = 0

The multiplier M is the torque along either shaft. The moment of a on b acts along the line that halves the angle
between the shafts, perpendicular to their common normal, and so bends both shafts by M tan(bend/2):

.. math::  M\,\frac{\mu_3 + \xi_3}{1 + \mu_3 \cdot \xi_3}

With ``compliance`` a law replaces a rigid constraint: torsional elasticity or play (``about_axis``), or elasticity of
the position. A universal joint turns its second shaft unevenly.
"""

from mecano.constraints.along_coordinate.measure import REACTIONS, Outputs
from mecano.constraints.body_fixed import relative_rotation
from mecano.constraints.coordinates.twist import turned, twist_gradient
from mecano.constraints.joint_nodes import check_one_place, one_position
from mecano.constraints.joint_samples import SPRUNG
from mecano.constraints.pair import AXIS_B, bent_place, held, pair_force
from mecano.element_interface import Display, Output
from mecano.elements.joints.lower_pair import LowerPair, Shared, sharing_pair
from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, atan2, number, sqrt
from mecano.maths.vector import cross, dot, mat, put, vec
from mecano.schema import DIRECTION, Field

HELD = ("about_axis", "along_1", "along_2", "along_axis")
STRAIGHT = 1e-30  # square of the sine of the bend below which it has no slope


@kernel
def _put_bend(p, at, F, y, i):
    mu_3, xi_3 = vec(p.mu[2], 0), relative_rotation(at) @ vec(p.xi[2], 0)
    normal = cross(mu_3, xi_3)
    y[i] = atan2(sqrt(at_least(dot(normal, normal), STRAIGHT)), dot(mu_3, xi_3))


@kernel
def _put_moment(p, at, torque, y, i):
    mu = mat(p.mu)
    put(y, i, -torque * (mu @ twist_gradient(relative_rotation(at), mu[2], vec(p.xi[2], 0))[0]))


@kernel
def _put_reactions(p, at, F, y, i):
    """Write force and moment on b of a joint each of whose axes is held by a part of its own."""
    angle, rate = turned(p, at)
    put(y, i, pair_force(p, at))
    _put_moment(p, at, held(p, at, 2, angle, rate), y, i + 3)


@kernel
def _put_reactions_of_shared(p, at, F, y, i):
    """Write the force on b that its shared position hides, and the moment of the multiplier."""
    put(y, i, -(mat(p.mu) @ (mat(at.R[0]).T @ vec(F, 6))))
    _put_moment(p, at, number(at.q[12]), y, i + 3)


BENT = {"axis": (1, 0, 0), "axis_b": (1, 0.3, 0.2)}  # of samples
CONSTANT_VELOCITY = sharing_pair(
    "constant_velocity", __doc__,
    LowerPair(
        axis=Field("axis", DIRECTION, "-", "axis of the shaft of a at the start, inertial"),
        held=HELD,
        display=Display(force="force", along_axes=True),
        motions=(Outputs((Output("bend", "rad", "angle between both shafts", geometric=True),), _put_bend),),
        reactions=Outputs(REACTIONS, _put_reactions),
        fields=(AXIS_B,),
        place=bent_place,
    ),
    Shared(one_position, ("about_axis",), _put_reactions_of_shared, ("force",), check_one_place),
    cases=(BENT, {**BENT, "axis_1": (0.0, 1.0, 2.0), "compliance": dict.fromkeys(HELD, SPRUNG)}),
)  # fmt: skip
