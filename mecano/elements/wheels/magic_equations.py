"""Equations of the Magic Formula: forces and moments in the axes of a .tir file, rolling forward.

Numbers (4.E..) are those of Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, (A..) those of Besselink, Schmeitz and
Pacejka, Vehicle System Dynamics 48 (2010). A record ``p`` has the coefficients under the names that they have in the
file; VERSION < 6 is 5.2.
"""

import math
from typing import NamedTuple

from mecano.jit.kernel import kernel
from mecano.maths.dual import at_least, at_most, atan2, chain, cos, exp, select, sin, sqrt, value

EPSILON = 1e-6  # keeps quotients finite where the formula is zero


class Slips(NamedTuple):
    """Arguments of the formula, in the axes of the file."""

    N: float
    df: float
    dp: float
    kappa: float
    alpha: float
    gamma: float
    rolls: float  # V_x/V: share of the shifts, which a tyre at rest has not
    turn: float  # turn slip W/V [1/m]
    spin: float  # turn slip with the part of the camber [1/m]


class Turn(NamedTuple):
    """Factors of turn slip, (4.76)-(4.106): ``zeta_i`` of the book, and the shift S_Hyphi of the slip angle."""

    zeta_0: float
    zeta_1: float
    zeta_2: float
    zeta_3: float
    zeta_5: float
    zeta_6: float
    shift: float


@kernel
def straight(p, s):
    """Return the Turn of a tyre without turn slip."""
    return Turn(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0)


@kernel
def no_moment(p, s, most, G_y):
    """Return the peak of the moment of turn slip and zeta_7 of a tyre without turn slip."""
    return 0.0, 1.0


@kernel
def atan(x):
    """Return the arc tangent."""
    return atan2(x, 1.0)


@kernel
def power(x, p):
    """Return x^p of x > 0."""
    y = value(x) ** p
    return chain(x, y, p * y / value(x))


@kernel
def sign(x):
    """Return 1 or -1, without a slope."""
    return select(value(x) < 0.0, -1.0, 1.0)


@kernel
def curved(B, C, E, x):
    """Return the angle C atan{B x - E (B x - atan(B x))}."""
    z = B * x
    return C * atan(z - at_most(E, 1.0) * (z - atan(z)))


@kernel
def longitudinal(p, s, mu, turn):
    """Return F_x0 and the slip stiffness, (4.E9)-(4.E18)."""
    camber = p.LGAX * s.gamma
    by_pressure = 1.0 + p.PPX3 * s.dp + p.PPX4 * s.dp * s.dp
    D = (p.PDX1 + p.PDX2 * s.df) * by_pressure * (1.0 - p.PDX3 * camber * camber) * p.LMUX * mu * s.N * turn.zeta_1
    x = s.kappa + s.rolls * (p.PHX1 + p.PHX2 * s.df) * p.LHX
    E = (p.PEX1 + p.PEX2 * s.df + p.PEX3 * s.df * s.df) * (1.0 - p.PEX4 * sign(x)) * p.LEX
    K = s.N * (p.PKX1 + p.PKX2 * s.df) * exp(p.PKX3 * s.df) * (1.0 + p.PPX1 * s.dp + p.PPX2 * s.dp * s.dp) * p.LKX
    C = p.PCX1 * p.LCX
    shift = s.rolls * s.N * (p.PVX1 + p.PVX2 * s.df) * p.LVX * p.LMUX * mu * turn.zeta_1
    return D * sin(curved(K / (C * D + EPSILON), C, E, x)) + shift, K


class Side(NamedTuple):
    """Lateral force in pure side slip, with the quantities that other equations need."""

    F: float
    K: float
    D: float
    BC: float
    S_H: float
    S_V: float


@kernel
def cornering_stiffness(p, s, g):
    """Return K_y of a scaled camber angle without turn slip, (4.E25)."""
    F_0 = p.LFZO * p.FNOMIN
    K = p.PKY1 * F_0 * (1.0 + p.PPY1 * s.dp) * (1.0 - p.PKY3 * g * sign(g)) * p.LKY
    return K * sin(p.PKY4 * atan(s.N / F_0 / ((p.PKY2 + p.PKY5 * g * g) * (1.0 + p.PPY2 * s.dp))))


@kernel
def camber_stiffness(p, s):
    """Return K_ygamma0, (4.E30)."""
    return s.N * (p.PKY6 + p.PKY7 * s.df) * (1.0 + p.PPY5 * s.dp) * p.LKYC


@kernel
def lateral(p, s, mu, gamma, turn):
    """Return the Side at a camber angle, (4.E19)-(4.E30)."""
    old = p.VERSION < 6.0
    g, friction = p.LGAY * gamma, p.LMUY * mu * turn.zeta_2
    K = cornering_stiffness(p, s, g) * turn.zeta_3
    thrust = s.N * (p.PVY3 + p.PVY4 * s.df) * g * p.LKYC * friction
    by_camber = turn.zeta_0 * camber_stiffness(p, s) * g
    turned = select(old, p.PHY3 * g, (by_camber - thrust) / (K + EPSILON * sign(K)) + turn.shift)
    S_H = s.rolls * ((p.PHY1 + p.PHY2 * s.df) * p.LHY + turned)
    S_V = s.rolls * (s.N * (p.PVY1 + p.PVY2 * s.df) * p.LVY * friction + thrust)
    x, C = s.alpha + S_H, p.PCY1 * p.LCY
    by_pressure = 1.0 + p.PPY3 * s.dp + p.PPY4 * s.dp * s.dp
    D = (p.PDY1 + p.PDY2 * s.df) * by_pressure * (1.0 - p.PDY3 * g * g) * friction * s.N
    E = (p.PEY1 + p.PEY2 * s.df) * (1.0 + p.PEY5 * g * g - (p.PEY3 + p.PEY4 * g) * sign(x)) * p.LEY
    B = K / (C * D + EPSILON * sign(D))
    return Side(D * sin(curved(B, C, E, x)) + S_V, K, D, B * C, S_H, S_V)


@kernel
def combined(p, s, side):
    """Return the weights G of F_x0 and F_y0, and S_Vyk, (4.E50)-(4.E67).

    The weights are positive, (4.E51), (4.E59). With C > 1 their cosines are not beyond a large slip: a force along the
    slip would drive a tyre that slides sideways, and the deflection of a carcass would have no unique rate.
    """
    g = s.gamma
    B = (p.RBX1 + p.RBX3 * g * g) * cos(atan(p.RBX2 * s.kappa)) * p.LXAL
    E = p.REX1 + p.REX2 * s.df
    G_x = at_least(cos(curved(B, p.RCX1, E, s.alpha + p.RHX1)), 0.0) / cos(curved(B, p.RCX1, E, p.RHX1))
    B = (p.RBY1 + p.RBY4 * g * g) * cos(atan(p.RBY2 * (s.alpha - p.RBY3))) * p.LYKA
    E, shift = p.REY1 + p.REY2 * s.df, p.RHY1 + p.RHY2 * s.df
    G_y = at_least(cos(curved(B, p.RCY1, E, s.kappa + shift)), 0.0) / cos(curved(B, p.RCY1, E, shift))
    D = side.D * (p.RVY1 + p.RVY2 * s.df + p.RVY3 * g) * cos(atan(p.RVY4 * s.alpha))
    return G_x, G_y, D * sin(p.RVY5 * atan(p.RVY6 * s.kappa)) * p.LVYKA


@kernel
def equivalent(x, ratio, kappa):
    """Return the equivalent slip angle in combined slip, (4.E77), (4.E78), as (A54), (A55) of Besselink et al."""
    tan_x = sin(x) / cos(x)
    z = ratio * kappa
    return atan(sqrt(tan_x * tan_x + z * z)) * sign(x)


@kernel
def aligning(p, s, mu, side, ratio, F_x, F_y, F_side, turn, twist):
    """Return M_z for forward rolling and its part of turn slip, (4.E31)-(4.E49), (4.E71)-(4.E78).

    ``F_side``: force on the pneumatic trail; ``twist``: peak of the moment of turn slip, zeta_7.
    """
    R0, g = p.UNLOADED_RADIUS, p.LGAZ * s.gamma
    size, straight, scale = g * sign(g), cos(s.alpha), p.LKY / (p.LMUY * mu)
    B = (p.QBZ1 + p.QBZ2 * s.df + p.QBZ3 * s.df * s.df) * (1.0 + p.QBZ4 * g + p.QBZ5 * size) * scale
    D = s.N * (p.QDZ1 + p.QDZ2 * s.df) * (1.0 - p.PPZ1 * s.dp) * (1.0 + p.QDZ3 * g + p.QDZ4 * g * g)
    D = D * R0 / (p.LFZO * p.FNOMIN) * p.LTR * turn.zeta_5
    x = s.alpha + p.QHZ1 + p.QHZ2 * s.df + (p.QHZ3 + p.QHZ4 * s.df) * g
    bent = 1.0 + (p.QEZ4 + p.QEZ5 * g) * (2.0 / math.pi) * atan(B * p.QCZ1 * x)
    E = (p.QEZ1 + p.QEZ2 * s.df + p.QEZ3 * s.df * s.df) * bent
    trail = D * cos(curved(B, p.QCZ1, E, equivalent(x, ratio, s.kappa))) * straight
    x = s.alpha + side.S_H + side.S_V / (side.K + EPSILON * sign(side.K))
    by_camber = (p.QDZ8 + p.QDZ9 * s.df) * (1.0 + p.PPZ2 * s.dp) + (p.QDZ10 + p.QDZ11 * s.df) * size
    residual = (p.QDZ6 + p.QDZ7 * s.df) * p.LRES * turn.zeta_2 + by_camber * g * p.LKZC * turn.zeta_0
    D = s.N * R0 * residual * p.LMUY * mu * straight
    B = (p.QBZ9 * scale + p.QBZ10 * side.BC) * turn.zeta_6
    arm = R0 * (p.SSZ1 + p.SSZ2 * F_y / p.FNOMIN + (p.SSZ3 + p.SSZ4 * s.df) * g) * p.LS
    fall = cos(twist[1] * atan(B * equivalent(x, ratio, s.kappa)))
    return D * fall - trail * F_side + arm * F_x, twist[0] * fall


@kernel
def overturning(p, s, F_y):
    """Return M_x, (4.E69), with the terms QSX12 to QSX14 of Besselink et al."""
    y, n, g = F_y / p.FNOMIN, s.N / p.FNOMIN, s.gamma
    size, z = g * sign(g), p.QSX6 * n
    swing = p.QSX4 * cos(p.QSX5 * atan(z * z)) * sin(p.QSX7 * g + p.QSX8 * atan(p.QSX9 * y))
    of_load = (
        p.QSX1 * p.LVMX - p.QSX2 * g * (1.0 + p.PPMX1 * s.dp) + p.QSX3 * y + swing + p.QSX10 * atan(p.QSX11 * n) * g
    )
    of_force = F_y * (p.QSX13 + p.QSX14 * size) - s.N * p.QSX12 * g * size
    return p.UNLOADED_RADIUS * p.LMX * (s.N * of_load + of_force)


@kernel
def rolling_resistance(p, s, F_x, V_x):
    """Return M_y, which opposes forward rolling, (4.E70) as (A48) of Besselink et al."""
    v, n = V_x / p.LONGVL, s.N / p.FNOMIN
    share = p.QSY1 + p.QSY2 * F_x / p.FNOMIN + p.QSY3 * v * sign(v) + p.QSY4 * v * v * v * v
    share = share + (p.QSY5 + p.QSY6 * n) * s.gamma * s.gamma
    return -p.UNLOADED_RADIUS * p.FNOMIN * p.LMY * share * power(n, p.QSY7) * (1.0 + s.dp) ** p.QSY8


@kernel
def rolling_radius(p, N, spin):
    """Return R_e [m], (A3) of Besselink et al.; without a vertical stiffness, the free radius."""
    n, rim = N / p.FNOMIN, spin * p.UNLOADED_RADIUS / p.LONGVL
    soft = select(p.VERTICAL_STIFFNESS > 0.0, p.FNOMIN / at_least(p.VERTICAL_STIFFNESS, 1.0), 0.0)
    pressed = soft * (p.DREFF * atan(p.BREFF * n) + p.FREFF * n)
    return p.UNLOADED_RADIUS * (p.Q_RE0 + p.Q_V1 * rim * rim) - pressed


def formula_of(factors, moment):
    """Return the formula with turn slip or without: ``factors`` gives the Turn, ``moment`` its peak and zeta_7."""

    @kernel
    def formula(p, s, mu, V_x):
        """Return (F_x, F_y, M_x, M_y, M_z, part of M_z that is not from rolling) of Slips, rolling forward."""
        turn = factors(p, s)
        F_x0, K_x = longitudinal(p, s, mu, turn)
        side = lateral(p, s, mu, s.gamma, turn)
        upright = lateral(p, s, mu, 0.0 * s.gamma, straight(p, s))
        G_x, G_y, S = combined(p, s, side)
        F_x, F_y = G_x * F_x0, G_y * side.F + S
        F_side = G_y * select(p.VERSION < 6.0, side.F, upright.F)
        ratio = K_x / (side.K + EPSILON * sign(side.K))
        twist = moment(p, s, side.D / turn.zeta_2, G_y)
        M_z, M_turn = aligning(p, s, mu, side, ratio, F_x, F_y, F_side, turn, twist)
        return F_x, F_y, overturning(p, s, F_y), rolling_resistance(p, s, F_x, V_x), M_z, M_turn

    return formula
