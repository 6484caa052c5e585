r"""Brake: a torque about the axle of a wheel against a reference node, the leg or arm that carries it.

With the axis a carried by the wheel, the relative rate W = a.(omega_wheel - omega_reference) and the speed u of the
wheel's node, the torque that opposes W is

    tau = min(T(t), B) phi(|W|/eps) sign W,      phi(x) = x (2 - x) for x < 1, else 1.

A bound B keeps the wheel from skidding. For friction mu_0 exp(-kappa u), of which sigma <= 1 is used, it is

    B(u) = sigma mu_0 F_ref r exp(-kappa u)    F_ref constant: ``bound: {exponential: {start: ..., rate: kappa}}``
    B = sigma mu_0 exp(-kappa u) F_r r         F_r, r of the tyre now: ``wheel: ..., adhesion: {exponential: ...}``

and ``anti_skid`` lets the brake go while the slip ratio of the ``wheel`` is large. The smaller of T
and B is taken without a corner, and never above either: (T + B - sqrt((T - B)^2 + (s^2) 4 T B))/2 with s = 0.02. A
stopped wheel is held: under a moment m < T it creeps at about eps m/(2 T).
"""

import math

import numpy as np

from mecano.compiled.kernel import kernel
from mecano.constraints.disc import carried_axis
from mecano.constraints.ground import GROUND_RECORD, prepare_ground, slope_below
from mecano.contract import Kind, Output, record
from mecano.elements.brake_bound import (
    BY_ADHESION,
    BY_SPEED,
    PLACE,
    SPIN,
    UNBOUNDED,
    bound_of,
    scaled,
    summed,
)
from mecano.elements.tire_law import TIRE_RECORD, prepare_tire_law
from mecano.laws.table import evaluate_curve
from mecano.maths.vector import add_mat, add_vec, dot, mat, outer, skew, vec
from mecano.schema import CURVE, DIRECTION, NODE_PAIR, NUMBER, WHEEL, Field, mapping, positive

RECORD = record(
    axis=3, torque="i", bound="i", bounded=(), rate_regularization=(), watches=(), slip_start=(), slip_width=(),
    least_speed=(), **GROUND_RECORD, **TIRE_RECORD,
)  # fmt: skip
SMOOTH = 0.02  # s of the smaller of both
REFERENCE = 0  # local unknowns: rotation of the reference node; then place and rotation of the wheel's


@kernel
def _least(T, B):
    """The smaller of two torques >= 0, smooth, and its derivative by B."""
    if T <= 0.0 or B <= 0.0:
        return 0.0, 0.0
    root = math.sqrt((T - B) ** 2 + 4.0 * SMOOTH * SMOOTH * T * B)
    return 0.5 * (T + B - root), 0.5 * (1.0 - (B - T + 2.0 * SMOOTH * SMOOTH * T) / root)


@kernel
def _torque(p, laws, t, q, v, R):
    """Torque [N m] at full rate, its Gradient by the motion of the wheel, and the Bound."""
    T, _, _ = evaluate_curve(laws, p.torque, t)
    least, by_B, bound = max(T, 0.0), 0.0, bound_of(p, laws, q, v, R)
    if p.bounded != UNBOUNDED:
        least, by_B = _least(least, bound.B)
    by = summed(scaled(by_B * bound.factor, bound.B_by), scaled(least, bound.factor_by))
    return least * bound.factor, by, bound


@kernel
def _sign(rate, eps):
    """Smooth sign of the rate, and its derivative."""
    x = abs(rate) / eps
    if x >= 1.0:
        return math.copysign(1.0, rate), 0.0
    return math.copysign(x * (2.0 - x), rate), 2.0 * (1.0 - x) / eps


@kernel
def _rate(p, v, R):
    """Relative rate W, axis in the axes of the reference node, relative rotation."""
    A = mat(R[0]).T @ mat(R[1])
    b = A @ vec(p.axis, 0)
    return dot(vec(p.axis, 0), vec(v, SPIN)) - dot(b, vec(v, REFERENCE)), b, A


@kernel
def force(p, at, f, K, C, M):
    """Moments on both nodes and their derivatives."""
    axis, Omega, Rn = vec(p.axis, 0), vec(at.v, REFERENCE), mat(at.R[1])
    rate, b, A = _rate(p, at.v, at.R)
    T, by, _ = _torque(p, at.laws, at.t, at.q, at.v, at.R)
    g, g_rate = _sign(rate, p.rate_regularization)
    tau, tau_rate, by = T * g, T * g_rate, scaled(g, by)
    add_vec(f, SPIN, tau, axis)
    add_vec(f, REFERENCE, -tau, b)
    # b = A xi turns with both nodes: db = hat(b) dTheta_reference - A hat(xi) dTheta_wheel
    b_r, b_w = skew(b), -(A @ skew(axis))
    for place, moment in ((SPIN, axis), (REFERENCE, -b)):
        add_mat(C, place, SPIN, 1.0, outer(moment, tau_rate * axis + Rn.T @ by.w))
        add_mat(C, place, REFERENCE, -tau_rate, outer(moment, b))
        add_mat(C, place, PLACE, 1.0, outer(moment, by.v))
        add_mat(K, place, PLACE, 1.0, outer(moment, by.x))
        add_mat(K, place, REFERENCE, -tau_rate, outer(moment, b_r.T @ Omega))
        turned = -tau_rate * (b_w.T @ Omega) + Rn.T @ by.t
        add_mat(K, place, SPIN, 1.0, outer(moment, turned))
    add_mat(K, REFERENCE, REFERENCE, -tau, b_r)
    add_mat(K, REFERENCE, SPIN, -tau, b_w)


@kernel
def observe(p, at, F, y, e):
    """Torque, bound, relative rate, power, slip ratio."""
    rate, _, _ = _rate(p, at.v, at.R)
    T, _, bound = _torque(p, at.laws, at.t, at.q, at.v, at.R)
    tau = T * _sign(rate, p.rate_regularization)[0]
    y[0] = tau
    y[1] = bound.B
    y[2] = rate
    y[3] = tau * rate
    y[4] = bound.slip
    e[2] = tau * rate


def prepare(d, nodes, context):
    """Record: axis in the wheel's frame, laws; ground and tyre of the wheel that it watches."""
    bounded = BY_SPEED if d["bound"] is not None else BY_ADHESION if d["adhesion"] is not None else UNBOUNDED
    law = d["bound"] if d["bound"] is not None else d["adhesion"]
    values = {
        "axis": carried_axis(d, nodes[1:]),
        "torque": int(context.laws.add(d["torque"])),
        "bound": int(context.laws.add(law)) if bounded else 0,
        "bounded": bounded,
        "rate_regularization": d["rate_regularization"],
        "watches": float(d["wheel"] is not None),
    }
    if d["wheel"] is not None:
        values |= prepare_ground(d["wheel"]["ground"], context) | prepare_tire_law(d["wheel"]["tire_law"], context)
    if d["anti_skid"] is not None:
        given = d["anti_skid"]
        values |= {"slip_start": given["slip"], "slip_width": given["width"], "least_speed": given["least_speed"]}
    return {"least_speed": LEAST_SPEED, **values}


def check(d, nodes):
    """Texts on a bound that needs a wheel, on what is no wheel with a tyre, or not the wheel that is braked."""
    wheel, wanted = d["wheel"], [name for name in ("adhesion", "anti_skid") if d[name] is not None]
    if wheel is None:
        return [f"'{name}' needs 'wheel', the name of the wheel whose tyre is meant" for name in wanted]
    if "tire_law" not in wheel:
        return [f"'wheel' must be a wheel with a tire law, got a {wheel['type']}"]
    texts = []
    if not wanted:
        texts.append("'wheel' is of no use without 'adhesion' or 'anti_skid'")
    if d["bound"] is not None and d["adhesion"] is not None:
        texts.append("'bound' and 'adhesion' exclude one another")
    if wheel["node"] != d["nodes"][1]:
        texts.append(f"'nodes' must end with '{wheel['node']}', the node of the wheel")
    a, b = (np.array(axis, float) / np.linalg.norm(axis) for axis in (d["axis"], wheel["axis"]))
    if np.linalg.norm(np.cross(a, b)) > PARALLEL:
        texts.append("'axis' is not that of the wheel")
    return texts


def _wheel(rng, wave):
    """Values of a large wheel that touches the ground from near the origin."""
    ground, normal, level = slope_below(rng, wave)
    rising = (("polynomial", {"coefficients": [0.0, 2e3, 3e2]}),)
    falling = (("exponential", {"start": 0.8, "limit": 0.3, "rate": 0.1, "origin": 0.0}),)
    return {
        "node": "hub", "axis": level + 0.3 * normal, "ground": ground,
        "tire_law": {"radius": 12.0, "radial": rising, "radial_damping": 0.02, "friction": falling,
                     "friction_by_speed": 1.0, "slip_regularization": 0.1},
    }  # fmt: skip


def sample(rng):
    """Bounded by the speed and not, turning and nearly stopped; by the grip of a wheel, by its slip, by both."""
    falling = (("exponential", {"start": 3.0, "limit": 0.5, "rate": 0.3, "origin": 0.0}),)
    rising = (("linear", {"slope": 1.0, "offset": 1.5}),)
    large = (("linear", {"slope": 1e4, "offset": 8e3}),)
    wave = (("sine", {"amplitude": 0.2, "frequency": 0.03, "phase": 1.0, "offset": 0.0}),)
    skid = {"slip": -6.0, "width": 20.0, "least_speed": 2.0}
    nodes = {"nodes": ["leg", "hub"]}
    cases = [
        ({"axis": rng.normal(size=3), "torque": rising, "bound": bound, "rate_regularization": eps, **nodes}, 2, "")
        for bound, eps in ((falling, 0.1), (None, 0.1), (falling, 50.0))
    ]
    for height, bounds in ((wave, {"adhesion": falling}), (None, {"bound": falling, "anti_skid": skid}),
                           (wave, {"adhesion": falling, "anti_skid": skid})):  # fmt: skip
        wheel = _wheel(rng, height)
        values = {"axis": wheel["axis"], "torque": large, "rate_regularization": 20.0, "wheel": wheel, **bounds}
        cases.append((values | nodes, [(np.zeros(3), np.eye(3)), (np.zeros(3), np.eye(3))], ""))
    return cases


def slip_ratio(value):
    """Check: between rolling and locked."""
    return None if 0.0 < value < 1.0 else "must lie between 0 and 1"


LEAST_SPEED = 1.0  # m/s
PARALLEL = 1e-6
ANTI_SKID = mapping(
    Field("slip", NUMBER, "-", "slip ratio from which on the torque is reduced", check=slip_ratio),
    Field("width", NUMBER, "-", "further slip in which it falls to zero", 0.1, positive),
    Field("least_speed", NUMBER, "m/s", "v_0 of the slip ratio, which fades at lower speeds", LEAST_SPEED, positive),
)

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
        Field("wheel", WHEEL, "-", "the wheel that is braked, for 'adhesion' and 'anti_skid'", None),
        Field(
            "adhesion",
            CURVE,
            "-",
            "never above this curve of the speed [m/s], times radial force and loaded radius of the wheel",
            None,
        ),
        Field("anti_skid", ANTI_SKID, "-", "lets the brake go while the slip ratio of the wheel is large", None),
        Field("rate_regularization", NUMBER, "rad/s", "rate eps below which the torque falls to zero", 0.1, positive),
    ),
    outputs=(
        Output("torque", "N m", "torque on the reference node about the axis; the opposite on the wheel"),
        Output("bound", "N m", "upper bound at present, without the anti-skid; zero without one"),
        Output("rate", "rad/s", "angular velocity of the wheel about its axis, relative to the reference node"),
        Output("power", "W", "power taken from the wheel"),
        Output("slip_ratio", "-", "slip ratio that the anti-skid counts; zero without 'wheel'"),
    ),
    prepare=prepare,
    check=check,
    force=force,
    observe=observe,
    sample=sample,
)
