r"""Friction of a guide: force along the axis from the reactions of a prismatic or cylindrical joint.

With the normal force N of the two ends of the guide and the drag
:math:`c(v) = \mu(|v|)\,\phi(|v|)\,\mathrm{sign}\,v`, a prismatic joint, whose key at the radius :math:`r_k` carries the
moment :math:`M_3` about the axis, has

.. math::  P = (N + |M_3|/r_k)\, c(\dot s)

In a cylindrical joint of radius r the surfaces slide at :math:`(\dot s, r\dot\theta)`: friction acts against that
vector of length u, so that a turning shaft slides easily:

.. math::  P = N\,\mu(u)\,\phi(u)\,\dot s/u, \qquad M = r\,N\,\mu(u)\,\phi(u)\,r\dot\theta/u
"""

import math

from mecano.compiled.kernel import kernel
from mecano.constraints.axis_law import add_along, turning_blocks
from mecano.constraints.carried import (
    add_blocks,
    relative_rotation,
    turning_rate,
    twist_curvature,
    twist_gradient,
)  # fmt: skip
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
from mecano.constraints.slide import add_slide_curvature, slide, slide_gradient, slide_rate_gradient
from mecano.contract import Kind, Output, Row, record
from mecano.laws.friction import friction_factor
from mecano.maths.vector import ZERO, add_col, add_mat, add_vec, mat, outer, vec

KEYED_RECORD = record(mu=3, inverse_key=(), **FRICTION_RECORD)
ROUND_RECORD = record(mu=3, xi=3, radius=(), **FRICTION_RECORD)
FORCE = Output("friction_force", "N", "force of the friction along the axis; > 0 against a positive velocity")


@kernel
def _keyed_normal(p, q):
    """N + |M_3|/r_k and its derivatives by the five borrowed multipliers."""
    N, by = pads(q[12], q[13], q[9], q[10], p.inverse_length)
    torsion = q[11]
    by_torsion = math.copysign(p.inverse_key, torsion) if torsion != 0.0 else 0.0
    return N + p.inverse_key * abs(torsion), (by[2], by[3], by_torsion, by[0], by[1])


@kernel
def keyed_force(p, at, f, K, C, M):
    """Opposite forces on both nodes, and the moment on the first."""
    mu, A = vec(p.mu, 0), mat(at.R[0])
    N, by = _keyed_normal(p, at.q)
    c, c_v = drag(p, at.laws, slide(at.q, at.v, A, mu)[1])
    b, r = slide_gradient(at.q, A, mu), slide_rate_gradient(at.q, at.v, A, mu)
    add_along(f, K, C, N * c, 0.0, N * c_v, ((0, b[0], r[0]), (3, b[1], r[1]), (6, b[2], r[2])))
    add_slide_curvature(K, N * c, at.q, A, mu)
    for j in range(5):
        for i in range(3):
            add_col(K, 3 * i, 9 + j, at.k * c * by[j], b[i])


@kernel
def keyed_observe(p, at, F, y, e):
    """Force, normal force, power."""
    rate = slide(at.q, at.v, mat(at.R[0]), vec(p.mu, 0))[1]
    y[1] = _keyed_normal(p, at.q)[0]
    y[0] = y[1] * drag(p, at.laws, rate)[0]
    y[2] = y[0] * rate
    e[2] = y[2]


@kernel
def _round(p, laws, q, rate, turn):
    """N, its derivatives, (P, M)/N and the derivative (2, 2) of that by the rates of s and theta."""
    N, by = pads(q[14], q[15], q[12], q[13], p.inverse_length)
    r = p.radius
    rim = r * turn
    u = math.sqrt(rate * rate + rim * rim)
    _, b, b1 = friction_factor(laws, p.coefficient, p.regularization, u)
    bend = b1 / (u * u) if u > 0.0 else 0.0
    crossed = r * bend * rate * rim
    slope = ((b + bend * rate * rate, crossed), (crossed, r * r * (b + bend * rim * rim)))
    return N, (by[2], by[3], by[0], by[1]), (b * rate, r * b * rim), slope


@kernel
def round_force(p, at, f, K, C, M):
    """Opposite forces and moments on both nodes."""
    mu, xi, A = vec(p.mu, 0), vec(p.xi, 0), mat(at.R[0])
    Q = relative_rotation(A, mat(at.R[1]))
    omega_0, omega_1 = vec(at.v, 3), vec(at.v, 9)
    gradient, H = twist_gradient(Q, mu, xi), twist_curvature(Q, mu, xi)
    N, by, c, slope = _round(p, at.laws, at.q, slide(at.q, at.v, A, mu)[1], turning_rate(gradient, omega_0, omega_1))
    b, r = slide_gradient(at.q, A, mu), slide_rate_gradient(at.q, at.v, A, mu)
    (_, _, turn_0), (_, _, turn_1) = turning_blocks(3, 9, gradient, H, omega_0, omega_1)
    blocks = (
        (0, b[0], r[0], ZERO, ZERO),
        (3, b[1], r[1], gradient[0], turn_0),
        (6, b[2], r[2], ZERO, ZERO),
        (9, ZERO, ZERO, gradient[1], turn_1),
    )
    for i, s_i, _, g_i, _ in blocks:
        along = c[0] * s_i + c[1] * g_i
        add_vec(f, i, N, along)
        by_s = N * slope[0][0] * s_i + N * slope[1][0] * g_i
        by_g = N * slope[0][1] * s_i + N * slope[1][1] * g_i
        for j, s_j, rs_j, g_j, rg_j in blocks:
            add_mat(K, i, j, 1.0, outer(by_s, rs_j))
            add_mat(K, i, j, 1.0, outer(by_g, rg_j))
            add_mat(C, i, j, 1.0, outer(by_s, s_j))
            add_mat(C, i, j, 1.0, outer(by_g, g_j))
        for j in range(4):
            add_col(K, i, 12 + j, at.k * by[j], along)
    add_slide_curvature(K, N * c[0], at.q, A, mu)
    add_blocks(K, 3, 9, N * c[1], H)


@kernel
def round_observe(p, at, F, y, e):
    """Force, moment, normal force, power."""
    mu, xi, A = vec(p.mu, 0), vec(p.xi, 0), mat(at.R[0])
    rate = slide(at.q, at.v, A, mu)[1]
    turn = turning_rate(twist_gradient(relative_rotation(A, mat(at.R[1])), mu, xi), vec(at.v, 3), vec(at.v, 9))
    N, _, c, _ = _round(p, at.laws, at.q, rate, turn)
    y[0], y[1], y[2] = N * c[0], N * c[1], N
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
    force=keyed_force,
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
    force=round_force,
    observe=round_observe,
)
