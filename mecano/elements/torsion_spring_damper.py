r"""Torsion spring-damper: a moment about an axis, from a law of the relative angle of two nodes and its rate.

Node a carries the unit axis :math:`\mu` and two axes perpendicular to it, node b carries the same triad at the
start, its axis being :math:`\xi`; Q is the rotation of the second triad in the first. The angle is the twist of Q,

.. math::  \theta = \mathrm{atan2}(Q_{21} - Q_{12},\; Q_{11} + Q_{22}),

which is the hinge angle where a hinge keeps :math:`\xi = \mu` and stays smooth and symmetric in both nodes off that
alignment, up to :math:`\xi = -\mu`. It is followed over whole turns by the memory of the last accepted angle. Its
gradient (inertial) is :math:`g = (\mu + \xi)/(1 + \mu \cdot \xi)`:

.. math::  \dot\theta = g \cdot (\omega_b - \omega_a), \qquad f_a = -M R_a^T g, \qquad f_b = M R_b^T g,
   \qquad M = M(\theta - \theta_0, \dot\theta)

The tangents follow from :math:`\delta P = P \hat{\delta\Theta_b} - \hat{\delta\Theta_a} P` with
:math:`P = R_a^T R_b`; even where the axes are aligned the derivative of g does not vanish. M > 0 turns the nodes
back against a positive angle, as N > 0 of a spring pulls its ends together.
"""

import math

from numba import njit

from mecano.constraints.carried import follow, relative_rotation
from mecano.constraints.joint_frame import triad
from mecano.constraints.stop_modes import EVENTS, MODES, law_record, put_stop_events
from mecano.contract import Kind, Output, record
from mecano.laws.table import evaluate_force, potential
from mecano.maths.vec import (
    add,
    add_mat,
    add_vec,
    cross,
    dot,
    madd,
    mat,
    matmul,
    mscale,
    mul,
    outer,
    scale,
    skew,
    sub,
    tmul,
    transpose,
    vec,
)
from mecano.schema import DIRECTION, LAW, NODE_PAIR, NUMBER, Field

RECORD = record(law="i", natural_angle=(), axes_a=(3, 3), axes_b=(3, 3), low=(), high=())


@njit
def _gradient(p, P):
    """Gradients G_a, G_b of the angle in the axes of each node; mu and xi in the axes of a, then of b."""
    s_a, s_b = vec(p.axes_a[2], 0), vec(p.axes_b[2], 0)
    xi_a, mu_b = mul(P, s_b), tmul(P, s_a)
    size = 1.0 / (1.0 + dot(s_a, xi_a))
    return scale(size, add(s_a, xi_a)), scale(size, add(mu_b, s_b)), s_a, xi_a, mu_b, s_b, size


@njit
def _angle(p, last, P):
    """The angle, by whole turns nearest to ``last`` [rad]."""
    Q = matmul(mat(p.axes_a), matmul(P, transpose(mat(p.axes_b))))
    return follow(last, math.atan2(Q[1][0] - Q[0][1], Q[0][0] + Q[1][1]))


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Opposite moments on both nodes; H_ij is the derivative of G_i by the material rotation of node j."""
    P = relative_rotation(mat(R[0]), mat(R[1]))
    G_a, G_b, s_a, xi_a, mu_b, s_b, size = _gradient(p, P)
    omega_a, omega_b = vec(v, 0), vec(v, 3)
    rate = dot(G_b, omega_b) - dot(G_a, omega_a)
    T, T_angle, T_rate = evaluate_force(laws, p.law, _angle(p, m[0], P) - p.natural_angle, rate)
    add_vec(f, 0, -T, G_a)
    add_vec(f, 3, T, G_b)

    by_a, by_b = scale(-size, cross(s_a, xi_a)), scale(-size, cross(s_b, mu_b))
    H_aa = madd(mscale(size, skew(xi_a)), outer(G_a, by_a))
    H_ab = madd(mscale(-size, matmul(P, skew(s_b))), outer(G_a, by_b))
    H_ba = madd(mscale(-size, matmul(transpose(P), skew(s_a))), outer(G_b, by_a))
    H_bb = madd(mscale(size, skew(mu_b)), outer(G_b, by_b))
    add_mat(K, 0, 0, -T, H_aa)
    add_mat(K, 0, 3, -T, H_ab)
    add_mat(K, 3, 0, T, H_ba)
    add_mat(K, 3, 3, T, H_bb)
    rate_a, rate_b = sub(tmul(H_ba, omega_b), tmul(H_aa, omega_a)), sub(tmul(H_bb, omega_b), tmul(H_ab, omega_a))
    dT_a = sub(scale(T_rate, rate_a), scale(T_angle, G_a))
    dT_b = add(scale(T_rate, rate_b), scale(T_angle, G_b))
    for i, sign, G in ((0, -1.0, G_a), (3, 1.0, G_b)):
        add_mat(K, i, 0, sign, outer(G, dT_a))
        add_mat(K, i, 3, sign, outer(G, dT_b))
        add_mat(C, i, 0, -sign * T_rate, outer(G, G_a))
        add_mat(C, i, 3, sign * T_rate, outer(G, G_b))


@njit
def _angle_and_rate(p, m, v, R):
    P = relative_rotation(mat(R[0]), mat(R[1]))
    gradient = _gradient(p, P)
    return _angle(p, m[0], P), dot(gradient[1], vec(v, 3)) - dot(gradient[0], vec(v, 0))


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Angle, rate, moment; energies."""
    angle, rate = _angle_and_rate(p, m, v, R)
    T, _, _ = evaluate_force(laws, p.law, angle - p.natural_angle, rate)
    elastic, _, _ = evaluate_force(laws, p.law, angle - p.natural_angle, 0.0)
    y[0] = angle
    y[1] = rate
    y[2] = T
    e[1] = potential(laws, p.law, angle - p.natural_angle)
    e[2] = (T - elastic) * rate


@njit
def event_values(p, m, mode, t, laws, q, v, a, R, g):
    """Stops of the law."""
    put_stop_events(g, p.low, p.high, _angle_and_rate(p, m, v, R)[0] - p.natural_angle)


@njit
def commit(p, m, mode, t, laws, q, v, a, R, m_out):
    """Remember the angle."""
    m_out[0] = _angle_and_rate(p, m, v, R)[0]


def prepare(d, nodes, context):
    """Record of one spring: the triad in the axes of both nodes."""
    axes = triad(d["axis"])
    return {
        "natural_angle": d["natural_angle"],
        "axes_a": axes @ nodes[0][1],
        "axes_b": axes @ nodes[1][1],
        **law_record(d["law"], context),
    }


def sample(rng):
    """A hinge spring with stops in each mode, a nonlinear one with a natural angle."""
    law = (
        ("spring", {"stiffness": 4.0}),
        ("damper_polynomial", {"coefficients": [0.0, 2.0, 0.0, 1.0]}),
        ("stop", {"stiffness": 9.0, "lower": -0.5, "upper": 0.5, "damping": 0.1}),
    )
    nonlinear = (
        ("table", {"points": [[-7, -3], [0, 0], [7, 8]], "file": None, "interpolation": "cubic", "beyond": "extend"}),
        ("damper", {"coefficient": 1.5}),
    )
    samples = [
        ({"law": law, "axis": rng.normal(size=3), "natural_angle": angle}, 2, mode)
        for mode, angle in zip(MODES, (1.5, 0.0, -1.5), strict=True)
    ]
    return [*samples, ({"law": nonlinear, "axis": rng.normal(size=3), "natural_angle": 0.7}, 2, "between")]


TORSION_SPRING_DAMPER = Kind(
    name="torsion_spring_damper",
    section="elements",
    doc=__doc__,
    dtype=RECORD,
    layout=("R0", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "nodes a and b; either may be ground"),
        Field("axis", DIRECTION, "-", "axis at the start, inertial"),
        Field("law", LAW, "-", "moment [N m] from angle [rad] and rate [rad/s]; > 0 turns against a positive angle"),
        Field("natural_angle", NUMBER, "rad", "angle at which the extension of the law is zero", 0.0),
    ),
    outputs=(
        Output("angle", "rad", "rotation of b relative to a about the axis since the start, over any turns"),
        Output("rate", "rad/s", "rate of the angle"),
        Output("moment", "N m", "moment of the law: on a about +axis, on b about -axis"),
    ),
    modes=MODES,
    events=EVENTS,
    memory=("angle",),
    prepare=prepare,
    force=force,
    observe=observe,
    event_values=event_values,
    commit=commit,
    sample=sample,
)
