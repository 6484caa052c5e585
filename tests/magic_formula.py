"""The Magic Formula once more, from the printed equations, independent of mecano: arrays, SI units, forward rolling.

Numbers in round brackets are those of Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, chapter 4; (A..) those of the
appendix of Besselink, Schmeitz and Pacejka, Vehicle System Dynamics 48 (2010). Version 5.2: 2nd ed. 2006, section 4.3.
"""

import re

import numpy as np


def read(path):
    """Numbers of a .tir file by name."""
    found = re.findall(r"^([A-Z_0-9]+)\s*=\s*([-+0-9.eE]+)", path.read_text(), re.MULTILINE)
    return {key: float(text) for key, text in found}


def forces(given, Fz, kappa, alpha, gamma, Vx, pressure, version=6.1, Vs=0.0, turn=None):  # noqa: PLR0915 as printed
    """(Fx, Fy, Mx, My, Mz) at arrays of load, slips, camber [N, -, rad, rad] and speed [m/s], pressure [Pa].

    ``turn``: (rate of yaw, spin of the wheel) [rad/s] with turn slip, (4.75)-(4.106), the rate in the axes of ISO.
    """

    def c(name, default=0.0):
        return given.get(name, default)

    def scale(*names):
        return np.prod([c(name, 1.0) for name in names])

    Fz, kappa, alpha, gamma, Vx = np.broadcast_arrays(Fz, kappa, alpha, gamma, Vx)
    Fz0, R0, V0 = given["FNOMIN"], given["UNLOADED_RADIUS"], c("LONGVL", 16.7)
    Fz0_ = scale("LFZO") * Fz0  # (4.E1)
    df = (Fz - Fz0_) / Fz0_  # (4.E2a)
    dp = (pressure - given["NOMPRES"]) / given["NOMPRES"]  # (4.E2b)
    slow = 1.0 + c("LMUV") * Vs / V0  # (4.E7)
    l_mux, l_muy = scale("LMUX") / slow, scale("LMUY") / slow

    # turn slip, (4.75)-(4.79), (4.90), (4.91), (4.102), (4.105), (4.106)
    z0 = z1 = z2 = z3 = z5 = z6 = 1.0
    if turn:
        Vc, eps = Vx / np.cos(alpha), c("PECP1") * (1 + c("PECP2") * df)
        phit = turn[0] / Vc
        phi = (turn[0] + (1 - eps) * turn[1] * np.sin(gamma)) / Vc
        Bxp = c("PDXP1") * (1 + c("PDXP2") * df) * np.cos(np.arctan(c("PDXP3") * kappa))
        Byp = c("PDYP1") * (1 + c("PDYP2") * df) * np.cos(np.arctan(c("PDYP3") * np.tan(alpha)))
        z0, z1 = 0.0, np.cos(np.arctan(Bxp * R0 * phi))
        z2 = np.cos(np.arctan(Byp * (R0 * np.abs(phi) + c("PDYP4") * np.sqrt(R0 * np.abs(phi)))))
        z3 = np.cos(np.arctan(c("PKYP1") * R0**2 * phi**2))
        z5, z6 = np.cos(np.arctan(c("QDTP1") * R0 * phi)), np.cos(np.arctan(c("QBRP1") * R0 * phi))

    # longitudinal force in pure slip, (4.E9)-(4.E18)
    g = scale("LGAX") * gamma
    kx = kappa + (c("PHX1") + c("PHX2") * df) * scale("LHX")
    Cx = c("PCX1") * scale("LCX")
    mux = (c("PDX1") + c("PDX2") * df) * (1 + c("PPX3") * dp + c("PPX4") * dp**2) * (1 - c("PDX3") * g**2) * l_mux
    Dx = mux * Fz * z1
    Ex = np.minimum((c("PEX1") + c("PEX2") * df + c("PEX3") * df**2) * (1 - c("PEX4") * np.sign(kx)) * scale("LEX"), 1)
    Kx = Fz * (c("PKX1") + c("PKX2") * df) * np.exp(c("PKX3") * df) * (1 + c("PPX1") * dp + c("PPX2") * dp**2)
    Kx = Kx * scale("LKX")
    Bx = Kx / (Cx * Dx)
    SVx = Fz * (c("PVX1") + c("PVX2") * df) * scale("LVX") * l_mux * z1
    Fx0 = Dx * np.sin(Cx * np.arctan(Bx * kx - Ex * (Bx * kx - np.arctan(Bx * kx)))) + SVx

    def side(gamma, turn, z0, z2, z3):
        """Lateral force in pure slip, (4.E19)-(4.E30), of version 5.2 (4.E19)-(4.E30) of 2006."""
        g = scale("LGAY") * gamma
        Cy = c("PCY1") * scale("LCY")
        mu = (c("PDY1") + c("PDY2") * df) * (1 - c("PDY3") * g**2) * (1 + c("PPY3") * dp + c("PPY4") * dp**2) * l_muy
        Dy = mu * Fz * z2
        load = Fz / Fz0_ / ((c("PKY2") + c("PKY5") * g**2) * (1 + c("PPY2") * dp))
        Ky = c("PKY1") * Fz0_ * (1 + c("PPY1") * dp) * (1 - c("PKY3") * np.abs(g)) * scale("LKY")
        Ky = Ky * np.sin(c("PKY4", 2.0) * np.arctan(load)) * z3
        SVg = Fz * (c("PVY3") + c("PVY4") * df) * g * scale("LKYC") * l_muy * z2
        SVy = Fz * (c("PVY1") + c("PVY2") * df) * scale("LVY") * l_muy * z2 + SVg
        SHy = (c("PHY1") + c("PHY2") * df) * scale("LHY")
        if version < 6:
            SHy = SHy + c("PHY3") * g
        else:
            Kyg = Fz * (c("PKY6") + c("PKY7") * df) * (1 + c("PPY5") * dp) * scale("LKYC")
            z4 = 1.0
            if turn:  # (4.80), (4.84)-(4.89)
                upright = Fz / Fz0_ / (c("PKY2") * (1 + c("PPY2") * dp))
                Ky0 = c("PKY1") * Fz0_ * (1 + c("PPY1") * dp) * scale("LKY") * z3
                Ky0 = Ky0 * np.sin(c("PKY4", 2.0) * np.arctan(upright))
                CH, DH, EH = c("PHYP1"), c("PHYP2") + c("PHYP3") * df, c("PHYP4")
                x = Kyg / (1 - eps) / (CH * DH * Ky0) * R0 * phi
                z4 = 1 + DH * np.sin(CH * np.arctan(x - EH * (x - np.arctan(x)))) - SVg / Ky
            SHy = SHy + (Kyg * g - SVg) / Ky * z0 + z4 - 1
        ay = alpha + SHy
        Ey = (c("PEY1") + c("PEY2") * df) * scale("LEY")
        Ey = np.minimum(Ey * (1 + c("PEY5") * g**2 - (c("PEY3") + c("PEY4") * g) * np.sign(ay)), 1)
        By = Ky / (Cy * Dy)
        F = Dy * np.sin(Cy * np.arctan(By * ay - Ey * (By * ay - np.arctan(By * ay)))) + SVy
        return F, mu, Ky, By * Cy, SHy, SVy

    Fy0, muy, Ky, ByCy, SHy, SVy = side(gamma, turn, z0, z2, z3)

    # combined slip, (4.E50)-(4.E67)
    Bxa = (c("RBX1") + c("RBX3") * gamma**2) * np.cos(np.arctan(c("RBX2") * kappa)) * scale("LXAL")
    Exa, SHxa, a_s = np.minimum(c("REX1") + c("REX2") * df, 1), c("RHX1"), alpha + c("RHX1")
    G0 = np.cos(c("RCX1") * np.arctan(Bxa * SHxa - Exa * (Bxa * SHxa - np.arctan(Bxa * SHxa))))
    Fx = np.cos(c("RCX1") * np.arctan(Bxa * a_s - Exa * (Bxa * a_s - np.arctan(Bxa * a_s)))) / G0 * Fx0
    Byk = (c("RBY1") + c("RBY4") * gamma**2) * np.cos(np.arctan(c("RBY2") * (alpha - c("RBY3")))) * scale("LYKA")
    Eyk, SHyk = np.minimum(c("REY1") + c("REY2") * df, 1), c("RHY1") + c("RHY2") * df
    k_s = kappa + SHyk
    G0 = np.cos(c("RCY1") * np.arctan(Byk * SHyk - Eyk * (Byk * SHyk - np.arctan(Byk * SHyk))))
    Gyk = np.cos(c("RCY1") * np.arctan(Byk * k_s - Eyk * (Byk * k_s - np.arctan(Byk * k_s)))) / G0
    DVyk = muy * Fz * z2 * (c("RVY1") + c("RVY2") * df + c("RVY3") * gamma) * np.cos(np.arctan(c("RVY4") * alpha))
    SVyk = DVyk * np.sin(c("RVY5") * np.arctan(c("RVY6") * kappa)) * scale("LVYKA")
    Fy = Gyk * Fy0 + SVyk

    # overturning moment, (4.E69), with the terms QSX12-14 of the paper
    n, f = Fz / Fz0, Fy / Fz0
    Mx = c("QSX1") * scale("LVMX") - c("QSX2") * gamma * (1 + c("PPMX1") * dp) + c("QSX3") * f
    Mx = Mx + c("QSX4") * np.cos(c("QSX5") * np.arctan((c("QSX6") * n) ** 2)) * np.sin(
        c("QSX7") * gamma + c("QSX8") * np.arctan(c("QSX9") * f)
    )
    Mx = R0 * Fz * (Mx + c("QSX10") * np.arctan(c("QSX11") * n) * gamma) * scale("LMX")
    Mx = Mx + R0 * (Fy * (c("QSX13") + c("QSX14") * np.abs(gamma)) - Fz * c("QSX12") * gamma * np.abs(gamma)) * scale(
        "LMX"
    )

    # rolling resistance, (A48)
    My = c("QSY1") + c("QSY2") * Fx / Fz0 + c("QSY3") * np.abs(Vx / V0) + c("QSY4") * (Vx / V0) ** 4
    My = My + (c("QSY5") + c("QSY6") * n) * gamma**2
    My = -R0 * Fz0 * scale("LMY") * My * n ** c("QSY7", 1.0) * (pressure / given["NOMPRES"]) ** c("QSY8")

    # aligning moment, (4.E31)-(4.E49), (A54)-(A60), (4.E71)-(4.E75)
    g = scale("LGAZ") * gamma
    Bt = (c("QBZ1") + c("QBZ2") * df + c("QBZ3") * df**2) * (1 + c("QBZ4") * g + c("QBZ5") * np.abs(g))
    Bt = Bt * scale("LKY") / l_muy
    Dt = (c("QDZ1") + c("QDZ2") * df) * (1 - c("PPZ1") * dp) * (1 + c("QDZ3") * g + c("QDZ4") * g**2)
    Dt = Dt * Fz * R0 / Fz0_ * scale("LTR") * z5
    at = alpha + c("QHZ1") + c("QHZ2") * df + (c("QHZ3") + c("QHZ4") * df) * g
    Et = 1 + (c("QEZ4") + c("QEZ5") * g) * 2 / np.pi * np.arctan(Bt * c("QCZ1") * at)
    Et = np.minimum((c("QEZ1") + c("QEZ2") * df + c("QEZ3") * df**2) * Et, 1)

    def equivalent(angle):
        return np.arctan(np.hypot(np.tan(angle), Kx / Ky * kappa)) * np.sign(angle)

    z = Bt * equivalent(at)
    t = Dt * np.cos(c("QCZ1") * np.arctan(z - Et * (z - np.arctan(z)))) * np.cos(alpha)
    ar = alpha + SHy + SVy / Ky
    Br = (c("QBZ9") * scale("LKY") / l_muy + c("QBZ10") * ByCy) * z6
    of_camber = (c("QDZ8") + c("QDZ9") * df) * (1 + c("PPZ2") * dp) + (c("QDZ10") + c("QDZ11") * df) * np.abs(g)
    Dr = (c("QDZ6") + c("QDZ7") * df) * scale("LRES") * z2 + of_camber * g * scale("LKZC") * z0
    Dr, Cr = Fz * R0 * Dr * l_muy * np.cos(alpha), 1.0
    if turn:  # (4.92)-(4.99), (4.103), (4.104)
        full = c("QCRP1") * np.abs(muy) * R0 * Fz * np.sqrt(Fz / Fz0_) * scale("LMP")
        CD, ED = c("QDRP1"), c("QDRP2")
        DD = full / np.sin(0.5 * np.pi * CD)
        Kz = Fz * R0 * (c("QDZ8") + c("QDZ9") * df + (c("QDZ10") + c("QDZ11") * df) * np.abs(g)) * scale("LKZC")
        x = Kz / (CD * DD * (1 - eps)) * R0 * phi
        Drp = DD * np.sin(CD * np.arctan(x - ED * (x - np.arctan(x))))
        full = full * 2 / np.pi * np.arctan(c("QCRP2") * R0 * np.abs(phit)) * Gyk
        Dr, Cr = Dr + Drp, 2 / np.pi * np.arccos(np.minimum(full / np.abs(Drp), 1.0))
    s = R0 * (c("SSZ1") + c("SSZ2") * Fy / Fz0 + (c("SSZ3") + c("SSZ4") * df) * g) * scale("LS")
    trailing = Fy - SVyk if version < 6 else Gyk * side(0.0 * gamma, None, 1.0, 1.0, 1.0)[0]  # (4.E74)
    Mz = -t * trailing + Dr * np.cos(Cr * np.arctan(Br * equivalent(ar))) + s * Fx
    return Fx, Fy, Mx, My, Mz


def rolling_radius(given, Fz, omega):
    """Effective rolling radius R_e, (A3) with the radius growing by (A1)."""
    R0, Fz0, Cz = given["UNLOADED_RADIUS"], given["FNOMIN"], given["VERTICAL_STIFFNESS"]
    free = R0 * (given.get("Q_RE0", 1.0) + given.get("Q_V1", 0.0) * (omega * R0 / given.get("LONGVL", 16.7)) ** 2)
    n = Fz / Fz0
    return free - Fz0 / Cz * (given["DREFF"] * np.arctan(given["BREFF"] * n) + given["FREFF"] * n)
