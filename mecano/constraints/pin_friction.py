r"""Friction of one pin of a universal joint, from the force and the couple that the cross transmits.

The pin :math:`\mu_3` is carried by the first node, the other one, :math:`\xi`, by the second. With the force F of the
joint (inertial multipliers), the multiplier m of :math:`\mu_3 \cdot \xi = 0` and the components along
:math:`\mu_1, \mu_2` of both :math:`y = \mu R_0^T F` and the other pin, (u, w), the two ends of the pin, a length
:math:`\ell` apart, carry :math:`y/2 \pm (m/\ell) (u, w)`. N is the sum of the sizes of both, and

.. math::  M = r\,N\,\mu(|v|)\,\phi(|v|)\,\mathrm{sign}\,v, \qquad v = r\dot\theta

acts against the angle of the pin.
"""

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import add_turning
from mecano.constraints.carried import product_gradient, relative_rotation, turning_rate
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
from mecano.constraints.pin_angle import pin_curvature, pin_gradient
from mecano.contract import Kind, Row, record
from mecano.maths.vector import add_col, add_mat, cross, dot, mat, outer, vec

RECORD = record(mu=(3, 3), xi=3, radius=(), **FRICTION_RECORD)
BORROWED = 6


@kernel
def _normal(p, q, R_0, A):
    """N, its derivatives by y_1, y_2, (m/l)(u, w), and u, w, y in the axes of the first node."""
    mu, pin, F = mat(p.mu), A @ vec(p.xi, 0), R_0.T @ vec(q, BORROWED + 1)
    u, w, couple = dot(mu[0], pin), dot(mu[1], pin), q[BORROWED]
    N, by = pads(dot(mu[0], F), dot(mu[1], F), couple * u, couple * w, p.inverse_length)
    return N, by, u, w, F


@kernel
def force(p, at, f, K, C, M):
    """Opposite moments on both nodes."""
    mu, xi, R_0 = mat(p.mu), vec(p.xi, 0), mat(at.R[0])
    A = relative_rotation(R_0, mat(at.R[1]))
    gradient, H = pin_gradient(A, mu, xi), pin_curvature(A, mu, xi)
    omega_0, omega_1 = vec(at.v, 0), vec(at.v, 3)
    c, c_v = drag(p, at.laws, p.radius * turning_rate(gradient, omega_0, omega_1))
    N, by, u, w, F = _normal(p, at.q, R_0, A)
    moment, slope, per_N = p.radius * N * c, p.radius**2 * N * c_v, p.radius * c
    add_turning(f, K, C, moment, 0.0, slope, gradient, H, omega_0, omega_1)

    by_u, by_w, couple = product_gradient(A, mu[0], xi), product_gradient(A, mu[1], xi), at.q[BORROWED]
    on_1 = couple * by[2] * by_u[1] + couple * by[3] * by_w[1]
    on_0 = couple * by[2] * by_u[0] + couple * by[3] * by_w[0]
    on_0 = on_0 + (by[0] * cross(mu[0], F) + by[1] * cross(mu[1], F))
    by_F = R_0 @ (by[0] * mu[0] + by[1] * mu[1])
    for i in range(2):
        add_mat(K, 3 * i, 0, per_N, outer(gradient[i], on_0))
        add_mat(K, 3 * i, 3, per_N, outer(gradient[i], on_1))
        add_col(K, 3 * i, BORROWED, at.k * per_N * (by[2] * u + by[3] * w), gradient[i])
        add_mat(K, 3 * i, BORROWED + 1, at.k * per_N, outer(gradient[i], by_F))


@kernel
def observe(p, at, F, y, e):
    """Moment, normal force, power."""
    A = relative_rotation(mat(at.R[0]), mat(at.R[1]))
    rate = turning_rate(pin_gradient(A, mat(p.mu), vec(p.xi, 0)), vec(at.v, 0), vec(at.v, 3))
    y[1] = _normal(p, at.q, mat(at.R[0]), A)[0]
    y[0] = p.radius * y[1] * drag(p, at.laws, p.radius * rate)[0]
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
    force=force,
    observe=observe,
)
