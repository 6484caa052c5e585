r"""Friction of a guide: force along the axis caused by the reactions of a prismatic or cylindrical joint.

With the normal force N of the two ends of the guide and the drag :math:`c(v) = \mu(|v|)\,\phi(|v|)\,\mathrm{sign}\,v`,
a prismatic joint, whose key at the radius :math:`r_k` carries the moment :math:`M_3` about the axis, has

.. math::  P = (N + |M_3|/r_k)\, c(\dot s)

In a cylindrical joint of radius r the surfaces slide at :math:`(\dot s, r\dot\theta)`: friction acts against this
vector of length u, so that a rotating shaft slides easily:

.. math::  P = N\,\mu(u)\,\phi(u)\,\dot s/u, \qquad M = r\,N\,\mu(u)\,\phi(u)\,r\dot\theta/u
"""

from mecano.constraints.along_coordinate.friction import (
    AXIS_ROWS,
    FORCE_ROWS,
    FRICTION_FORCE,
    FRICTION_MOMENT,
    FRICTION_RECORD,
    NORMAL_FORCE,
    PADS,
    POWER,
    REGULARIZED,
    drag,
    friction_kind,
    pads,
)  # fmt: skip
from mecano.constraints.body_fixed import relative_rotation
from mecano.constraints.coordinates.coordinate import add_along, rate_of
from mecano.constraints.coordinates.slide import SLIDE, slide_gradient
from mecano.constraints.coordinates.twist import TWIST, twist_gradient
from mecano.element_interface import Kind, Row, record
from mecano.jit.kernel import kernel
from mecano.laws.friction import friction
from mecano.maths.dual import sqrt
from mecano.maths.vector import vec


@kernel
def _keyed_load(p, at, rate):
    """Return P [N] at this sliding velocity, and N + |M_3|/r_k [N]."""
    N = pads(at.q[12], at.q[13], at.q[9], at.q[10], p.inverse_length) + p.inverse_key_radius * abs(at.q[11])
    return N * drag(p, at.laws, rate), N


@kernel
def _gradients(p, at):
    """Return the gradients of sliding and turning by blocks of the local unknowns."""
    b_0, b_1 = twist_gradient(relative_rotation(at), vec(p.mu[2], 0), vec(p.xi[2], 0))
    return slide_gradient(at, vec(p.mu[2], 0)), ((3, b_0), (9, b_1))


@kernel
def _round_friction(p, at, rate, turn):
    """Return P [N] and M [N m] at these rates of sliding and turning, and N [N]."""
    N, rim = pads(at.q[14], at.q[15], at.q[12], at.q[13], p.inverse_length), p.radius * turn
    b = friction(at.laws, p.coefficient, p.regularization, sqrt(rate * rate + rim * rim))
    return N * b * rate, p.radius * N * b * rim, N


@kernel
def round_residual(p, at, f):
    """Add opposite forces and moments to both nodes."""
    along, about = _gradients(p, at)
    P, M, _ = _round_friction(p, at, rate_of(along, at.v), rate_of(about, at.v))
    add_along(f, P, along)
    add_along(f, M, about)


@kernel
def round_observe(p, at, F, y, e):
    """Write force, moment, normal force, power."""
    along, about = _gradients(p, at)
    rate, turn = rate_of(along, at.v), rate_of(about, at.v)
    P, M, N = _round_friction(p, at, rate, turn)
    y[0], y[1], y[2], y[3] = P, M, N, P * rate + M * turn
    e[2] = P * rate + M * turn


KEYED_FRICTION = friction_kind(
    "keyed_friction", __doc__ + PADS + REGULARIZED, SLIDE, {"inverse_key_radius": ()},
    (*AXIS_ROWS, Row("moment about the axis", "N m", "rad"), *FORCE_ROWS[:2]), FRICTION_FORCE, _keyed_load,
)  # fmt: skip

ROUND_FRICTION = Kind(
    name="round_friction", doc=__doc__ + PADS + REGULARIZED, dtype=record(radius=(), **TWIST.axes, **FRICTION_RECORD),
    layout=("x0", "R0", "x1", "R1"),
    coupled_multipliers=(*AXIS_ROWS, *FORCE_ROWS[:2]),
    outputs=(FRICTION_FORCE, FRICTION_MOMENT, NORMAL_FORCE, POWER),
    residual=round_residual,
    observe=round_observe,
)  # fmt: skip
