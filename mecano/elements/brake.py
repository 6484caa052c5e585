r"""Brake: a torque about the axle of a wheel against a reference node, the leg or arm that carries it.

With the axis a carried by the wheel, the relative rate W = a.(omega_wheel - omega_reference) and the speed u = |v| of
the wheel's node, the torque that opposes W is

    tau = min(T(t), T_max(u)) phi(|W|/eps) sign W,      phi(x) = x (2 - x) for x < 1, else 1.

The bound T_max(u) keeps the wheel from skidding: for friction mu_0 exp(-kappa u) under the force F_ref at the radius r,
with a margin sigma <= 1, it is sigma mu_0 F_ref r exp(-kappa u), ``bound: {exponential: {start: ..., rate: kappa}}``.
The smaller of both is taken without a corner, and never above either: (T + B - sqrt((T - B)^2 + (s^2) 4 T B))/2 with
s = 0.02. A stopped wheel is held: under a moment m < T it creeps at about eps m/(2 T).
"""

import math

from numba import njit

from mecano.constraints.disc import carried_axis
from mecano.contract import Kind, Output, record
from mecano.laws.table import evaluate_curve
from mecano.maths.vec import (
    add_mat,
    add_vec,
    dot,
    mat,
    matmul,
    mscale,
    mul,
    norm,
    outer,
    scale,
    skew,
    transpose,
    vec,
)  # fmt: skip
from mecano.schema import CURVE, DIRECTION, NODE_PAIR, NUMBER, Field, positive

RECORD = record(axis=3, torque="i", bound="i", bounded=(), rate_regularization=())
SMOOTH = 0.02  # s of the smaller of both
REFERENCE, PLACE, WHEEL = 0, 3, 6  # local unknowns: rotation, position, rotation


@njit
def _least(T, B):
    """The smaller of two torques >= 0, smooth, and its derivative by B."""
    if T <= 0.0 or B <= 0.0:
        return 0.0, 0.0
    root = math.sqrt((T - B) ** 2 + 4.0 * SMOOTH * SMOOTH * T * B)
    return 0.5 * (T + B - root), 0.5 * (1.0 - (B - T + 2.0 * SMOOTH * SMOOTH * T) / root)


@njit
def _torque(p, laws, t, u):
    """Torque [N m] at full rate, its derivative by the speed u [m/s], and the bound."""
    T, _, _ = evaluate_curve(laws, p.torque, t)
    T = max(T, 0.0)
    if p.bounded == 0.0:
        return T, 0.0, 0.0
    B, B_u, _ = evaluate_curve(laws, p.bound, u)
    least, by_B = _least(T, B)
    return least, by_B * B_u, B


@njit
def _sign(rate, eps):
    """Smooth sign of the rate, and its derivative."""
    x = abs(rate) / eps
    if x >= 1.0:
        return math.copysign(1.0, rate), 0.0
    return math.copysign(x * (2.0 - x), rate), 2.0 * (1.0 - x) / eps


@njit
def _rate(p, v, R):
    """Relative rate W, axis in the axes of the reference node, relative rotation."""
    A = matmul(transpose(mat(R[0])), mat(R[1]))
    b = mul(A, vec(p.axis, 0))
    return dot(vec(p.axis, 0), vec(v, WHEEL)) - dot(b, vec(v, REFERENCE)), b, A


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Moments on both nodes and their derivatives."""
    axis, Omega = vec(p.axis, 0), vec(v, REFERENCE)
    rate, b, A = _rate(p, v, R)
    u = norm(vec(v, PLACE))
    T, T_u, _ = _torque(p, laws, t, u)
    g, g_rate = _sign(rate, p.rate_regularization)
    tau, tau_rate = T * g, T * g_rate
    add_vec(f, WHEEL, tau, axis)
    add_vec(f, REFERENCE, -tau, b)
    # b = A xi turns with both nodes: db = hat(b) dTheta_reference - A hat(xi) dTheta_wheel
    b_r, b_w = skew(b), mscale(-1.0, matmul(A, skew(axis)))
    for place, moment in ((WHEEL, axis), (REFERENCE, scale(-1.0, b))):
        add_mat(C, place, WHEEL, tau_rate, outer(moment, axis))
        add_mat(C, place, REFERENCE, -tau_rate, outer(moment, b))
        if u > 0.0:
            add_mat(C, place, PLACE, T_u * g / u, outer(moment, vec(v, PLACE)))
        add_mat(K, place, REFERENCE, -tau_rate, outer(moment, mul(transpose(b_r), Omega)))
        add_mat(K, place, WHEEL, -tau_rate, outer(moment, mul(transpose(b_w), Omega)))
    add_mat(K, REFERENCE, REFERENCE, -tau, b_r)
    add_mat(K, REFERENCE, WHEEL, -tau, b_w)


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Torque, bound, relative rate, power."""
    rate, _, _ = _rate(p, v, R)
    T, _, bound = _torque(p, laws, t, norm(vec(v, PLACE)))
    tau = T * _sign(rate, p.rate_regularization)[0]
    y[0] = tau
    y[1] = bound
    y[2] = rate
    y[3] = tau * rate
    e[2] = tau * rate


def prepare(d, nodes, context):
    """Record: axis in the wheel's frame, laws."""
    bounded = d["bound"] is not None
    return {
        "axis": carried_axis(d, nodes[1:]),
        "torque": int(context.laws.add(d["torque"])),
        "bound": int(context.laws.add(d["bound"])) if bounded else 0,
        "bounded": float(bounded),
        "rate_regularization": d["rate_regularization"],
    }


def sample(rng):
    """Bounded by the speed and not, turning and nearly stopped."""
    falling = (("exponential", {"start": 3.0, "limit": 0.5, "rate": 0.3, "origin": 0.0}),)
    rising = (("linear", {"slope": 1.0, "offset": 1.5}),)
    cases = ((falling, 0.1), (None, 0.1), (falling, 50.0))
    return [
        ({"axis": rng.normal(size=3), "torque": rising, "bound": bound, "rate_regularization": eps}, 2, "")
        for bound, eps in cases
    ]


BRAKE = Kind(
    name="brake",
    section="loads",
    doc=__doc__,
    dtype=RECORD,
    layout=("R0", "x1", "R1"),
    fields=(
        Field("nodes", NODE_PAIR, "-", "reference node (leg, arm) and node of the wheel"),
        Field("axis", DIRECTION, "-", "axle at the start, inertial"),
        Field("torque", CURVE, "N m", "torque, a curve of the time; nothing where negative"),
        Field("bound", CURVE, "N m", "never above this curve of the speed [m/s] of the wheel", None),
        Field("rate_regularization", NUMBER, "rad/s", "rate eps below which the torque falls to zero", 0.1, positive),
    ),
    outputs=(
        Output("torque", "N m", "torque on the reference node about the axis; the opposite on the wheel"),
        Output("bound", "N m", "upper bound at the present speed; zero without one"),
        Output("rate", "rad/s", "angular velocity of the wheel about its axis, relative to the reference node"),
        Output("power", "W", "power taken from the wheel"),
    ),
    prepare=prepare,
    force=force,
    observe=observe,
    sample=sample,
)
