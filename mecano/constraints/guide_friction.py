r"""Friction of a guide: force along the axis from the reactions of a prismatic or cylindrical joint.

With the normal force N of the two ends of the guide and the drag
:math:`c(v) = \mu(|v|)\,\phi(|v|)\,\mathrm{sign}\,v`, a prismatic joint, whose key at the radius :math:`r_k` carries the
moment :math:`M_3` about the axis, has

.. math::  P = (N + |M_3|/r_k)\, c(\dot s)

In a cylindrical joint of radius r the surfaces slide at :math:`(\dot s, r\dot\theta)`: friction acts against that
vector of length u, so that a turning shaft slides easily:

.. math::  P = N\,\mu(u)\,\phi(u)\,\dot s/u, \qquad M = r\,N\,\mu(u)\,\phi(u)\,r\dot\theta/u
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import add_along, rate_of
from mecano.constraints.carried import relative_rotation, twist_gradient
from mecano.constraints.friction import (
    AXIS_ROWS,
    FORCE_ROWS,
    FRICTION_MOMENT,
    FRICTION_RECORD,
    NORMAL_FORCE,
    PADS,
    POWER,
    REGULARIZED,
    drag,
    friction_record,
    pads,
)  # fmt: skip
from mecano.constraints.slide import slide_along
from mecano.contract import Kind, Output, Row, record
from mecano.laws.friction import friction
from mecano.maths.dual import sqrt
from mecano.maths.vector import mat, vec

KEYED_RECORD = record(mu=3, inverse_key=(), **FRICTION_RECORD)
ROUND_RECORD = record(mu=3, xi=3, radius=(), **FRICTION_RECORD)
FORCE = Output("friction_force", "N", "force of the friction along the axis; > 0 against a positive velocity")


@kernel
def _keyed_friction(p, at, rate):
    """P [N] at this rate of sliding, N + |M_3|/r_k [N]."""
    N = pads(at.q[12], at.q[13], at.q[9], at.q[10], p.inverse_length) + p.inverse_key * abs(at.q[11])
    return N * drag(p, at.laws, rate), N


@kernel
def keyed_residual(p, at, f):
    """Add opposite forces on both nodes, and the moment on the first."""
    along = slide_along(p, at)
    add_along(f, _keyed_friction(p, at, rate_of(along, at.v))[0], along)


@kernel
def keyed_observe(p, at, F, y, e):
    """Force, normal force, power."""
    rate = rate_of(slide_along(p, at), at.v)
    y[0], y[1] = _keyed_friction(p, at, rate)
    y[2] = y[0] * rate
    e[2] = y[2]


@kernel
def _turn_along(p, at):
    b_0, b_1 = twist_gradient(relative_rotation(mat(at.R[0]), mat(at.R[1])), vec(p.mu, 0), vec(p.xi, 0))
    return (3, b_0), (9, b_1)


@kernel
def _round_friction(p, at, rate, turn):
    """P [N] and M [N m] at these rates of sliding and turning, N [N]."""
    N, rim = pads(at.q[14], at.q[15], at.q[12], at.q[13], p.inverse_length), p.radius * turn
    b = friction(at.laws, p.coefficient, p.regularization, sqrt(rate * rate + rim * rim))
    return N * b * rate, p.radius * N * b * rim, N


@kernel
def round_residual(p, at, f):
    """Add opposite forces and moments on both nodes."""
    along, about = slide_along(p, at), _turn_along(p, at)
    P, M, _ = _round_friction(p, at, rate_of(along, at.v), rate_of(about, at.v))
    add_along(f, P, along)
    add_along(f, M, about)


@kernel
def round_observe(p, at, F, y, e):
    """Force, moment, normal force, power."""
    rate, turn = rate_of(slide_along(p, at), at.v), rate_of(_turn_along(p, at), at.v)
    y[0], y[1], y[2] = _round_friction(p, at, rate, turn)
    y[3] = y[0] * rate + y[1] * turn
    e[2] = y[3]


def keyed_record(mu_3, friction, context):
    """Record of a prismatic joint: the axis (3,) carried by the first node, the deck's friction."""
    key = friction["key_radius"]
    inverse = 0.0 if key is None else 1.0 / key
    return {"mu": mu_3, "inverse_key": inverse, **friction_record(friction, context)}


def round_record(mu_3, xi_3, friction, context):
    """Record of a cylindrical joint: the axis (3,) in the axes of each node, the deck's friction."""
    return {"mu": mu_3, "xi": xi_3, "radius": friction["radius"], **friction_record(friction, context)}


KEYED_FRICTION = Kind(
    name="keyed_friction",
    section="",
    doc=__doc__ + PADS + REGULARIZED,
    dtype=KEYED_RECORD,
    layout=("x0", "R0", "x1"),
    borrowed=(*AXIS_ROWS, Row("moment about the axis", "N m", "rad"), *FORCE_ROWS[:2]),
    outputs=(FORCE, NORMAL_FORCE, POWER),
    residual=keyed_residual,
    observe=keyed_observe,
)

ROUND_FRICTION = Kind(
    name="round_friction",
    section="",
    doc=__doc__ + PADS + REGULARIZED,
    dtype=ROUND_RECORD,
    layout=("x0", "R0", "x1", "R1"),
    borrowed=(*AXIS_ROWS, *FORCE_ROWS[:2]),
    outputs=(FORCE, FRICTION_MOMENT, NORMAL_FORCE, POWER),
    residual=round_residual,
    observe=round_observe,
)
