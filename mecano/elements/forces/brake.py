r"""Brake: a torque about the axle of a wheel against a reference node, the leg or arm that carries the wheel.

With the axis a fixed in the wheel, the relative rate :math:`W = a \cdot (\omega_w - \omega_r)` of the wheel against the
reference node, and the speed u of the wheel's node, the torque that opposes W is

.. math::  \tau = \min(T, B)\, \varphi(|W|/\epsilon)\, \mathrm{sign}\, W

with :math:`\varphi(x) = x (2 - x)` for x < 1, else 1. T is a function of time or a formula of signals, such as the
output of an anti-skid controller. A bound B keeps the wheel from skidding: ``bound`` is a curve B(u), and ``adhesion``
a curve of the coefficient of friction that is used at the speed u, with the radial force and the loaded radius of the
``wheel``,

.. math::  B = \mu(u)\, F_r\, r

For a friction :math:`\mu_0 \exp(-\kappa u)`, of which the share :math:`\sigma \le 1` is used, write
``adhesion: {exponential: {start: ..., rate: ...}}`` with the start :math:`\sigma \mu_0` and the rate :math:`\kappa`.
``anti_skid`` releases the brake while the slip ratio of the ``wheel`` is large.

The minimum of T and B is smoothed and never exceeds either: :math:`(T + B - \sqrt{(T - B)^2 + 4 s^2 T B})/2` with
s = 0.02. A stopped wheel is held: under a moment m < T it creeps at about :math:`\epsilon m/(2 T)`.
"""

from typing import NamedTuple

import numpy as np

from mecano.constraints.along_coordinate.demand import is_formula, law_of, on_demand
from mecano.constraints.ground import GROUND_RECORD, prepare_ground, slope_below
from mecano.constraints.tread import flat_on_ground, rounded_on_ground
from mecano.constraints.triads import carried_axis, unit
from mecano.element_interface import Kind, Output, named, record
from mecano.elements.wheels.crown import crown_of
from mecano.elements.wheels.tire_law import RADIAL_RECORD, prepare_radial, radial_force, speed_over_ground
from mecano.jit.kernel import kernel
from mecano.laws.friction import sticking
from mecano.laws.law_table import curve, terms_of
from mecano.maths.dual import at_least, at_most, constant, select, sqrt
from mecano.maths.surface import directions
from mecano.maths.vector import add_vec, cross, dot, mat, norm, vec
from mecano.schema import CURVE, DIRECTION, DRIVE, NODE_PAIR, NUMBER, WHEEL, Field, mapping, positive, requirement

RECORD = record(
    axis=3, law="i", bound="i", bounded=(), rate_regularization=(), watches=(), slip_start=(), slip_width=(),
    least_speed=(), **GROUND_RECORD, **RADIAL_RECORD,
)  # fmt: skip
SMOOTH = 0.02  # s of the smooth minimum
REFERENCE, POSITION, SPIN = 0, 3, 6  # local unknowns: rotation of the reference node; both of the wheel's node
UNBOUNDED, BY_SPEED, BY_ADHESION = 0.0, 1.0, 2.0


class Bound(NamedTuple):
    """The bound of a brake."""

    B: float  # [N m]
    factor: float  # of the anti-skid
    slip: float  # slip ratio


@kernel
def bound_of(p, at):
    """Return the Bound: a curve B(u) of the speed u of the wheel, or mu(u) F_r r of its tyre, zero in the air.

    The radial force F_r and the loaded radius r are those of the disc, without the lateral displacement of a patch; a
    rounded tread counts as if its contact were as far from the axle as that of an upright wheel.
    """
    velocity = vec(at.v, POSITION)
    if p.watches == 0.0:
        B = curve(at.laws, p.bound, norm(velocity))
        return Bound(B, constant(1.0, B), constant(0.0, B))
    R = mat(at.R[1])
    axis, omega = R @ vec(p.axis, 0), R @ vec(at.v, SPIN)
    k = flat_on_ground(p, at.laws, vec(at.q, POSITION), axis)
    if p.crown > 0.0:
        k = rounded_on_ground(p, at.laws, vec(at.q, POSITION), axis)
    g = k.g
    r, u = at_most(g.r, p.radius), speed_over_ground(g.n, velocity)
    w1 = -dot(g.n, velocity + cross(omega, g.arm)) / k.tilt
    pressing = select(g.r < p.radius, radial_force(p, at.laws, p.radius - g.r, w1) * r, 0.0)
    pressing = select(p.bounded == BY_ADHESION, pressing, 1.0)
    slip = _slip_ratio(p, dot(directions(axis, g)[0], velocity), dot(omega, axis) * r)
    return Bound(curve(at.laws, p.bound, u) * pressing, _released(p, slip), slip)


@kernel
def _slip_ratio(p, forward, rim):
    """Return the slip ratio (v_x - Omega r) v_x/(v_x^2 + v_0^2) from the velocities [m/s] of the centre and of the rim.

    At speeds above v_0 it is that of textbooks; it vanishes with the speed, so that a stopped wheel is held.
    """
    return (forward - rim) * forward / (forward * forward + p.least_speed * p.least_speed)


@kernel
def _released(p, slip):
    """Return the factor of the anti-skid: 1 up to the slip kappa_0, falling smoothly to 0 at kappa_0 + width."""
    width = select(p.slip_width > 0.0, p.slip_width, 1.0)
    x = at_most(at_least((slip - p.slip_start) / width, 0.0), select(p.slip_width > 0.0, 1.0, 0.0))
    return 1.0 - x * x * (3.0 - 2.0 * x)


@kernel
def _least(T, B):
    """Return the smooth minimum of two torques >= 0."""
    positive = at_least(T, 0.0) * at_least(B, 0.0)
    difference = T - B
    root = sqrt(difference * difference + 4.0 * SMOOTH * SMOOTH * positive)
    return select(positive > 0.0, 0.5 * (T + B - root), 0.0)


def _functions(demand):
    """Return ``residual`` and ``observe`` of a brake with this demanded torque."""

    @kernel
    def braking(p, at):
        """Return torque [N m], relative rate W [rad/s], axis in the axes of the reference node, and the Bound."""
        b = mat(at.R[0]).T @ (mat(at.R[1]) @ vec(p.axis, 0))
        rate = dot(vec(p.axis, 0), vec(at.v, SPIN)) - dot(b, vec(at.v, REFERENCE))
        T, bound = at_least(demand(p, at), 0.0), bound_of(p, at)
        T = bound.factor * select(p.bounded == UNBOUNDED, T, _least(T, bound.B))
        return T * sticking(p.rate_regularization, abs(rate)) * rate, rate, b, bound

    @kernel
    def residual(p, at, f):
        tau, _, b, _ = braking(p, at)
        add_vec(f, SPIN, tau, vec(p.axis, 0))
        add_vec(f, REFERENCE, -tau, b)

    @kernel
    def observe(p, at, F, y, e):
        tau, rate, _, bound = braking(p, at)
        y[0], y[1], y[2], y[3], y[4] = tau, bound.B, rate, tau * rate, bound.slip
        e[2] = tau * rate

    return named(residual, observe)


def prepare(d, nodes, context):
    """Return the record: axis in the wheel's frame, laws; ground and tyre of the wheel that it refers to."""
    bounded = BY_SPEED if d["bound"] is not None else BY_ADHESION if d["adhesion"] is not None else UNBOUNDED
    law = d["bound"] if d["bound"] is not None else d["adhesion"]
    values = {
        "axis": carried_axis(d, nodes[1:]),
        "law": law_of(d["torque"], context),
        "bound": context.laws.add(law) if bounded else 0,
        "bounded": bounded,
        "rate_regularization": d["rate_regularization"],
        "watches": float(d["wheel"] is not None),
    }
    if d["wheel"] is not None:
        values |= prepare_ground(d["wheel"]["ground"], context, crown_of(d["wheel"]))
        values |= prepare_radial(d["wheel"]["tire_law"], context)
    if d["anti_skid"] is not None:
        given = d["anti_skid"]
        values |= {"slip_start": given["slip"], "slip_width": given["width"], "least_speed": given["least_speed"]}
    return {"least_speed": LEAST_SPEED, **values}


def check(d, nodes):
    """Return errors for a negative torque, a bound without a wheel, and a wheel without tyre or that is not braked."""
    terms = [] if is_formula(d["torque"]) else terms_of(d["torque"])
    if [name for name, _ in terms] == ["constant"] and terms[0][1]["value"] < 0.0:
        return ["'torque' must not be negative: a brake opposes every rotation; for a motor use a 'couple'"]
    wheel, wanted = d["wheel"], [name for name in ("adhesion", "anti_skid") if d[name] is not None]
    if wheel is None:
        return [f"'{name}' needs 'wheel', the name of the wheel with the tyre" for name in wanted]
    if "tire_law" not in wheel:
        return [f"'wheel' must be a wheel with a tire law, got a {wheel['type']}"]
    if "ground" not in wheel:
        return [f"'wheel' must roll on one of the 'grounds', not on a body: it is a {wheel['type']}"]
    texts = []
    if not wanted:
        texts.append("'wheel' has no effect without 'adhesion' or 'anti_skid'")
    if wheel["ground"].get("profile") and wheel["tire_law"].get("enveloping"):
        texts.append("'adhesion' and 'anti_skid' are not available on a 'profile' that the tyre of 'wheel' envelops")
    if wheel["ground"].get("motion"):
        texts.append("'adhesion' and 'anti_skid' hold for a ground at rest, but the ground of 'wheel' moves")
    if d["bound"] is not None and d["adhesion"] is not None:
        texts.append("'bound' and 'adhesion' exclude one another")
    if wheel["node"] != d["nodes"][1]:
        texts.append(f"'nodes' must end with '{wheel['node']}', the node of the wheel")
    if np.linalg.norm(np.cross(unit(d["axis"]), unit(wheel["axis"]))) > PARALLEL:
        texts.append("'axis' is not parallel to the axis of the wheel")
    return texts


def _wheel(rng, wave):
    """Return the values of a large wheel that touches the ground from near the origin."""
    ground, normal, level = slope_below(rng, wave)
    rising = (("polynomial", {"coefficients": [0.0, 2e3, 3e2]}),)
    return {
        "node": "hub", "axis": level + 0.3 * normal, "ground": ground,
        "tire_law": {"radius": 12.0, "radial": rising, "radial_damping": 0.02},
    }  # fmt: skip


def sample(rng):
    """Return samples with and without a bound, rotating and nearly stopped; with adhesion, anti-skid, and both."""
    falling = (("exponential", {"start": 3.0, "limit": 0.5, "rate": 0.3, "origin": 0.0}),)
    rising = (("linear", {"slope": 1.0, "offset": 1.5}),)
    large = (("linear", {"slope": 1e4, "offset": 8e3}),)
    wave = (("sine", {"amplitude": 0.2, "frequency": 0.03, "phase": 1.0, "offset": 0.0}),)
    skid = {"slip": -6.0, "width": 20.0, "least_speed": 2.0}
    nodes = {"nodes": ["leg", "hub"]}
    cases = [
        ({"axis": rng.normal(size=3), "torque": T, "bound": bound, "rate_regularization": eps, **nodes}, 2, "")
        for T in (rising, "command")
        for bound, eps in ((falling, 0.1), (None, 0.1), (falling, 50.0))
    ]
    for height, bounds, crown in (
        (wave, {"adhesion": falling}, 0.0), (None, {"bound": falling, "anti_skid": skid}, 0.0),
        (wave, {"adhesion": falling, "anti_skid": skid}, 0.0), (None, {"adhesion": falling, "anti_skid": skid}, 3.0),
    ):  # fmt: skip
        wheel = _wheel(rng, height)
        wheel["tire_law"]["crown_radius"] = crown
        values = {"axis": wheel["axis"], "torque": large, "rate_regularization": 20.0, "wheel": wheel, **bounds}
        cases.append((values | nodes, [(np.zeros(3), np.eye(3)), (np.zeros(3), np.eye(3))], ""))
    return cases


LEAST_SPEED = 1.0  # m/s
PARALLEL = 1e-6
ANTI_SKID = mapping(
    Field(
        "slip", NUMBER, "-", "slip ratio above which the torque is reduced",
        check=requirement(lambda slip: 0.0 < slip < 1.0, "must lie between 0 and 1"),
    ),
    Field("width", NUMBER, "-", "further slip over which it falls to zero", 0.1, positive),
    Field("least_speed", NUMBER, "m/s", "v_0 of the slip ratio, which fades at lower speeds", LEAST_SPEED, positive),
)  # fmt: skip
FIELDS = (
    Field("nodes", NODE_PAIR, "-", "reference node (leg, arm) and node of the wheel"),
    Field("axis", DIRECTION, "-", "axle at the start, inertial"),
    Field("torque", DRIVE, "N m", "torque T that is demanded; zero where negative"),
    Field(
        "bound", CURVE, "N m", "upper bound of the torque, a curve of the speed [m/s] of the wheel", None,
        argument="m/s",
    ),
    Field("wheel", WHEEL, "-", "the wheel that is braked, for 'adhesion' and 'anti_skid'", None),
    Field(
        "adhesion", CURVE, "-",
        "upper bound of the torque: this curve of the speed [m/s] times radial force and loaded radius", None,
        argument="m/s",
    ),
    Field("anti_skid", ANTI_SKID, "-", "releases the brake while the slip ratio of the wheel is large", None),
    Field("rate_regularization", NUMBER, "rad/s", "rate eps below which the torque falls to zero", 0.1, positive),
)  # fmt: skip
OUTPUTS = (
    Output("torque", "N m", "torque on the reference node about the axis; the opposite on the wheel"),
    Output("bound", "N m", "current upper bound, without the anti-skid; zero without one"),
    Output("rate", "rad/s", "angular velocity of the wheel about its axis, relative to the reference node"),
    Output("power", "W", "power taken from the wheel"),
    Output("slip_ratio", "-", "slip ratio as used by the anti-skid; zero without 'wheel'"),
)


BRAKE = on_demand(
    Kind(
        name="brake", section="loads", doc=__doc__, dtype=RECORD, layout=("R0", "x1", "R1"),
        fields=FIELDS,
        outputs=OUTPUTS,
        counts_angles=lambda d: [("axis", d["axis"], d["nodes"])],
        **named(prepare, check, sample),
    ),
    _functions, "torque",
)  # fmt: skip
