r"""Turn slip: the moment and the lateral force of a tyre whose path is curved, and that turns on the spot.

A rectangular contact of length 2a and width 2b, with bristles on all of it, turns about the normal at the rate W while
the wheel rolls with V_r (Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, section 3.3). W/V, with V = sqrt(V_r^2 +
v_0^2), is the turn slip: in steady rolling without slip, the curvature of the path. For small turn slip the bristles
beside the middle are sheared along t, all others, whose path is an arc, along l:

    M_s = -C_t (b^2/3) W/V,      G_l = -C_l (a/3) (W/V) (V_r/V)

with the slip stiffnesses C_t and C_l. In a contact that slides as a whole, such as on the spot, the moment is that of
friction under a pressure that is parabolic along t and uniform across,

    |M_s| = mu N k,   k^2 = (3 a/8)^2 + (b/2)^2 + 0.068 a b

where k, the mean distance of the pressure from the centre, is within 1.2 % of its integral (exact for a line). In
between, force and moment share the friction: the force without sliding, G, has a third component G_m = M_s/k in the law
of the tyre,

    G_m = -C_t (W/V) {b^2/(3 k) + (k - b^2/(3 k)) x^2/(1 + x^2)},   G_l = -C_l (a/3) (W/V) (V_r/V)/sqrt(1 + 2 x_m^2)

with x and x_m, |G| and |G_m| for small turn slip over the |G| at which all of the contact slides. So a contact that
slides with v obeys (F, M_s/k) = -mu N (v, k W)/sqrt(v^2 + k^2 W^2), the ellipsoid by which Howe and Cutkosky (Int. J.
Robotics Research 15, 1996) replace the limit surface of Goyal, Ruina and Papadopoulos (Wear 143, 1991); the lateral
force of a narrow turn, in which bristles in front and behind slide to opposite sides, fades. The two quotients are
fitted to bristles (docs/tyre-equations.md).

W is the rate of the plane of the wheel about n, without the part of the spin of a leaning wheel, which belongs to the
camber thrust: W = n.omega - (s/q) l.omega with the sine s and the cosine q of the camber. The moment dissipates -M_s W.
"""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

from mecano.elements.wheels.slip_law import CARCASS_FIELDS, SlipForces
from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, sqrt
from mecano.maths.vector import dot
from mecano.schema import NUMBER, Field, not_negative, positive

BRISTLE_FIELDS = (
    Field(
        "contact_width", NUMBER, "m", "2b, for turn slip: the moment of a tyre that turns on the spot or in a tight "
        "turn; none when 0", 0.0, not_negative,
    ),
    Field("least_speed", NUMBER, "m/s", "v_0, speed below which the slip no longer grows as 1/speed", 0.1, positive),
    *CARCASS_FIELDS,
)  # fmt: skip


@cache
def turning_law(law):
    """Return the SlipLaw ``law`` with turn slip."""
    return replace(law, name=f"{law.name}_turning", forces=law.turning)


@cache
def twisting_law(law, field):
    """Return the SlipLaw ``law``, of this field, for a contact that the carcass of a ``transient_wheel`` lets twist."""

    def prepare(d, context):
        return {**law.prepare(d, context), "torsion": d[field]["torsional_stiffness"]}

    record = {**law.record, "torsion": ()}
    return turning_law(replace(law, name=f"{law.name}_twisting", record=record, prepare=prepare, twists=True))


class TurnSlip(NamedTuple):
    """Turn slip of a contact, and the components of the force without sliding that it changes."""

    W: float  # [rad/s]
    k: float  # [m]
    G_l: float  # [N]
    G_m: float  # M_s/k [N]


@kernel
def turn_slip(slip, a, b, C_t, C_l, G_t, G_l, V, V_r, full):
    """Return the TurnSlip of a Slip under the force (G_t, G_l) of its slip velocity; all slides from |G| = full on.

    ``a``, ``b`` > 0: half length and half width of the contact.
    """
    W, k = turning_rate(slip), reach(a, b)
    turn, shear = C_t * W / V, b * b / (3.0 * k)
    x_m = shear * turn / full
    G_l = G_l - a / 3.0 * C_l * (W / V) * (V_r / V) / sqrt(1.0 + 2.0 * x_m * x_m)
    x2 = (G_t * G_t + G_l * G_l) / (full * full) + x_m * x_m
    return TurnSlip(W, k, G_l, -turn * (shear + (k - shear) * x2 / (1.0 + x2)))


@kernel
def slip_speeds(p, k):
    """Return the slip velocities of the Slip ``k`` along t and l, V_r and V [m/s]; ``p`` has ``least_speed``."""
    rolling = dot(k.t, k.u) - dot(k.t, k.v_0)
    return dot(k.t, k.v), dot(k.l, k.v), rolling, sqrt(rolling * rolling + p.least_speed * p.least_speed)


@kernel
def bristle_forces(k, share, G_t, g, v, aligning):
    """Return the SlipForces of a ``share`` of the force without sliding, G_t along t and those of the TurnSlip ``g``.

    ``aligning`` [N m]: moment about n of slip that does not turn; v: slip velocity along (t, l). Slip that the force
    drives dissipates nothing.
    """
    F_t, F_l, spin = share * G_t, share * g.G_l, share * g.k * g.G_m
    power, M = F_t * v[0] + F_l * v[1], spin + aligning
    lost = at_least(-power, 0.0) - spin * g.W
    return SlipForces(F_t * k.t + F_l * k.l, M * k.n, lost, lost + power + M * dot(k.n, k.omega))


@kernel
def turning_rate(slip):
    """Return the rate W [rad/s] at which the plane of the wheel of a Slip turns about the normal."""
    return dot(slip.n, slip.omega) - slip.lean / sqrt(1.0 - slip.lean * slip.lean) * dot(slip.l, slip.omega)


@kernel
def reach(a, b):
    """Return k [m], the mean distance of the pressure from the centre of a contact of half length a, half width b."""
    return sqrt(9.0 / 64.0 * a * a + 0.25 * b * b + 0.068 * a * b)
