r"""Friction of a bearing that turns: moment about the axis from the radial, axial and tilting reactions of a hinge.

With the normal force N of the two ends of the bearing, the axial force :math:`F_3` at a collar of radius
:math:`r_c`, and the drag :math:`c(v) = \mu(|v|)\,\phi(|v|)\,\mathrm{sign}\,v`:

.. math::  M = r\,N\,c(r\dot\theta) + r_c\,|F_3|\,c(r_c\dot\theta)
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
from mecano.contract import Kind, record
from mecano.maths.vector import mat, vec

RECORD = record(mu=3, xi=3, radius=(), collar_radius=(), **FRICTION_RECORD)
BORROWED = 6


@kernel
def _along(p, at):
    b_0, b_1 = twist_gradient(relative_rotation(mat(at.R[0]), mat(at.R[1])), vec(p.mu, 0), vec(p.xi, 0))
    return (0, b_0), (3, b_1)


@kernel
def _friction(p, at, rate):
    """M [N m] at this rate of the angle, N [N]."""
    m, F, axial = BORROWED, BORROWED + 2, at.q[BORROWED + 4]
    N = pads(at.q[F], at.q[F + 1], at.q[m], at.q[m + 1], p.inverse_length)
    collar = p.collar_radius * abs(axial) * drag(p, at.laws, p.collar_radius * rate)
    return p.radius * N * drag(p, at.laws, p.radius * rate) + collar, N


@kernel
def residual(p, at, f):
    """Add opposite moments on both nodes."""
    along = _along(p, at)
    add_along(f, _friction(p, at, rate_of(along, at.v))[0], along)


@kernel
def observe(p, at, F, y, e):
    """Moment, normal force, power."""
    rate = rate_of(_along(p, at), at.v)
    y[0], y[1] = _friction(p, at, rate)
    y[2] = y[0] * rate
    e[2] = y[2]


def hinge_friction_record(mu_3, xi_3, friction, context):
    """Record: the axis (3,) in the axes of each node, and the deck's friction."""
    geometry = {"radius": friction["radius"], "collar_radius": friction["collar_radius"]}
    return {"mu": mu_3, "xi": xi_3, **geometry, **friction_record(friction, context)}


HINGE_FRICTION = Kind(
    name="hinge_friction",
    section="",
    doc=__doc__ + PADS + REGULARIZED,
    dtype=RECORD,
    layout=("R0", "R1"),
    borrowed=(*AXIS_ROWS, *FORCE_ROWS),
    outputs=(FRICTION_MOMENT, NORMAL_FORCE, POWER),
    residual=residual,
    observe=observe,
)
