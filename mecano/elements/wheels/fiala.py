r"""Brush tyre in steady slip (Fiala): force and aligning moment from slip stiffness, friction and contact length.

Elastic bristles on a contact of length 2a carry a parabolic pressure and slide where their shear exceeds mu times the
pressure (Fiala 1954; Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, section 3.2). With the slip velocity
v = (v_t, v_l), the rolling velocity V_r, the slip stiffnesses C_t, C_l and the camber stiffness C_g, the force without
sliding is

    G = -(C_t v_t, C_l v_l)/V - (0, C_g gamma) (V_r/V)^2,   V = sqrt(V_r^2 + v_0^2),   x = |G|/(3 mu N)

V_r is the velocity of the axle along t less the slip velocity, the spin times the rolling radius: v/V_r is the
theoretical slip, which under braking is larger than the slip relative to the velocity of the axle. The force of the
bristles is (3.11), in combined slip (3.45), here for two stiffnesses:

    F = G (1 - x + x^2/3) for x < 1,   mu N G/|G| beyond (the whole contact slides)
    M = (a/3) C_l (v_l V_r/V^2) (1 - x)^3 n for x < 1, else 0

with the trail (a/3) (1 - x)^3/(1 - x + x^2/3) in pure side slip; in reverse the other edge of the contact leads. In
pure side slip V_r is the velocity of the axle along t, and tan alpha = v_l/|V_r|. With v_0 = ``least_speed`` the slip
is finite at rest, where the tyre therefore creeps. A tyre with the camber angle gamma, sin gamma = n.a, is pushed to
the side to which its top leans, by C_g gamma for small angles, within the same limit of friction; this camber thrust
has no aligning moment. The force dissipates -F.v where it opposes the slip; the moment exchanges the power M.omega with
the rolling, and so does the camber thrust the power with which it drives the slip. The friction mu is a curve of the
slip speed. With a ``contact_width`` the tyre has turn slip: G has a third component G_m, which adds M_s = k G_m
(1 - x + x^2/3) to the moment, and G_l a part of the curved path (turn_slip.py).
"""

from mecano.elements.wheels.slip_law import SlipLaw, check_twist, friction_limit
from mecano.elements.wheels.turn_slip import BRISTLE_FIELDS, TurnSlip, bristle_forces, slip_speeds, turn_slip
from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve
from mecano.laws.probe import negative_curves
from mecano.maths.dual import at_least, at_most, atan2, select, sqrt
from mecano.schema import CURVE, NUMBER, Field, mapping, not_negative

FIELDS = (
    Field("cornering_stiffness", CURVE, "N/rad", "C_l, lateral force per slip angle; a curve of the normal force [N]",
          argument="N"),
    Field(
        "longitudinal_stiffness", CURVE, "N",
        "C_t, driving force per slip ratio; a curve of the normal force [N]; C_l when absent", None, argument="N"
    ),
    Field("friction", CURVE, "-", "coefficient of friction mu, a curve of the slip speed [m/s]", argument="m/s"),
    Field("camber_stiffness", CURVE, "N/rad", "C_g, lateral force per camber; a curve of the normal force [N]", 0.0,
          argument="N"),
    Field("contact_length", NUMBER, "m", "2a, for the aligning moment", 0.0, not_negative),
    *BRISTLE_FIELDS,
)  # fmt: skip


def check(law):
    """Return errors for negative friction or stiffness."""
    d = law["fiala"]
    names = ("cornering_stiffness", "longitudinal_stiffness", "camber_stiffness", "friction")
    return check_twist("fiala", d) + negative_curves("tire_law.fiala", {name: d[name] for name in names})


def forces_of(turns):
    """Return ``forces``, with turn slip if the contact ``turns``."""

    @kernel
    def forces(p, laws, k):
        """Return the SlipForces of the Slip ``k``."""
        v_t, v_l, rolling, V = slip_speeds(p, k)
        load = at_least(k.N, 0.0)
        along = p.longitudinal_stiffness if p.longitudinal_stiffness > 0 else p.cornering_stiffness
        C_t, C_l = curve(laws, along, load), curve(laws, p.cornering_stiffness, load)
        G_t, G_s = -C_t * v_t / V, -C_l * v_l / V
        camber, ahead = atan2(k.lean, sqrt(1.0 - k.lean * k.lean)), rolling / V
        G_l = G_s - curve(laws, p.camber_stiffness, load) * camber * (ahead * ahead)
        sliding = friction_limit(p, laws, k)
        a, b, g = 0.5 * p.contact_length, 0.5 * p.contact_width, TurnSlip(0.0 * V, 0.0, G_l, 0.0 * V)
        if turns:
            g = turn_slip(k, a, b, C_t, C_l, G_t, G_l, V, rolling, 3.0 * sliding)
        x = sqrt(G_t * G_t + g.G_l * g.G_l + g.G_m * g.G_m) / (3.0 * sliding)
        y = at_most(x, 1.0)
        share = select(x < 1.0, 1.0 - y + y * y / 3.0, 1.0 / (3.0 * at_least(x, 1.0)))
        aligning = -a / 3.0 * (1.0 - y) * (1.0 - y) * (1.0 - y) * G_s * ahead
        return bristle_forces(k, share, G_t, g, (v_t, v_l), aligning)

    return forces


def sample(rng):
    """Return laws for adhesion with one stiffness and camber, for sliding with two, and with turn slip."""
    falling = (("exponential", {"start": 0.9, "limit": 0.5, "rate": 0.2, "origin": 0.0}),)
    rising = (("linear", {"slope": 0.5, "offset": 3e3}),)
    base = {"contact_length": 3.0, "least_speed": 0.5, "carcass_stiffness": [2e3, 3e3], "creep_length": 0.5}
    return [
        {"cornering_stiffness": rising, "camber_stiffness": rising, "friction": falling, **base},
        {"cornering_stiffness": 3e5, "longitudinal_stiffness": 5e5, "friction": 0.4, **base},
        {"cornering_stiffness": rising, "camber_stiffness": rising, "friction": falling, "contact_width": 4.0, **base,
         "torsional_stiffness": 4e3},
    ]  # fmt: skip


FIALA = SlipLaw(
    "fiala", __doc__, mapping(*FIELDS), forces_of(False), check=check, sample=sample,
    turning=forces_of(True), passive=False,
)  # fmt: skip
