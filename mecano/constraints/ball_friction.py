r"""Friction of a ball in its socket: a moment against the relative angular velocity.

With the force F that the joint transmits, the radius r, the relative angular velocity w (of b, seen from a) and
:math:`u = r |w|`:

.. math::  M = r\, |F|\, \mu(u)\,\phi(u)\, w/|w|

on a along w, on b against it: the ball bears at one point, next to which it slides as fast as it can.
"""

import math

from mecano.compiled.kernel import kernel
from mecano.constraints.carried import relative_rotation
from mecano.constraints.friction import FRICTION_RECORD, POWER, REGULARIZED, TINY, friction_record
from mecano.contract import Kind, Output, Row, record
from mecano.laws.friction import friction_factor
from mecano.maths.vector import EYE, add_col, add_mat, add_vec, dot, mat, norm, outer, skew, vec

RECORD = record(radius=(), **FRICTION_RECORD)
BORROWED = 6


@kernel
def _friction(p, laws, q, v, A):
    """Angular velocity w, moment over normal force (3,) and its derivative by w, in axes of a; |F|."""
    w = A @ vec(v, 3) - vec(v, 0)
    u = p.radius * norm(w)
    _, b, b1 = friction_factor(laws, p.coefficient, p.regularization, u)
    r2 = p.radius * p.radius
    bend = r2 * r2 * b1 / (u * u) if u > 0.0 else 0.0
    slope = r2 * b * EYE + bend * outer(w, w)
    return w, r2 * b * w, slope, norm(vec(q, BORROWED))


@kernel
def force(p, at, f, K, C, M):
    """Opposite moments on both nodes."""
    A = relative_rotation(mat(at.R[0]), mat(at.R[1]))
    back = A.T
    omega_1 = vec(at.v, 3)
    _, moment, slope, N = _friction(p, at.laws, at.q, at.v, A)
    moment_b, D = back @ moment, N * slope
    add_vec(f, 0, -N, moment)
    add_vec(f, 3, N, moment_b)
    by_0, by_1 = D @ skew(A @ omega_1), D @ (A @ skew(omega_1))
    add_mat(K, 0, 0, -1.0, by_0)
    add_mat(K, 0, 3, 1.0, by_1)
    add_mat(K, 3, 0, 1.0, back @ (by_0 - N * skew(moment)))
    add_mat(K, 3, 3, 1.0, -(back @ by_1) + N * skew(moment_b))
    add_mat(C, 0, 0, 1.0, D)
    add_mat(C, 0, 3, -1.0, D @ A)
    add_mat(C, 3, 0, -1.0, back @ D)
    add_mat(C, 3, 3, 1.0, back @ (D @ A))
    for j in range(3):
        share = at.k * at.q[BORROWED + j] / max(N, TINY)
        add_col(K, 0, BORROWED + j, -share, moment)
        add_col(K, 3, BORROWED + j, share, moment_b)


@kernel
def observe(p, at, F, y, e):
    """Moment, normal force, power."""
    w, moment, _, N = _friction(p, at.laws, at.q, at.v, relative_rotation(mat(at.R[0]), mat(at.R[1])))
    y[0] = N * math.sqrt(dot(moment, moment))
    y[1] = N
    y[2] = N * dot(moment, w)
    e[2] = y[2]


def ball_friction_record(friction, context):
    """Record from the deck's friction."""
    return {"radius": friction["radius"], **friction_record(friction, context)}


BALL_FRICTION = Kind(
    name="ball_friction",
    section="",
    doc=__doc__ + REGULARIZED,
    dtype=RECORD,
    layout=("R0", "R1"),
    borrowed=tuple(Row(f"force {axis} of the joint", "N", "m") for axis in "xyz"),
    outputs=(
        Output("friction_moment", "N m", "size of the moment of the friction"),
        Output("normal_force", "N", "size of the force that the ball transmits"),
        POWER,
    ),
    force=force,
    observe=observe,
)
