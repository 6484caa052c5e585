r"""Tyre of an aircraft by size and pressure: the formulas of Smiley and Horne, NASA TR R-64 (NACA TN 4110, 1958).

They are fitted to measurements on bias-ply tyres of the types I, III and VII. d and w are the diameter and the width of
the unloaded tyre, p its inflation pressure, p_r its rated pressure, a quarter of the bursting pressure, delta the
vertical deflection, x = delta/d, z = delta/w:

    vertical force             F_z = (p + 0.08 p_r) w sqrt(w d) {0.96 z + 0.216 z^2/C_z up to z = 10 C_z/3,
                                                                 2.4 (z - C_z) beyond}
    cornering stiffness        N = C_c (p + 0.44 p_r) w^2 {1.2 x - 8.8 x^2 up to x = 0.0875, 0.067375 - 0.34 x beyond}
    relaxation length          L_y = (2.8 - 0.8 p/p_r) w {11 x up to 0.053, 64 x - 500 x^2 - 1.4045 up to 0.068,
                                                          0.9075 - 4 x beyond}
    lateral stiffness          K_y = tau w (p + 0.24 p_r) (1 - 0.7 z)
    fore-and-aft stiffness     K_x = 0.8 d (p + 4 p_r) x^(1/3)
    torsional stiffness        K_a = (p + 0.8 p_r) w^3 {250 x^2 up to 0.03, 15 (x - 0.015) beyond}
    half length of the contact h = 0.85 sqrt(delta (d - delta))

with C_z = 0.02, tau = 3, C_c = 63 for the type I, 0.03, 2, 57 for III and VII. N is per radian. (0.067375, which makes
N continuous, is printed as 0.0674.) Force and moment of yawed rolling are those of the slip law ``yawed_rolling``; its
moment for small angles, 0.8 h N psi, is the aligning moment of a patch.

A deck names size, pressure and the vertical load of the wheel. When it is read, the fields of the tyre law that it does
not give are filled in: the radial force, and either the lateral law of a patch (with ``friction``) or the stiffnesses
of ``yawed_rolling``. Values that are constant in wheels are those under this load.
"""

import math

from mecano.elements.wheels.lateral_law import LATERAL_TYPE
from mecano.elements.wheels.slip_law import default_values
from mecano.laws.tabulated import table_law
from mecano.schema import NUMBER, Field, choice, mapping, positive

TYPES = {"I": (0.02, 3.0, 63.0), "III": (0.03, 2.0, 57.0), "VII": (0.03, 2.0, 57.0)}  # C_z, tau, C_c
PARTS = 40  # intervals between joints of the tables: within 1e-4 of the formulas
PEAK, JOINT = 1.2 / 17.6, 0.0875  # delta/d of the largest N, and from which on it falls linearly
VANISHES = 0.067375 / 0.34  # delta/d for which N is zero
BURSTING = 4.0  # times the rated pressure
SMALL = 0.8  # aligning moment over N psi h for small angles

FIELDS = (
    Field("diameter", NUMBER, "m", "d, of the unloaded tyre", check=positive),
    Field("width", NUMBER, "m", "w, of the unloaded tyre", check=positive),
    Field("pressure", NUMBER, "Pa", "p, inflation pressure above that of the air", check=positive),
    Field("rated_pressure", NUMBER, "Pa", "p_r, rated pressure: a quarter of the bursting pressure", check=positive),
    Field("tire_type", choice(*TYPES), "-", "I smooth contour, III low pressure, VII extra high pressure", "VII"),
    Field("load", NUMBER, "N", "vertical load for which constants of the law are computed", check=positive),
    Field(
        "lateral", choice("relaxation", "string", "straight_tangent", "moreland"), "-",
        "form of the lateral law of a patch, unless 'lateral' of the tyre law is given", "relaxation",
    ),
    Field("deflection", NUMBER, "m", "delta under the load; with F_z = load when absent", None, positive),
    Field(
        "cornering_stiffness", NUMBER, "N/rad",
        "N under the load; C_c (p + 0.44 p_r) w^2 (1.2 x - 8.8 x^2), x = delta/d up to 0.0875, C_c = 57 (I: 63), when "
        "absent", None, positive,
    ),
    Field(
        "relaxation_length", NUMBER, "m",
        "L_y under the load; (2.8 - 0.8 p/p_r) w 11 x, x up to 0.053, when absent", None, positive,
    ),
    Field("contact_length", NUMBER, "m", "2h under the load; 1.7 sqrt(delta (d - delta)) when absent", None, positive),
    Field(
        "lateral_stiffness", NUMBER, "N/m",
        "K_y under the load; tau w (p + 0.24 p_r) (1 - 0.7 delta/w), tau = 2 (I: 3), when absent", None, positive,
    ),
    Field(
        "fore_and_aft_stiffness", NUMBER, "N/m",
        "K_x under the load; 0.8 d (p + 4 p_r) x^(1/3) when absent", None, positive,
    ),
    Field(
        "torsional_stiffness", NUMBER, "N m/rad",
        "K_a under the load; (p + 0.8 p_r) w^3 15 (x - 0.015), x from 0.03 on, when absent", None, positive,
    ),
)  # fmt: skip
SMILEY_HORNE = Field(
    "smiley_horne", mapping(*FIELDS), "-", "aircraft tyre by size and pressure (NASA TR R-64): fills in fields", None
)


def vertical_force(d, delta):
    """Return F_z [N] at the deflection ``delta`` [m] >= 0; ``d``: values of FIELDS."""
    C_z, z = TYPES[d["tire_type"]][0], delta / d["width"]
    share = 0.96 * z + 0.216 * z * z / C_z if z <= 10.0 * C_z / 3.0 else 2.4 * (z - C_z)
    return share * _force(d)


def _force(d):
    """Return (p + 0.08 p_r) w sqrt(w d) [N]."""
    return (d["pressure"] + 0.08 * d["rated_pressure"]) * d["width"] * math.sqrt(d["width"] * d["diameter"])


def deflection(d, force):
    """Return the deflection [m] at which F_z is ``force`` [N]."""
    C_z, share = TYPES[d["tire_type"]][0], force / _force(d)
    if share > 5.6 * C_z:
        return d["width"] * (share / 2.4 + C_z)
    return d["width"] * 2.0 * share / (0.96 + math.sqrt(0.9216 + 0.864 * share / C_z))


def cornering_stiffness(d, delta):
    """Return N [N/rad]."""
    x = delta / d["diameter"]
    share = 1.2 * x - 8.8 * x * x if x <= JOINT else max(0.067375 - 0.34 * x, 0.0)
    return TYPES[d["tire_type"]][2] * (d["pressure"] + 0.44 * d["rated_pressure"]) * d["width"] ** 2 * share


def relaxation_length(d, delta):
    """Return L_y [m]."""
    x = delta / d["diameter"]
    middle = 64.0 * x - 500.0 * x * x - 1.4045
    share = 11.0 * x if x <= 0.053 else middle if x <= 0.068 else 0.9075 - 4.0 * x
    return (2.8 - 0.8 * d["pressure"] / d["rated_pressure"]) * d["width"] * share


def lateral_stiffness(d, delta):
    """Return K_y [N/m]."""
    tau, w = TYPES[d["tire_type"]][1], d["width"]
    return tau * w * (d["pressure"] + 0.24 * d["rated_pressure"]) * (1.0 - 0.7 * delta / w)


def fore_and_aft_stiffness(d, delta):
    """Return K_x [N/m]."""
    x = delta / d["diameter"]
    return 0.8 * d["diameter"] * (d["pressure"] + 4.0 * d["rated_pressure"]) * x ** (1.0 / 3.0)


def torsional_stiffness(d, delta):
    """Return K_a [N m/rad]."""
    x = delta / d["diameter"]
    share = 250.0 * x * x if x <= 0.03 else 15.0 * (x - 0.015)
    return (d["pressure"] + 0.8 * d["rated_pressure"]) * d["width"] ** 3 * share


def contact_length(d, delta):
    """Return 2h [m]."""
    return 1.7 * math.sqrt(delta * (d["diameter"] - delta))


AT_LOAD = (
    cornering_stiffness, relaxation_length, contact_length, lateral_stiffness, fore_and_aft_stiffness,
    torsional_stiffness,
)  # fmt: skip


def under_load(d):
    """Return the values under the load, {field: number}; those that ``d`` gives remain."""
    delta = d["deflection"] or deflection(d, d["load"])
    return {"deflection": delta, **{f.__name__: d[f.__name__] or f(d, delta) for f in AT_LOAD}}


def errors(d):
    """Return [(field, text)] for values outside the range of the formulas."""
    found = []
    if d["width"] >= d["diameter"]:
        found.append(("width", f"must be less than the diameter, {d['diameter']:g} m, got {d['width']:g} m"))
    if d["pressure"] > 0.5 * BURSTING * d["rated_pressure"]:
        text = "must be at most twice the rated pressure, half of the bursting pressure: is the unit right?"
        found.append(("pressure", f"({d['pressure']:g} Pa) {text}"))
    delta, most = d["deflection"] or deflection(d, d["load"]), VANISHES * d["diameter"]
    if not found and delta >= most:
        field = "deflection" if d["deflection"] else "load"
        text = f"deforms the tyre by {delta:.4g} m; the formulas are valid below {most:.4g} m, 0.198 of the diameter"
        found.append((field, f"({d[field]:g} {'m' if d['deflection'] else 'N'}) {text}"))
    return found


def radial_law(d):
    """Return F_z as a law of the deflection, a table."""
    w = d["width"]
    joint = 10.0 * TYPES[d["tire_type"]][0] / 3.0 * w
    return table_law([[delta, vertical_force(d, delta)] for delta in (*_even(0.0, joint, 1), w)], "extend")


def cornering_law(d):
    """Return N as a law of the deflection, a table; it has the cornering stiffness of ``d`` under the load."""
    scale = d["cornering_stiffness"] / cornering_stiffness(d, d["deflection"])
    places = [d["diameter"] * x for x in (*_even(0.0, PEAK, -1), *_even(PEAK, JOINT, 1), VANISHES)]
    return table_law([[delta, scale * cornering_stiffness(d, delta)] for delta in places], "hold")


def _even(first, last, more):
    """Return numbers of equal distances from ``first`` to ``last``, and ``more`` beyond (-1: without the last)."""
    return [first + (last - first) * i / PARTS for i in range(PARTS + 1 + more)]


def lateral_law(d):
    """Return the lateral law of a patch, in the form that ``d`` names; ``d`` contains the values under the load."""
    N, L_y = d["cornering_stiffness"], d["relaxation_length"]
    rolling = {"cornering_stiffness": N, "relaxation_length": L_y}
    own, stiffness = {
        "relaxation": (rolling, N / L_y),
        "straight_tangent": ({**rolling, "contact_length": d["contact_length"]}, 0.0),
        "string": (
            {**rolling, "contact_length": d["contact_length"], "torsional_stiffness": d["torsional_stiffness"]}, 0.0,
        ),
        "moreland": (
            {"lateral_stiffness": d["lateral_stiffness"], "yaw_coefficient": 1.0 / N,
             "torsional_stiffness": d["torsional_stiffness"]}, d["lateral_stiffness"],
        ),
    }[d["lateral"]]  # fmt: skip
    form = next(field.type for field in LATERAL_TYPE.options if field.name == d["lateral"])
    trail = 0.5 * SMALL * d["contact_length"]  # of strings, from their contact length
    aligning = [trail * stiffness, 0.0, 0.0, 0.0]
    values = {d["lateral"]: default_values(form.options, own), "aligning_moment": aligning}
    return default_values(LATERAL_TYPE.options, values)


def rolling_stiffnesses(d, creep_length):
    """Return the values of ``yawed_rolling`` that follow from size and pressure.

    The lateral stiffness of its carcass is that with which the relaxation length under the load is L_y.
    """
    lateral = d["cornering_stiffness"] / (d["relaxation_length"] - creep_length)
    return {"cornering_stiffness": cornering_law(d), "carcass_stiffness": [d["fore_and_aft_stiffness"], lateral]}


def text_under_load(d):
    """Return as text deflection, stiffnesses and lengths of the tyre under its load, for the summary of a model."""
    return (
        f"under {d['load']:.4g} N its deflection is {d['deflection']:.4g} m, {d['deflection'] / d['diameter']:.3g} of "
        f"the diameter; cornering stiffness {d['cornering_stiffness']:.4g} N/rad, relaxation length "
        f"{d['relaxation_length']:.4g} m, contact length {d['contact_length']:.4g} m, stiffness at rest: lateral "
        f"{d['lateral_stiffness']:.4g} N/m, fore and aft {d['fore_and_aft_stiffness']:.4g} N/m, torsional "
        f"{d['torsional_stiffness']:.4g} N m/rad"
    )


def completed(values):
    """Return the values of other fields of a tyre law; ``values["smiley_horne"]`` contains those under the load."""
    d = values["smiley_horne"]
    found = {"radius": 0.5 * d["diameter"], "radial": radial_law(d), "valid_deformation": VANISHES * d["diameter"]}
    return {**found, "lateral": lateral_law(d)} if values["friction"] is not None else found
