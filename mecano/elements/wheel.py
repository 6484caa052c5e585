r"""Wheel that deforms radially and slips on the ground, at any lean and heading.

Theory: section 3.3 of Cardona, Geradin and Doan, CMAME 89 (1991), equations (27)-(46), here for leaning
wheels too. With the axis a = R a0, the contact C = x + r c (n, q = |n - (n.a) a| and r taken at C),
and the tyre law:

    radial deformation   w = radius - r                  dw/dt = -n.(v + omega x r c)/q
    normal force         N = F_r(w, dw/dt)/q             F_r acts in the plane of the wheel
    slip velocity        v_C = (I - n n^T)(v + omega x r c)
    friction             F_fr = mu(|v_C|) sigma(u) phi(|v_C|) N v_C/|v_C|,   u = |(I - n n^T) v|

The whole ground force -(F_fr - N n) acts at C. Internal forces, with f = F_fr - N n (36):

    force: f          material moment: R^T (r c x f)

Upright this is the paper's vector; leaning, -N (r c) x n is the moment that tips the wheel. Its power is
F_fr.v_C + F_r dw/dt: what slip and damping dissipate, never negative, and what the radial law stores. The
tangents are exact and not symmetric, through slip, lean, and the curvature of the ground; dw/dt depends
on q and on v.

In mode "air" there is no force. In mode "contact" the tyre law goes on smoothly to w < 0, for the sake of
steps that end at the lift-off; no accepted step is there. A regularized contact creeps: at rest under a
driving force T it slides at about eps T/(2 mu N).

Validity: one contact; where the ground is hollow, its radius of curvature is larger than the wheel's
radius; the wheel does not lie flat (q > 0: checked at the start, finite at all times). The node is the
wheel body's: its rotation spins with the wheel.
"""

from typing import NamedTuple

from numba import njit

from mecano.constraints.disc import carried_axis
from mecano.constraints.ground import (
    GROUND_RECORD,
    LEAN,
    check_axle,
    check_ground,
    ends,
    lean_of,
    normal_and_level,
    prepare_ground,
    touch,
)
from mecano.contract import Event, Kind, Output, record
from mecano.elements.tire_law import (
    TIRE_RECORD,
    check_tire_law,
    elastic_energy,
    elastic_force,
    gripping,
    prepare_tire_law,
    radial_force,
    speed_over_ground,
)
from mecano.maths.contact_force import add_columns, add_force, add_position_tangent, add_velocity_tangent
from mecano.maths.surface import disc_variation
from mecano.maths.vec import (
    EYE,
    ZERO,
    add,
    cross,
    dot,
    madd,
    mat,
    matmul,
    mscale,
    mul,
    norm,
    outer,
    put,
    scale,
    skew,
    sub,
    tmul,
    vec,
)
from mecano.schema import DIRECTION, GROUND, NODE, TIRE_LAW, Field

AIR, CONTACT = 0, 1

FIELDS = (
    Field("node", NODE, "-", "centre of the wheel; its rotation spins with the wheel"),
    Field("axis", DIRECTION, "-", "spin axis at the start, inertial; rolling forward turns right-handed"),
    Field("tire_law", TIRE_LAW, "-", "radius, radial force and friction of the tyre"),
    Field("ground", GROUND, "-", "ground it rolls on"),
)

OUTPUTS = (
    Output("height", "m", "height of the centre over the ground, along the normal at the contact"),
    Output("loaded_radius", "m", "distance from the centre to the contact; the radius when in the air"),
    Output("deformation", "m", "radial deformation w of the tyre; zero in the air"),
    Output("radial_force", "N", "radial force F_r in the plane of the wheel"),
    Output("normal_force", "N", "normal force N of the ground on the wheel"),
    Output("longitudinal_force", "N", "friction of the ground on the wheel, along t = a x n/|a x n|"),
    Output("lateral_force", "N", "friction of the ground on the wheel, along l = n x t (upright: the axis)"),
    Output("contact_force", "N", "force of the ground on the wheel, inertial", (3,)),
    Output("longitudinal_slip", "m/s", "slip velocity along t; in the air, of the lowest point of the rim"),
    Output("lateral_slip", "m/s", "slip velocity along l; in the air, of the lowest point of the rim"),
    Output("spin_rate", "rad/s", "angular velocity of the wheel along its axis"),
    Output("contact_point", "m", "contact, inertial; in the air, the lowest point of the rim", (3,)),
    Output("friction_coefficient", "-", "friction over normal force, mu phi; zero in the air"),
    LEAN,
)


class Slip(NamedTuple):
    """State of force in a contact; 3-vectors in the inertial frame."""

    f: tuple  # F_fr - N n [N]: what the wheel exerts on the ground
    u: tuple  # velocity of the wheel at C [m/s]
    v_C: tuple  # slip velocity [m/s]
    e: tuple  # its direction, zero at rest
    w1: float  # dw/dt [m/s]
    F: float  # F_r [N]
    F_w: float  # dF_r/dw [N/m]
    F_w1: float  # dF_r/d(dw/dt) [N s/m]
    N: float  # normal force [N]
    grip: float  # mu phi [-]
    b: float  # mu phi/|v_C| [s/m]
    b1: float  # |v_C| db/d|v_C| [s/m]
    b_u: float  # db/d(speed of the axle) [s2/m2]
    v: tuple  # velocity of the axle [m/s]
    ahead: tuple  # its direction over the ground


@njit
def _slip(p, laws, g, u, v):
    """The Slip of a wheel of record ``p`` in the Contact ``g``, whose point at C moves with ``u``, its axle with v."""
    along = dot(g.n, u)
    w1 = -along / g.q
    F, F_w, F_w1 = radial_force(p, laws, p.radius - g.r, w1)
    v_C = sub(u, scale(along, g.n))
    speed = norm(v_C)
    axle_speed, ahead = speed_over_ground(g.n, v)
    grip, b, b1, b_u = gripping(p, laws, speed, axle_speed)
    N = F / g.q
    f = scale(N, sub(scale(b, v_C), g.n))
    e = scale(1.0 / speed, v_C) if speed > 0.0 else ZERO
    return Slip(f, u, v_C, e, w1, F, F_w, F_w1, N, grip, b, b1, b_u, v, ahead)


@njit
def _by_velocity(g, k):
    """df/du, 3x3, of the Slip ``k``: the contact is fixed."""
    dN = scale(-k.F_w1 / g.q**2, g.n)
    dv = madd(mscale(k.b, madd(EYE, outer(scale(-1.0, g.n), g.n))), outer(scale(k.b1, k.e), k.e))
    return madd(outer(sub(scale(k.b, k.v_C), g.n), dN), mscale(k.N, dv))


@njit
def _by_contact(g, k, dw, by):
    """df, 3x3, of the Slip ``k`` by three variables of which w has the derivatives ``dw`` (3,): u is fixed."""
    lift = tmul(by.n, k.u)  # d(n.u)
    dw1 = add(scale(-1.0 / g.q, lift), scale(k.w1 * g.s / g.q**2, by.s))
    dF = add(scale(k.F_w, dw), scale(k.F_w1, dw1))
    dN = add(scale(1.0 / g.q, dF), scale(k.N * g.s / g.q**2, by.s))
    dv_C = madd(outer(scale(-1.0, g.n), lift), mscale(k.w1 * g.q, by.n))
    d_speed = scale(-dot(g.n, k.v), tmul(by.n, k.ahead))
    dv = madd(mscale(k.b, dv_C), outer(scale(k.b1, k.e), tmul(dv_C, k.e)))
    dv = madd(dv, outer(scale(k.b_u, k.v_C), d_speed))
    return madd(outer(sub(scale(k.b, k.v_C), g.n), dN), mscale(k.N, madd(dv, mscale(-1.0, by.n))))


@njit
def force(p, m, mode, t, k, penalty, laws, q, v, a, R, f, K, C, M):
    """Add force and material moment of the ground, and their derivatives; see the contract."""
    if mode == AIR:
        return
    Rn = mat(R[0])
    axis = mul(Rn, vec(p.axis, 0))
    g = touch(p, laws, vec(q, 0), axis)
    omega = mul(Rn, vec(v, 3))
    slip = _slip(p, laws, g, add(vec(v, 0), cross(omega, g.arm)), vec(v, 0))
    add_force(f, Rn, g.arm, slip.f)

    arm, w = skew(g.arm), skew(omega)
    by_x, by_t = disc_variation(vec(p.direction, 0), axis, g)
    f_u = _by_velocity(g, slip)
    add_velocity_tangent(C, Rn, g.arm, f_u)
    by_speed = outer(scale(slip.N * slip.b_u, slip.v_C), slip.ahead)
    add_columns(C, 0, Rn, EYE, by_speed, matmul(arm, by_speed))
    f_x = madd(_by_contact(g, slip, scale(-1.0 / g.q, g.n), by_x), matmul(f_u, matmul(w, by_x.arm)))
    u_t = madd(matmul(arm, w), matmul(w, by_t.arm))
    f_t = madd(_by_contact(g, slip, scale(-g.r / g.q, cross(g.c, g.n)), by_t), matmul(f_u, u_t))
    add_position_tangent(K, Rn, g.arm, (by_x.arm, by_t.arm), slip.f, (f_x, f_t))


@njit
def observe(p, m, mode, t, laws, q, v, a, R, F, y, e):
    """Outputs and energies; see OUTPUTS and the contract."""
    Rn = mat(R[0])
    axis, omega = mul(Rn, vec(p.axis, 0)), mul(Rn, vec(v, 3))
    g = touch(p, laws, vec(q, 0), axis)
    radius = g.r if mode == CONTACT else p.radius
    arm = scale(radius, g.c)
    slip = _slip(p, laws, g, add(vec(v, 0), cross(omega, arm)), vec(v, 0))
    # an accepted step that ends at the lift-off is within the tolerance of w = 0, on either side
    touching = mode == CONTACT and slip.F > 0.0
    F, N = (slip.F, slip.N) if touching else (0.0, 0.0)
    w = max(0.0, p.radius - radius)
    tangential = scale(1.0 / g.q, cross(axis, g.n))
    lateral = cross(g.n, tangential)
    y[0] = g.r * g.q
    y[1] = radius
    y[2] = w
    y[3] = F
    y[4] = N
    if touching:
        y[5] = -dot(slip.f, tangential)
        y[6] = -dot(slip.f, lateral)
        put(y, 7, scale(-1.0, slip.f))
        y[16] = slip.grip
    y[10] = dot(slip.v_C, tangential)
    y[11] = dot(slip.v_C, lateral)
    y[12] = dot(omega, axis)
    put(y, 13, add(vec(q, 0), arm))
    y[17] = lean_of(g)
    elastic, _ = elastic_force(p, laws, w)
    e[1] = elastic_energy(p, laws, w)
    e[2] = N * slip.grip * norm(slip.v_C) + (F - elastic) * slip.w1


@njit
def event_values(p, m, mode, t, laws, q, v, a, R, g):
    """Write w for the touch-down, -w for the lift-off [m]."""
    contact = touch(p, laws, vec(q, 0), mul(mat(R[0]), vec(p.axis, 0)))
    g[0] = p.radius - contact.r
    g[1] = contact.r - p.radius


def prepare(d, nodes, context):
    """Record: axis in the node's frame, ground, tyre law."""
    return {
        "axis": carried_axis(d, nodes),
        **prepare_ground(d["ground"], context),
        **prepare_tire_law(d["tire_law"], context),
    }


def check(d, nodes):
    """Texts on an unusable ground or tyre law, a wheel that lies flat or starts below the ground."""
    texts = check_ground(d["ground"]) + check_tire_law(d["tire_law"])
    return texts + check_axle(d["ground"], nodes[0][0], d["axis"])


def sample(rng):
    """Large wheels that touch the ground from near the origin: plane, profile, slip, stick, air."""
    wave = (("sine", {"amplitude": 0.3, "frequency": 0.03, "phase": 1.0, "offset": 0.0}),)
    radial = (("polynomial", {"coefficients": [0.0, 2e3, 3e2, -4.0, 0.5]}),)
    friction = (("exponential", {"start": 0.8, "limit": 0.3, "rate": 0.1, "origin": 0.0}),)
    samples = []
    for profile, eps, mode in ((False, 0.05, "contact"), (True, 50.0, "contact"), (True, 0.05, "air")):
        normal, level = normal_and_level(rng)
        ground = {"plane": {"point": -8.0 * normal, "normal": normal}, "profile": None}
        if profile:
            ground["profile"] = {"direction": rng.normal(size=3), "height": wave}
        tire_law = {
            "radius": 12.0, "radial": radial, "radial_damping": 0.02, "friction": friction,
            "friction_by_speed": (("exponential", {"start": 1.0, "limit": 0.0, "rate": 0.2, "origin": 0.0}),),
            "slip_regularization": eps, "valid_deformation": None, "lateral": None,
        }  # fmt: skip
        lean = level + rng.uniform(-0.5, 0.5) * normal
        samples.append(({"axis": lean, "tire_law": tire_law, "ground": ground}, 1, mode))
    return samples


def limits(d):
    """The range of the radial law."""
    valid = d["tire_law"]["valid_deformation"]
    return [] if valid is None else [("deformation", valid, f"the radial law holds up to {valid:g} m only")]


WHEEL = Kind(
    name="wheel",
    section="elements",
    doc=__doc__,
    dtype=record(axis=3, **GROUND_RECORD, **TIRE_RECORD),
    layout=("x0", "R0"),
    fields=FIELDS,
    outputs=OUTPUTS,
    modes=("air", "contact"),
    events=(
        Event("touch_down", "air", "contact", "the undeformed rim reaches the ground"),
        Event("lift_off", "contact", "air", "the deformation returns to zero"),
    ),
    prepare=prepare,
    check=check,
    limits=limits,
    ends=ends,
    force=force,
    observe=observe,
    event_values=event_values,
    sample=sample,
)
