r"""Friction of one pin of a universal joint, caused by the force and the couple that the cross transmits.

The pin :math:`\mu_3` is fixed in the first node, the other one, :math:`\xi`, in the second. With the force F of the
joint (inertial multipliers), the multiplier m of :math:`\mu_3 \cdot \xi = 0` and the components along
:math:`\mu_1, \mu_2` of both :math:`y = \mu R_0^T F` and the other pin, (u, w), the two ends of the pin, a length
:math:`\ell` apart, carry :math:`y/2 \pm (m/\ell) (u, w)`. N is the sum of the magnitudes of both, and

.. math::  M = r\,N\,\mu(|v|)\,\phi(|v|)\,\mathrm{sign}\,v, \qquad v = r\dot\theta

acts against the angle of the pin.
"""

from mecano.constraints.along_coordinate.friction import FRICTION_MOMENT, REGULARIZED, drag, friction_kind, pads
from mecano.constraints.body_fixed import relative_rotation
from mecano.constraints.coordinates.pin_angle import PIN_ANGLE
from mecano.element_interface import Row
from mecano.jit.kernel import kernel
from mecano.maths.vector import dot, mat, vec

COUPLE, FORCE = 6, 7  # local indices of the coupled multipliers
ROWS = (
    Row("moment that keeps the pins perpendicular", "N m", "rad"),
    *(Row(f"force {axis} of the joint", "N", "m") for axis in "xyz"),
)


@kernel
def _load(p, at, rate):
    """Return M [N m] at this rate of the angle, and N [N]."""
    mu, pin, F = mat(p.mu), relative_rotation(at) @ vec(p.xi, 0), mat(at.R[0]).T @ vec(at.q, FORCE)
    couple = at.q[COUPLE]
    m_1, m_2 = couple * dot(mu[0], pin), couple * dot(mu[1], pin)
    N = pads(dot(mu[0], F), dot(mu[1], F), m_1, m_2, p.inverse_length)
    return p.radius * N * drag(p, at.laws, p.radius * rate), N


PIN_FRICTION = friction_kind(
    "pin_friction", __doc__ + REGULARIZED, PIN_ANGLE, {"radius": ()}, ROWS, FRICTION_MOMENT, _load
)
