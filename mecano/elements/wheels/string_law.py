r"""Tyres as a stretched string: the law of von Schlippe and Dietrich, and the straight tangent.

A string on an elastic foundation of stiffness c per length, under tension, lies on the ground over the contact length
2a and returns to the wheel plane ahead of and behind it as exp(-distance/sigma) (von Schlippe and Dietrich 1941;
Pacejka, Tire and Vehicle Dynamics, chapter 5). It has no corner at the leading edge, and the part on the ground stays
in place: with the deflection v(x, t) over the contact -a < x < a of a wheel that moves with V, sideways with v_lat, and
turns with omega_n,

    dv/dt = V dv/dx - v_lat - x omega_n,      dv/dx = -v/sigma at x = a

Every point of the contact repeats the leading edge after some distance: a delay. Averaged over the contact, the mean
deflection and the slope of the chord, psi = (v(a) - v(-a))/(2a), satisfy dv/dt = V psi - v_lat *exactly*: they are y
(with opposite sign) and psi of the patch, and this equation is v_C = 0.

``string`` takes v as a cubic, v = -y + c_1 P_1 + b P_2 + c_3 P_3 in Legendre polynomials of x/a (the tau method of
third degree: a rational approximation of the delay). The condition at the leading edge and the definition of psi give
c_3 = (a y - a (a + sigma) psi - (a + 3 sigma) b)/(5 sigma) and c_1 = a psi - c_3; the first two moments of the equation
above give the equations of psi and of the bow b, an additional unknown. With g_0 = V/S, g_1 = 1/S,
S = sqrt(V^2 + v_0^2):

    M = kap {g_0 (psi - y/(sigma + a))
             + g_1 [(a + 3 sigma)/(3 (sigma + a)) (dc_1/dt + a omega_n) + sigma/(sigma + a) db/dt]}
    X = 2c (sigma + a) {g_1 a db/dt - 5 g_0 c_3}

which vanish in free rolling. Forces and moment are those of the string, c (integral of v + sigma (v(a) + v(-a))) and
c (integral of v x + sigma (sigma + a)(v(a) - v(-a))):

    F = 2c [(sigma + a) y - sigma b],    aligning moment = 2c [a^2 c_1/3 + sigma (sigma + a) a psi]

``straight_tangent`` takes the deflection at the leading edge, whose equation has no delay, as y, and the tangent there
as the contact line: it is of first order in the distance. docs/tyre-equations.md compares both with the exact delay.

    M = kap {psi - y/sigma + a omega_n V^3/(V^4 + v_0^4)},    F = 1/C y/sigma,    aligning moment = 1/C t y/sigma

Its psi is the slip angle at the leading edge, not a twist against a stiffness: as in the law with a relaxation length
(lateral_law.py) a change of psi does not carry the patch along; its kap, sigma/C, only scales the equation.

Both have the cornering stiffness 1/C = 2c (sigma + a)^2 and the pneumatic trail t = a (sigma (sigma + a) +
a^2/3)/(sigma + a)^2; the kap of the string is the torsional stiffness of the patch. In reverse the other edge leads:
the straight tangent turns over (lateral_law.py), while the equations of the string hold for rolling forward.

These equations assume that the contact line adheres. Where it slides, dc_1/dt uses the dy/dt of an adhering contact
line, from the motion of the wheel alone: otherwise dy/dt would enter M with no opposing term (docs/tyre-equations.md).
"""

import numpy as np

from mecano.jit.kernel import kernel
from mecano.maths.dual import select, sqrt
from mecano.schema import NUMBER, Field, mapping, positive

CORNERING_STIFFNESS = Field(
    "cornering_stiffness", NUMBER, "N/rad", "lateral force per slip angle in steady rolling", check=positive
)
CORNERING = (
    CORNERING_STIFFNESS,
    Field("relaxation_length", NUMBER, "m", "sigma, decay length of the string ahead of the contact", check=positive),
    Field("contact_length", NUMBER, "m", "2a", check=positive),
)
TORSIONAL_STIFFNESS = Field(
    "torsional_stiffness", NUMBER, "N m/rad", "kap: moment per turn psi of the patch; matters under braking", 1.0e4,
    positive,
)  # fmt: skip
LEAST = Field("least_speed", NUMBER, "m/s", "v_0, below which rolling does not turn the patch", 0.5, positive)
STRING_TYPE = mapping(*CORNERING, TORSIONAL_STIFFNESS, LEAST)
TANGENT_TYPE = mapping(*CORNERING, LEAST)
NO_PACE, OF_STRING, OF_TANGENT = 0.0, 1.0, 2.0


def prepare_string(law):
    """Return the values of the record for a lateral law with a contact length; {} for other laws."""
    d = law["string"] or law["straight_tangent"]
    if not d:
        return {}
    sigma, a = d["relaxation_length"], 0.5 * d["contact_length"]
    c = 0.5 * d["cornering_stiffness"] / (sigma + a) ** 2
    values = _string(sigma, a, c, d["torsional_stiffness"]) if law["string"] else _tangent(sigma, a, c)
    A1_air = law["relaxation_in_air"] * values["A0"]
    return {**values, "A1_air": A1_air, "least_speed": d["least_speed"]}


def _string(sigma, a, c, kap):
    c_3 = np.array([a, -a * (a + sigma), -(a + 3.0 * sigma)]) / (5.0 * sigma)
    c_1 = np.array([0.0, a, 0.0]) - c_3
    turned, size = (a + 3.0 * sigma) / (3.0 * (sigma + a)), 2.0 * c * (sigma + a)
    bow = np.array([0.0, 0.0, 1.0])
    A0 = [[size, 0.0, -2.0 * c * sigma], [-kap / (sigma + a), kap, 0.0], -5.0 * size * c_3]
    A1 = [np.zeros(3), kap * (turned * c_1 + sigma / (sigma + a) * bow), size * a * bow]
    moment = 2.0 * c * (a * a / 3.0 * c_1 + np.array([0.0, sigma * (sigma + a) * a, 0.0]))
    turning = [0.0, kap * turned * a, 0.0]
    values = {"A0": np.array(A0), "A1": np.array(A1), "turning": turning, "moment": moment}
    return {**values, "pace": OF_STRING, "twist": 1.0}


def _tangent(sigma, a, c):
    cornering = 2.0 * c * (sigma + a) ** 2
    side, kap = cornering / sigma, cornering * sigma
    A0 = np.array([[side, 0.0, 0.0], [-kap / sigma, kap, 0.0], [0.0, 0.0, side]])
    moment = [2.0 * a * c * (a * a / 3.0 + sigma * (sigma + a)) / sigma, 0.0, 0.0]
    turning = [0.0, kap * a, 0.0]
    return {"A0": A0, "A1": np.zeros((3, 3)), "turning": turning, "moment": moment, "pace": OF_TANGENT, "twist": 0.0}


@kernel
def pace(p, u):
    """Return g_0 and g_1 for the speed u [m/s]."""
    slow = p.least_speed
    size, fast = sqrt(u * u + slow * slow), u * u * u
    string, tangent = p.pace == OF_STRING, p.pace == OF_TANGENT
    of_tangent = fast / (u * fast + slow * slow * slow * slow)
    return select(string, u / size, 1.0), select(string, 1.0 / size, select(tangent, of_tangent, 1.0))
