r"""Tyre in yawed rolling after Smiley and Horne: cornering force and self-aligning torque against one angle.

For aircraft tyres of any size, load and pressure the force and the moment fall on two curves if the yaw angle psi is
multiplied by the cornering stiffness N and divided by mu F_z (NASA TR R-64, 1960; NACA TN 4110, 1958):

    phi = N psi/(mu F_z)
    F(phi) = mu F_z {phi - 4 phi^3/27 up to phi = 1.5, 1 beyond}
    M(phi) = mu F_z h {0.8 phi up to 0.1, phi - phi^2 - 0.01 up to 0.55, 0.2925 - 0.1 phi up to 2.925, 0 beyond}

with the half length h = c sqrt(w (2 r - w)) of the contact at the deformation w of a tyre of the radius r, c =
``contact_share`` of the chord. N is a curve of w. The report has no braking: in combined slip the force is that of the
whole slip, against it, with the slip velocity (v_t, v_l), the spin times the rolling radius V_r, V = sqrt(V_r^2 +
v_0^2) and the slip stiffness C_t:

    G = -(C_t v_t/V, N atan(v_l/V)),   phi = |G|/(mu F_z),   F(phi) G/|G|,   -M(phi) (G_l/|G|) (V_r/V) n

In pure side slip this is the law above, with the angle psi; in reverse the moment changes its sign. There is no camber
thrust. The force dissipates -F.v >= 0; the moment exchanges the power M.omega with the rolling. The friction mu is a
curve of the slip speed. With v_0 = ``least_speed`` the slip is finite at rest, where the tyre therefore creeps. With a
``contact_width`` the tyre has turn slip (turn_slip.py), with a = h: G has a third component G_m, and M_s =
F(phi) k G_m/|G| is added to the moment.
"""

from mecano.elements.wheels.slip_law import SlipLaw, check_twist, friction_limit
from mecano.elements.wheels.turn_slip import BRISTLE_FIELDS, TurnSlip, bristle_forces, slip_speeds, turn_slip
from mecano.jit.kernel import kernel
from mecano.laws.law_table import curve
from mecano.laws.probe import negative_curves
from mecano.maths.dual import at_least, atan2, select, sqrt
from mecano.schema import CURVE, NUMBER, Field, mapping, share

LEAST_DEPTH = 1e-9  # lower bound of the deformation in h, over the radius: the root has a slope at zero
FULL, STRAIGHT, CURVED = 1.5, 0.1, 0.55  # phi: sliding; ends of the first and the second piece of the moment

FIELDS = (
    Field(
        "cornering_stiffness", CURVE, "N/rad", "N, lateral force per angle; a curve of the radial deformation [m]; by "
        "'smiley_horne' when absent", None, argument="m",
    ),
    Field(
        "longitudinal_stiffness", CURVE, "N",
        "C_t, driving force per slip ratio; a curve of the radial deformation [m]; N when absent", None, argument="m"
    ),
    Field("friction", CURVE, "-", "coefficient of friction mu, a curve of the slip speed [m/s]", argument="m/s"),
    Field("contact_share", NUMBER, "-", "c, length of the contact over that of the chord", 0.85, share),
    *BRISTLE_FIELDS,
)  # fmt: skip


def check(law):
    """Return errors for a missing cornering stiffness and for negative friction."""
    d = law["yawed_rolling"]
    texts = check_twist("yawed_rolling", d)
    if d["cornering_stiffness"] is None:
        texts.append("'tire_law.yawed_rolling' has no 'cornering_stiffness': give it, or 'smiley_horne', which does")
    return texts + negative_curves("tire_law.yawed_rolling", {"friction": d["friction"]})


def forces_of(turns):
    """Return ``forces``, with turn slip if the contact ``turns``."""

    @kernel
    def forces(p, laws, k):
        """Return the SlipForces of the Slip ``k``."""
        v_t, v_l, rolling, V = slip_speeds(p, k)
        w = at_least(k.w, LEAST_DEPTH * p.radius)
        along = p.longitudinal_stiffness if p.longitudinal_stiffness > 0 else p.cornering_stiffness
        C_t, C_l = at_least(curve(laws, along, w), 0.0), at_least(curve(laws, p.cornering_stiffness, w), 0.0)
        G_t, G_l = -C_t * v_t / V, -C_l * atan2(v_l, V)
        limit = friction_limit(p, laws, k)
        h, b = p.contact_share * sqrt(w * (2.0 * p.radius - w)), 0.5 * p.contact_width
        g = TurnSlip(0.0 * V, 0.0 * h, G_l, 0.0 * V)
        if turns:
            g = turn_slip(k, h, b, C_t, C_l, G_t, G_l, V, rolling, FULL * limit)
        phi = sqrt(G_t * G_t + g.G_l * g.G_l + g.G_m * g.G_m) / limit
        used = select(phi < FULL, 1.0 - 4.0 / 27.0 * phi * phi, 1.0 / at_least(phi, FULL))
        return bristle_forces(k, used, G_t, g, (v_t, v_l), -arm(phi) * h * (rolling / V) * G_l)

    return forces


@kernel
def arm(phi):
    """Return M/(phi mu F_z h)."""
    inner = at_least(phi, STRAIGHT)
    sliding = at_least(0.2925 / inner - 0.1, 0.0)
    return select(phi < CURVED, 1.0 - inner - 0.01 / inner, sliding)


def sample(rng):
    """Return laws for adhesion and for sliding, with one stiffness and with two, and with turn slip."""
    falling = (("exponential", {"start": 0.9, "limit": 0.5, "rate": 0.2, "origin": 0.0}),)
    rising = (("polynomial", {"coefficients": [1e3, 4e3, -300.0]}),)
    base = {"least_speed": 0.5, "carcass_stiffness": [2e3, 3e3], "creep_length": 0.5}
    return [
        {"cornering_stiffness": rising, "friction": falling, **base},
        {"cornering_stiffness": 3e5, "longitudinal_stiffness": 5e5, "friction": 0.4, **base},
        {"cornering_stiffness": rising, "friction": falling, "contact_width": 4.0, **base,
         "torsional_stiffness": 4e3},
    ]  # fmt: skip


YAWED_ROLLING = SlipLaw(
    "yawed_rolling", __doc__, mapping(*FIELDS), forces_of(False), check=check, sample=sample,
    turning=forces_of(True), passive=False,
)  # fmt: skip
