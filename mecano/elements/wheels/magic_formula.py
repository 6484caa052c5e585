r"""Magic Formula of Pacejka in steady slip: force and moment (overturning, rolling, aligning) from a .tir file.

Equations (4.E9)-(4.E78) of Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, as in Besselink, Schmeitz and Pacejka, An
improved Magic Formula/Swift tyre model that can handle inflation pressure changes, Vehicle System Dynamics 48 (2010),
for files of versions 6.1 and 6.2; in files of 5.2 the camber terms are those of the 2nd ed. 2006. With the effective
rolling radius R_e, the slip velocity of the contact and V = sqrt(V_x^2 + v_0^2):

    kappa = -(V_x - R_e Omega)/V,   tan alpha = V_sy/V,   gamma = asin(n.a),   df = N/F_z0 - 1,   dp = p/p_0 - 1

    y(x) = D sin[C atan{B x - E (B x - atan(B x))}],   G(x) = cos[C atan{B x - E (B x - atan(B x))}]/the same at S_H

    F_x = G(alpha) F_x0(kappa),   F_y = G(kappa) F_y0(alpha, gamma) + S_Vyk,   M_z = -t F_y' + M_zr + s F_x

in the axes (t, l, n), which are the axes of ISO 8855 used in such files; G is zero where it would be negative. A wheel
that rolls backward is one that rolls forward in the axes (-t, -l, n), also in its asymmetries, which a file does not
describe apart as conicity and ply steer; within -v_0 < V_x < v_0 forces and moments pass smoothly from one to the
other. M_y, M_z and the shifts S_H, S_V of F_x0 and F_y0 (conicity, ply steer, camber) come from rolling: they have the
factor V_x/V, so that a tyre at rest is without force. The formula is a fit: near zero slip its shifts may drive the
wheel. The power that the force takes from the slip, rolling resistance from the spin, and the moment of turn slip from
the turning counts as dissipated; the rest is exchanged with the rolling.

With ``turn_slip``, the curvature W/V of the path of the contact changes all forces and moments by (4.76)-(4.106) of the
book (magic_turn_slip.py); a tyre that turns on the spot then has the moment QCRP1 R0 mu N sqrt(N/F_z0).
"""

import math
from dataclasses import replace

from mecano.elements.wheels.magic_equations import Slips, atan, formula_of, no_moment, rolling_radius, straight
from mecano.elements.wheels.magic_turn_slip import COEFFICIENTS as OF_TURN_SLIP
from mecano.elements.wheels.magic_turn_slip import check as check_turn_slip
from mecano.elements.wheels.magic_turn_slip import of_camber, turned, turning_moment
from mecano.elements.wheels.slip_law import TORSIONAL_STIFFNESS, Carcass, SlipForces, SlipLaw, check_twist, slipping
from mecano.elements.wheels.turn_slip import turning_rate
from mecano.jit.kernel import kernel
from mecano.laws.tabulated import table_law, two_increasing
from mecano.maths.dual import at_least, at_most, atan2, sqrt, value
from mecano.maths.vector import dot
from mecano.schema import BOOLEAN, NUMBER, POINTS, TEXT, Field, mapping, named, positive

NEEDED = "FNOMIN UNLOADED_RADIUS PCX1 PDX1 PKX1 PCY1 PDY1 PKY1 PKY2".split()
POSITIVE = "FNOMIN UNLOADED_RADIUS PCX1 PCY1 NOMPRES LONGVL LFZO LMUX LMUY".split()
ONE = (  # coefficients, such as scaling factors, that are 1 if a file does not give them
    "LFZO LCX LMUX LEX LKX LHX LVX LCY LMUY LEY LKY LKYC LHY LVY LTR LRES LKZC LXAL LYKA LVYKA LS LMX LVMX LMY "
    "LGAX LGAY LGAZ LSGKP LSGAL LMP Q_RE0 QSY7 NOMPRES INFLPRES"
).split()
ZERO = (
    "PDX2 PDX3 PEX1 PEX2 PEX3 PEX4 PKX2 PKX3 PHX1 PHX2 PVX1 PVX2 PPX1 PPX2 PPX3 PPX4 "
    "RBX1 RBX2 RBX3 RCX1 REX1 REX2 RHX1 "
    "PDY2 PDY3 PEY1 PEY2 PEY3 PEY4 PEY5 PKY3 PKY5 PKY6 PKY7 PHY1 PHY2 PHY3 PVY1 PVY2 PVY3 PVY4 "
    "PPY1 PPY2 PPY3 PPY4 PPY5 RBY1 RBY2 RBY3 RBY4 RCY1 REY1 REY2 RHY1 RHY2 RVY1 RVY2 RVY3 RVY4 RVY5 RVY6 "
    "QBZ1 QBZ2 QBZ3 QBZ4 QBZ5 QBZ9 QBZ10 QCZ1 QDZ1 QDZ2 QDZ3 QDZ4 QDZ6 QDZ7 QDZ8 QDZ9 QDZ10 QDZ11 QEZ1 QEZ2 QEZ3 QEZ4 "
    "QEZ5 QHZ1 QHZ2 QHZ3 QHZ4 PPZ1 PPZ2 SSZ1 SSZ2 SSZ3 SSZ4 "
    "QSX1 QSX2 QSX3 QSX4 QSX5 QSX6 QSX7 QSX8 QSX9 QSX10 QSX11 QSX12 QSX13 QSX14 PPMX1 "
    "QSY1 QSY2 QSY3 QSY4 QSY5 QSY6 QSY8 LMUV BREFF DREFF FREFF Q_V1 "
    "VERTICAL_STIFFNESS VERTICAL_DAMPING Q_FZ1 Q_FZ2 PFZ1 LONGITUDINAL_STIFFNESS LATERAL_STIFFNESS PCFX3 PCFY3 "
    "PTX1 PTX2 PTX3 PTY1 PTY2 VERSION"
).split()
DEFAULTS = {
    **dict.fromkeys(ONE, 1.0), **dict.fromkeys((*ZERO, *OF_TURN_SLIP), 0.0), "PKY4": 2.0, "LONGVL": 16.7
}  # fmt: skip
RANGES = {  # key of the upper bound of a range: (output in this range, key of the lower bound, description)
    "KPUMAX": ("slip_ratio", "KPUMIN", "slip ratio"), "ALPMAX": ("slip_angle", "ALPMIN", "slip angle [rad]"),
    "CAMMAX": ("lean", "CAMMIN", "camber angle [rad]"), "FZMAX": ("normal_force", "FZMAX", "normal force [N]"),
}  # fmt: skip
OTHERS = {
    *RANGES, *(low for _, low, _ in RANGES.values()), "FZMIN", "PRESMIN", "PRESMAX", "VXLOW", "FITTYP", "USE_MODE",
    "YAW_STIFFNESS", "MC_CONTOUR_A",
}  # fmt: skip
KNOWN = {*NEEDED, *DEFAULTS, *OTHERS}
LEAST_LOAD = 1e-3  # of the nominal load: below it, force and moments are proportional to the load
LEAST_GRIP = 1e-6  # lower bound of the factor on the friction
CREEP = 0.1  # creep length of the carcass, relative to the relaxation length

RECORD = {**dict.fromkeys((*NEEDED, *DEFAULTS), ()), "pressure": (), "least_speed": (), "side": ()}
FIELDS = (
    Field("file", TEXT, "-", "a .tir file of version 5.2, 6.1 or 6.2 in the folder of the deck", None),
    Field("coefficients", named(NUMBER), "-", "the coefficients of such a file in SI units, instead of 'file'", None),
    Field(
        "deflection_load", POINTS, "m, N", "deflections, loads; when absent, DEFLECTION_LOAD_CURVE of the file", None,
        two_increasing,
    ),
    Field("pressure", NUMBER, "Pa", "inflation pressure; that of the file when absent", None, positive),
    Field("mirrored", BOOLEAN, "-", "true for a tyre on the other side of the vehicle than in the file", False),
    Field("least_speed", NUMBER, "m/s", "v_0, speed below which slips no longer grow as 1/speed", 1.0, positive),
    Field(
        "turn_slip", BOOLEAN, "-", "true for turn slip by the coefficients of the file, of version 6.1 or 6.2; when "
        "absent, true if the last digit of USE_MODE in the file is 5", None,
    ),
    TORSIONAL_STIFFNESS,
)  # fmt: skip


def coefficients(law):
    """Return all coefficients of a tyre law as {name: value}, with defaults."""
    given = law["magic_formula"]["coefficients"]
    nominal = given.get("NOMPRES", given.get("INFLPRES", 1.0))
    return {**DEFAULTS, "NOMPRES": nominal, "INFLPRES": nominal, **given}


def prepare(law, context):
    """Return the values of RECORD."""
    d, found = law["magic_formula"], coefficients(law)
    own = {
        "pressure": d["pressure"] or found["INFLPRES"], "least_speed": d["least_speed"],
        "side": -1.0 if d["mirrored"] else 1.0,
    }  # fmt: skip
    return {**{name: found[name] for name in RECORD if name in found}, **own}


def check(law):
    """Return errors for values that must be positive, and for stiffnesses that drive the slip."""
    d = law["magic_formula"]
    found = coefficients(law)
    wrong = [name for name in POSITIVE if found[name] <= 0.0]
    texts = [f"'tire_law.magic_formula': {name} must be greater than zero, got {found[name]:g}" for name in wrong]
    texts = texts or [*_unsuitable(d, found)]
    return texts or (check_turn_slip(found) if d["turn_slip"] else check_twist("magic_formula", d, "turn_slip"))


def missing_coefficients(given):
    """Return the names of the coefficients that a formula needs and {name: value} lacks."""
    return [name for name in NEEDED if name not in given]


def _unsuitable(d, c):
    """Yield errors for slip stiffnesses of the wrong sign at the nominal load, and a pressure without a nominal one."""
    along, aside = signed_stiffness(c, c["LFZO"] * c["FNOMIN"])
    for stiffness, name, sign in ((along, "PKX1", "positive"), (-aside, "PKY1", "negative")):
        if stiffness < 0.0:
            yield (
                f"'tire_law.magic_formula': {name} = {c[name]:g} gives a force that drives the slip instead of "
                f"opposing it; in the axes of .tir files (ISO 8855) {name} is {sign}"
            )
    if d["pressure"] and not {"NOMPRES", "INFLPRES"} & set(d["coefficients"]):
        yield "'tire_law.magic_formula.pressure': the file has no NOMPRES, so its forces do not depend on the pressure"


def limits(law):
    """Return the limits of slips, camber and load for which the file is valid."""
    given, found = law["magic_formula"]["coefficients"], []
    for high, (output, low, what) in RANGES.items():
        if high in given:
            most = max(abs(given[high]), abs(given.get(low, 0.0)))
            found.append((output, most, f"the .tir file is valid up to a {what} of {most:g}"))
    return found


def completed(law):
    """Return radius, radial law and radial damping of the file, as far as it gives them."""
    c = coefficients(law)
    if c["UNLOADED_RADIUS"] <= 0.0:
        return {}
    found, R0, load = {"radius": c["UNLOADED_RADIUS"]}, c["UNLOADED_RADIUS"], c["FNOMIN"]
    pressed = 1.0 + c["PFZ1"] * ((law["magic_formula"]["pressure"] or c["INFLPRES"]) / c["NOMPRES"] - 1.0)
    slope, bend = c["Q_FZ1"], c["Q_FZ2"]
    if slope == 0.0 and c["VERTICAL_STIFFNESS"] > 0.0:
        slope = math.sqrt(max((c["VERTICAL_STIFFNESS"] * R0 / load) ** 2 - 4.0 * bend, 0.0))
    if slope > 0.0:
        numbers = [0.0, pressed * load * slope / R0, pressed * load * bend / R0**2]
        found["radial"] = (("polynomial", {"coefficients": numbers}),)
    if points := law["magic_formula"]["deflection_load"]:
        found["radial"] = table_law([[w, pressed * F] for w, F in points], "extend")
    if c["VERTICAL_DAMPING"] > 0.0:
        found["radial_damping"] = c["VERTICAL_DAMPING"] / load
    return found


def slip_stiffness(c, load):
    """Return the slip stiffnesses (along t, along l) [N, N/rad] > 0 at a load [N] and the pressure of the file."""
    along, aside = signed_stiffness(c, load)
    return abs(along), abs(aside)


def signed_stiffness(c, load):
    """Return the same as slopes of F_x over kappa, positive, and of F_y over alpha, negative, in the axes of files."""
    dp, df = c["INFLPRES"] / c["NOMPRES"] - 1.0, load / (c["LFZO"] * c["FNOMIN"]) - 1.0
    along = load * (c["PKX1"] + c["PKX2"] * df) * math.exp(c["PKX3"] * df) * c["LKX"]
    along *= 1.0 + c["PPX1"] * dp + c["PPX2"] * dp * dp
    at_load = math.atan((df + 1.0) / (c["PKY2"] * (1.0 + c["PPY2"] * dp)))
    aside = c["PKY1"] * c["LFZO"] * c["FNOMIN"] * (1.0 + c["PPY1"] * dp) * math.sin(c["PKY4"] * at_load) * c["LKY"]
    return along, aside


def relaxation_lengths(c, load):
    """Return the relaxation lengths (along t, along l) [m] at a load [N], or None.

    From PTX and PTY of version 5.2, or slip stiffness over carcass stiffness; None if the file gives neither.
    """
    df, R0 = load / (c["LFZO"] * c["FNOMIN"]) - 1.0, c["UNLOADED_RADIUS"]
    if c["PTX1"] > 0.0 and c["PTY1"] > 0.0:
        along = load * (c["PTX1"] + c["PTX2"] * df) * math.exp(-c["PTX3"] * df) * R0 / c["FNOMIN"] * c["LSGKP"]
        return along, c["PTY1"] * math.sin(2.0 * math.atan(load / (c["PTY2"] * c["FNOMIN"]))) * R0 * c["LSGAL"]
    if c["LONGITUDINAL_STIFFNESS"] > 0.0 and c["LATERAL_STIFFNESS"] > 0.0:
        dp = c["INFLPRES"] / c["NOMPRES"] - 1.0
        stiffness = c["LONGITUDINAL_STIFFNESS"] * (1 + c["PCFX3"] * dp), c["LATERAL_STIFFNESS"] * (1 + c["PCFY3"] * dp)
        return tuple(slip / carcass for slip, carcass in zip(slip_stiffness(c, load), stiffness, strict=True))
    return None


def carcass(law):
    """Return the Carcass with the relaxation lengths of the file at its nominal load, or None."""
    c = coefficients(law)
    lengths = relaxation_lengths(c, c["FNOMIN"])
    if lengths is None:
        return None
    slips = slip_stiffness(c, c["FNOMIN"])
    stiffness = tuple(C / (length * (1.0 - CREEP)) for C, length in zip(slips, lengths, strict=True))
    return Carcass(stiffness, tuple(CREEP * length for length in lengths))


def sample(rng):
    """Return tyres of versions 6.1, 5.2, and 6.2 with turn slip, for a large wheel under about 10 kN."""
    numbers = dict(EXAMPLE)
    return [
        {"coefficients": {**numbers, "VERSION": 6.1}, "least_speed": 0.5, "pressure": 2.5e5},
        {"coefficients": {**numbers, "VERSION": 5.2, "PHY3": 0.03}, "least_speed": 0.5, "mirrored": True},
        {
            "coefficients": {**numbers, "VERSION": 6.2},
            "least_speed": 0.5,
            "turn_slip": True,
            "torsional_stiffness": 4e3,
        },
    ]


@kernel
def at_effective_radius(p, k):
    """Return the Slip of a rim of the effective rolling radius, on which the formula is based."""
    R_e, spin = _rolled(p, k, at_least(k.N, LEAST_LOAD * p.FNOMIN))
    ahead = ((R_e - (p.radius - at_least(k.w, 0.0))) * spin) * k.t
    return slipping(k, k.v - ahead, k.v_0 - ahead)


@kernel
def _rolled(p, k, N):
    """Return the effective rolling radius [m], and the spin relative to the normal, which turns on a drum [rad/s]."""
    R_e = rolling_radius(p, N, k.spin)
    return R_e, k.spin / (1.0 + k.curvature * R_e)


@kernel
def _ramp(x):
    """Return 3 x^2 - 2 x^3 between 0 and 1, constant beyond."""
    x = at_most(at_least(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@kernel
def no_spin(p, k, V, df):
    """Return the rate of turning [rad/s], the turn slip and the spin [1/m] of a tyre without turn slip."""
    return 0.0, 0.0, 0.0


@kernel
def spin_of(p, k, V, df):
    """Return the rate of turning [rad/s], the turn slip and the spin [1/m] of the Slip ``k``."""
    W = turning_rate(k)
    return W, p.side * W / V, p.side * (W + of_camber(p, df) * k.spin * k.lean) / V


@kernel
def of_axle(p, k, R_e, rolled):
    """Return the slip velocity [m/s] along t of a rim of the radius R_e [m] from the velocity of the axle."""
    return dot(k.t, k.v) + (dot(k.t, k.u) - dot(k.t, k.v_0)) - R_e * rolled


@kernel
def of_tread(p, k, R_e, rolled):
    """Return the same for the contact of a rounded tread, which is at another distance from a leaning axle."""
    return dot(k.t, k.v) - (R_e - (p.radius - at_least(k.w, 0.0))) * rolled


def forces_of(formula, spin, sliding=of_axle):
    """Return ``forces`` by a formula, with turn slip or without; ``sliding`` gives the slip velocity along t."""

    @kernel
    def forces(p, laws, k):
        """Return the SlipForces of the Slip ``k``."""
        backward = _ramp(0.5 - 0.5 * dot(k.t, k.u) / p.least_speed)
        F, M, lost = 0.0 * k.v, 0.0 * k.v, 0.0 * k.N
        for way in (1.0, -1.0):
            part = 1.0 - backward if way > 0.0 else backward
            if value(part) > 0.0:
                F_way, M_way, lost_way = rolling(p, k, way)
                F, M, lost = F + part * F_way, M + part * M_way, lost + part * lost_way
        return SlipForces(F, M, lost, lost + dot(F, k.v) + dot(M, k.omega))

    @kernel
    def rolling(p, k, way):
        """Return force [N], moment [N m] and dissipated power [W] of a wheel that rolls along ``way`` t, 1 or -1."""
        V_x, V_sy = way * dot(k.t, k.u), way * dot(k.l, k.v)
        least = LEAST_LOAD * p.FNOMIN
        N = at_least(k.N, least)
        R_e, rolled = _rolled(p, k, N)
        V_sx = way * sliding(p, k, R_e, rolled)
        V = sqrt(V_x * V_x + p.least_speed * p.least_speed)
        lean = way * atan2(k.lean, sqrt(1.0 - k.lean * k.lean))
        mu = at_least(k.grip, LEAST_GRIP) / (1.0 + p.LMUV * sqrt(V_sx * V_sx + V_sy * V_sy) / p.LONGVL)
        df, dp = N / (p.LFZO * p.FNOMIN) - 1.0, p.pressure / p.NOMPRES - 1.0
        forward, (W, turn, phi) = V_x / V, spin(p, k, sqrt(V * V + V_sy * V_sy), df)
        s = Slips(N, df, dp, -V_sx / V, p.side * atan(V_sy / V), p.side * lean, forward, turn, phi)
        F_x, F_y, M_x, M_y, M_z, M_turn = formula(p, s, mu, V_x)
        share = at_least(at_most(k.N / least, 1.0), 0.0)
        F_t, F_l, twist = share * F_x, share * p.side * F_y, share * p.side * M_turn
        along, across = way * k.t, way * k.l
        upright = share * p.side * forward * M_z + twist
        M = (share * p.side * M_x) * along + (share * forward * M_y) * across + upright * k.n
        lost = -(F_t * V_sx + F_l * V_sy) - share * forward * M_y * dot(across, k.omega) - twist * W
        return F_t * along + F_l * across, M, at_least(lost, 0.0)

    return forces


EXAMPLE = {  # plausible values, with all terms of the formula nonzero
    "FNOMIN": 8e3, "UNLOADED_RADIUS": 12.0, "LONGVL": 2.0, "NOMPRES": 2.2e5, "LMUV": 0.02, "LFZO": 1.1,
    "PCX1": 1.6, "PDX1": 1.2, "PDX2": -0.1, "PDX3": 1.5, "PEX1": 0.2, "PEX2": 0.1, "PEX3": -0.05, "PEX4": 0.1,
    "PKX1": 20.0, "PKX2": -0.5, "PKX3": 0.2, "PHX1": 0.001, "PHX2": -0.002, "PVX1": 0.01, "PVX2": 0.01,
    "PPX1": -0.3, "PPX2": 0.1, "PPX3": -0.1, "PPX4": 0.05, "RBX1": 12.0, "RBX2": -10.0, "RBX3": 1.0, "RCX1": 1.1,
    "REX1": 0.1, "REX2": -0.1, "RHX1": 0.01,
    "PCY1": 1.3, "PDY1": 1.0, "PDY2": -0.15, "PDY3": 2.0, "PEY1": -0.8, "PEY2": -0.5, "PEY3": 0.1, "PEY4": -2.0,
    "PEY5": 1.0, "PKY1": -18.0, "PKY2": 1.8, "PKY3": 0.3, "PKY4": 1.9, "PKY5": 0.5, "PKY6": -0.9, "PKY7": -0.2,
    "PHY1": 0.003, "PHY2": -0.001, "PVY1": 0.03, "PVY2": -0.02, "PVY3": -0.3, "PVY4": 0.05,
    "PPY1": -0.4, "PPY2": 0.3, "PPY3": -0.1, "PPY4": 0.05, "PPY5": -0.2,
    "RBY1": 8.0, "RBY2": 6.0, "RBY3": 0.02, "RBY4": 0.5, "RCY1": 1.05, "REY1": 0.2, "REY2": -0.1, "RHY1": 0.01,
    "RHY2": -0.005, "RVY1": 0.05, "RVY2": -0.02, "RVY3": 0.3, "RVY4": 20.0, "RVY5": 1.9, "RVY6": 8.0,
    "QBZ1": 9.0, "QBZ2": -1.0, "QBZ3": -0.5, "QBZ4": 0.2, "QBZ5": -0.3, "QBZ9": 15.0, "QBZ10": 0.1, "QCZ1": 1.15,
    "QDZ1": 0.1, "QDZ2": -0.01, "QDZ3": 0.1, "QDZ4": 2.0, "QDZ6": -0.005, "QDZ7": 0.002, "QDZ8": -0.2, "QDZ9": -0.02,
    "QDZ10": 0.1, "QDZ11": 0.05, "QEZ1": -1.5, "QEZ2": 0.2, "QEZ3": -0.1, "QEZ4": 0.15, "QEZ5": -0.8, "QHZ1": 0.005,
    "QHZ2": -0.002, "QHZ3": 0.1, "QHZ4": 0.02, "PPZ1": -0.3, "PPZ2": 0.2, "SSZ1": 0.03, "SSZ2": 0.005, "SSZ3": 0.5,
    "SSZ4": -0.2, "QSX1": 0.01, "QSX2": 0.8, "QSX3": 0.05, "QSX4": 0.02, "QSX5": 1.2, "QSX6": 0.9, "QSX7": 2.0,
    "QSX8": 0.8, "QSX9": 1.5, "QSX10": 0.2, "QSX11": 1.1, "QSX12": 0.1, "QSX13": 0.01, "QSX14": 0.02, "PPMX1": 0.1,
    "PECP1": 0.6, "PECP2": 0.1, "PDXP1": 0.4, "PDXP2": 0.1, "PDXP3": 2.0, "PKYP1": 0.8, "PDYP1": 0.5, "PDYP2": 0.1,
    "PDYP3": 3.0, "PDYP4": 0.2, "PHYP1": 1.1, "PHYP2": 0.15, "PHYP3": 0.02, "PHYP4": -2.0, "QDTP1": 5.0, "QCRP1": 0.2,
    "QCRP2": 0.4, "QBRP1": 0.3, "QDRP1": 1.1, "QDRP2": -1.5, "LMP": 0.9,
    "QSY1": 0.01, "QSY2": 0.02, "QSY3": 0.001, "QSY4": 1e-4, "QSY5": 0.1, "QSY6": 0.05, "QSY7": 0.85, "QSY8": -0.4,
    "BREFF": 8.0, "DREFF": 0.25, "FREFF": 0.07, "VERTICAL_STIFFNESS": 2e4, "Q_RE0": 0.995, "Q_V1": 0.001,
    "LONGITUDINAL_STIFFNESS": 9e3, "LATERAL_STIFFNESS": 5e3,
}  # fmt: skip

WITHOUT_TURN, WITH_TURN = (formula_of(straight, no_moment), no_spin), (formula_of(turned, turning_moment), spin_of)


def rounded(law):
    """Return the SlipLaw for a rounded tread."""
    return replace(law, forces=forces_of(*WITHOUT_TURN, of_tread), turning=forces_of(*WITH_TURN, of_tread))


MAGIC_FORMULA = SlipLaw(
    "magic_formula", __doc__, mapping(*FIELDS), forces_of(*WITHOUT_TURN), RECORD, prepare,
    check, limits, carcass, completed, sample, seen=at_effective_radius, passive=False,
    turning=forces_of(*WITH_TURN), rounded=rounded,
)  # fmt: skip
