"""Turn slip in the Magic Formula: (4.76)-(4.106) of Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, section 4.3.3.

The spin phi of a contact has a part from the curvature of its path, the turn slip phi_t, and one from camber,

    phi = phi_t + (1 - eps_gamma) Omega sin(gamma)/V,   phi_t = W/V,   V = sqrt(V_x^2 + V_sy^2 + v_0^2)

(of the axes of ISO 8855, whose W is opposite to that of the book). It lowers the friction and the stiffnesses of the
other slips, and takes the place of camber in the lateral force, as a shift of the slip angle, and in the moment.
sqrt((R0 phi)^2 + 1e-12), which has a slope at zero, stands for |R0 phi|.
"""

import math

from mecano.elements.wheels.magic_equations import (
    EPSILON,
    Turn,
    atan,
    camber_stiffness,
    cornering_stiffness,
    curved,
    sign,
)
from mecano.jit.kernel import kernel
from mecano.maths.dual import at_most, atan2, cos, sin, sqrt

COEFFICIENTS = (
    "PECP1 PECP2 PDXP1 PDXP2 PDXP3 PKYP1 PDYP1 PDYP2 PDYP3 PDYP4 PHYP1 PHYP2 PHYP3 PHYP4 QDTP1 QCRP1 QCRP2 QBRP1 "
    "QDRP1 QDRP2"
).split()
NEEDED = "PKY6", "QDZ8", "PHYP1", "PHYP2", "QCRP1", "QDRP1"  # without these, camber has no force or moment


def check(c):
    """Return errors in the coefficients ``c`` of a tyre with turn slip."""
    where = "'tire_law.magic_formula.turn_slip'"
    if c["VERSION"] < 6.0:
        return [f"{where}: available for files of version 6.1 and 6.2, not of {c['VERSION']:g}"]
    if missing := [name for name in NEEDED if c[name] == 0.0]:
        return [f"{where}: the file has no {', '.join(missing)}, or zero; 'turn_slip: false' runs without"]
    if c["PECP1"] >= 1.0 or not 0.0 < c["QDRP1"] < 2.0:
        return [f"{where}: PECP1 must be less than 1 and QDRP1 between 0 and 2, got {c['PECP1']:g}, {c['QDRP1']:g}"]
    return []


@kernel
def size_of(x):
    """Return |x|, smooth at zero."""
    return sqrt(x * x + EPSILON * EPSILON)


@kernel
def falling(x):
    """Return cos(atan(x))."""
    return 1.0 / sqrt(1.0 + x * x)


@kernel
def of_camber(p, df):
    """Return 1 - eps_gamma, (4.90)."""
    return 1.0 - p.PECP1 * (1.0 + p.PECP2 * df)


@kernel
def turned(p, s):
    """Return the Turn of a tyre with turn slip."""
    x = p.UNLOADED_RADIUS * s.spin
    size, slope = size_of(x), sin(s.alpha) / cos(s.alpha)
    B_x = p.PDXP1 * (1.0 + p.PDXP2 * s.df) * falling(p.PDXP3 * s.kappa)
    B_y = p.PDYP1 * (1.0 + p.PDYP2 * s.df) * falling(p.PDYP3 * slope)
    zeta_3 = falling(p.PKYP1 * x * x)
    K = cornering_stiffness(p, s, 0.0 * s.gamma) * zeta_3
    C, D = p.PHYP1, p.PHYP2 + p.PHYP3 * s.df
    B = camber_stiffness(p, s) / (of_camber(p, s.df) * C * D * K)
    return Turn(
        0.0, falling(B_x * x), falling(B_y * (size + p.PDYP4 * sqrt(size))), zeta_3, falling(p.QDTP1 * x),
        falling(p.QBRP1 * x), D * sin(curved(B, C, p.PHYP4, x)),
    )  # fmt: skip


@kernel
def turning_moment(p, s, most, G_y):
    """Return D_rphi [N m] and zeta_7, (4.93)-(4.99), (4.103), (4.104); ``most``: mu_y N [N]."""
    R0, g, x = p.UNLOADED_RADIUS, p.LGAZ * s.gamma, p.UNLOADED_RADIUS * s.spin
    full, size = p.QCRP1 * R0 * most * sign(most) * sqrt(s.N / (p.LFZO * p.FNOMIN)) * p.LMP, size_of(x)
    K = s.N * R0 * (p.QDZ8 + p.QDZ9 * s.df + (p.QDZ10 + p.QDZ11 * s.df) * g * sign(g)) * p.LKZC
    C = p.QDRP1
    D = full / math.sin(0.5 * math.pi * C)
    peak = D * sin(curved(K * sign(K) / (C * D * of_camber(p, s.df)), C, p.QDRP2, size))
    sideways = (2.0 / math.pi) * full * G_y * atan(p.QCRP2 * size_of(R0 * s.turn))
    share = at_most(sideways / peak, 1.0 - EPSILON * EPSILON)
    return sign(K) * (x / size) * peak, (2.0 / math.pi) * atan2(sqrt(1.0 - share * share), share)
