r"""Friction of one pin of a universal joint, from the force and the couple that the cross transmits.

The pin :math:`\mu_3` is carried by the first node, the other one, :math:`\xi`, by the second. With the force F of the
joint (inertial multipliers), the multiplier m of :math:`\mu_3 \cdot \xi = 0` and the components along
:math:`\mu_1, \mu_2` of both :math:`y = \mu R_0^T F` and the other pin, (u, w), the two ends of the pin, a length
:math:`\ell` apart, carry :math:`y/2 \pm (m/\ell) (u, w)`. N is the sum of the sizes of both, and

.. math::  M = r\,N\,\mu(|v|)\,\phi(|v|)\,\mathrm{sign}\,v, \qquad v = r\dot\theta

acts against the angle of the pin.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import add_along, rate_of
from mecano.constraints.carried import relative_rotation
from mecano.constraints.friction import (
    FRICTION_MOMENT,
    FRICTION_RECORD,
    NORMAL_FORCE,
    POWER,
    REGULARIZED,
    drag,
    friction_record,
    pads,
)  # fmt: skip
from mecano.constraints.pin_law import pin_along
from mecano.contract import Kind, Row, record
from mecano.maths.vector import dot, mat, vec

RECORD = record(mu=(3, 3), xi=3, radius=(), **FRICTION_RECORD)
BORROWED = 6


@kernel
def _friction(p, at, rate):
    """M [N m] at this rate of the angle, N [N]."""
    R_0, mu = mat(at.R[0]), mat(p.mu)
    pin, F = relative_rotation(R_0, mat(at.R[1])) @ vec(p.xi, 0), R_0.T @ vec(at.q, BORROWED + 1)
    couple = at.q[BORROWED]
    m_1, m_2 = couple * dot(mu[0], pin), couple * dot(mu[1], pin)
    N = pads(dot(mu[0], F), dot(mu[1], F), m_1, m_2, p.inverse_length)
    return p.radius * N * drag(p, at.laws, p.radius * rate), N


@kernel
def residual(p, at, f):
    """Add opposite moments on both nodes."""
    along = pin_along(p, at)
    add_along(f, _friction(p, at, rate_of(along, at.v))[0], along)


@kernel
def observe(p, at, F, y, e):
    """Moment, normal force, power."""
    rate = rate_of(pin_along(p, at), at.v)
    y[0], y[1] = _friction(p, at, rate)
    y[2] = y[0] * rate
    e[2] = y[2]


def pin_friction_record(mu, xi, radius, friction, context):
    """Record: axes (3, 3) of the first node, rows, the pin (3,) of the second, radius [m] of the pin mu_3."""
    return {"mu": mu, "xi": xi, "radius": radius, **friction_record(friction, context)}


PIN_FRICTION = Kind(
    name="pin_friction",
    section="",
    doc=__doc__ + REGULARIZED,
    dtype=RECORD,
    layout=("R0", "R1"),
    borrowed=(
        Row("moment that keeps the pins perpendicular", "N m", "rad"),
        *(Row(f"force {axis} of the joint", "N", "m") for axis in "xyz"),
    ),
    outputs=(FRICTION_MOMENT, NORMAL_FORCE, POWER),
    residual=residual,
    observe=observe,
)
