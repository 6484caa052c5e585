r"""Fixed joint: two nodes share position and rotation (Boolean identification: no equation).

Nodes with different orientations at the start keep their relative rotation, each axis by a multiplier.

With ``compliance`` laws hold b along and about the axes that a carries; axes without a law have a multiplier each.
:math:`\mu_3` is ``axis``, :math:`\mu_1` is ``axis_1`` or the inertial axis most perpendicular to it. For stiffness that
couples the axes see ``bushing``. With ``release`` it holds b by multipliers until then.
"""

import numpy as np

from mecano.constraints.along_coordinate.measure import Outputs
from mecano.constraints.joint_nodes import check_one_place, one_position, one_rotation, turned_apart
from mecano.constraints.joint_samples import AXIS_1, PLAY, SPRUNG
from mecano.constraints.pair import AXES, axis_place, pair_force, pair_moment
from mecano.element_interface import Display, Output
from mecano.elements.joints.lower_pair import LowerPair, Shared, sharing_pair
from mecano.jit.kernel import kernel
from mecano.maths.vector import mat, put, vec
from mecano.schema import DIRECTION, Field


@kernel
def _put_shared(p, at, F, y, i):
    """Write the reactions that shared unknowns hide."""
    put(y, i, -vec(F, 6))
    put(y, i + 3, -(mat(at.R[1]) @ vec(F, 9)))


@kernel
def _put_held(p, at, F, y, i):
    """Write the reactions where every axis is held by a part of its own."""
    axes = mat(at.R[0]) @ mat(p.mu).T
    put(y, i, axes @ pair_force(p, at))
    put(y, i + 3, axes @ pair_moment(p, at))


FIXED = sharing_pair(
    "fixed", __doc__,
    LowerPair(
        axis=Field("axis", DIRECTION, "-", "axis of the compliance at the start, inertial", (0.0, 0.0, 1.0)),
        held=AXES,
        display=Display(force="force"),
        reactions=Outputs(
            (
                Output("force", "N", "force of a on b, inertial axes", (3,)),
                Output("moment", "N m", "moment of a on b, inertial axes", (3,)),
            ),
            _put_held,
        ),
        place=lambda d, nodes, context: {**axis_place(d, nodes, context), "start": np.zeros(3)},
    ),
    Shared(
        lambda d, nodes: one_position(d, nodes) + one_rotation(d, nodes),
        (),
        _put_shared,
        ("force", "moment"),
        check_one_place,
        turned_apart,
    ),
    cases=(
        {},
        {"axis_1": AXIS_1, "compliance": dict.fromkeys(AXES, SPRUNG)},
        {"axis_1": AXIS_1, "compliance": {"along_2": PLAY, "about_1": SPRUNG}},
    ),
)  # fmt: skip
