r"""Friction of a bearing that turns: moment about the axis from the radial, axial and tilting reactions of a hinge.

With the normal force N of the two ends of the bearing, the axial force :math:`F_3` at a collar of radius
:math:`r_c`, and the drag :math:`c(v) = \mu(|v|)\,\phi(|v|)\,\mathrm{sign}\,v`:

.. math::  M = r\,N\,c(r\dot\theta) + r_c\,|F_3|\,c(r_c\dot\theta)
"""

import math

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import add_turning
from mecano.constraints.carried import relative_rotation, turning_rate, twist_curvature, twist_gradient
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
from mecano.maths.vector import add_col, mat, vec

RECORD = record(mu=3, xi=3, radius=(), collar_radius=(), **FRICTION_RECORD)
BORROWED = 6


@kernel
def _moment(p, laws, q, rate):
    """M, its derivatives by the rate and by the five multipliers, N."""
    N, by = pads(q[BORROWED + 2], q[BORROWED + 3], q[BORROWED], q[BORROWED + 1], p.inverse_length)
    c, c_v = drag(p, laws, p.radius * rate)
    c_collar, c_collar_v = drag(p, laws, p.collar_radius * rate)
    axial = q[BORROWED + 4]
    M = p.radius * N * c + p.collar_radius * abs(axial) * c_collar
    M_rate = p.radius**2 * N * c_v + p.collar_radius**2 * abs(axial) * c_collar_v
    r_c = p.radius * c
    sign = math.copysign(1.0, axial) if axial != 0.0 else 0.0
    return M, M_rate, (r_c * by[2], r_c * by[3], r_c * by[0], r_c * by[1], p.collar_radius * c_collar * sign), N


@kernel
def force(p, at, f, K, C, M):
    """Opposite moments on both nodes."""
    mu, xi = vec(p.mu, 0), vec(p.xi, 0)
    A = relative_rotation(mat(at.R[0]), mat(at.R[1]))
    gradient, H = twist_gradient(A, mu, xi), twist_curvature(A, mu, xi)
    omega_0, omega_1 = vec(at.v, 0), vec(at.v, 3)
    moment, moment_rate, by, _ = _moment(p, at.laws, at.q, turning_rate(gradient, omega_0, omega_1))
    add_turning(f, K, C, moment, 0.0, moment_rate, gradient, H, omega_0, omega_1)
    for i in range(5):
        add_col(K, 0, BORROWED + i, at.k * by[i], gradient[0])
        add_col(K, 3, BORROWED + i, at.k * by[i], gradient[1])


@kernel
def observe(p, at, F, y, e):
    """Moment, normal force, power."""
    A = relative_rotation(mat(at.R[0]), mat(at.R[1]))
    rate = turning_rate(twist_gradient(A, vec(p.mu, 0), vec(p.xi, 0)), vec(at.v, 0), vec(at.v, 3))
    y[0], _, _, y[1] = _moment(p, at.laws, at.q, rate)
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
    force=force,
    observe=observe,
)
