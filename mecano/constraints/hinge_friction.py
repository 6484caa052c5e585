r"""Friction of a rotating bearing: moment about the axis caused by radial, axial and tilting reactions of a hinge.

With the normal force N of the two ends of the bearing, the axial force :math:`F_3` at a collar of radius
:math:`r_c`, and the drag :math:`c(v) = \mu(|v|)\,\phi(|v|)\,\mathrm{sign}\,v`:

.. math::  M = r\,N\,c(r\dot\theta) + r_c\,|F_3|\,c(r_c\dot\theta)
"""

from mecano.constraints.along_coordinate.friction import (
    AXIS_ROWS,
    FORCE_ROWS,
    FRICTION_MOMENT,
    PADS,
    REGULARIZED,
    drag,
    friction_kind,
    pads,
)  # fmt: skip
from mecano.constraints.coordinates.twist import TWIST
from mecano.jit.kernel import kernel

COUPLE, FORCE, AXIAL = 6, 8, 10  # local indices of the coupled multipliers


@kernel
def _load(p, at, rate):
    """Return M [N m] at this rate of the angle, and N [N]."""
    N = pads(at.q[FORCE], at.q[FORCE + 1], at.q[COUPLE], at.q[COUPLE + 1], p.inverse_length)
    collar = p.collar_radius * abs(at.q[AXIAL]) * drag(p, at.laws, p.collar_radius * rate)
    return p.radius * N * drag(p, at.laws, p.radius * rate) + collar, N


HINGE_FRICTION = friction_kind(
    "hinge_friction", __doc__ + PADS + REGULARIZED, TWIST, {"radius": (), "collar_radius": ()},
    (*AXIS_ROWS, *FORCE_ROWS), FRICTION_MOMENT, _load,
)  # fmt: skip
